"""f, s and the density of ω_o from a `.barbule` file, written after docs/formats/material.md; standard library only.

    barbule brdf starling --wavelength 520 --wi 0,30 --wo 0,-30 --instance 7 --json | python3 brdf.py starling.barbule

reads documents of `barbule brdf --json`, one a line, and prints their f, s and pdf (not of separate polarizations)."""
import json, sys
from array import array
from functools import lru_cache
from statistics import NormalDist
from math import acos, asin, atan, copysign, cos, cosh, erf, exp, floor, log, pi, radians, sin, sinh, sqrt, tanh

N, BASES, WORD = 1024, 128, 2**64 - 1  # points and number of the noise's base functions
clamp = lambda v, low, high: min(max(v, low), high)
signed, share = (lambda k: max((k - 32768) / 32767, -1)), (lambda k: k / 65535)
MAPS = {"m": lambda k: 0.001 ** (1 - share(k)), "phi": lambda k: signed(k) * pi / 2 * (1 - 1e-7), "rho": lambda k: share(k) ** 2,
        "length": lambda k: 64 ** signed(k), "fraction_1": share, "fraction_1_slope": lambda k: 4 * signed(k), "share": share, "correlation": share}
STEPS = [k / 10 for k in range(-30, 31)]  # of tanh-sinh quadrature
TANH_SINH = [(0.5 + 0.5 * tanh(pi / 2 * sinh(k)), pi / 40 * cosh(k) / cosh(pi / 2 * sinh(k)) ** 2) for k in STEPS]  # on [0, 1]
integral = lambda f, a, b: (b - a) * sum(w * f(a + (b - a) * u) for u, w in TANH_SINH)
data = open(sys.argv[1], "rb").read()
header = json.loads(data[8:(start := 8 + int.from_bytes(data[:8], "little"))])
about = json.loads(header.pop("__metadata__")["barbule"])
assert about["schema"] == 5 and "m" in header
arrays = {name: array({"F64": "d", "F32": "f", "U16": "H"}[entry["dtype"]], data[slice(*(start + at for at in entry["data_offsets"]))])
          for name, entry in header.items()}
waves, cos_theta, cos_phi, power = (arrays[k] for k in ("wavelengths_nm", "cos_theta", "cos_phi", "noise_power"))
both, SIGMA, seed = about["sides"] == "both", about["sigma"], about["seed"]
height, achromatic = about.get("height_um", 0), about.get("achromatic", 0)
single = lambda v: array("f", [v])[0]
stored = lambda name, at, ending="": single(MAPS[name](arrays[name + ending][at]))
# The nodes: φ_i rises, and each axis has one more at grazing, with the lobes of its neighbour.
phi_i = [acos(c) for c in cos_phi] + [-acos(c) for c in cos_phi if both and c < 1 - 1e-12]
thetas, phis, order = len(cos_theta), len(phi_i), sorted(range(len(phi_i)), key=lambda p: phi_i[p])
columns = [order[0]] * both + order + [order[-1]]  # the stored φ_i of each
PHI = [-1] * both + [copysign(1 - cos(phi_i[p]), phi_i[p]) for p in order] + [1]

def find(places, at):  # the place below and the share of the next
    below = clamp(sum(place <= at for place in places), 1, max(len(places) - 1, 1)) - 1
    return below, clamp((at - places[below]) / (places[below + 1] - places[below]), 0, 1) if len(places) > 1 else 0.0

def knot(nm, c, cos_p):  # shares of the halo's Gaussians, then its power
    if "halo_sigma" not in arrays:
        return [1.0]
    (nms, cs, ps), n = (arrays["halo_" + k] for k in ("wavelengths_nm", "cos_theta", "cos_phi")), arrays["halo_index"][0]
    inside, (t, a), (p, b) = (lambda z: sqrt(1 - (1 - z * z) / n**2)), find(cs, c), find(ps, cos_p)
    sums, corners = [0.0] * (1 + len(arrays["halo_sigma"])), [(t + i, p + j, (a if i else 1 - a) * (b if j else 1 - b)) for i in (0, 1) for j in (0, 1)]
    for row, column, weight in corners:
        k, up = find(nms, nm * inside(cs[row] * ps[column]) / inside(c * cos_p)) if weight else (0, 0)
        for wave, part in (k, weight * (1 - up)), (k + 1, weight * up):
            if part:
                at = (wave * len(cs) + row) * len(ps) + column
                values = *arrays["halo_shares"][at :: len(nms) * len(cs) * len(ps)], arrays["halo_power"][at]
                sums = [sum + part * value for sum, value in zip(sums, values)]
    return sums

