// The wavelengths at which a picture is worked out, and what each gives of its colour.

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
