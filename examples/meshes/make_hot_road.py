#!/usr/bin/env python3
"""Write hot_road/*.ply, what stands on and beside the road of inferior_mirage.toml: one file per material, millimetres.

The camera is at x = z = 0 and looks along −z; y is up. Only what its narrow field of view sees is there.

    python make_hot_road.py [hot_road]
"""
import sys
from pathlib import Path

import numpy as np

ROAD = 4.0                # half its width, metres
NEAR, FAR = 60.0, 3200.0  # where the ground begins and ends, metres from the camera
SPREAD = 0.04             # half the ground's width over its distance: the field of view and a margin

LORRY, CAR, MAST, HOUSE, HILLS = 430.0, 300.0, 360.0, 800.0, 3000.0  # metres from the camera


def box(low, high):
    """Six faces as (corner, edge a, edge b), normals a × b outward."""
    x, y, z = low
    w, h, d = np.subtract(high, low)
    a, b, c = (w, 0, 0), (0, h, 0), (0, 0, d)
    far = tuple(high)

    def back(edge):
        return tuple(-value for value in edge)

    return [((x, y, z), b, a), ((x, y, z), a, c), ((x, y, z), c, b),
            (far, back(a), back(b)), (far, back(c), back(a)), (far, back(b), back(c))]


def upright(x0, x1, y0, y1, z):
    """A face towards the camera."""
    return [((x0, y0, z), (x1 - x0, 0, 0), (0, y1 - y0, 0))]


def quads(*groups):
    """Vertices (V, 3) and faces (F, 3) of lists of parallelograms."""
    corner, a, b = np.moveaxis(np.array([quad for group in groups for quad in group], dtype=float), 1, 0)
    vertices = np.stack([corner, corner + a, corner + a + b, corner + b], axis=1).reshape(-1, 3)
    first = 4 * np.arange(len(corner))[:, None]
    return vertices, np.concatenate([first + np.array(half) for half in ((0, 1, 2), (0, 2, 3))])


def strip(left, right):
    """A ribbon between two rows of points that go away from the camera, normals up."""
    n = len(left)
    i = np.arange(n - 1)
    faces = [np.stack([i, n + i, n + i + 1], axis=1), np.stack([i, n + i + 1, i + 1], axis=1)]
    return np.concatenate([left, right]), np.concatenate(faces)


def joined(*meshes):
    """One mesh of several."""
    first = np.cumsum([0, *(len(vertices) for vertices, _ in meshes)])
    return (np.concatenate([vertices for vertices, _ in meshes]),
            np.concatenate([faces + at for (_, faces), at in zip(meshes, first, strict=False)]))


def row(x, z):
    return np.column_stack([np.broadcast_to(x, z.shape), 0 * z, -z])


def ground():
    """Asphalt, and the sand on either side of it."""
    z = np.geomspace(NEAR, FAR, 25)
    edge = np.maximum(ROAD + 2.0, SPREAD * z)
    return (strip(row(-ROAD, z), row(ROAD, z)),
            joined(strip(row(-edge, z), row(-ROAD, z)), strip(row(ROAD, z), row(edge, z))))


def markings():
    """Dashes 4 m long in the middle, lines at the edges; 1 mm above the asphalt."""
    dashes = [((-0.09, 0.001, -z), (0.18, 0, 0), (0, 0, -4.0)) for z in np.arange(NEAR, 400.0, 12.0)]
    edges = [((x - 0.09, 0.001, -NEAR), (0.18, 0, 0), (0, 0, NEAR - 1500.0)) for x in (-3.7, 3.7)]
    return quads(dashes, edges)


def wheels(x, half, z):
    return box((x - half, 0, z), (x - half + 0.3, 0.7, z + 0.6)) + box((x + half - 0.3, 0, z), (x + half, 0.7, z + 0.6))


def hills():
    """Two ridges, as silhouettes towards the camera."""
    found = []
    for z, base, waves in ((HILLS, 7.0, ((4.0, 190.0, 0.4), (2.0, 71.0, 2.0), (0.8, 23.0, 1.1))),
                           (0.8 * HILLS, 3.0, ((2.6, 140.0, 4.4), (1.0, 47.0, 0.3), (0.4, 13.0, 2.7)))):
        x = np.linspace(-SPREAD * z, SPREAD * z, 161)
        top = base + sum(size * np.sin(2 * np.pi * x / wide + phase) for size, wide, phase in waves)
        low, high = np.column_stack([x, 0 * x, 0 * x - z]), np.column_stack([x, np.maximum(top, 0.3), 0 * x - z])
        # the ribbon's own "away" is to the right here, its "right" below
        found.append(strip(high, low))
    return found


