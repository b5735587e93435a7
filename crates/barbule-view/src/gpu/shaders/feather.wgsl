// A feather's BRDF from its tables alone, in single precision: docs/formats/brdf-tables.md, whose steps are named here.
// Its reference is `PlainBrdf` of barbule-appearance. Goes with waves.wgsl.
//
// Directions have length 1 in the barbule's frame (x across, y along, z up) and point away from it; angles are in rad,
// wavelengths in nm, values in 1/sr without the cosine. What does not depend on the wavelength is worked out once for a pair
// of directions (`feather_seen`), what does not depend on the pair once for an instance (`feather_draw`).

struct FeatherHeader {
    // Places along θ, φ and λ; sets of nodes, 1 or 2.
    sizes: vec4u,
    // First texels of the places along θ (with C), φ (with T) and λ, and of the slopes.
    starts: vec4u,
    // First texels of 1/Q, of rotations (with wings) and of the nodes; how many texels the nodes of a set are.
    more: vec4u,
    // Shapes have the cosine: 1; light from φ_i < 0 is the mirror image: 1; reciprocity: 0 none, 1 steeper, 2 mean;
    // polarization: 0 unpolarized, 1, 2.
    flags: vec4u,
    // −1/σ² of each Gaussian along the barbule; 0 of those that are not there.
    spreads: vec4f,
    // Bases over the height phase, µm; 1 − C₁ of the noise; how many Gaussians there are.
    noise: vec4f,
    // split_mix(seed), low and high word; of 65536 instances so many are achromatic.
    name: vec4u,
}

@group(1) @binding(0) var<uniform> feather: FeatherHeader;
// All numbers, one after another in rows of 2048 texels.
@group(1) @binding(1) var feather_numbers: texture_2d<f32>;
// The noise's base functions: two texels for each point.
@group(1) @binding(2) var feather_codes: texture_2d<i32>;

const FEATHER_NODE_TEXELS: u32 = 5u;
const FEATHER_INTERVALS_OF_Q: f32 = 4096.0;
const FEATHER_CODES_OF_BASE: u32 = 513u;

fn feather_texel(at: u32) -> vec4f {
    return textureLoad(feather_numbers, vec2i(i32(at & 2047u), i32(at >> 11u)), 0);
}

// Step 2 ------------------------------------------------------------------------------------------------------------

// A place on an axis: the one below and the share of the next.
struct FeatherPlace {
    below: u32,
    share: f32,
}

fn feather_find(first: u32, count: u32, at: f32) -> FeatherPlace {
    if count < 2u {
        return FeatherPlace(0u, 0.0);
    }
    var low = 0u;
    var high = count - 1u;
    while high - low > 1u {
        let middle = (low + high) / 2u;
        if feather_texel(first + middle).x <= at {
            low = middle;
        } else {
            high = middle;
        }
    }
    let place = feather_texel(first + low).x;
    let next = feather_texel(first + low + 1u).x;
    return FeatherPlace(low, clamp((at - place) / (next - place), 0.0, 1.0));
}

// A wavelength in the tables: its place, and the wave number 2π/λ in rad/µm.
struct FeatherWave {
    below: u32,
    share: f32,
    number: f32,
}

fn feather_wave(nm: f32) -> FeatherWave {
    let place = feather_find(feather.starts.z, feather.sizes.z, nm);
    return FeatherWave(place.below, place.share, 6283.185307179586 / nm);
}

// Steps 1 to 3 ------------------------------------------------------------------------------------------------------

// ω_i in its cell. Three corners count: the one below, the next along the axis of the larger share, the one above in both.
struct FeatherLight {
    // −1 where mirrored.
    sign: f32,
    tau: f32,
    // y_i and cosθ_i.
    along: vec2f,
    // The corners' nodes at the shortest wavelength, their C and their T.
    nodes: vec3u,
    c: vec3f,
    t: vec3f,
    // Larger and smaller share of θ and φ.
    shares: vec2f,
    // κ, g and 1/l of achromatic instances.
    slope: vec3f,
}

fn feather_tau(sine: f32, cosine: f32) -> f32 {
    return select((1.0 + sine) / cosine, cosine / (1.0 - sine), sine < 0.0);
}

