#!/usr/bin/env python3
"""Smooth spectra of the three primaries of sRGB for lights, as in Mallett & Yuksel 2019 (needs numpy).

Prints R and G at 380, 390 ... 720 nm (B is 1 - R - G): values in 0 ... 1 whose product with D65, cut to 380 ... 720 nm,
has exactly the colour of its primary; of all such the one with the least sum of squared differences between neighbours.
Run from the repository's root: python3 scripts/sky-primaries.py
"""
import numpy as np

rows = np.array([[float(v) for v in line.split(",")] for line in open("crates/barbule/data/cie.csv") if line[0].isdigit()])
nm = rows[:, 0]
rows = rows[(nm >= 380) & (nm <= 720)]
nm, matching, d65 = rows[:, 0], rows[:, 1:4], rows[:, 6] / 100
trapezoid = np.where((nm == 380) | (nm == 720), 0.5, 1.0)
to_rgb = np.array([
    [3.240969941904521, -1.537383177570093, -0.498610760293003],
    [-0.96924363628087, 1.87596750150772, 0.041555057407175],
    [0.055630079696993, -0.203976958888976, 1.056971514242878],
])
white = np.linalg.solve(to_rgb, np.ones(3))
weights = (trapezoid * d65)[:, None] * matching
weights = weights * (white / weights.sum(0))
knots = np.arange(380, 721, 10.0)
n = len(knots)
hat = np.maximum(0, 1 - np.abs(nm[:, None] - knots[None, :]) / 10)
colour = to_rgb @ (weights.T @ hat)  # 3 x n: linear sRGB of a reflectance given at the knots

# Unknowns: R and G at the knots. min ||D R||^2 + ||D G||^2 + ||D (R + G)||^2 under equalities and bounds, by ADMM.
difference = np.diff(np.eye(n), axis=0)
smooth = difference.T @ difference
P = np.block([[2 * smooth, smooth], [smooth, 2 * smooth]]) + 1e-9 * np.eye(2 * n)
zero = np.zeros_like(colour)
A = np.block([[colour, zero], [zero, colour]])
b = np.concatenate([np.eye(3)[0], np.eye(3)[1]])
C = np.vstack([np.eye(2 * n), np.hstack([np.eye(n), np.eye(n)])])  # R, G and R + G in 0 ... 1
rho = 0.3
K = np.block([[P + rho * C.T @ C, A.T], [A, np.zeros((6, 6))]])
z, u = np.zeros(3 * n), np.zeros(3 * n)
inverse = np.linalg.inv(K)
for _ in range(400_000):
    x = (inverse @ np.concatenate([rho * C.T @ (z - u), b]))[: 2 * n]
    z = np.clip(C @ x + u, 0, 1)
    u += C @ x - z
print("violation of the bounds", np.abs(C @ x - z).max())
x = np.clip(x, 0, 1).round(6)
for name, values in (("R", x[:n]), ("G", x[n:])):
    print(name, ", ".join(f"{v:.6f}" for v in values))
    print("colour", colour @ values)
print("least of B", (1 - x[:n] - x[n:]).min())
