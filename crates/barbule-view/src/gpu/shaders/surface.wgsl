// Meshes of barbules, barbs and shafts under one lamp and an even sky, seen from one place, in linear sRGB. Goes with
// waves.wgsl, feather.wgsl and keratin.wgsl.
//
// As in the renderer, the viewer's direction is the one that tables are looked up with, and the lamp's is the other.

struct View {
    // From the scene, mm, to the picture.
    clip_from_scene: mat4x4f,
    // Where the eye is, mm; w is 0 where it is infinitely far, in this direction.
    eye: vec4f,
    // Unit vector towards the lamp, and its irradiance over π: a white surface that faces it shines so.
    lamp: vec4f,
    // Linear sRGB of the sky's radiance; share of the instances' contrast that is shown.
    sky: vec4f,
    // Barbules side by side: units of u and v, a barbule's width and length, mm.
    barbules: vec4f,
    // Length of a cell, mm; slope at its ends, rad; 1 where places are texture coordinates of barbules side by side, 0 where
    // they are of ribbons; unused.
    cells: vec4f,
}

@group(2) @binding(0) var<uniform> view: View;

struct Keratins {
    // Undersides of barbules, rami, shafts.
    all: array<Keratin, 3>,
}

@group(2) @binding(1) var<uniform> keratins: Keratins;

// Parts of meshes; zones of a feather are 16 apart.
const PART_RAMUS: u32 = 4u;
const PART_SHAFT: u32 = 5u;
// Below this share of their contrast nobody sees instances.
const LEAST_CONTRAST: f32 = 0.1;

struct Corner {
    @location(0) position: vec3f,
    @location(1) normal: vec3f,
    @location(2) tangent: vec3f,
    @location(3) place: vec2f,
    // Slope at the ends of cells, rad, and half the barbule's width, mm.
    @location(4) shape: vec2f,
    @location(5) part: u32,
    @location(6) name: vec2u,
}

struct Surface {
    @builtin(position) at: vec4f,
    @location(0) position: vec3f,
    @location(1) normal: vec3f,
    @location(2) tangent: vec3f,
    @location(3) place: vec2f,
    @location(4) shape: vec2f,
    @location(5) @interpolate(flat, either) part: u32,
    @location(6) @interpolate(flat, either) name: vec2u,
}

@vertex
fn vs_surface(corner: Corner) -> Surface {
    var surface: Surface;
    surface.at = view.clip_from_scene * vec4f(corner.position, 1.0);
    surface.position = corner.position;
    surface.normal = corner.normal;
    surface.tangent = corner.tangent;
    surface.place = corner.place;
    surface.shape = corner.shape;
    surface.part = corner.part;
    surface.name = corner.name;
    return surface;
}

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

// Linear sRGB of f times the cosine, and of the albedo: what a barbule's upper side makes of lamp and sky.
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
fn fs_feather(surface: Surface, @builtin(front_facing) is_front: bool) -> @location(0) vec4f {
    let to_eye = normalize(view.eye.xyz - surface.position * view.eye.w);
    // Derivatives are of all pixels alike, before anything branches.
    let across = dpdx(surface.position);
    let down = dpdy(surface.position);
    let footprint = 0.5 * sqrt(length(cross(across, down)));
    let cell = cell_of(surface.name, surface.place, surface.shape, footprint);
    // y along the barbule, z its normal on the side that is seen.
    let side = select(-1.0, 1.0, is_front);
    let normal = normalize(surface.normal);
    let level = normalize(surface.tangent - normal * dot(normal, surface.tangent));
    let sine = sin(cell.pitch);
    let cosine = cos(cell.pitch);
    let along = level * cosine + normal * sine;
    let z = side * (normal * cosine - level * sine);
    let x = cross(along, z);
    let wo = vec3f(dot(to_eye, x), dot(to_eye, along), dot(to_eye, z));
    let wi = vec3f(dot(view.lamp.xyz, x), dot(view.lamp.xyz, along), dot(view.lamp.xyz, z));
    // Where interpolated normals look away although the face does not, nothing is seen edge on.
    let seen = normalize(vec3f(wo.xy, max(wo.z, 1e-3)));
    let part = surface.part % 16u;
    var f = vec3f(0.0);
    var reflected = vec3f(0.0);
    if part < PART_RAMUS && is_front {
        f = barbule_colour(seen, wi, cell);
        reflected = feather_albedo_colour(seen);
    } else {
        let keratin = keratins.all[select(select(0u, 1u, part == PART_RAMUS), 2u, part == PART_SHAFT)];
        f = keratin_colour(keratin, seen, wi);
        reflected = keratin_albedo_colour(keratin, seen);
    }
    let pi = 3.141592653589793;
    let light = pi * view.lamp.w * max(wi.z, 0.0) * f + view.sky.xyz * reflected;
    return vec4f(clamp(light, vec3f(-60000.0), vec3f(60000.0)), 1.0);
}