fn feather_light(w: vec3f) -> FeatherLight {
    let cos_theta = length(w.xz);
    let sign = select(1.0, -1.0, feather.flags.y == 1u && w.x < 0.0);
    let sine = sign * w.x / cos_theta;
    let cosine = w.z / cos_theta;
    let theta = feather_find(feather.starts.x, feather.sizes.x, cos_theta);
    // 1 − cosφ without cancellation.
    let v = abs(sine) * sine / (1.0 + cosine);
    let phi = feather_find(feather.starts.y, feather.sizes.y, v);
    // Both sides are counted from the normal outwards.
    let is_outwards = feather_texel(feather.starts.y + phi.below).x >= 0.0;
    let near = select(phi.below + 1u, phi.below, is_outwards);
    let far = select(phi.below, phi.below + 1u, is_outwards);
    let phi_share = select(1.0 - phi.share, phi.share, is_outwards);
    let is_theta_first = theta.share >= phi_share;
    let rows = vec3u(theta.below, select(theta.below, theta.below + 1u, is_theta_first), theta.below + 1u);
    let columns = vec3u(near, select(far, near, is_theta_first), far);
    let cells = rows * feather.sizes.y + columns;
    let larger = max(theta.share, phi_share);
    let smaller = min(theta.share, phi_share);
    var light: FeatherLight;
    light.sign = sign;
    light.tau = feather_tau(sine, max(cosine, 1e-4));
    light.along = vec2f(w.y, cos_theta);
    light.nodes = cells * feather.sizes.z;
    light.shares = vec2f(larger, smaller);
    let c = feather.starts.x + rows;
    light.c = vec3f(feather_texel(c.x).y, feather_texel(c.y).y, feather_texel(c.z).y);
    let t = feather.starts.y + columns;
    light.t = vec3f(feather_texel(t.x).y, feather_texel(t.y).y, feather_texel(t.z).y);
    let at = feather.starts.w + cells;
    light.slope = (1.0 - larger) * feather_texel(at.x).xyz + (larger - smaller) * feather_texel(at.y).xyz
        + smaller * feather_texel(at.z).xyz;
    return light;
}

// The four nodes that count at a wavelength: their numbers, weights and corners. Of the tables' own wavelengths the last has
// the weight 0.
struct FeatherNodes {
    at: vec4u,
    weight: vec4f,
    corner: vec4u,
}

fn feather_nodes(light: FeatherLight, wave: FeatherWave) -> FeatherNodes {
    let below = light.nodes + wave.below;
    let up = select(0u, 1u, wave.share > 0.0);
    let is_first = wave.share >= light.shares.x;
    let is_second = wave.share >= light.shares.y;
    var nodes: FeatherNodes;
    nodes.at = vec4u(
        below.x,
        select(below.y, below.x + up, is_first),
        select(below.z, below.y + up, is_second),
        below.z + up,
    );
    nodes.corner = vec4u(0u, select(1u, 0u, is_first), select(2u, 1u, is_second), 2u);
    let a = max(wave.share, light.shares.x);
    let b = max(min(wave.share, light.shares.x), light.shares.y);
    let c = min(wave.share, light.shares.y);
    nodes.weight = vec4f(1.0 - a, a - b, b - c, c);
    return nodes;
}

// Steps 4 to 6 ------------------------------------------------------------------------------------------------------

// Light and eye together, in one order.
struct FeatherPair {
    light: FeatherLight,
    // τ_i τ_o, and at the three corners e, z and j.
    tau: f32,
    e: vec3f,
    z: vec3f,
    j: vec3f,
    // exp(−t²/σ²)/(Q z_o) of each Gaussian along the barbule.
    along: vec4f,
    // x and z of ω_i + ω_o.
    sum: vec2f,
    // Its slope on the side of the tables.
    facet: f32,
}

