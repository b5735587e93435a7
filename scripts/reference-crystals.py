#!/usr/bin/env python3
"""Writes crates/barbule/tests/it/data/treams.json: what crystals of rods reflect, by the published treams package.

treams (Beutel, Fernandez-Corbaton & Rockstuhl 2024, Comput. Phys. Commun. 297, 109076; MIT licence) is a T-matrix
code of its own: cylindrical waves of either helicity, Ewald's lattice sums, plane-wave scattering matrices. Every case
is solved at two sizes; `error` is the largest change of any J, R or T between them.

Needs: pip install treams==0.4.7. Run from the root of the repository (20 minutes): python3 scripts/reference-crystals.py
"""

import importlib.metadata
import json
import pathlib
import warnings

import numpy as np
import treams
from treams.special import vpw_A

warnings.filterwarnings("ignore", message="'where' used without 'out'")  # treams sets what is left out itself

TOUCHING = 0.18 * 0.75**0.5

# Rods by layer, from the top: (x, depth, shells from the outermost: (diameter, medium)), µm. The last number says how
# many multipoles and plane waves to either side are taken, first and then.
CELLS = {
    "mallard": (0.2, [[(i % 2 * 0.1, 0.345 + 0.18 * i, [(0.13, "melanin")])] for i in range(6)], [(8, 10), (10, 13)]),
    "magpie": (
        0.18,
        [[(i % 2 * 0.09, 0.22 + TOUCHING * i, [(0.18, "melanin"), (0.09, "air")])] for i in range(3)],
        [(15, 17), (18, 20)],
    ),
    "peafowl": (
        0.16,
        [
            [(0.08, 0.15 + 0.095 * i, [(0.055, "air")]) if i % 2 else (0.0, 0.15 + 0.095 * i, [(0.12, "melanin")])]
            for i in range(11)
        ],
        [(8, 12), (10, 16)],
    ),
    "row of solid rods": (0.25, [[(0.0, 0.12, [(0.14, "melanin")])]], [(9, 9), (12, 12)]),
    "row of hollow rods": (0.22, [[(0.05, 0.16, [(0.17, "melanin"), (0.11, "air")])]], [(9, 9), (12, 12)]),
    "square holes": (0.22, [[(0.0, 0.16 + 0.22 * i, [(0.12, "air")])] for i in range(4)], [(8, 8), (10, 11)]),
    "long period": (0.62, [[(0.0, 0.2, [(0.2, "melanin")])], [(0.2, 0.45, [(0.16, "air")])]], [(10, 16), (13, 21)]),
    "irregular": (
        0.29,
        [
            [(0.03, 0.11, [(0.12, "melanin"), (0.05, "air")]), (0.21, 0.15, [(0.07, "air")])],
            [(0.15, 0.33, [(0.1, "melanin")])],
        ],
        [(8, 12), (10, 15)],
    ),
}

# λ (nm), θ_i, φ_i (degrees): normal, conical, steep, and where two orders leave crystals of such periods.
WAVES = [(500, 0, 0), (450, 20, 30), (600, -35, 55), (400, 60, -40), (330, 15, -75)]


def media(nm):
    """Relative permittivities."""
    melanin = complex(1.648 + 23700 / nm**2, 0.56 * np.exp(-nm / 270))
    return {"keratin": complex(1.532 + 5890 / nm**2) ** 2, "melanin": melanin**2, "air": 1 + 0j}


def turned(v):
    """From Barbule's axes (x across the rods, y along them, z up) to those of treams' stacks (rods along x)."""
    return np.array([-v[1], v[0], v[2]])


def polarizations(theta, phi):
    """e₁ and e₂ of a direction."""
    (st, ct), (sp, cp) = ((np.sin(a), np.cos(a)) for a in (theta, phi))
    return turned([-st * sp, ct, -st * cp]), turned([cp, 0, -sp])


def stack(period, layers, eps, k0, k_across, k_along, multipoles, orders):
    """Scattering matrices of layers under the flat surface, which is the origin, and the plane waves they are in."""
    host = treams.Material(eps["keratin"])
    basis = treams.PlaneWaveBasisByComp.default(
        [[k_along, k_across + 2 * np.pi * m / period] for m in range(-orders, orders + 1)]
    )

    def cylinder(shells):
        radii = [diameter / 2 for diameter, _ in reversed(shells)]
        materials = [treams.Material(eps[medium]) for _, medium in reversed(shells)]
        return treams.TMatrixC.cylinder(k_along, multipoles, k0, radii, [*materials, host])

    parts, below = [], None
    for rods in reversed(layers):
        depth = rods[0][1]
        cluster = treams.TMatrixC.cluster(
            [cylinder(shells) for _, _, shells in rods], [[x, depth - z, 0] for x, z, _ in rods]
        )
        lattice = treams.Lattice(period, "x"), treams.WaveVector([k_across, np.nan, k_along])
        array = treams.SMatrices.from_array(cluster.latticeinteraction.solve(*lattice), basis)
        if below is not None:
            parts.append(treams.SMatrices.propagation([0, 0, below - depth], basis, k0, host))
        parts.append(array)
        below = depth
    parts.append(treams.SMatrices.propagation([0, 0, below], basis, k0, host))
    parts.append(treams.SMatrices.interface(basis, k0, [host, treams.Material(1)]))
    return treams.SMatrices.stack(parts), basis