def profile(m2, sine, cosine, half, z):  # a lobe of strength 1; half: sin and cos of φ_o/2
    q = m2 + (1 - m2) * (half[0] * cosine + half[1] * sine) ** 2
    along = half[1] * cosine + half[0] * sine if about["kind"] == "marginal" else 1
    return along * z / (q**2 * (z + sqrt(z * z + m2 * (1 - z * z))))

def area(m2, phi, cosine_i):  # ∫ profile dφ_o, flat in s with h = a s/√(1 − s²)
    a = sqrt(m2 / max(1 - m2, 1e-12))
    def term(s):
        h = clamp(a * s / sqrt(1 - s * s), -1, 1)
        half = asin(h) - phi / 2  # φ_o/2
        value = profile(m2, sin(phi / 2), cos(phi / 2), (sin(half), cos(half)), max(cosine_i * cos(2 * half), 0))
        return value * 2 * a / ((1 - s * s) ** 1.5 * max(sqrt(1 - h * h), 1e-9))
    first, last = ((h := sin((end + phi) / 2)) / sqrt(a * a + h * h) for end in (-pi / 2, pi / 2))
    return integral(term, (middle := clamp(0, first, last)), last) - integral(term, middle, first)

student = lambda t: (t / (1 + t * t) + atan(t)) / pi  # ∫₀^t 2/(π (1 + s²)²) ds
continued = lambda here, beside, c, c_beside: max(here - (beside - here) * c / (c_beside - c), 0) / here if here > 0 else 1

@lru_cache(None)
def lengths(direction):  # l of achromatic instances: the geometric mean over the wavelengths
    logs = [log(stored("length", wave * thetas * phis + direction)) for wave in range(len(waves))]
    return single(exp(sum(logs) / len(logs)))

def chromatic(measured, common):  # l of the others
    rest = (exp(-1) - achromatic * exp(-((measured / common) ** 2))) / (1 - achromatic)
    return measured / sqrt(-log(clamp(rest, 0.05, 0.8))) if achromatic else measured

@lru_cache(None)
def node(t, p, wave):  # m², sin and cos of φ_eff/2, strength, density and chance of lobes; what else there is
    index = lambda t, p: (wave * thetas + max(t - 1, 0)) * phis + columns[p]
    bare = lambda t, p: sum(stored("rho", index(t, p), ending) for ending in ("", "_2")[:1 + ("rho_2" in arrays)])
    power = lambda t, p: min(knot(waves[wave], cos_theta[max(t - 1, 0)], cos(phi_i[columns[p]]))[-1], 1 / max(bare(t, p), 1e-30))
    rho = lambda t, p: bare(t, p) * power(t, p)
    at, here, factor, lobes = index(t, p), rho(t, p), 1.0, []
    if t == 0 and thetas > 1:
        factor *= continued(here, rho(2, p), *cos_theta[:2])
    if (p == len(columns) - 1 or both and p == 0) and phis > 1:
        beside = p - 2 if p else 2
        factor *= continued(here, rho(t, beside), cos(phi_i[columns[p]]), cos(phi_i[columns[beside]]))
    factor = min(factor, 1 / here) if here > 0 else 1.0
    extras = 1 / chromatic(stored("length", at), lengths(at % (thetas * phis))), stored("correlation", at), stored("fraction_1", at), stored("fraction_1_slope", at)
    for ending in ("", "_2"):
        there = "m" + ending in arrays
        m, phi, energy = (stored(name, at, ending) if there else none for name, none in (("m", 1.0), ("phi", 0.0), ("rho", 0.0)))
        phi = clamp(phi, 1e-4 - pi / 2, pi / 2 - 1e-4)
        energy *= power(t, p)
        strength = factor * energy / area(m * m, phi, cos_theta[max(t - 1, 0)])
        rest, chance = sqrt(max(1 - m * m, 1e-12)), max(energy, 1e-9) * max(factor, 1e-3)
        inside = student(sin(pi / 4 + phi / 2) * rest / m) + student(sin(pi / 4 - phi / 2) * rest / m)
        lobes.append([*map(single, (m * m, sin(phi / 2), cos(phi / 2), strength)), chance * m**3 * rest / (pi * inside), chance])
    m, phi, share = (clamp(stored(name, at, "_sta"), 1e-4 - pi / 2, pi / 2 - 1e-4) for name in ("m", "phi", "share"))
    lobes.append([*map(single, (m * m, sin(phi / 2), cos(phi / 2), share * m**4))])
    return lobes, [*map(single, extras)]