fn feather_along(light: vec2f, wo: vec3f, cos_o: f32) -> vec4f {
    let cosine = light.y * cos_o - light.x * wo.y;
    let sine = light.x * cos_o + wo.y * light.y;
    var t2 = 0.5 * (1.0 - cosine);
    if cosine > 0.0 {
        t2 = sine * sine / (2.0 + 2.0 * cosine);
    }
    let place = sqrt(min(light.y, 1.0)) * FEATHER_INTERVALS_OF_Q;
    let low = min(floor(place), FEATHER_INTERVALS_OF_Q - 1.0);
    let at = feather.more.x + u32(low);
    let inverse_q = mix(feather_texel(at), feather_texel(at + 1u), place - low);
    return exp(t2 * feather.spreads) * inverse_q / wo.z;
}

fn feather_pair(wi: vec3f, wo: vec3f) -> FeatherPair {
    var pair: FeatherPair;
    pair.light = feather_light(wi);
    let cos_o = length(wo.xz);
    let cosine = max(wo.z / cos_o, 1e-8);
    pair.tau = pair.light.tau * feather_tau(pair.light.sign * wo.x / cos_o, cosine);
    let t = pair.light.t;
    pair.e = inverseSqrt(t * t + pair.tau * pair.tau);
    let turned = 2.0 * (pair.tau * pair.e) * (t * pair.e);
    pair.z = pair.light.c * turned;
    pair.j = turned / cosine;
    pair.along = feather_along(pair.light.along, wo, cos_o);
    pair.sum = wi.xz + wo.xz;
    pair.facet = clamp(pair.light.sign * pair.sum.x / pair.sum.y, -1.0, 1.0);
    return pair;
}

// What the nodes of a set say together: P and S in rad⁻¹, numbers 12 to 15, and Σ H exp(−t²/σ²)/(Q z_o).
struct FeatherMixed {
    mean: f32,
    steady: f32,
    rest: vec4f,
    along: f32,
}

fn feather_mixed(pair: FeatherPair, nodes: FeatherNodes, which: u32) -> FeatherMixed {
    var mixed = FeatherMixed(0.0, 0.0, vec4f(0.0), 0.0);
    var halo = vec3f(0.0);
    for (var n = 0u; n < 4u; n++) {
        let weight = nodes.weight[n];
        if weight == 0.0 {
            continue;
        }
        let first = feather.more.z + which * feather.more.w + nodes.at[n] * FEATHER_NODE_TEXELS;
        let low = feather_texel(first);
        let middle = feather_texel(first + 1u);
        let high = feather_texel(first + 2u);
        let m2 = low.xyz;
        let r = vec3f(low.w, middle.xy);
        let m = vec3f(middle.zw, high.x);
        let strength = high.yzw;
        let corner = nodes.corner[n];
        let e = pair.e[corner];
        let z = pair.z[corner];
        let away = (pair.tau - m) * e;
        let q = m2 + r * away * away;
        let aligned = select(vec3f(1.0), (pair.tau + m) * e, feather.flags.x == 1u);
        let root = sqrt(z * z + m2 * (1.0 - z * z));
        let lobes = strength * aligned * z / (q * q * (z + root));
        mixed.mean += weight * pair.j[corner] * (lobes.x + lobes.y);
        mixed.steady += weight * strength.z / (q.z * q.z);
        mixed.rest += weight * feather_texel(first + 3u);
        if feather.noise.z > 1.0 {
            halo += weight * feather_texel(first + 4u).yzw;
        }
    }
    mixed.steady = min(mixed.steady, 1.0) * mixed.mean;
    mixed.along = (1.0 - halo.x - halo.y - halo.z) * pair.along.x + dot(halo, pair.along.yzw);
    return mixed;
}

// Step 7 ------------------------------------------------------------------------------------------------------------

// Whole numbers below 2⁶⁴ are two words, the low one first.

fn words_product(a: u32, b: u32) -> vec2u {
    let low = (a & 0xffffu) * (b & 0xffffu);
    let first = (a & 0xffffu) * (b >> 16u);
    let second = (a >> 16u) * (b & 0xffffu);
    let middle = (low >> 16u) + (first & 0xffffu) + (second & 0xffffu);
    let high = (a >> 16u) * (b >> 16u) + (first >> 16u) + (second >> 16u) + (middle >> 16u);
    return vec2u((low & 0xffffu) | (middle << 16u), high);
}

fn words_times(a: vec2u, b: vec2u) -> vec2u {
    let low = words_product(a.x, b.x);
    return vec2u(low.x, low.y + a.x * b.y + a.y * b.x);
}

