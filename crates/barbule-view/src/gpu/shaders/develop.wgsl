// From a picture in linear sRGB to what a screen shows. Goes with tone.wgsl.

struct Develop {
    // Factor of the exposure; 1 by the film's curve, 0 by the plain one; 1 where the target applies sRGB's transfer curve itself.
    how: vec4f,
    // Linear sRGB on the screen behind the picture.
    behind: vec4f,
}

@group(0) @binding(0) var<uniform> develop: Develop;
@group(0) @binding(1) var develop_light: texture_2d<f32>;

struct Whole {
    @builtin(position) at: vec4f,
    // From the upper left, 0 to 1.
    @location(0) place: vec2f,
}

@vertex
fn vs_develop(@builtin(vertex_index) corner: u32) -> Whole {
    // One triangle over all of the picture.
    let place = vec2f(f32(corner & 1u), f32(corner >> 1u)) * 2.0;
    return Whole(vec4f(2.0 * place.x - 1.0, 1.0 - 2.0 * place.y, 0.0, 1.0), place);
}

fn develop_pixel(whole: Whole) -> vec4f {
    let size = vec2f(textureDimensions(develop_light));
    let at = vec2i(clamp(floor(whole.place * size), vec2f(0.0), size - 1.0));
    return textureLoad(develop_light, at, 0);
}

// A linear colour of the screen as the target takes it.
fn develop_shown(shown: vec3f) -> vec4f {
    if develop.how.z > 0.5 {
        return vec4f(shown, 1.0);
    }
    return vec4f(tone_encoded(shown), 1.0);
}

// A frame as it is, to be mixed into the mean.
@fragment
fn fs_gather(whole: Whole) -> @location(0) vec4f {
    return develop_pixel(whole);
}

@fragment
fn fs_develop(whole: Whole) -> @location(0) vec4f {
    let light = develop_pixel(whole);
    if light.w == 0.0 {
        return develop_shown(develop.behind.xyz);
    }
    // As the renderer develops: what is behind is on the screen as it is.
    let front = tone_shown(light.xyz / max(light.w, 1e-4) * develop.how.x, develop.how.y > 0.5);
    let shown = mix(develop.behind.xyz, front, light.w);
    return develop_shown(shown);
}
