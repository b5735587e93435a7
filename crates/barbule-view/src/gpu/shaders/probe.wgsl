// Values one by one, each pixel one of a list: how the shaders are held against their references. Goes with feather.wgsl,
// colour.wgsl and tone.wgsl.

// ω_i with λ in nm (0: colour by all wavelengths), then ω_o; two texels for each question, in rows of 2048.
@group(2) @binding(0) var probe_directions: texture_2d<f32>;
// The instance's name, low and high word; 1 if there is one; what is asked.
@group(2) @binding(1) var probe_names: texture_2d<u32>;

const PROBE_VALUES: u32 = 0u;
const PROBE_COLOUR: u32 = 1u;
const PROBE_TONE: u32 = 2u;

@vertex
fn vs_probe(@builtin(vertex_index) corner: u32) -> @builtin(position) vec4f {
    // One triangle over all of the picture.
    return vec4f(f32(corner & 1u) * 4.0 - 1.0, f32(corner >> 1u) * 4.0 - 1.0, 0.0, 1.0);
}

@fragment
fn fs_probe(@builtin(position) pixel: vec4f) -> @location(0) vec4f {
    let column = i32(pixel.x);
    let row = i32(pixel.y);
    let first = textureLoad(probe_directions, vec2i(2 * column, row), 0);
    let second = textureLoad(probe_directions, vec2i(2 * column + 1, row), 0);
    let name = textureLoad(probe_names, vec2i(column, row), 0);
    if name.w == PROBE_TONE {
        return vec4f(tone_shown(first.xyz, second.x > 0.5), 1.0);
    }
    var draw = feather_mean();
    if name.z == 1u {
        draw = feather_draw(name.xy);
    }
    if name.w == PROBE_COLOUR {
        return vec4f(feather_colour(first.xyz, second.xyz, draw), 1.0);
    }
    let wave = feather_wave(first.w);
    let values = feather_values(feather_seen(first.xyz, second.xyz), wave, draw);
    var albedo = 0.0;
    if first.z > 0.0 {
        albedo = feather_albedo(feather_light(first.xyz), wave);
    }
    return vec4f(values, albedo, 1.0);
}