fn words_plus(a: vec2u, b: vec2u) -> vec2u {
    let low = a.x + b.x;
    return vec2u(low, a.y + b.y + select(0u, 1u, low < a.x));
}

// Less than 32 bits down.
fn words_down(a: vec2u, bits: u32) -> vec2u {
    return vec2u((a.x >> bits) | (a.y << (32u - bits)), a.y >> bits);
}

// SplitMix64 (Steele, Lea & Flood 2014).
fn split_mix(state: vec2u) -> vec2u {
    var word = words_plus(state, vec2u(0x7f4a7c15u, 0x9e3779b9u));
    word = words_times(word ^ words_down(word, 30u), vec2u(0x1ce4e5b9u, 0xbf58476du));
    word = words_times(word ^ words_down(word, 27u), vec2u(0x133111ebu, 0x94d049bbu));
    return word ^ words_down(word, 31u);
}

// A barbule among others, or none: the smooth mean.
struct FeatherDraw {
    is_one: bool,
    // The share of what it is beside the mean that is seen.
    share: f32,
    is_achromatic: bool,
    // Factors E where x_i + x_o < 0, and where not.
    wings: vec2f,
    // B, and bases over the height phase, µm.
    base: f32,
    bases_um: f32,
    shift: i32,
    direction: i32,
    // Cosines and sines of both rotations.
    rotation: vec2f,
    own: vec2f,
}

fn feather_mean() -> FeatherDraw {
    return FeatherDraw(false, 0.0, false, vec2f(1.0), 0.0, 0.0, 0, 1, vec2f(1.0, 0.0), vec2f(1.0, 0.0));
}

fn feather_draw(instance: vec2u) -> FeatherDraw {
    let h = split_mix(feather.name.xy ^ split_mix(instance));
    let more = words_times(h, vec2u(0x7f4a7c15u, 0x9e3779b9u));
    let rotations = feather.more.y;
    var draw: FeatherDraw;
    draw.is_one = true;
    draw.share = 1.0;
    draw.is_achromatic = (more.y >> 16u) < feather.name.z;
    let below = feather_texel(rotations + ((h.x >> 8u) & 255u)).z;
    let above = feather_texel(rotations + (((h.x >> 28u) | (h.y << 4u)) & 255u)).z;
    draw.wings = vec2f(below, above);
    draw.base = f32(h.x & 127u) + f32((more.y >> 8u) & 255u) / 256.0;
    draw.bases_um = select(feather.noise.x, 0.0, draw.is_achromatic);
    draw.shift = i32((h.x >> 16u) & 1023u);
    draw.direction = select(1, -1, (h.y >> 31u) == 1u);
    draw.rotation = feather_texel(rotations + ((h.y >> 8u) & 1023u)).xy;
    draw.own = feather_texel(rotations + ((h.y >> 18u) & 1023u)).xy;
    return draw;
}

// q and q' before they are turned, at a point of two bases, the next of them with the share s.
fn feather_point(base: u32, s: f32, point: i32) -> vec4f {
    let j = u32(point & 1023);
    let at = 2u * (base * FEATHER_CODES_OF_BASE + (j & 511u));
    let first = textureLoad(feather_codes, vec2i(i32(at & 2047u), i32(at >> 11u)), 0);
    let next = textureLoad(feather_codes, vec2i(i32((at + 1u) & 2047u), i32((at + 1u) >> 11u)), 0);
    let numbers = mix(vec4f(first), vec4f(next), s);
    return select(numbers, numbers.zwxy, j >= 512u);
}

