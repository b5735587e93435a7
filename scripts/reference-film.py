#!/usr/bin/env python3
"""Writes crates/barbule/tests/it/data/tmm.json: reflection and transmission of random stacks by the published tmm package.

Needs: pip install tmm==0.2.0. Run from the root of the repository: python3 scripts/reference-film.py
"""

import json
import pathlib

import numpy as np
import tmm

rng = np.random.default_rng(2026)


def pair(z):
    return [float(np.real(z)), float(np.imag(z))]


def case(indices, thickness, wavelength, degrees):
    d = [np.inf, *thickness, np.inf]
    th = np.radians(degrees)
    entry = {"n": [pair(n) for n in indices], "thickness_nm": list(map(float, thickness)), "wavelength_nm": wavelength,
             "angle_deg": degrees}
    for pol in "sp":
        result = tmm.coh_tmm(pol, list(map(complex, indices)), d, th, wavelength)
        # tmm's p amplitudes are of E: t_H = t_E n_exit / n_entry, and r has the sign of H already.
        t = result["t"] * (indices[-1] / indices[0] if pol == "p" else 1)
        entry[pol] = {"r": pair(result["r"]), "t": pair(t), "R": float(result["R"]), "T": float(result["T"]),
                      "A": [float(a) for a in tmm.absorp_in_each_layer(result)[1:-1]]}
    return entry


def stack(layers, lossy, entry=1.0):
    n = rng.uniform(1.2, 2.5, layers).astype(complex)
    if lossy:
        n += 1j * rng.uniform(0, 0.3, layers) * (rng.random(layers) < 0.5)
    last = rng.uniform(1.0, 2.0) + (0.2j * rng.random() if lossy else 0)
    return [entry, *n, last], rng.uniform(5, 300, layers)


cases = []
for layers in (0, 1, 2, 5, 12, 30):
    for lossy in (False, True):
        for degrees in (0.0, 27.3, 61.0, 85.0, 89.9):
            n, d = stack(layers, lossy)
            cases.append(case(n, d, float(rng.uniform(300, 830)), degrees))
for lossy in (False, True):  # total internal reflection at the exit and in thin layers
    for degrees in (45.0, 60.0, 75.0, 89.0):
        n, d = stack(4, lossy, entry=1.9)
        n[2], n[-1] = 1.3, 1.0
        cases.append(case(n, d * 0.5, float(rng.uniform(300, 830)), degrees))
for lossy in (False, True):  # 100 layers
    for degrees in (0.0, 50.0, 89.9):
        n, d = stack(100, lossy)
        if lossy:
            n[1:-1] = [complex(z.real, z.imag * 0.02) for z in n[1:-1]]
        cases.append(case(n, d, float(rng.uniform(300, 830)), degrees))

document = {
    "origin": f"tmm {tmm.__version__ if hasattr(tmm, '__version__') else '0.2.0'} (S. J. Byrnes, MIT licence) by scripts/reference-film.py; "
              "amplitudes of s are of E, of p of H",
    "cases": cases,
}
path = pathlib.Path("crates/barbule/tests/it/data/tmm.json")
path.write_text(json.dumps(document, separators=(",", ":")) + "\n")
print(len(cases), "cases,", path.stat().st_size, "bytes")
