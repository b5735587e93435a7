// Layers on a rough surface, from the share of light that they reflect at each wavelength and angle: `ThinFilm` of
// barbule-appearance, which is its reference and says where the formulas come from. Goes with waves.wgsl.

struct LayersHeader {
    // GGX α; the rest is unused.
    how: vec4f,
    // Steps of the cosine of what is reflected, and of the albedo; first value of the albedo; unused.
    sizes: vec4u,
}

@group(1) @binding(0) var<uniform> layers: LayersHeader;
// What is reflected at each wavelength and cosine, then the albedo likewise, one after another in rows of 2048 texels.
@group(1) @binding(1) var layers_numbers: texture_2d<f32>;

fn layers_number(at: u32) -> f32 {
    return textureLoad(layers_numbers, vec2i(i32(at & 2047u), i32(at >> 11u)), 0).x;
}

// Where a cosine lies among even steps: the one below and the share of the next.
struct LayersPlace {
    below: u32,
    share: f32,
}

fn layers_place(cosine: f32, steps: u32) -> LayersPlace {
    let at = clamp(cosine, 0.0, 1.0) * f32(steps);
    let below = min(u32(at), steps - 1u);
    return LayersPlace(below, at - f32(below));
}

// A value at a place of one of the tables' wavelengths.
fn layers_between(first: u32, wave: u32, steps: u32, place: LayersPlace) -> f32 {
    let at = first + wave * (steps + 1u) + place.below;
    return mix(layers_number(at), layers_number(at + 1u), place.share);
}

// Smith's Λ.
fn layers_hidden(w: vec3f) -> f32 {
    let slope = dot(w.xy, w.xy) * layers.how.x * layers.how.x / max(w.z * w.z, 1e-30);
    return 0.5 * (sqrt(1.0 + slope) - 1.0);
}

// f over the reflectance at the facets, 1/sr.
fn layers_facets(wi: vec3f, wo: vec3f, h: vec3f) -> f32 {
    let pi = 3.141592653589793;
    let alpha2 = layers.how.x * layers.how.x;
    let t = dot(h.xy, h.xy) / alpha2 + h.z * h.z;
    return 1.0 / (pi * alpha2 * t * t * 4.0 * wi.z * wo.z * (1.0 + layers_hidden(wi) + layers_hidden(wo)));
}

// f at the wavelength of this number in the tables, 1/sr.
fn layers_value(wi: vec3f, wo: vec3f, wave: u32) -> f32 {
    if wi.z <= 0.0 || wo.z <= 0.0 {
        return 0.0;
    }
    let h = normalize(wi + wo);
    return layers_facets(wi, wo, h) * layers_between(0u, wave, layers.sizes.x, layers_place(dot(wi, h), layers.sizes.x));
}

// Linear sRGB of f, 1/sr.
fn layers_colour(wi: vec3f, wo: vec3f) -> vec3f {
    var sum = vec3f(0.0);
    if wi.z <= 0.0 || wo.z <= 0.0 {
        return sum;
    }
    let h = normalize(wi + wo);
    let place = layers_place(dot(wi, h), layers.sizes.x);
    for (var k = 0u; k < waves.count.x; k++) {
        let wave = waves.all[k];
        sum += wave.parts.xyz * layers_between(0u, u32(wave.place.x), layers.sizes.x, place);
    }
    return sum * layers_facets(wi, wo, h);
}

fn layers_albedo(w: vec3f, wave: u32) -> f32 {
    return layers_between(layers.sizes.z, wave, layers.sizes.y, layers_place(w.z, layers.sizes.y));
}

// Linear sRGB of all that is reflected of light from ω_i.
fn layers_albedo_colour(w: vec3f) -> vec3f {
    var sum = vec3f(0.0);
    for (var k = 0u; k < waves.count.x; k++) {
        let wave = waves.all[k];
        sum += wave.parts.xyz * layers_albedo(w, u32(wave.place.x));
    }
    return sum;
}
