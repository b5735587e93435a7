"""f, s and the density of ω_o from a `.barbule` file, written after docs/formats/material.md; standard library only.

    barbule brdf starling --wavelength 520 --wi 0,30 --wo 0,-30 --instance 7 --json | python3 brdf.py starling.barbule

reads documents of `barbule brdf --json`, one a line, and prints their f, s and pdf as computed here. Refused: separate
polarizations, thinned materials, and bright cells next to grazing, which the program scales down."""
import json, sys
from array import array
from math import atan, cos, cosh, erf, exp, floor, hypot, log, pi, radians, sin, sinh, sqrt, tanh

N, BASES, WORD = 1024, 512, 2**64 - 1  # points and number of the noise's base functions
clamp = lambda v, low, high: min(max(v, low), high)
columns = lambda rows: [list(column) for column in zip(*rows)]
omega = lambda theta, phi: (cos(theta) * sin(phi), sin(theta), cos(theta) * cos(phi))
signed = lambda k: max((k - 32768) / 32767, -1)
MAPS = {"m": lambda k: 0.001 ** (1 - k / 65535), "rho": lambda k: (k / 65535) ** 2,
        "phi": lambda k: signed(k) * pi / 2 * (1 - 1e-7), "length": lambda k: 64 ** signed(k)}
TANH_SINH = [(0.5 + 0.5 * tanh(pi / 2 * sinh(k / 7)), pi / 28 * cosh(k / 7) / cosh(pi / 2 * sinh(k / 7)) ** 2)
             for k in range(-20, 21)]  # nodes and weights on [0, 1]
