#!/usr/bin/env python3
"""Write cold_sea/*.ply: the ships of superior_mirage.toml and the coast of fata_morgana.toml, one file per colour.

All stand 20 km from the camera, which is over x = z = 0 and looks along −z; y is up. The sea is a sphere of radius
6371 km that touches y = 0 at the camera, so that it is 31.4 m lower there. Silhouettes: flat, in front of each other
by half a metre.

    python make_cold_sea.py [cold_sea]
"""
import sys
from pathlib import Path

import numpy as np

EARTH, DISTANCE = 6371e3, 20e3
SEA = -DISTANCE**2 / (EARTH + np.sqrt(EARTH**2 - DISTANCE**2))  # y of the sea's surface there
UNDER = -3.0  # hulls and cliffs go on below the water


def polygons(*outlines, depth=0):
    """Vertices (V, 3) and faces (F, 3) of convex polygons given as lists of (x, height above the sea), as fans."""
    vertices, faces, first = [], [], 0
    for outline in outlines:
        n = len(outline)
        vertices += [(x, SEA + h, -DISTANCE + 0.5 * depth) for x, h in outline]
        faces += [(first, first + i, first + i + 1) for i in range(1, n - 1)]
        first += n
    return np.array(vertices, dtype=float), np.array(faces)


def slab(x0, x1, h0, h1):
    return [(x0, h0), (x1, h0), (x1, h1), (x0, h1)]


def ships():
    """A steamer, 130 m long with a mast of 30 m, and a sailing boat of 22 m."""
    windows = [slab(x, x + 2.4, 10.6, 12.6) for x in np.arange(-72.0, -44.0, 4.0)]
    return {
        "hull": polygons([(-100, UNDER), (18, UNDER), (31, 9.5), (-103, 8.0)], slab(-14, -12.6, 8, 24),
                         slab(-80.5, -79.3, 8, 30)),
        "boot_topping": polygons([(-100, UNDER), (18, UNDER), (23, 1.6), (-101.0, 1.6)], depth=1),
        "decks": polygons(slab(-90, -40, 8, 14), slab(-84, -54, 14, 18.5), depth=1),
        "windows": polygons(*windows, slab(-82, -56, 15.6, 17.4), depth=2),
        "funnel": polygons(slab(-72, -63, 18.5, 22), slab(-72, -63, 24, 26.5), depth=1),
        "funnel_band": polygons(slab(-72, -63, 22, 24), depth=1),
        "boat": polygons([(84, UNDER), (100, UNDER), (104, 2.2), (81, 2.0)], slab(91.7, 92.3, 2, 22.5)),
        "mainsail": polygons([(81, 3.0), (91.4, 3.0), (91.4, 22.0)], depth=1),
        "jib": polygons([(92.6, 2.6), (103, 2.6), (92.6, 18.0)], depth=1),
    }


def coast():
    """An ice cliff from 16 to 34 m in five shades, and a lighthouse of 36 m in red and white."""
    random = np.random.default_rng(1818)
    x = np.concatenate([[-165.0], -165 + np.cumsum(random.uniform(3.0, 11.0, 60))])
    x = x[x < 60.0]
    top = 25 + 4 * np.sin(x / 21.0) + 3 * np.sin(x / 8.7 + 1) + random.uniform(-2.5, 2.5, x.size)
    shade = random.integers(0, 4, x.size)
    facets = [[(a, UNDER), (b, UNDER), (b, low), (a, high)]
              for a, b, high, low in zip(x[:-1], x[1:], top[:-1], top[1:] - random.uniform(0, 1.5, x.size - 1),
                                         strict=True)]
    made = {f"ice_{k}": polygons(*[facet for facet, s in zip(facets, shade[:-1], strict=True) if s == k])
            for k in range(4)}
    snow = [[(a, high - 2.2), (b, low - 1.8), (b, low), (a, high)] for (_, _, (b, low), (a, high)) in facets]
    made["snow"] = polygons(*snow, depth=1)
    made["rock"] = polygons([(70, UNDER), (150, UNDER), (138, 4.0), (112, 7.0), (88, 5.5)])
    heights = np.linspace(6.0, 33.0, 7)
    bands = [[(105.5 - w0, a), (105.5 + w0, a), (105.5 + w1, b), (105.5 - w1, b)]
             for a, b, w0, w1 in zip(heights[:-1], heights[1:], np.linspace(3.6, 2.4, 7)[:-1],
                                     np.linspace(3.6, 2.4, 7)[1:], strict=True)]
    made["tower_red"] = polygons(*bands[0::2], [(102.3, 33.0), (108.7, 33.0), (105.5, 36.5)], depth=1)
    made["tower_white"] = polygons(*bands[1::2], slab(116, 130, 5, 12), depth=1)
    made["roof"] = polygons([(114.5, 12), (131.5, 12), (123, 16)], depth=1)
    return made


def write_ply(path, vertices, faces):
    """Text PLY, to the millimetre."""
    lines = ["ply", "format ascii 1.0", f"comment made by {Path(__file__).name}", f"element vertex {len(vertices)}",
             "property double x", "property double y", "property double z", f"element face {len(faces)}",
             "property list uchar int vertex_indices", "end_header"]
    lines += [" ".join(f"{value:.3f}" for value in vertex) for vertex in vertices]
    lines += [f"3 {a} {b} {c}" for a, b, c in faces]
    path.write_text("\n".join(lines) + "\n", encoding="ascii")


if __name__ == "__main__":
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).with_name("cold_sea")
    folder.mkdir(exist_ok=True)
    for name, mesh in {**ships(), **coast()}.items():
        write_ply(folder / f"{name}.ply", *mesh)
