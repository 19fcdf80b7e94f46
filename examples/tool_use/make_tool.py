"""Writes the hook of this example to its own folder: python3 make_tool.py

A rod of circular section, bent to a J, with round ends, in millimeters. The lowest point is the origin, the shank is along z, and the
bend is in the plane y = 0.
"""

import math
import struct
from pathlib import Path

RADIUS = 5.0
BEND = 15.0
SHANK = 40.0
AROUND = 12
# Number of rings along the bend, and along each round end without its pole.
ALONG, CAP = 11, 2
# Angle of the bend, less than half a turn.
TURN = math.radians(150)


def station(angle):
    """Returns center of the section and direction of the rod at an angle of the bend."""
    center = (-BEND * math.cos(angle), BEND + RADIUS - BEND * math.sin(angle))
    return center, (math.sin(angle), -math.cos(angle))


def sections():
    """Returns center, direction and radius of every section from pole to pole. Centers and directions are in the plane y = 0."""
    top, down = station(0.0)
    top = (top[0], top[1] + SHANK)
    end, out = station(TURN)
    first = [math.pi / 2 * step / (CAP + 1) for step in range(CAP + 1)]
    for angle in first:
        yield moved(top, down, -RADIUS * math.cos(angle)), down, RADIUS * math.sin(angle)
    yield top, down, RADIUS
    for step in range(ALONG):
        yield *station(TURN * step / (ALONG - 1)), RADIUS
    for angle in reversed(first):
        yield moved(end, out, RADIUS * math.cos(angle)), out, RADIUS * math.sin(angle)


def moved(point, direction, way):
    return tuple(p + d * way for p, d in zip(point, direction))


def ring(center, direction, radius):
    """Returns points counter-clockwise about the direction. A pole is a ring of one point."""
    if radius == 0.0:
        return [(center[0], 0.0, center[1])]
    # This vector is across the rod in the plane of the bend. Its cross product with y, which is (0, 1, 0), is the direction.
    across = (direction[1], -direction[0])
    angles = [2 * math.pi * step / AROUND for step in range(AROUND)]
    return [
        (
            center[0] + across[0] * radius * math.cos(angle),
            radius * math.sin(angle),
            center[1] + across[1] * radius * math.cos(angle),
        )
        for angle in angles
    ]


def triangles():
    rings = [ring(*section) for section in sections()]
    for low, high in zip(rings, rings[1:]):
        for step in range(AROUND):
            a, b = (low[(step + k) % len(low)] for k in (0, 1))
            d, c = (high[(step + k) % len(high)] for k in (0, 1))
            if len(low) > 1:
                yield (a, b, c)
            if len(high) > 1:
                yield (a, c, d)


def main():
    corners = list(triangles())
    with open(Path(__file__).parent / "tool.stl", "wb") as file:
        file.write(b"A hook, in millimeters: make_tool.py".ljust(80, b" "))
        file.write(struct.pack("<I", len(corners)))
        for triangle in corners:
            # Readers compute the normals.
            file.write(struct.pack("<12fH", 0, 0, 0, *(x for corner in triangle for x in corner), 0))


main()
