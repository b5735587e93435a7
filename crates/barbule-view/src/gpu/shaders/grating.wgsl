// A diffraction grating over pigment, from its tables alone and in single precision: `GratingTables` of barbule-appearance
// says the formulas, and its `Grating` is the reference. Goes with waves.wgsl.
//
// Directions have length 1 and point away from the surface, whose normal is z; values are in 1/sr without the cosine.

struct GratingHeader {
    // Places on either side of frequency 0 along x and y; texels of a place's series; terms that are read.
    places: vec4u,
    // First texels of ρ and of the pigment; azimuths and cosines of ρ.
    starts: vec4u,
    // 1/step along x and y, µm; standard deviation of a place's Gaussian along x and y, in steps, 0 of tents.
    steps: vec4f,
    // 2/kappa_most, µm; scale, µm²; index; reach in standard deviations.
    optics: vec4f,
    // Of ρ: smallest cosθ, shortest wavelength and nm from one to the next; how many wavelengths.
    rho: vec4f,
    // What the boundary reflects of even light; the rest is unused.
    mean: vec4f,
}

@group(1) @binding(0) var<uniform> grating: GratingHeader;
// Series, ρ and pigment, one after another in rows of 2048 texels.
@group(1) @binding(1) var grating_numbers: texture_2d<f32>;

const GRATING_PI: f32 = 3.141592653589793;
// Shortest wavelength of the pigment, nm, and how many values, one per nm.
const GRATING_PIGMENT_NM: f32 = 300.0;
const GRATING_PIGMENT_VALUES: f32 = 531.0;
// Texels of a series at most.
const GRATING_QUADS: u32 = 16u;

fn grating_texel(at: u32) -> vec4f {
    return textureLoad(grating_numbers, vec2i(i32(at & 2047u), i32(at >> 11u)), 0);
}

// Fresnel's reflectance of unpolarized light.
fn grating_fresnel(cosine: f32) -> f32 {
    let index = grating.optics.z;
    let c = clamp(cosine, 0.0, 1.0);
    let t = sqrt(max(1.0 - (1.0 - c * c) / (index * index), 0.0));
    let s = (c - index * t) / (c + index * t);
    let p = (index * c - t) / (index * c + t);
    return 0.5 * (s * s + p * p);
}

// Light and eye together: what does not depend on the wavelength.
struct GratingSeen {
    is_up: bool,
    // ω_i + ω_o.
    sum: vec3f,
    // R Γ scale, and (1 − R)(1 − R)/π.
    mirrored: f32,
    through: f32,
    wi: vec3f,
    wo: vec3f,
}

fn grating_seen(wi: vec3f, wo: vec3f) -> GratingSeen {
    var seen: GratingSeen;
    seen.is_up = wi.z > 0.0 && wo.z > 0.0;
    if !seen.is_up {
        return seen;
    }
    seen.sum = wi + wo;
    seen.wi = wi;
    seen.wo = wo;
    let toward = 1.0 + dot(wi, wo);
    let gamma = toward * toward / (wi.z * wo.z * seen.sum.z * seen.sum.z);
    seen.mirrored = grating_fresnel(dot(wi, normalize(seen.sum))) * gamma * grating.optics.y;
    seen.through = (1.0 - grating_fresnel(wi.z)) * (1.0 - grating_fresnel(wo.z)) / GRATING_PI;
    return seen;
}

// ρ of a direction: what the orders make of all its light, between the table's values.
fn grating_rho(nm: f32, w: vec3f) -> f32 {
    let azimuths = grating.starts.z;
    let cosines = grating.starts.w;
    let lowest = grating.rho.x;
    let last = grating.rho.w - 1.0;
    let wave = clamp((nm - grating.rho.y) / grating.rho.z, 0.0, last);
    let wave_low = min(floor(wave), last - 1.0);
    let highest = f32(cosines - 1u);
    let cosine = clamp(sqrt((max(w.z, lowest) - lowest) / (1.0 - lowest)), 0.0, 1.0) * highest;
    let cosine_low = min(floor(cosine), highest - 1.0);
    let turn = fract(atan2(w.y, w.x) / (2.0 * GRATING_PI)) * f32(azimuths);
    let here = u32(floor(turn)) % azimuths;
    let next = (here + 1u) % azimuths;
    var sum = 0.0;
    for (var k = 0u; k < 4u; k++) {
        let up = vec2f(f32(k & 1u), f32(k >> 1u));
        let weights = mix(vec2f(1.0) - vec2f(wave - wave_low, cosine - cosine_low),
            vec2f(wave - wave_low, cosine - cosine_low), up);
        let row = (u32(wave_low + up.x) * cosines + u32(cosine_low + up.y)) * azimuths;
        let first = grating.starts.x + row;
        let value = mix(grating_texel(first + here).x, grating_texel(first + next).x, turn - floor(turn));
        sum += weights.x * weights.y * value;
    }
    return sum;
}

