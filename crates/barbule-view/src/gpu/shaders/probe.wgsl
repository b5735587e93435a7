// Values one by one, each pixel one of a list: how the shaders are held against their references. Goes with one of
// probe_feather.wgsl, probe_grating.wgsl and probe_tone.wgsl. Numbers are drawn as their bits: not every adapter draws into
// single precision.

// ω_i with λ in nm, then ω_o; two texels for each question.
@group(2) @binding(0) var probe_directions: texture_2d<f32>;
// The instance's name, low and high word; 1 if there is one; 1 if a colour is asked.
@group(2) @binding(1) var probe_names: texture_2d<u32>;

struct ProbeQuestion {
    first: vec4f,
    second: vec4f,
    name: vec4u,
}

fn probe_question(pixel: vec4f) -> ProbeQuestion {
    let at = vec2i(pixel.xy);
    let first = textureLoad(probe_directions, vec2i(2 * at.x, at.y), 0);
    let second = textureLoad(probe_directions, vec2i(2 * at.x + 1, at.y), 0);
    return ProbeQuestion(first, second, textureLoad(probe_names, at, 0));
}

@vertex
fn vs_probe(@builtin(vertex_index) corner: u32) -> @builtin(position) vec4f {
    // One triangle over all of the picture.
    return vec4f(f32(corner & 1u) * 4.0 - 1.0, f32(corner >> 1u) * 4.0 - 1.0, 0.0, 1.0);
}
