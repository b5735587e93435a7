// Surfaces of barbules, barbs and shafts. Goes with waves.wgsl, feather.wgsl, keratin.wgsl and surface.wgsl.

// Parts of meshes; zones of a feather are 16 apart.
const PART_RAMUS: u32 = 4u;
const PART_SHAFT: u32 = 5u;
// Below this share of their contrast nobody sees instances.
const LEAST_CONTRAST: f32 = 0.1;

// A cell of a barbule.
struct Cell {
    // The name from which its individual is drawn.
    instance: vec2u,
    // How far its surface leans along the barbule, rad.
    pitch: f32,
    // 1/√n of n cells in the pixel.
    contrast: f32,
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
    if view.cells.z > 0.5 {
        let on = place * view.barbules.xy;
        let row = select(0.0, floor(on.y / view.barbules.z), view.barbules.z > 0.0);
        let barbule = select(0.0, floor(on.x / view.barbules.w), view.barbules.w > 0.0);
        var phase = 0.0;
        if view.barbules.z > 0.0 || view.barbules.w > 0.0 {
            id = split_mix(split_mix(split_mix(name) ^ split_mix(words_of_whole(row))) ^ split_mix(words_of_whole(barbule)));
            phase = unit_of_words(split_mix(id));
        }
        let along = select(0.5, (on.x - barbule * view.barbules.w) / view.cells.x + phase, view.cells.x > 0.0);
        number = floor(along);
        within = along - number;
        width = view.barbules.z;
        cell.instance = split_mix(id ^ split_mix(words_of_whole(number)));
    } else {
        cell.instance = split_mix(id ^ split_mix(words_of_whole(max(number, 0.0))));
    }
    cell.pitch = select(shape.x, view.cells.y, view.cells.z > 0.5) * (1.0 - 2.0 * within);
    if length_of_cell <= 0.0 {
        length_of_cell = 10.0 * width;
    }
    let cells = max(2.0 * footprint / max(width, 1e-9), 1.0) * max(2.0 * footprint / max(length_of_cell, 1e-9), 1.0);
    cell.contrast = select(1.0, inverseSqrt(cells), width > 0.0);
    return cell;
}

// Linear sRGB of f of a barbule's upper side, 1/sr.
fn barbule_colour(to_eye: vec3f, to_lamp: vec3f, cell: Cell) -> vec3f {
    let shown = cell.contrast * view.sky.w;
    var f = vec3f(0.0);
    if shown < 1.0 {
        f = (1.0 - select(0.0, shown, shown > LEAST_CONTRAST)) * feather_colour(to_eye, to_lamp, feather_mean());
    }
    if shown > LEAST_CONTRAST {
        f += min(shown, 1.0) * feather_colour(to_eye, to_lamp, feather_draw(cell.instance));
    }
    return f;
}

@fragment
fn fs_surface(surface: Surface, @builtin(front_facing) is_front: bool) -> @location(0) vec4f {
    // Derivatives first, before anything branches.
    let pixel = cross(dpdx(surface.position), dpdy(surface.position));
    let cell = cell_of(surface.name, surface.place, surface.shape, 0.5 * sqrt(length(pixel)));
    let local = local_of(surface, is_front, cell.pitch);
    let part = surface.part % 16u;
    if part < PART_RAMUS && is_front {
        let f = barbule_colour(local.to_eye, local.to_lamp, cell);
        return light_of(local, f, feather_albedo_colour(local.to_eye));
    }
    let keratin = keratins.all[select(select(0u, 1u, part == PART_RAMUS), 2u, part == PART_SHAFT)];
    let f = keratin_colour(keratin, local.to_eye, local.to_lamp);
    return light_of(local, f, keratin_albedo_colour(keratin, local.to_eye));
}