def solve(period, layers, nm, theta, phi, multipoles, orders):
    """m → J[out][in] of the propagating reflected orders, and the transmitted power by incident polarization."""
    eps, k0 = media(nm), 2 * np.pi / (nm * 1e-3)
    k_across, k_along = -k0 * np.cos(theta) * np.sin(phi), k0 * np.sin(theta)
    matrices, basis = stack(period, layers, eps, k0, k_across, k_along, multipoles, orders)
    kx, ky, helicity = basis.kx, basis.ky, basis.pol
    kz_above = np.sqrt(k0**2 - kx**2 - ky**2 + 0j)
    kz_below = np.sqrt(k0**2 * eps["keratin"] - kx**2 - ky**2)
    number = np.rint((ky - k_across) * period / (2 * np.pi)).astype(int)

    def field(amplitudes, kz, m):
        waves = [vpw_A(kx[i], ky[i], kz[i], 0.0, 0.0, 0.0, helicity[i]) for i in np.flatnonzero(number == m)]
        return amplitudes[number == m] @ np.array(waves).reshape(-1, 3)

    zeroth = np.flatnonzero(number == 0)
    units = np.array([vpw_A(kx[i], ky[i], -kz_above[i], 0.0, 0.0, 0.0, helicity[i]) for i in zeroth]).reshape(-1, 3)
    jones, transmitted = {}, []
    for q, e in enumerate(polarizations(theta, phi)):
        incident = np.zeros(len(kx), complex)
        incident[zeroth] = np.linalg.lstsq(units.T, e.astype(complex), rcond=None)[0]
        up, down = np.array(matrices[0, 1]) @ incident, np.array(matrices[1, 1]) @ incident
        for m in range(-orders, orders + 1):
            sine = m * nm * 1e-3 / (period * np.cos(theta)) - np.sin(phi)
            if abs(sine) < 1:
                o1, o2 = polarizations(-theta, np.arcsin(sine))
                e_up = field(up, kz_above, m)
                column = jones.setdefault(m, np.zeros((2, 2), complex))
                column[:, q] = e_up @ o1, e_up @ o2
        power = 0.0
        for m in range(-orders, orders + 1):
            kz = kz_below[number == m][0]
            if kz.imag == 0:
                e_down = field(down, -kz_below, m)
                power += np.vdot(e_down, e_down).real * kz.real / (k0 * np.cos(theta) * np.cos(phi))
        transmitted.append(power)
    return jones, np.array(transmitted)


def pairs(matrix):
    return [[[float(z.real), float(z.imag)] for z in row] for row in matrix]


def case(name, period, layers, sizes, nm, theta_deg, phi_deg):
    theta, phi = np.radians(theta_deg), np.radians(phi_deg)
    (rough, t_rough), (jones, t) = (solve(period, layers, nm, theta, phi, *size) for size in sizes)
    error = max(np.abs(t - t_rough).max(), *(np.abs(jones[m] - rough[m]).max() for m in jones))
    eps = media(nm)
    entry = {"cell": name, "wavelength_nm": nm, "theta_deg": theta_deg, "phi_deg": phi_deg}
    entry |= {medium: [eps[medium].real, eps[medium].imag] for medium in ("keratin", "melanin")}
    entry |= {"orders": [{"m": m, "J": pairs(jones[m])} for m in sorted(jones)], "transmitted": list(map(float, t))}
    print(f"{name} {nm} {theta_deg} {phi_deg}: {len(jones)} orders, error {error:.1e}", flush=True)
    return entry | {"error": float(f"{error:.1e}")}


cells, cases = {}, []
for name, (period, layers, sizes) in CELLS.items():
    rods = [{"x_um": x, "depth_um": z, "shells": shells} for layer in layers for x, z, shells in layer]
    cells[name] = {"period_um": period, "rods": rods}
    cases += [case(name, period, layers, sizes, *wave) for wave in WAVES]

document = {
    "origin": f"treams {importlib.metadata.version('treams')} (MIT licence) by scripts/reference-crystals.py: rods in keratin under air; J as `barbule "
    "crystal` gives it, `transmitted` over incident power; `error` is the largest change from smaller expansions",
    "cells": cells,
    "cases": cases,
}
path = pathlib.Path("crates/barbule/tests/it/data/treams.json")
path.write_text(json.dumps(document, separators=(",", ":")) + "\n")
print(len(cases), "cases,", path.stat().st_size, "bytes")