def tree(x, z, height):
    """A trunk and a crown of two crossed rhombi."""
    crown, half = 0.3 * height, 0.24 * height
    trunk = box((x - 0.15, 0, z - 0.15), (x + 0.15, crown, z + 0.15))
    leaves = [((x, crown * 0.8, z), (half, 0.4 * height, d), (-half, 0.38 * height, d)) for d in (-0.4, 0.4)]
    return trunk, leaves


def meshes():
    """Name → (vertices, faces)."""
    asphalt, sand = ground()
    far, near = hills()
    lorry, car = -LORRY, -CAR
    trunks, crowns = zip(*[tree(x, -z, h) for x, z, h in
                           ((15.5, 620, 7.0), (18.6, 700, 8.5), (20.9, 640, 6.0), (-19.5, 760, 7.5))], strict=True)
    bands = [box((-8.15, 0.5 * i, -MAST), (-7.85, 0.5 * i + 0.5, -MAST + 0.3)) for i in range(10)]
    found = {
        "asphalt": asphalt,
        "sand": sand,
        "lines": markings(),
        "far_hills": far,
        "near_hills": near,
        # both show their fronts
        "car": quads(box((1.1, 0.25, car - 4.3), (2.9, 0.85, car)),
                     box((1.3, 0.85, car - 3.2), (2.7, 1.45, car - 1.0))),
        "cab": quads(box((-3.2, 0.5, lorry - 2.0), (-0.8, 2.9, lorry))),
        "trailer": quads(box((-3.25, 0.9, lorry - 12.0), (-0.75, 3.9, lorry - 2.2))),
        "dark": quads(wheels(2.0, 0.85, car - 1.2), wheels(-2.0, 1.15, lorry - 1.3),
                      upright(1.4, 2.6, 0.92, 1.38, car - 0.99), upright(-3.0, -1.0, 1.7, 2.6, lorry + 0.01),
                      upright(-17.6, -16.7, 1.0, 2.2, -HOUSE + 0.01), upright(-14.3, -13.4, 1.0, 2.2, -HOUSE + 0.01),
                      *trunks),
        "lamps": quads(upright(1.2, 1.5, 0.55, 0.75, car + 0.01), upright(2.5, 2.8, 0.55, 0.75, car + 0.01),
                       upright(-3.1, -2.7, 0.7, 1.0, lorry + 0.01), upright(-1.3, -0.9, 0.7, 1.0, lorry + 0.01)),
        "red_bands": quads(*bands[0::2]),
        "white_bands": quads(*bands[1::2]),
        "house": quads(box((-19.0, 0, -HOUSE - 8), (-12.0, 3.2, -HOUSE))),
        "roof": roof(),
        "leaves": quads(*crowns),
    }
    return found


def roof():
    """A gable towards the camera."""
    z0, z1 = -HOUSE + 0.3, -HOUSE - 8.3
    front = [(-19.4, 3.2, z0), (-11.6, 3.2, z0), (-15.5, 5.6, z0)]
    back = [(x, y, z1) for x, y, _ in front]
    faces = [(0, 1, 2), (3, 5, 4), (0, 2, 5), (0, 5, 3), (1, 4, 5), (1, 5, 2), (0, 3, 4), (0, 4, 1)]
    return np.array(front + back), np.array(faces)


def write_ply(path, vertices, faces):
    """Text PLY, to the millimetre."""
    lines = ["ply", "format ascii 1.0", f"comment made by {Path(__file__).name}", f"element vertex {len(vertices)}",
             "property double x", "property double y", "property double z", f"element face {len(faces)}",
             "property list uchar int vertex_indices", "end_header"]
    lines += [" ".join(f"{value:.3f}".rstrip("0").rstrip(".") for value in vertex)
              for vertex in vertices]
    lines += [f"3 {a} {b} {c}" for a, b, c in faces]
    path.write_text("\n".join(lines) + "\n", encoding="ascii")


if __name__ == "__main__":
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).with_name("hot_road")
    folder.mkdir(exist_ok=True)
    for name, mesh in meshes().items():
        write_ply(folder / f"{name}.ply", *mesh)