// q and q' of an instance at x = (x_i + x_o)/l and the height phase, rad/µm.
fn feather_noise(draw: FeatherDraw, x: f32, phase: f32) -> vec4f {
    let place = 512.0 * clamp(x, -512.0, 512.0) - 0.5;
    let t = place - floor(place);
    let k = i32(floor(place));
    let slice = min(draw.base + draw.bases_um * phase, 32768.0);
    let s = slice - floor(slice);
    let base = u32(floor(slice)) & 127u;
    let scale = inverseSqrt((1.0 - 2.0 * t * (1.0 - t) * feather.noise.y) * (1.0 - 2.0 * s * (1.0 - s)));
    let here = feather_point(base, s, draw.shift + draw.direction * k);
    let next = feather_point(base, s, draw.shift + draw.direction * (k + 1));
    let q = scale * mix(here, next, t);
    let c = vec2f(draw.rotation.x, draw.own.x);
    let sine = vec2f(draw.rotation.y, draw.own.y);
    let real = q.xz * c - q.yw * sine;
    let imaginary = q.xz * sine + q.yw * c;
    return vec4f(real.x, imaginary.x, real.y, imaginary.y);
}

// Step 8 ------------------------------------------------------------------------------------------------------------

fn feather_speckle(mean: f32, steady: f32, q: vec2f) -> f32 {
    let kept = min(steady, mean);
    let half = 0.5 * (mean - kept);
    let real = sqrt(half) * q.x + sqrt(kept);
    return real * real + half * q.y * q.y;
}

// Which polarization a set's values are of; 0 of both together.
fn feather_polarization(which: u32) -> u32 {
    return select(select(0u, which + 1u, feather.sizes.w == 2u), feather.flags.w, feather.flags.w != 0u);
}

// P of an instance, by P and S of the mean, polarization 1's part and what else the nodes hold.
fn feather_drawn(pair: FeatherPair, mixed: FeatherMixed, part: f32, kind: u32, wave: FeatherWave, draw: FeatherDraw) -> f32 {
    let inverse_length = select(mixed.rest.x, pair.light.slope.z, draw.is_achromatic);
    let q = feather_noise(draw, pair.sum.x * inverse_length, pair.sum.y * wave.number);
    let gamma = mixed.rest.y;
    let second = gamma * q.xy + sqrt(max(1.0 - gamma * gamma, 0.0)) * q.zw;
    var value = 0.0;
    if kind == 0u {
        let other = 1.0 - part;
        value = 0.5 * feather_speckle(2.0 * part * mixed.mean, 2.0 * part * mixed.steady, q.xy)
            + 0.5 * feather_speckle(2.0 * other * mixed.mean, 2.0 * other * mixed.steady, second);
    } else {
        value = feather_speckle(mixed.mean, mixed.steady, select(second, q.xy, kind == 1u));
    }
    let wing = select(draw.wings.y, draw.wings.x, pair.sum.x < 0.0);
    let slope = pair.light.slope;
    let steep = slope.x * pair.sum.x;
    let a = min(0.5 * steep * steep / pair.sum.y * mixed.rest.x, 1e6);
    return value * (1.0 + slope.y * (wing - 1.0) * a * a / (0.2 + 0.2 * a + 0.6 * a * a * a));
}

// f and s in one order of light and eye.
fn feather_one_way(pair: FeatherPair, wave: FeatherWave, draw: FeatherDraw) -> vec2f {
    let nodes = feather_nodes(pair.light, wave);
    var values = vec2f(0.0);
    for (var which = 0u; which < feather.sizes.w; which++) {
        var mixed = feather_mixed(pair, nodes, which);
        let part = clamp(mixed.rest.z + mixed.rest.w * pair.facet, 0.0, 1.0);
        let kind = feather_polarization(which);
        let own = select(select(2.0 - 2.0 * part, 2.0 * part, kind == 1u), 1.0, kind == 0u);
        mixed.mean *= own;
        mixed.steady *= own;
        var f = mixed.mean;
        if draw.is_one {
            f = mix(mixed.mean, feather_drawn(pair, mixed, part, kind, wave, draw), draw.share);
        }
        values += mixed.along * vec2f(f, mixed.steady);
    }
    return values / f32(feather.sizes.w);
}

// Step 9 ------------------------------------------------------------------------------------------------------------

// cosφ of the flatter direction from which on both tables are asked: of 80° and 85°.
const FEATHER_HORIZON = vec2f(0.17364818, 0.08715574);

// Light and eye as the tables take them: in the order given, exchanged, or both ways.
struct FeatherSeen {
    is_up: bool,
    is_both: bool,
    // How near to the horizon the flatter direction of tables of the steeper one is: share of the geometric mean of both orders.
    horizon: f32,
    there: FeatherPair,
    back: FeatherPair,
}

