#!/usr/bin/env python3
"""Write the flat patterns and the prism of the gallery's scenes, binary PLY.

checkerboard.ply  the light squares of 10 × 10 in the unit square about the origin, facing +z: squares where column +
                  row is even, from the corner (-0.5, -0.5).
dots.ply          32 × 24 square dots, facing +z, in a field 1 wide and 0.75 high about the origin: pitch 1/32, side
                  0.4 of it.
prism.ply         equilateral, sides of 1 in the xz plane about the origin, one edge at -z, from y = 0 to 1; closed.

    python make_patterns.py [FOLDER]
"""
import sys
from pathlib import Path

import numpy as np

SQUARES = 10
DOTS, DOT_SIDE = (32, 24), 0.4


def squares(centers, side):
    """Squares facing +z about centers (N, 2): vertices (4N, 3), faces (2N, 3)."""
    corners = 0.5 * side * np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)])
    flat = (np.asarray(centers)[:, None] + corners).reshape(-1, 2)
    first = 4 * np.arange(len(centers))[:, None]
    faces = np.concatenate([first + (0, 1, 2), first + (0, 2, 3)], axis=1).reshape(-1, 3)
    return np.column_stack([flat, np.zeros(len(flat))]), faces


def checkerboard():
    """Light squares of the board."""
    column, row = (each.ravel() for each in np.meshgrid(np.arange(SQUARES), np.arange(SQUARES)))
    light = (column + row) % 2 == 0
    return squares((np.stack([column, row], axis=1)[light] + 0.5) / SQUARES - 0.5, 1 / SQUARES)


def dot_centers():
    """(768, 2), rows from the bottom."""
    column, row = (each.ravel() for each in np.meshgrid(np.arange(DOTS[0]), np.arange(DOTS[1])))
    return (np.stack([column, row], axis=1) + 0.5 - 0.5 * np.array(DOTS)) / DOTS[0]


def dots():
    """The dots."""
    return squares(dot_centers(), DOT_SIDE / DOTS[0])


def prism():
    """Six vertices; eight triangles that face outward."""
    angle = np.radians([-90, 30, 150])  # of the edges, from +x to +z
    base = np.stack([np.cos(angle), np.zeros(3), np.sin(angle)], axis=1) / np.sqrt(3)
    faces = [(0, 1, 2), (3, 5, 4)]
    for a, b in ((0, 1), (1, 2), (2, 0)):
        faces += [(a, a + 3, b), (b, a + 3, b + 3)]
    return np.concatenate([base, base + (0, 1, 0)]), np.array(faces)


def write_ply(path, vertices, faces):
    """Binary little-endian PLY."""
    header = ("ply\nformat binary_little_endian 1.0\ncomment written by make_patterns.py\n"
              f"element vertex {len(vertices)}\nproperty float x\nproperty float y\nproperty float z\n"
              f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n")
    rows = np.empty(len(faces), dtype=[("count", "u1"), ("corner", "<i4", 3)])
    rows["count"], rows["corner"] = 3, faces
    with open(path, "wb") as file:
        file.write(header.encode("ascii") + vertices.astype("<f4").tobytes() + rows.tobytes())


PATTERNS = {"checkerboard": checkerboard, "dots": dots, "prism": prism}

if __name__ == "__main__":
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).resolve().parent
    for name, made in PATTERNS.items():
        write_ply(folder / f"{name}.ply", *made())
