// Pigmented keratin: a rough boundary over a diffuse body, `bsdf::Keratin` of barbule-appearance, which is its reference and
// says where the formulas come from. Its light is white or the body's, so its colour needs no sum over wavelengths.

struct Keratin {
    // Linear sRGB of the body.
    body: vec4f,
    // GGX α, refractive index, the boundary's mean albedo.
    optics: vec4f,
    // The boundary's albedo at cosines of 0 to 1 in steps of 1/32, four a row.
    albedo: array<vec4f, 9>,
}

fn keratin_fresnel(cosine: f32, index: f32) -> f32 {
    let c = clamp(cosine, 0.0, 1.0);
    let t = sqrt(max(1.0 - (1.0 - c * c) / (index * index), 0.0));
    let s = (c - index * t) / (c + index * t);
    let p = (index * c - t) / (index * c + t);
    return 0.5 * (s * s + p * p);
}

fn keratin_albedo(keratin: Keratin, cosine: f32) -> f32 {
    var rows = keratin.albedo;
    let at = clamp(cosine, 0.0, 1.0) * 32.0;
    let low = min(u32(at), 31u);
    let here = rows[low / 4u][low % 4u];
    let next = rows[(low + 1u) / 4u][(low + 1u) % 4u];
    return mix(here, next, at - f32(low));
}

// Smith's Λ.
fn keratin_hidden(w: vec3f, alpha: f32) -> f32 {
    let slope = dot(w.xy, w.xy) * alpha * alpha / max(w.z * w.z, 1e-30);
    return 0.5 * (sqrt(1.0 + slope) - 1.0);
}

// Linear sRGB of f, 1/sr.
fn keratin_colour(keratin: Keratin, wi: vec3f, wo: vec3f) -> vec3f {
    if wi.z <= 0.0 || wo.z <= 0.0 {
        return vec3f(0.0);
    }
    let pi = 3.141592653589793;
    let alpha = keratin.optics.x;
    let h = normalize(wi + wo);
    let t = dot(h.xy, h.xy) / (alpha * alpha) + h.z * h.z;
    let distribution = 1.0 / (pi * alpha * alpha * t * t);
    let masked = 1.0 + keratin_hidden(wi, alpha) + keratin_hidden(wo, alpha);
    let gloss = keratin_fresnel(dot(wi, h), keratin.optics.y) * distribution / (4.0 * wi.z * wo.z * masked);
    let let_in = (1.0 - keratin_albedo(keratin, wi.z)) * (1.0 - keratin_albedo(keratin, wo.z));
    return vec3f(gloss) + keratin.body.xyz * let_in / (pi * (1.0 - keratin.optics.z));
}

// Linear sRGB of all that is reflected of light from ω_i.
fn keratin_albedo_colour(keratin: Keratin, wi: vec3f) -> vec3f {
    let boundary = keratin_albedo(keratin, wi.z);
    return vec3f(boundary) + (1.0 - boundary) * keratin.body.xyz;
}