def simplex(theta, phi, nm):  # (weight, t, p, wave) of the nodes that are mixed; φ on the side of the tables
    (t, a), (p, b), (wave, c) = find([0, *cos_theta], cos(theta)), find(PHI, copysign(1 - cos(phi), phi)), find(waves, nm)
    p, outwards, b = (p + 1, p, 1 - b) if PHI[p] < 0 else (p, p + 1, b)
    steps, corner = sorted([(a, 0, t + 1), (b, 1, outwards), (c, 2, wave + 1)], reverse=True), [t, p, wave]
    for (share, axis, place), above in zip([(1, 0, t), *steps], [*(step[0] for step in steps), 0]):
        corner[axis] = place
        if share > above:
            yield single(share - above), *corner

def slopes(theta, phi):  # κ, g and 1/l of achromatic instances
    (t, a), (p, b) = find([0, *cos_theta], cos(theta)), find(PHI, copysign(1 - cos(phi), phi))
    p, outwards, b = (p + 1, p, 1 - b) if PHI[p] < 0 else (p, p + 1, b)
    weights = (1 - max(a, b), t, p), (abs(a - b), *((t + 1, p) if a >= b else (t, outwards))), (min(a, b), t + 1, outwards)
    stored = lambda name, row, p: arrays[name][max(row - 1, 0) * phis + columns[p]]
    common = lambda row, p: 1 / lengths(max(row - 1, 0) * phis + columns[p])
    mixed = [sum(w * stored(name, row, p) for w, row, p in weights) for name in ("steepness", "strength")]
    return [*mixed, sum(w * common(row, p) for w, row, p in weights)]

def mixed(nodes, phi, phi_o):  # P of mean and steady part, density of φ_o, its weight, extras
    sums = [0.0] * 8
    for weight, t, p, wave in nodes:
        lobes, extras = node(t, p, wave)
        phi_n, cosine_n = phi_i[columns[p]], cos_theta[max(t - 1, 0)]
        level, shift = 1 - sin(phi) * sin(phi_n), sin(phi) - sin(phi_n)
        stretch = cos(phi) * cos(phi_n) / (level + shift * sin(phi_o))
        sine, cosine = (level * sin(phi_o) + shift) / (level + shift * sin(phi_o)), cos(phi_o) * stretch
        half = sine / sqrt(2 + 2 * cosine), sqrt(0.5 + 0.5 * cosine)
        one, two = (lobe[3] * profile(*lobe[:3], half, cosine_n * cosine) for lobe in lobes[:2])
        h2 = [(half[0] * c + half[1] * s) ** 2 for _, s, c, *_ in lobes]
        steady = lobes[2][3] / (lobes[2][0] + (1 - lobes[2][0]) * h2[2]) ** 2
        drawn = sum(d * sqrt(1 - h) / (m2 + (1 - m2) * h) ** 2 for (m2, *_, d, _), h in zip(lobes[:2], h2))
        parts = stretch * (one + two), steady, stretch * drawn, lobes[0][5] + lobes[1][5], *extras
        sums = [total + weight * part for total, part in zip(sums, parts)]
    return [sums[0], sums[0] * min(sums[1], 1), *sums[2:]]

