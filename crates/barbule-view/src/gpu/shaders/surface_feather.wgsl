// Surfaces of barbules. Goes with waves.wgsl, feather.wgsl, keratin.wgsl and surface.wgsl.

// Below this share of their contrast nobody sees instances.
const LEAST_CONTRAST: f32 = 0.1;
// Over this blur an arch's width is even within a few percent.
const MOST_BLUR: f32 = 3.0;

// A cell of a barbule.
struct Cell {
    // The name from which its individual is drawn, and its barbule's.
    instance: vec2u,
    barbule: vec2u,
    // How far its surface leans along the barbule, rad.
    pitch: f32,
    // 1/√n of n cells in the pixel.
    contrast: f32,
    // Whether it is a wall to the next cell.
    is_wall: bool,
    // −1 to 1 across the barbule, and the pixel's radius over half the width.
    across: vec2f,
}

// A whole number below 2³¹ in size as a word of 64 bits, with its sign.
fn words_of_whole(value: f32) -> vec2u {
    let whole = i32(value);
    return vec2u(u32(whole), select(0u, 0xffffffffu, whole < 0));
}

// A name's number in [0, 1).
fn unit_of_words(words: vec2u) -> f32 {
    return min(f32(words.y) / 4294967296.0, 0.99999994);
}

// Which cell of which barbule a place is in; `footprint` is the radius of the pixel on the surface, mm.
fn cell_of(name: vec2u, place: vec2f, shape: vec2f, footprint: f32) -> Cell {
    var cell: Cell;
    var number = floor(place.x);
    var within = place.x - number;
    var id = name;
    var width = 2.0 * shape.y;
    var length_of_cell = view.cells.x;
    cell.across.x = place.y;
    if view.cells.z > 0.5 {
        let on = place * view.barbules.xy;
        let is_row = view.barbules.z > 0.0;
        let row = select(0.0, floor(on.y / view.barbules.z), is_row);
        let barbule = select(0.0, floor(on.x / view.barbules.w), view.barbules.w > 0.0);
        var phase = 0.0;
        if view.barbules.z > 0.0 || view.barbules.w > 0.0 {
            id = split_mix(split_mix(split_mix(name) ^ split_mix(words_of_whole(row))) ^ split_mix(words_of_whole(barbule)));
            phase = unit_of_words(split_mix(id));
        }
        let along = select(0.5, (on.x - barbule * view.barbules.w) / view.cells.x + phase, view.cells.x > 0.0);
        number = floor(along);
        within = along - number;
        // v grows to +x, as frames have it.
        width = view.barbules.z;
        cell.across.x = select(clamp(place.y, -1.0, 1.0), 2.0 * (on.y / width - row) - 1.0, is_row);
        cell.instance = split_mix(id ^ split_mix(words_of_whole(number)));
    } else {
        cell.instance = split_mix(id ^ split_mix(words_of_whole(max(number, 0.0))));
    }
    cell.barbule = id;
    let from_wall = min(within, 1.0 - within) * length_of_cell;
    cell.is_wall = length_of_cell > 0.0 && from_wall < 0.5 * dress.cells.z;
    cell.across.y = select(1e6, 2.0 * footprint / width, width > 0.0);
    cell.pitch = select(shape.x, view.cells.y, view.cells.z > 0.5) * (1.0 - 2.0 * within);
    if length_of_cell <= 0.0 {
        length_of_cell = 10.0 * width;
    }
    let cells = max(2.0 * footprint / max(width, 1e-9), 1.0) * max(2.0 * footprint / max(length_of_cell, 1e-9), 1.0);
    cell.contrast = select(1.0, inverseSqrt(cells), width > 0.0);
    return cell;
}

// A number of mean 0 and deviation 1 that a name stands for: the sum of four uniform ones.
fn bell(name: vec2u) -> f32 {
    let bits = split_mix(name ^ vec2u(0x7b11c3a1u, 0x5bd1e995u));
    let sum = (bits.x & 0xffffu) + (bits.x >> 16u) + (bits.y & 0xffffu) + (bits.y >> 16u);
    return (f32(sum) - 131070.0) * sqrt(3.0 / 4294967295.0);
}

// Factor to the size of the nanostructure in a cell.
fn size_of(cell: Cell) -> f32 {
    if dress.cells.x == 0.0 && dress.cells.y == 0.0 {
        return 1.0;
    }
    return 1.0 + dress.cells.x * bell(cell.instance) + dress.cells.y * bell(cell.barbule);
}

// ½ erfc(x/√2), to 1e-7 (Abramowitz & Stegun 7.1.26).
fn normal_above(x: f32) -> f32 {
    let z = abs(x) * 0.7071067811865476;
    let t = 1.0 / (1.0 + 0.3275911 * z);
    let series = t * (0.254829592 + t * (-0.284496736 + t * (1.421413741 + t * (-1.453152027 + t * 1.061405429))));
    let tail = 0.5 * series * exp(-z * z);
    return select(tail, 1.0 - tail, x < 0.0);
}

// Of a barbule that is an arch: how much of the light between two directions comes from this place across, over the width's mean.
fn arch_share(cell: Cell, wi: vec3f, wo: vec3f) -> f32 {
    let blur = sqrt(dress.arch.z * dress.arch.z + cell.across.y * cell.across.y);
    if dress.arch.w < 0.5 || blur > MOST_BLUR {
        return 1.0;
    }
    let middle = wi.xz + wo.xz;
    let low = dress.arch.x;
    let high = dress.arch.y;
    let mirror = clamp((2.0 * middle.x / max(length(middle), 1e-30) - low - high) / (high - low), -1.0, 1.0);
    let mean = 0.5 * (normal_above((mirror - 1.0) / blur) - normal_above((mirror + 1.0) / blur));
    let away = (cell.across.x - mirror) / blur;
    return exp(-0.5 * away * away) / (blur * 2.5066282746310002 * mean);
}

// Linear sRGB of f of a barbule's upper side, 1/sr.
fn barbule_colour(to_eye: vec3f, to_lamp: vec3f, cell: Cell, size: f32) -> vec3f {
    let shown = min(cell.contrast * view.sky.w, 1.0);
    var draw = feather_mean();
    if shown > LEAST_CONTRAST {
        draw = feather_draw(cell.instance);
        draw.share = shown;
    }
    let f = feather_colour(to_eye, to_lamp, draw, size);
    return f * arch_share(cell, to_eye, to_lamp);
}

@fragment
fn fs_surface(surface: Surface, @builtin(front_facing) is_front: bool) -> @location(0) vec4f {
    // Derivatives first, before anything branches.
    let pixel = cross(dpdx(surface.position), dpdy(surface.position));
    let cell = cell_of(surface.name, surface.place, surface.shape, 0.5 * sqrt(length(pixel)));
    let local = local_of(surface, is_front, cell.pitch);
    if is_front && !cell.is_wall {
        let size = size_of(cell);
        let f = barbule_colour(local.to_eye, local.to_lamp, cell, size);
        return light_of(local, f, feather_albedo_colour(local.to_eye, size));
    }
    return keratin_light(local);
}
