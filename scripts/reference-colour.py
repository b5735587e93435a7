#!/usr/bin/env python3
"""Writes crates/barbule/data/cie.csv (the observer and illuminants) and crates/barbule/tests/data/colour.json
(colours that the colour-science package finds for known spectra).

Needs: pip install colour-science==0.4.7. Run from the root of the repository: python3 scripts/reference-colour.py
"""

import json
import pathlib

import colour
import numpy as np

nm = np.arange(360, 831)
cmfs = colour.MSDS_CMFS["CIE 1931 2 Degree Standard Observer"]
assert (cmfs.wavelengths == nm).all()


def illuminant(name):
    """The published table to 780 nm, above it the CIE's daylight basis functions; between rows linear, as CIE 15 says."""
    sd = colour.SDS_ILLUMINANTS[name]
    xy = colour.temperature.CCT_to_xy_CIE_D({"D50": 5000, "D65": 6500}[name] * 1.4388 / 1.4380)
    daylight = colour.sd_CIE_illuminant_D_series(xy)
    both = np.array([[w, daylight[w], sd[w]] for w in range(360, 781, 10)])
    print(name, "daylight series against the table:", np.abs(both[:, 1] - both[:, 2]).max())
    more = np.arange(790, 831, 10)
    at = np.append(sd.wavelengths, more)
    return np.interp(nm, at, np.append(sd.values, [daylight[w] for w in more]))


# Illuminant A is defined by a formula (CIE 15: a Planckian radiator of 2848 K with c2 = 1.435e-2 m K).
a = 100 * (560 / nm) ** 5 * (np.exp(1.435e7 / (2848 * 560)) - 1) / (np.exp(1.435e7 / (2848 * nm)) - 1)
d50, d65 = illuminant("D50"), illuminant("D65")
published_a = colour.SDS_ILLUMINANTS["A"]
print("A against its table:", np.abs(np.interp(published_a.wavelengths, nm, a) - published_a.values)[12:].max())
lines = [
    "# CIE 1931 2 degree standard observer at 1 nm; illuminants A (formula of CIE 15), D50, D65 (CIE tables, above 780 nm",
    "# the CIE daylight basis functions, linear between rows)",
    "# from the colour-science package " + colour.__version__ + " (tables of the CIE) by scripts/reference-colour.py",
    "nm,x,y,z,a,d50,d65",
]
for row in zip(nm, *cmfs.values.T, a, d50, d65):
    lines.append(",".join([str(row[0])] + [f"{v:.10g}" for v in row[1:]]))
pathlib.Path("crates/barbule/data/cie.csv").write_text("\n".join(lines) + "\n")

spectra = {
    "white": np.ones(nm.size),
    "grey": np.full(nm.size, 0.18),
    "blue": np.exp(-(((nm - 450) / 30.0) ** 2)),
    "green": 0.05 + 0.6 * np.exp(-(((nm - 530) / 25.0) ** 2)),
    "red": 1 / (1 + np.exp(-(nm - 610) / 8.0)),
    "magenta": 1 - 0.9 * np.exp(-(((nm - 540) / 50.0) ** 2)),
    "film": 0.5 + 0.5 * np.cos(2 * np.pi * 2 * 1.55 * 595 / nm),
}
sources = {"D65": d65, "D50": d50, "A": a, "E": np.ones(nm.size)}
cases = []
for name, values in spectra.items():
    # Given at 6 nm from 360 to 828 and at 830, so that both sides interpolate the same samples linearly.
    at = np.append(np.arange(360, 830, 6), 830)
    sampled = np.interp(at, nm, values)
    sd = colour.SpectralDistribution(np.interp(nm, at, sampled), nm)
    for source, power in sources.items():
        xyz = colour.sd_to_XYZ(sd, cmfs, colour.SpectralDistribution(power, nm), method="Integration") / 100
        case = {"spectrum": name, "illuminant": source, "nm": at.tolist(), "values": [round(float(v), 12) for v in sampled],
                "xyz": xyz.tolist(), "xy": colour.XYZ_to_xy(xyz).tolist()}
        if source == "D65":
            case["linear_srgb"] = colour.XYZ_to_sRGB(xyz, apply_cctf_encoding=False).tolist()
            case["srgb"] = colour.XYZ_to_sRGB(np.clip(xyz, 0, None)).tolist()
        cases.append(case)
document = {"origin": f"colour-science {colour.__version__} (BSD licence) by scripts/reference-colour.py", "cases": cases}
path = pathlib.Path("crates/barbule/tests/data/colour.json")
path.write_text(json.dumps(document, separators=(",", ":")) + "\n")
print(len(cases), "cases,", path.stat().st_size, "bytes")