data = open(sys.argv[1], "rb").read()
header = json.loads(data[8:(start := 8 + int.from_bytes(data[:8], "little"))])
tensor = lambda name, kind: array(kind, data[slice(*(start + at for at in header[name]["data_offsets"]))])
about = json.loads(header["__metadata__"]["barbule"])
sigma, seed, power, nm_nodes = about["sigma"], about["seed"], tensor("noise_power", "d"), tensor("wavelengths_nm", "d")
cosines = tensor("cos_theta", "d"), tensor("cos_phi", "d")
thetas, phis = map(len, cosines)
assert "m" in header and all(abs(c - k / len(x)) < 1e-6 for x in cosines for k, c in enumerate(x, 1))
TURNS = [complex(cos(2 * pi * k / N), sin(2 * pi * k / N)) for k in range(N // 2)]
butterfly = lambda even, odd: [e + o for e, o in zip(even, odd)] + [e - o for e, o in zip(even, odd)]
turned = lambda c: [v * w for v, w in zip(c, TURNS[::N // 2 // len(c)])]
transform = lambda c: butterfly(transform(c[::2]), turned(transform(c[1::2]))) if len(c) > 1 else c
chained = lambda name, word: split_mix(name ^ split_mix(word))

def refine(v):  # monotone cubic through v, as many values to each interval as make 40 at least
    per, d = -(-40 // (len(v) - 1)), [b - a for a, b in zip(v, v[1:])]
    outer = lambda a, b, s: 0.0 if s * a <= 0 else 3 * a if a * b <= 0 and abs(s) > 3 * abs(a) else s
    inner = [2 * a * b / (a + b) if a * b > 0 else 0.0 for a, b in zip(d, d[1:])]
    g = [outer(d[0], d[1], 1.5 * d[0] - 0.5 * d[1]), *inner, outer(d[-1], d[-2], 1.5 * d[-1] - 0.5 * d[-2])]
    at = lambda k, t, u: v[k] * u * u * (1 + 2 * t) + v[k + 1] * t * t * (3 - 2 * t) + t * u * (g[k] * u - g[k + 1] * t)
    return [at(k, i / per, 1 - i / per) for k in range(len(d)) for i in range(per)] + [v[-1]]

def surface(name, wave, change, low, high, grazing=None):  # continued to cos = 0, on the fine grid [θ][φ]
    stored = array("f", map(MAPS[name.removesuffix("_sta")], tensor(name, "H")[wave * thetas * phis:][:thetas * phis]))
    rows = (change(stored[r:r + phis]) for r in range(0, thetas * phis, phis))
    rows = [refine([clamp(2 * v[0] - v[1], low, high) if grazing is None else grazing, *v]) for v in rows]
    rows = [[clamp(2 * a - b, low, high) for a, b in zip(*rows[:2])], *rows]
    return [[clamp(v, low, high) for v in row] for row in columns(map(refine, columns(rows)))]

def tilts(v):  # sinφ_eff/sinφ_i, continued to φ_i = 0
    v = [sin(phi) / sqrt(1 - (k / phis) ** 2) for k, phi in enumerate(v[:-1], 1)]
    return [*v, 2 * v[-1] - v[-2]]

def effective(wi, tilt):  # ω_eff
    cos_theta = hypot(wi[0], wi[2])
    sine = clamp(tilt * wi[0] / cos_theta, -0.9998, 0.9998)
    return cos_theta * sine, wi[1], cos_theta * sqrt(1 - sine * sine)

def lobe(m, incident, wo):  # f̂ of strength ρ (z·ω_eff)/J = 1, and the density of ω_o
    length = hypot(*(i + o for i, o in zip(incident, wo)))
    hx, hy, hz = ((i + o) / length for i, o in zip(incident, wo))
    z, a, d2 = wo[2], m / sqrt(max(1 - m * m, 1e-12)), exp(-((hy / sigma) ** 2)) / (sigma * sqrt(pi))
    d1 = m * m / (pi * (m * m + (1 - m * m) * hx * hx) ** 2)
    f = m / incident[2] * d1 * d2 / (z + sqrt(z * z + m * m * (1 - z * z)))
    t, d3 = sqrt(1 - hy * hy) / a, 1 / (a * (1 + (hx / a) ** 2) ** 2)
    return f, d2 / erf(1 / sigma) * d3 / (t / (1 + t * t) + atan(t)) * hz / (2 * length)

def reflected(m, incident):  # J/(z·ω_eff) = ∫ f̂ (z·ω_o) dω_o of that lobe, over y and sinφ_o, cut at D₁'s peak
    total, (x, y, z), cosine = 0.0, incident, hypot(incident[0], incident[2])
    peak = clamp(-x / cosine, -1, 1)
    for sine, width in [(end + (peak - end) * u, abs(peak - end) * w) for end in (-1, 1) for u, w in TANH_SINH]:
        spread = sigma * hypot(x + cosine * sine, z + cosine * sqrt(1 - sine * sine))
        for out in (k / 2 * spread - y for k in range(-9, 10)):
            c = sqrt(max(1 - out * out, 1e-12))
            total += width * spread / 2 * c * lobe(m, incident, (c * sine, out, c * sqrt(1 - sine * sine)))[0]
    return total

def layer(wave, near):  # m, tilt, strength of both lobes and 1/l, each [θ][φ]; strengths only about `near`
    found = []
    for end in ("", "_sta"):
        m = [[*map(exp, row)] for row in surface("m" + end, wave, lambda v: [*map(log, v)], log(0.001), 0)]
        tilt, rho = surface("phi" + end, wave, tilts, -10, 10, 1), surface("rho" + end, wave, list, 0, 1)
        def strength(theta, phi):
            (t, a), (p, b) = ((k * -(-40 // n), max(k / n, 1e-3)) for k, n in ((theta, thetas), (phi, phis)))
            if rho[t][p] == 0 or abs(a - near[0]) * thetas > 2 or abs(b - near[1]) * phis > 2:
                return 0.0
            assert rho[t][p] < 0.8, "next to grazing"
            return rho[t][p] / reflected(m[t][p], effective((a * sqrt(1 - b * b), sqrt(1 - a * a), a * b), tilt[t][p]))
        rows = [refine([strength(t, p) for p in range(phis + 1)]) for t in range(thetas + 1)]
        found += [m, tilt, columns(map(refine, columns(rows)))]
    return [*found, surface("length", wave, lambda v: [1 / l for l in v], 1 / 64, 64)]

def parameters(nm, near):  # linear in λ, bilinear in the cosines, from nodes in single precision
    mixed, wave = [0.0] * 7, sum(n <= nm for n in nm_nodes[1:-1])
    part = (nm - nm_nodes[wave]) / (nm_nodes[wave + 1] - nm_nodes[wave])
    for k, share in (wave, 1 - part), (wave + 1, part):
        for i, v in enumerate(layer(k, near) if share else []):
            y, x = near[0] * (len(v) - 1), near[1] * (len(v[0]) - 1)
            t, p = min(int(y), len(v) - 2), min(int(x), len(v[0]) - 2)
            a, b, c, d = array("f", v[t][p:p + 2] + v[t + 1][p:p + 2])
            low, high = a * (p + 1 - x) + b * (x - p), c * (p + 1 - x) + d * (x - p)
            mixed[i] += share * (low * (t + 1 - y) + high * (y - t))
    return mixed

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

def draw_bases():
    rows = []
    for base in range(BASES):
        name, terms = chained(chained(split_mix(seed), 0x6E6F697365), base), [0j] * N
        u = units(split_mix(name) << 64 | name | 1)
        normal = lambda: sqrt(-2 * log(1 - next(u))) * cos(2 * pi * next(u))
        for l, p in enumerate(power, 1):
            terms[l], terms[-l] = complex(normal(), normal()) * sqrt(p), complex(normal(), normal()) * sqrt(p)
        rows.append(array("f", [part for c in transform(terms) for part in (c.real, c.imag)]))
    scale = array("f", [32767 / max(max(map(abs, row)) for row in rows)])[0]
    rows = [[floor(abs(v) + 0.5) * (1 if v > 0 else -1) for v in array("f", [v * scale for v in row])] for row in rows]
    step = sqrt(2 * N * BASES / sum(v * v for row in rows for v in row))
    return [[step * complex(*c) for c in zip(row[::2], row[1::2])] for row in rows]

def noise(instance, x):  # q_r + j q_i
    bits = chained(split_mix(seed), instance)
    base, shift, way = BASE[bits % BASES], bits >> 16, -1 if bits >> 63 else 1
    k, t, angle = floor(x * N / 2 - 0.5), (x * N / 2 - 0.5) % 1, 2 * pi * ((bits >> 40) % 1024 + 0.5) / 1024
    near, far = (base[(shift + way * n) % N] for n in (k, k + 1))
    return ((1 - t) * near + t * far) / sqrt(1 - 2 * t * (1 - t) * (1 - C1)) * complex(cos(angle), sin(angle))

BASE, C1 = None, 2 * sum(p * TURNS[l].real for l, p in enumerate(power, 1))
for asked in map(json.loads, sys.stdin):
    theta, phi, found = radians(asked["theta_in_deg"]), radians(asked["phi_in_deg"]), []
    for nm, wi in ((nm, omega(theta, phi)) for nm in asked["wavelength_nm"]):
        m, tilt, strength, m_sta, tilt_sta, strength_sta, scale = parameters(nm, (cos(theta), cos(phi)))
        for wo in map(omega, map(radians, asked["theta_out_deg"]), map(radians, asked["phi_out_deg"])):
            f, pdf = lobe(m, effective(wi, tilt), wo)
            f, s = strength * f, min(strength_sta * lobe(m_sta, effective(wi, tilt_sta), wo)[0], strength * f)
            if asked["instance"] is not None:
                BASE = BASE or draw_bases()
                f = abs(sqrt((f - s) / 2) * noise(asked["instance"], (wi[0] + wo[0]) * scale) + sqrt(s)) ** 2
            found.append((f, s, pdf))
    rows = lambda v, count: [v[k:k + count] for k in range(0, len(v), count)]
    print(json.dumps({k: rows(v, len(asked["phi_out_deg"])) for k, v in zip(("f", "s", "pdf"), zip(*found))}))
