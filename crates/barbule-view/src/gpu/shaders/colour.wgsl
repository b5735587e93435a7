// From values wavelength by wavelength to linear sRGB. Goes with feather.wgsl.

struct Wave {
    // What a value of 1 at this wavelength gives of each channel of linear sRGB; the wave number 2π/λ, rad/µm.
    parts: vec4f,
    // Place below in the tables of the material that is drawn, the share of the next, and λ in nm.
    place: vec4f,
}

struct Waves {
    // How many there are.
    count: vec4u,
    all: array<Wave, 64>,
}

@group(0) @binding(0) var<uniform> waves: Waves;

fn wave_of(number: u32) -> FeatherWave {
    let wave = waves.all[number];
    return FeatherWave(u32(wave.place.x), wave.place.y, wave.parts.w);
}

// Linear sRGB of f, 1/sr: a perfect white has 1/π in each channel.
fn feather_colour(wi: vec3f, wo: vec3f, draw: FeatherDraw) -> vec3f {
    let seen = feather_seen(wi, wo);
    var sum = vec3f(0.0);
    if !seen.is_up {
        return sum;
    }
    for (var k = 0u; k < waves.count.x; k++) {
        sum += waves.all[k].parts.xyz * feather_values(seen, wave_of(k), draw).x;
    }
    return sum;
}

// Linear sRGB of all that is reflected of light from ω_i: under an even sky, by the reciprocity of what is drawn, the
// colour towards that direction.
fn feather_albedo_colour(wi: vec3f) -> vec3f {
    var sum = vec3f(0.0);
    if wi.z <= 0.0 {
        return sum;
    }
    let light = feather_light(wi);
    for (var k = 0u; k < waves.count.x; k++) {
        sum += waves.all[k].parts.xyz * feather_albedo(light, wave_of(k));
    }
    return sum;
}
