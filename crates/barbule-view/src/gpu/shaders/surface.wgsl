// Meshes under one lamp and an even sky, seen from one place, in linear sRGB. Goes with keratin.wgsl, and with one of
// surface_feather.wgsl, surface_grating.wgsl, surface_layers.wgsl and surface_keratin.wgsl.
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

struct Dress {
    // Keratin of undersides and of walls between cells; of all that has no other coat.
    keratin: Keratin,
    // Deviation of the nanostructure's size from cell to cell and from barbule to barbule, as shares; length of the walls between
    // cells, mm.
    cells: vec4f,
    // Of barbules that are arches: sines of the slopes at both edges, blur over half the width; 1 if they are.
    arch: vec4f,
}

@group(3) @binding(0) var<uniform> dress: Dress;

struct Corner {
    @location(0) position: vec3f,
    @location(1) normal: vec3f,
    @location(2) tangent: vec3f,
    @location(3) place: vec2f,
    // Slope at the ends of cells, rad, and half the barbule's width, mm.
    @location(4) shape: vec2f,
    @location(5) name: vec2u,
}

struct Surface {
    // The same to the last bit in every pass.
    @builtin(position) @invariant at: vec4f,
    @location(0) position: vec3f,
    @location(1) normal: vec3f,
    @location(2) tangent: vec3f,
    @location(3) place: vec2f,
    @location(4) shape: vec2f,
    @location(5) @interpolate(flat, either) name: vec2u,
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
    surface.name = corner.name;
    return surface;
}

// Light and eye in the frame of a place: x across, y along, z out of the side that is seen.
struct Local {
    to_eye: vec3f,
    to_lamp: vec3f,
}

// `pitch`: how far the surface leans along y, rad.
fn local_of(surface: Surface, is_front: bool, pitch: f32) -> Local {
    let side = select(-1.0, 1.0, is_front);
    let normal = normalize(surface.normal);
    let level = normalize(surface.tangent - normal * dot(normal, surface.tangent));
    let sine = sin(pitch);
    let cosine = cos(pitch);
    let y = level * cosine + normal * sine;
    let z = side * (normal * cosine - level * sine);
    let x = cross(y, z);
    let eye = normalize(view.eye.xyz - surface.position * view.eye.w);
    let to_eye = vec3f(dot(eye, x), dot(eye, y), dot(eye, z));
    let lamp = view.lamp.xyz;
    // Where interpolated normals look away although the face does not, it is seen edge on.
    return Local(
        normalize(vec3f(to_eye.xy, max(to_eye.z, 1e-3))),
        vec3f(dot(lamp, x), dot(lamp, y), dot(lamp, z)),
    );
}

// What shines from a place, by f and by what it reflects of even light.
fn light_of(local: Local, f: vec3f, reflected: vec3f) -> vec4f {
    let pi = 3.141592653589793;
    let light = pi * view.lamp.w * max(local.to_lamp.z, 0.0) * f + view.sky.xyz * reflected;
    // Half precision ends at 65504.
    return vec4f(clamp(light, vec3f(-60000.0), vec3f(60000.0)), 1.0);
}

// What shines from keratin.
fn keratin_light(local: Local) -> vec4f {
    let f = keratin_colour(dress.keratin, local.to_eye, local.to_lamp);
    return light_of(local, f, keratin_albedo_colour(dress.keratin, local.to_eye));
}

// Nothing is written where depths alone are drawn.
@fragment
fn fs_depth() -> @location(0) vec4f {
    return vec4f(0.0);
}
