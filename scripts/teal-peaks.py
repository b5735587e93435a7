#!/usr/bin/env python3
"""Reads peak wavelengths from the twelve published colours of a teal's wing patch: the rows of examples/published/green-winged-teal.csv.

Usage: scripts/teal-peaks.py FILE.csv > rows.csv        (needs `pip install colour-science==0.4.7`)

A spectrum is taken to be a dark floor and one bell above it: three numbers of a colour give its place and its height. Which observer
was meant, whether whites were adapted, how high the floor is and how wide the bell is not known: every combination is tried, those
that give back the two printed peaks (517 nm and 56.4 % at 20°, 468 nm at 55°) within 6 nm and 4 % are kept, and the rows have the
median of their peaks with the lowest and the highest. Where half of them or fewer find a peak brighter than the floor, there is none.
"""

import csv
import sys
import warnings

warnings.filterwarnings("ignore")
import colour
import numpy

NM = numpy.arange(380.0, 701.0, 4.0)
SRGB = numpy.array([[3.2406, -1.5372, -0.4986], [-0.9689, 1.8758, 0.0415], [0.0557, -0.2040, 1.0570]])
OBSERVERS = ("CIE 1931 2 Degree Standard Observer", "CIE 1964 10 Degree Standard Observer")
FLOORS, HALF_WIDTHS_NM = (0.02, 0.03, 0.04), (33.0, 35.5, 38.0)
PEAKS_NM, HEIGHTS = numpy.arange(400.0, 560.0), numpy.linspace(0.004, 0.8, 200)
PRINTED = {20.0: (517.0, 0.564), 55.0: (468.0, 0.072)}
NEAR_NM, NEAR_LEVEL = 6.0, 0.04


def weights(observer, adapted):
    """Linear sRGB as sums over reflectances at NM."""
    curves, light = colour.MSDS_CMFS[observer], colour.SDS_ILLUMINANTS["D65"]
    matching = numpy.array([numpy.interp(NM, curves.wavelengths, curves.values[:, k], left=0, right=0) for k in range(3)])
    lit = matching * numpy.interp(NM, light.wavelengths, light.values)
    return SRGB @ (lit / (lit.sum(axis=1, keepdims=True) if adapted else lit[1].sum()))


def encoded(linear):
    """sRGB of linear values, 0 to 1, cut off."""
    linear = numpy.clip(linear, 0, 1)
    return numpy.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)


def read(srgb, rgb, floor, half_width):
    """Peak in nm and reflectance there of the bell whose colour is nearest to `srgb`."""
    bells = numpy.exp(-numpy.log(2) * ((NM - PEAKS_NM[:, None]) / half_width) ** 2)
    linear = (bells @ rgb.T)[:, None, :] * HEIGHTS[None, :, None] + floor * rgb.sum(axis=1)
    seen = numpy.array([int(srgb[k : k + 2], 16) / 255 for k in (0, 2, 4)])
    distance = ((encoded(linear) - seen) ** 2).sum(axis=2)
    peak, height = numpy.unravel_index(distance.argmin(), distance.shape)
    return PEAKS_NM[peak], HEIGHTS[height] + floor


def main():
    lines = [line for line in open(sys.argv[1], encoding="utf-8") if not line.startswith("#")]
    rows = [(float(row["angle_deg"]), row["srgb"]) for row in csv.DictReader(lines)]
    kept = []
    for observer in OBSERVERS:
        for adapted in (False, True):
            rgb = weights(observer, adapted)
            for floor in FLOORS:
                for half_width in HALF_WIDTHS_NM:
                    series = {angle: read(srgb, rgb, floor, half_width) + (floor,) for angle, srgb in rows}
                    near = lambda at: all(abs(series[at][k] - PRINTED[at][k]) <= (NEAR_NM, NEAR_LEVEL)[k] for k in (0, 1))
                    if all(near(at) for at in PRINTED):
                        kept.append(series)
    print(f"{len(kept)} combinations of {4 * len(FLOORS) * len(HALF_WIDTHS_NM)} give the printed peaks", file=sys.stderr)
    for angle, srgb in rows:
        peaks = sorted(series[angle][0] for series in kept if series[angle][1] > 1.5 * series[angle][2] and PEAKS_NM[0] < series[angle][0])
        if 2 * len(peaks) <= len(kept):
            print(f"{angle:g},{srgb},,,")
        else:
            print(f"{angle:g},{srgb},{peaks[len(peaks) // 2]:.0f},{peaks[0]:.0f},{peaks[-1]:.0f}")


if __name__ == "__main__":
    main()