fn grating_pigment(nm: f32) -> f32 {
    let at = clamp(nm - GRATING_PIGMENT_NM, 0.0, GRATING_PIGMENT_VALUES - 1.0);
    let low = min(floor(at), GRATING_PIGMENT_VALUES - 2.0);
    let first = grating.starts.y + u32(low);
    return mix(grating_texel(first).x, grating_texel(first + 1u).x, at - low);
}

// The places about a frequency along an axis, as offsets from frequency 0, and where the frequency is among them.
struct GratingTaps {
    low: i32,
    high: i32,
    at: f32,
    // 1/deviation in places; 0 of tents.
    apart: f32,
}

fn grating_taps(at: f32, most: i32, deviation: f32) -> GratingTaps {
    var taps: GratingTaps;
    taps.at = at;
    if deviation > 0.0 {
        let reach = grating.optics.w * deviation;
        taps.low = max(i32(ceil(max(at - reach, -1e6))), -most);
        taps.high = min(i32(floor(min(at + reach, 1e6))), most);
        taps.apart = 1.0 / deviation;
    } else {
        let low = i32(floor(clamp(at, -1e6, 1e6)));
        taps.low = max(low, -most);
        taps.high = min(low + 1, most);
        taps.apart = 0.0;
    }
    return taps;
}

fn grating_weight(taps: GratingTaps, place: i32) -> f32 {
    let away = taps.at - f32(place);
    if taps.apart > 0.0 {
        return exp(-0.5 * away * away * taps.apart * taps.apart);
    }
    return max(1.0 - abs(away), 0.0);
}

// S: the orders' powers about a frequency, at x = 2κ/kappa_most + 1.
fn grating_power(f: vec2f, x: f32) -> f32 {
    let most = vec2i(grating.places.xy);
    let at = f * grating.steps.xy;
    let across = grating_taps(at.x, most.x, grating.steps.z);
    let along = grating_taps(at.y, most.y, grating.steps.w);
    let quads = min(grating.places.z, GRATING_QUADS);
    // T₀ … of four terms a place.
    var basis: array<vec4f, 16>;
    var before = x;
    var now = 1.0;
    for (var quad = 0u; quad < quads; quad++) {
        var four = vec4f(0.0);
        for (var k = 0u; k < 4u; k++) {
            four[k] = now;
            let next = 2.0 * x * now - before;
            before = now;
            now = next;
        }
        basis[quad] = four;
    }
    let columns = u32(2 * most.x + 1);
    var power = 0.0;
    for (var row = along.low; row <= along.high; row++) {
        let by_row = grating_weight(along, row);
        for (var column = across.low; column <= across.high; column++) {
            let place = u32(row + most.y) * columns + u32(column + most.x);
            let first = place * grating.places.z;
            var sum = 0.0;
            for (var quad = 0u; quad < quads; quad++) {
                sum += dot(grating_texel(first + quad), basis[quad]);
            }
            power += by_row * grating_weight(across, column) * sum;
        }
    }
    return max(power, 0.0);
}

// f at a wavelength, nm, with its wave number, rad/µm.
fn grating_value(seen: GratingSeen, nm: f32, number: f32) -> f32 {
    if !seen.is_up {
        return 0.0;
    }
    let um = 1e-3 * nm;
    let x = clamp(1.0 - number * seen.sum.z * grating.optics.x, -1.0, 1.0);
    let power = grating_power(-seen.sum.xy / um, x);
    let safe = max(1.0, max(grating_rho(nm, seen.wi), grating_rho(nm, seen.wo)));
    return seen.mirrored * power / (um * um * safe) + grating_pigment(nm) * seen.through;
}

// What is reflected of all light from ω_i at a wavelength, nm. Of the orders' light as if each were reflected as the mirror
// direction's is.
fn grating_albedo(w: vec3f, nm: f32) -> f32 {
    let mirrored = grating_fresnel(w.z);
    let orders = mirrored * min(grating_rho(nm, w), 1.0);
    return orders + (1.0 - mirrored) * (1.0 - grating.mean.x) * grating_pigment(nm);
}

// Linear sRGB of f, 1/sr: a perfect white has 1/π in each channel.
fn grating_colour(wi: vec3f, wo: vec3f) -> vec3f {
    let seen = grating_seen(wi, wo);
    var sum = vec3f(0.0);
    for (var k = 0u; k < waves.count.x; k++) {
        let wave = waves.all[k];
        sum += wave.parts.xyz * grating_value(seen, wave.place.z, wave.parts.w);
    }
    return sum;
}

// Linear sRGB of all that is reflected of light from ω_i.
fn grating_albedo_colour(w: vec3f) -> vec3f {
    var sum = vec3f(0.0);
    for (var k = 0u; k < waves.count.x; k++) {
        let wave = waves.all[k];
        sum += wave.parts.xyz * grating_albedo(w, wave.place.z);
    }
    return sum;
}