def along(nodes, theta, t2):  # E/Q of all Gaussians, and their density over cosθ_o
    sums, halos = [0.0, 0.0], [knot(waves[wave], [0, *cos_theta][t], 1 - abs(PHI[p]))[:-1] for _, t, p, wave in nodes]
    for k, sigma in enumerate([SIGMA, *arrays.get("halo_sigma", [])]):
        own = exp(-t2 / sigma**2) * sum(node[0] * single(halo[k - 1] if k else 1 - sum(halo)) for node, halo in zip(nodes, halos))
        ends = erf(cos(pi / 4 - theta / 2) / sigma) + erf(sin(pi / 4 - theta / 2) / sigma)
        sums = [sums[0] + own / spread(theta, sigma), sums[1] + own * sqrt(1 - t2) / (sigma * sqrt(pi) * ends)]
    return sums

@lru_cache(None)
def spread(theta, sigma):  # Q = ∫ exp(−sin²((θ_i + θ_o)/2)/σ²) cosθ_o dθ_o
    reach = 2 * asin(min(7 * sigma, 1))
    term = lambda angle: exp(-((sin(angle / 2) / sigma) ** 2)) * cos(angle - theta)
    return integral(term, 0, min(pi / 2 + theta, reach)) - integral(term, 0, max(theta - pi / 2, -reach))

def split_mix(v):  # SplitMix64
    v = v + 0x9E3779B97F4A7C15 & WORD
    v = (v ^ v >> 30) * 0xBF58476D1CE4E5B9 & WORD
    v = (v ^ v >> 27) * 0x94D049BB133111EB & WORD
    return v ^ v >> 31

def units(state):  # PCG XSL RR 128/64 (MCG)
    while True:
        state = state * 0x2360ED051FC65DA44385DF649FCCF645 & 2**128 - 1
        word, turn = (state >> 64 ^ state) & WORD, state >> 122
        yield (((word >> turn | word << 64 - turn) & WORD) >> 11) * 2.0**-53