fn feather_seen(wi: vec3f, wo: vec3f) -> FeatherSeen {
    var seen: FeatherSeen;
    seen.is_up = wi.z > 0.0 && wo.z > 0.0;
    if !seen.is_up {
        return seen;
    }
    let own = abs(wi.x) * wo.z;
    let other = abs(wo.x) * wi.z;
    let is_steeper = other < own || (other == own && wo.z > wi.z);
    let is_alike = feather.flags.y == 1u;
    let is_by_steeper = feather.flags.z == 1u && is_alike;
    if is_by_steeper {
        let flatter = min(wi.z / length(wi.xz), wo.z / length(wo.xz));
        seen.horizon = saturate((FEATHER_HORIZON.x - flatter) / (FEATHER_HORIZON.x - FEATHER_HORIZON.y));
    }
    let is_turned = is_by_steeper && is_steeper;
    seen.there = feather_pair(select(wi, wo, is_turned), select(wo, wi, is_turned));
    seen.is_both = feather.flags.z == 2u || (feather.flags.z == 1u && !is_alike) || seen.horizon > 0.0;
    if seen.is_both {
        seen.back = feather_pair(select(wo, wi, is_turned), select(wi, wo, is_turned));
    }
    return seen;
}

// f of an instance (or of the mean) and s at a wavelength.
fn feather_values(seen: FeatherSeen, wave: FeatherWave, draw: FeatherDraw) -> vec2f {
    if !seen.is_up {
        return vec2f(0.0);
    }
    var values = feather_one_way(seen.there, wave, draw);
    if seen.is_both {
        let back = feather_one_way(seen.back, wave, draw);
        if seen.horizon > 0.0 {
            values = mix(values, sqrt(max(values, vec2f(0.0))) * sqrt(max(back, vec2f(0.0))), seen.horizon);
        } else {
            values = 0.5 * (values + back);
        }
    }
    return values;
}

// What is reflected of light from ω_i, of the smooth mean before step 9: ∫ f (z·ω_o) dω_o.
fn feather_albedo(light: FeatherLight, wave: FeatherWave) -> f32 {
    let nodes = feather_nodes(light, wave);
    var sum = 0.0;
    for (var which = 0u; which < feather.sizes.w; which++) {
        for (var n = 0u; n < 4u; n++) {
            if nodes.weight[n] > 0.0 {
                let first = feather.more.z + which * feather.more.w + nodes.at[n] * FEATHER_NODE_TEXELS;
                sum += nodes.weight[n] * feather_texel(first + 4u).x;
            }
        }
    }
    return sum / f32(feather.sizes.w);
}

// Colours -----------------------------------------------------------------------------------------------------------

// A wavelength of the picture, where the nanostructure is larger than the material's by a factor: it scatters longer waves the
// same way.
fn feather_wave_of(number: u32, size: f32) -> FeatherWave {
    let wave = waves.all[number];
    if size != 1.0 {
        return feather_wave(wave.place.z / size);
    }
    return FeatherWave(u32(wave.place.x), wave.place.y, wave.parts.w);
}

// Linear sRGB of f, 1/sr: a perfect white has 1/π in each channel.
fn feather_colour(wi: vec3f, wo: vec3f, draw: FeatherDraw, size: f32) -> vec3f {
    let seen = feather_seen(wi, wo);
    var sum = vec3f(0.0);
    if !seen.is_up {
        return sum;
    }
    for (var k = 0u; k < waves.count.x; k++) {
        sum += waves.all[k].parts.xyz * feather_values(seen, feather_wave_of(k, size), draw).x;
    }
    return sum;
}

// Linear sRGB of all that is reflected of light from ω_i: by reciprocity, the colour towards ω_i under an even sky.
fn feather_albedo_colour(wi: vec3f, size: f32) -> vec3f {
    var sum = vec3f(0.0);
    if wi.z <= 0.0 {
        return sum;
    }
    let light = feather_light(wi);
    for (var k = 0u; k < waves.count.x; k++) {
        sum += waves.all[k].parts.xyz * feather_albedo(light, feather_wave_of(k, size));
    }
    return sum;
}
