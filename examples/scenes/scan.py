#!/usr/bin/env python3
"""Draws scan.png: a barred feather as a scanner might see it, tip above, 96 x 240 pixels.

Usage: python3 scan.py [scan.png]
"""

import math
import struct
import sys
import zlib

WIDTH, HEIGHT = 96, 240
CREAM, BUFF, BROWN, BLACK = (226, 208, 176), (186, 140, 88), (104, 64, 34), (44, 32, 26)


def mix(one, other, share):
    share = min(max(share, 0.0), 1.0)
    return tuple(a + (b - a) * share for a, b in zip(one, other))


def colour(across, along):
    """Of a place: across from -1 to 1, along from the base (0) to the tip (1)."""
    # Bars run towards the tip on either side of the shaft; each is darker at its upper edge.
    place = 7.0 * (along - 0.16 * abs(across)) + 0.12 * math.sin(9.0 * across)
    bar = place - math.floor(place)
    ground = mix(CREAM, BUFF, 0.75 - abs(across))
    pixel = mix(ground, BROWN, (bar - 0.52) / 0.06) if bar < 0.9 else BLACK
    return mix(pixel, BLACK, (along - 0.93) / 0.03)


def main():
    rows = bytearray()
    for y in range(HEIGHT):
        rows.append(0)
        for x in range(WIDTH):
            pixel = colour(2.0 * (x + 0.5) / WIDTH - 1.0, 1.0 - (y + 0.5) / HEIGHT)
            rows.extend(round(value) for value in pixel)

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    head = struct.pack(">IIBBBBB", WIDTH, HEIGHT, 8, 2, 0, 0, 0)
    png = b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(bytes(rows), 9)) + chunk(b"IEND", b"")
    with open(sys.argv[1] if len(sys.argv) > 1 else "scan.png", "wb") as file:
        file.write(png)


if __name__ == "__main__":
    main()