TURNS = [complex(cos(2 * pi * k / N), sin(2 * pi * k / N)) for k in range(N // 2)]
butterfly = lambda even, odd: [e + o for e, o in zip(even, odd)] + [e - o for e, o in zip(even, odd)]
turned = lambda c: [v * w for v, w in zip(c, TURNS[::N // 2 // len(c)])]
transform = lambda c: butterfly(transform(c[::2]), turned(transform(c[1::2]))) if len(c) > 1 else c
chained = lambda name, word: split_mix(name ^ split_mix(word))
C1 = 2 * sum(p * cos(2 * pi * l / N) for l, p in enumerate(power, 1))

@lru_cache(None)
def bases():
    rows, correlation = [], 0.0
    for base in range(BASES):
        name, terms = chained(chained(split_mix(seed), 0x6E6F697365), base), [0j] * N
        u = units(split_mix(name) << 64 | name | 1)
        normal = lambda: sqrt(-2 * log(1 - next(u))) * cos(2 * pi * next(u))
        for l, p in enumerate(power, 1):
            terms[l], terms[-l] = complex(normal(), normal()) * sqrt(p), complex(normal(), normal()) * sqrt(p)
        rows.append(array("f", [part for c in transform(terms) for part in (c.real, c.imag)]))
        beside = [] if base == 0 else [rows[base - 1], rows[0]] if base == BASES - 1 else [rows[base - 1]]
        own = sum(v * w for row in beside for v, w in zip(row, rows[base]))
        if correlation * own > 0:
            rows[base], own = array("f", [-v for v in rows[base]]), -own
        correlation += own
    scale = single(32767 / max(max(map(abs, row)) for row in rows))
    rows = [[floor(abs(v) + 0.5) * (1 if v > 0 else -1) for v in array("f", [v * scale for v in row])] for row in rows]
    step = sqrt(2 * N * BASES / sum(v * v for row in rows for v in row))
    return step, [[complex(*c) for c in zip(row[::2], row[1::2])] for row in rows]

is_achromatic = lambda bits: (bits * 0x9E3779B97F4A7C15 & WORD) >> 48 < 65536 * achromatic

def noise(bits, own, x, phase):  # q_r + j q_i of what polarizations share, or of what the second has beside it
    step, rows = bases()
    angle, first = 2 * pi * ((bits >> (50 if own else 40)) % 1024 + 0.5) / 1024, bits % BASES
    first += ((bits * 0x9E3779B97F4A7C15 & WORD) >> 40) % 256 / 256 + (0 if is_achromatic(bits) else single(height / 1.5175) * phase)
    b, s = int(min(first, 32768)), min(first, 32768) % 1
    base = [(1 - s) * this + s * after for this, after in zip(rows[b % BASES], rows[(b + 1) % BASES])]
    shift, way = (bits >> 16) + own * N // 2, -1 if bits >> 63 else 1
    k, t, turn = floor(x * N / 2 - 0.5), (x * N / 2 - 0.5) % 1, complex(single(step * cos(angle)), single(step * sin(angle)))
    near, far = (base[(shift + way * n) % N] for n in (k, k + 1))
    return ((1 - t) * near + t * far) / sqrt((1 - 2 * t * (1 - t) * (1 - C1)) * (1 - 2 * s * (1 - s))) * turn

@lru_cache(None)
def wings():  # values of E
    values = [exp(1.16 * NormalDist().inv_cdf((k + 0.5) / 256)) for k in range(256)]
    return [single(256 * value / sum(values)) for value in values]

def factor(instance, steepness, strength, inverse_length, x, z):  # τ
    a = min(steepness**2 * x * x / (2 * z) * inverse_length, 1e6)
    own = wings()[chained(split_mix(seed), instance) >> (28 if x >= 0 else 8) & 255]
    return 1 + strength * a * a / (0.2 + 0.2 * a + 0.6 * a**3) * (own - 1)

def speckled(mean, steady, instance, x, phase, gamma, part, polarization):
    name = chained(split_mix(seed), instance)
    first = noise(name, 0, x, phase)
    second = gamma * first + sqrt(max(1 - gamma * gamma, 0)) * noise(name, 1, x, phase)
    of = lambda f, s, q: abs(sqrt((f - min(s, f)) / 2) * q + sqrt(min(s, f))) ** 2
    parts = {"1": [(1, first)], "2": [(1, second)], "mean": [(part, first), (1 - part, second)]}
    return sum(of(mean * a, steady * a, q) for a, q in parts[polarization])

for asked in map(json.loads, sys.stdin):
    theta, phi, polarization, found = radians(asked["theta_in_deg"]), radians(asked["phi_in_deg"]), asked["polarization"], []
    side = -1 if phi < 0 and not both else 1
    azimuth = clamp(side * phi, -acos(1e-4), acos(1e-4))
    for nm in asked["wavelength_nm"]:
        nodes = list(simplex(theta, azimuth, nm))
        for theta_o, phi_o in zip(map(radians, asked["theta_out_deg"]), map(radians, asked["phi_out_deg"])):
            t2, x = sin((theta + theta_o) / 2) ** 2, cos(theta) * sin(phi) + cos(theta_o) * sin(phi_o)
            f, s, drawn, weight, inverse_length, gamma, *first = mixed(nodes, azimuth, side * phi_o)
            z = cos(theta) * cos(phi) + cos(theta_o) * cos(phi_o)
            part = clamp(first[0] + first[1] * clamp(side * x / z, -1, 1), 0, 1)
            f, s = (v * {"mean": 1, "1": 2 * part, "2": 2 - 2 * part}[polarization] for v in (f, s))
            if asked["instance"] is not None:
                steepness, strength, common = slopes(theta, azimuth)
                place = x * (common if is_achromatic(chained(split_mix(seed), asked["instance"])) else inverse_length)
                f = speckled(f, s, asked["instance"], place, 2000 * pi / nm * z, gamma, part, polarization)
                f *= factor(asked["instance"], steepness, strength, inverse_length, x, z)
            value, density = along(nodes, theta, t2)
            value /= cos(theta_o) * cos(phi_o)
            found.append((value * f, value * s, density / cos(theta_o) * drawn / weight))
    rows = [found[r:r + len(asked["phi_out_deg"])] for r in range(0, len(found), len(asked["phi_out_deg"]))]
    print(json.dumps({name: [[values[k] for values in row] for row in rows] for k, name in enumerate(("f", "s", "pdf"))}))
