"""A coat of feathers: one feather of curves at 2,000 places of a bird's breast, as a scene for `barbule render`.

    barbule bench render --write-curves coat
    python3 examples/scenes/coat.py coat [--rows 50] [--columns 40]

writes coat/coat.toml beside the feather's curve files, which its objects name. Feathers stand in rows, each half a feather
aside of the row above, point down the breast, and lie over those below like shingles; bars of rows are pale and dark in
turn. Turns, sizes and lifts vary a little, by a seeded generator: the same numbers on every machine.
"""

import argparse
import math
import pathlib
import random

# The feather's curve files go from y = -1 (quill) to 11 (tip): so it is 10 mm long.
SCALE = 0.8
# Of the breast, mm: a spheroid about y.
RADIUS, HALF_LENGTH = 25.0, 43.0
# What the patch covers: degrees to both sides, and of the meridian.
ACROSS, ALONG = 62.0, (-52.0, 44.0)
# Rows of one bar.
BAR = 6
# Rise of a feather over the one below, degrees.
LIFT = 12.0

HEAD = """\
# A coat of {count} feathers by instancing, made by examples/scenes/coat.py.
preset = "starling"
shows_feather = false
exposure = "auto"
size = [800, 1000]
scatterings = 8
sky = 0.6
background = "sky"
lights = []

[light]
azimuth_deg = 60.0
elevation_deg = 30.0
radius_deg = 12.0
strength = 2.0

[camera]
azimuth_deg = 180.0
elevation_deg = 62.0
roll_deg = 0.0
width_mm = 50.0
lens = 0.0
target_mm = [0.0, -3.0, 21.0]

[surfaces.barbs]
type = "hair"
longitudinal_roughness = 0.5
azimuthal_roughness = 0.5
eumelanin = 0.2
pheomelanin = 0.1

[surfaces.pale]
type = "hair"
longitudinal_roughness = 0.5
azimuthal_roughness = 0.5
eumelanin = 0.2
pheomelanin = 0.2

[surfaces.dark]
type = "hair"
longitudinal_roughness = 0.5
azimuthal_roughness = 0.5
eumelanin = 3.0
pheomelanin = 1.0
"""


def places(rows, columns):
    """Rows of lines of `instances`."""
    draw = random.Random(7).uniform
    for row in range(rows):
        # From the tail up, though the order does not matter.
        meridian = math.radians(ALONG[0] + (ALONG[1] - ALONG[0]) * row / max(rows - 1, 1))
        yield [feather(row, column, columns, meridian, draw) for column in range(columns)]


def feather(row, column, columns, meridian, draw):
    """One of a row on this meridian, half a feather aside of those above."""
    at = (column + 0.5 * (row % 2) + draw(-0.15, 0.15)) / max(columns - 0.5, 1.0)
    return place(math.radians(ACROSS * (2.0 * at - 1.0)), meridian + draw(-0.004, 0.004), draw)


def place(side, meridian, draw):
    """One feather whose quill stands in the skin at these angles."""
    ring = RADIUS * math.cos(meridian)
    point = [ring * math.sin(side), HALF_LENGTH * math.sin(meridian), ring * math.cos(side)]
    normal = unit([point[0] / RADIUS**2, point[1] / HALF_LENGTH**2, point[2] / RADIUS**2])
    across = unit(cross(normal, [0.0, 1.0, 0.0]))
    down = cross(across, normal)
    down = [-v for v in down] if down[1] > 0.0 else down
    # Turned about the normal, then lifted off the skin.
    turn, lift = math.radians(draw(-7.0, 7.0)), math.radians(LIFT + draw(-1.5, 1.5))
    along = add(down, across, math.cos(turn), math.sin(turn))
    y = add(along, normal, math.cos(lift), math.sin(lift))
    z = add(normal, along, math.cos(lift), -math.sin(lift))
    x = cross(y, z)
    # Rows of the matrix with columns x, y, z as turns about x, then y, then z.
    about = [math.atan2(y[2], z[2]), -math.asin(max(-1.0, min(1.0, x[2]))), math.atan2(x[1], x[0])]
    numbers = lambda values: "[" + ", ".join(f"{value:.3f}" for value in values) + "]"
    degrees = [math.degrees(angle) for angle in about]
    scale = SCALE * draw(0.92, 1.08)
    return f"    {{ scale = {scale:.3f}, rotate_deg = {numbers(degrees)}, translate_mm = {numbers(point)} }},"


def add(a, b, s, t):
    return [s * p + t * q for p, q in zip(a, b)]


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def unit(a):
    length = math.sqrt(sum(v * v for v in a))
    return [v / length for v in a]


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("folder", type=pathlib.Path, help="where the curve files are")
    parser.add_argument("--rows", type=int, default=50)
    parser.add_argument("--columns", type=int, default=40)
    wanted = parser.parse_args()
    if min(wanted.rows, wanted.columns) < 1:
        parser.error("give at least one row and one column")
    if not (wanted.folder / "feather_barbules.txt").is_file():
        parser.error(f"{wanted.folder} has no feather; run: barbule bench render --write-curves {wanted.folder}")
    rows = list(places(wanted.rows, wanted.columns))
    bars = [[row for number, row in enumerate(rows) if number // BAR % 2 == kind] for kind in (0, 1)]
    text = HEAD.format(count=wanted.rows * wanted.columns)
    for surface, part, own in (("barbs", "barbs", rows), ("pale", "barbules", bars[0]), ("dark", "barbules", bars[1])):
        if own:
            text += f'\n[[objects]]\ncurves = "feather_{part}.txt"\nsurface = "{surface}"\ninstances = [\n'
            text += "\n".join(line for row in own for line in row) + "\n]\n"
    path = wanted.folder / "coat.toml"
    path.write_text(text, encoding="utf-8")
    print(f"wrote {path}: {wanted.rows * wanted.columns} feathers")


if __name__ == "__main__":
    main()
