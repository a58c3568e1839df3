#!/usr/bin/env python3
"""Write trefoil.ply: a tube around a trefoil knot, closed, 16 000 triangles, binary PLY.

The knot r(t) = (sin t + 2 sin 2t, cos t − 2 cos 2t, −sin 3t) is scaled into the unit ball; the tube follows its Frenet
frame, which a trefoil has everywhere (its curvature vanishes nowhere).

    python make_trefoil.py [trefoil.ply]
"""
import sys
from pathlib import Path

import numpy as np

ALONG, AROUND = 400, 20
TUBE_RADIUS = 0.36        # of a knot that reaches 3.0 from its axis


def knot(t, derivative=0):
    """The knot or one of its derivatives at parameters t, (N, 3)."""
    phase = derivative * np.pi / 2

    def wave(function, frequency):
        return frequency**derivative * function(frequency * t + phase)

    return np.stack([wave(np.sin, 1) + 2 * wave(np.sin, 2), wave(np.cos, 1) - 2 * wave(np.cos, 2),
                     -wave(np.sin, 3)], axis=1)


def unit(vectors):
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)


def tube():
    """Vertices (V, 3) and faces (F, 3), counter-clockwise from outside."""
    t = 2 * np.pi * np.arange(ALONG) / ALONG
    tangent = unit(knot(t, 1))
    binormal = unit(np.cross(knot(t, 1), knot(t, 2)))
    normal = np.cross(binormal, tangent)
    angle = 2 * np.pi * np.arange(AROUND) / AROUND
    ring = np.cos(angle)[None, :, None] * normal[:, None] + np.sin(angle)[None, :, None] * binormal[:, None]
    vertices = (knot(t)[:, None] + TUBE_RADIUS * ring).reshape(-1, 3)

    i, j = np.meshgrid(np.arange(ALONG), np.arange(AROUND), indexing="ij")
    here, ahead = i * AROUND, (i + 1) % ALONG * AROUND
    beside = (j + 1) % AROUND
    a, b, c, d = here + j, ahead + j, ahead + beside, here + beside
    faces = np.concatenate([np.stack([a, c, b], axis=-1), np.stack([a, d, c], axis=-1)]).reshape(-1, 3)
    return vertices / np.linalg.norm(vertices, axis=1).max(), faces


def write_ply(path, vertices, faces):
    """Binary little-endian PLY with float32 vertices."""
    header = (f"ply\nformat binary_little_endian 1.0\ncomment made by {Path(__file__).name}\n"
              f"element vertex {len(vertices)}\nproperty float x\nproperty float y\nproperty float z\n"
              f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n")
    rows = np.empty(len(faces), dtype=[("count", "u1"), ("corners", "<i4", 3)])
    rows["count"], rows["corners"] = 3, faces
    path.write_bytes(header.encode() + vertices.astype("<f4").tobytes() + rows.tobytes())


if __name__ == "__main__":
    target = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).with_name("trefoil.ply")
    write_ply(target, *tube())
