#!/usr/bin/env python3
"""The curved cross room in Python: built part by part, rendered, saved as spectral EXR and PNG.

    python examples/room.py [--photons 3000000] [--size 400x300] [--straight] [-o room.png]
"""
import argparse

import numpy as np

import cpm

WHITE = ([400, 620, 700], [0.70, 0.75, 0.76])
RED = ([400, 560, 620, 700], [0.05, 0.08, 0.60, 0.64])
GREEN = ([400, 480, 530, 620, 700], [0.08, 0.20, 0.45, 0.15, 0.12])


def add_quad(scene, corner, a, b, material):
    """A parallelogram of two triangles with the normal a × b."""
    corner, a, b = np.array(corner, float), np.array(a, float), np.array(b, float)
    scene.add_mesh([corner, corner + a, corner + a + b, corner + b], [[0, 1, 2], [0, 2, 3]], material=material)


def build_room(medium):
    """The room of the paper: a box of 4 m with a cross-shaped hole in its left wall, a spot outside."""
    scene = cpm.Scene(medium=medium)
    white, red, green = (cpm.materials.Diffuse(paint) for paint in (WHITE, RED, GREEN))
    add_quad(scene, (-2, 0, -2), (0, 0, 4), (4, 0, 0), white)       # floor
    add_quad(scene, (-2, 4, -2), (4, 0, 0), (0, 0, 4), white)       # ceiling
    add_quad(scene, (2, 0, -2), (0, 0, 4), (0, 4, 0), white)        # right
    add_quad(scene, (-2, 0, -2), (4, 0, 0), (0, 4, 0), red)         # back
    add_quad(scene, (-2, 0, 2), (0, 4, 0), (4, 0, 0), green)        # front
    # Left, bottom to top: each band of the wall with half the width of the hole in it.
    for y0, y1, hole in [(0, 0.8, 0), (0.8, 1.7, 0.3), (1.7, 2.3, 1.2), (2.3, 3.2, 0.3), (3.2, 4, 0)]:
        for z0, z1 in [(-2, -hole), (hole, 2)] if hole else [(-2, 2)]:
            add_quad(scene, (-2, y0, z0), (0, y1 - y0, 0), (0, 0, z1 - z0), white)
    scene.add_light(cpm.lights.Spot((-5, 6.5, 0), (-2, 2.35, 0), cutoff=14.0, intensity=100.0))
    scene.camera = cpm.Camera.look_at((1.85, 3.0, 1.85), (-1.2, 0.6, -0.9), fov=70.0)
    return scene


def size(text):
    """400x300 as (400, 300); argparse says what is wrong."""
    try:
        width, height = map(int, text.lower().split("x"))
    except ValueError:
        raise argparse.ArgumentTypeError(f"'{text}' is not a size such as 400x300") from None
    return width, height


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--photons", type=int, default=3_000_000)
    parser.add_argument("--size", type=size, default=(400, 300), help="pixels: 400x300")
    parser.add_argument("--straight", action="store_true", help="n = 1: the homogeneous room")
    parser.add_argument("-o", "--output", nargs="+", default=["room.exr", "room.png"])
    options = parser.parse_args()

    medium = cpm.media.Homogeneous(1.0) if options.straight else cpm.media.LinearSquared(1.69, (0, -0.10, 0))
    image = cpm.render(build_room(medium), size=options.size, photons=options.photons,
                       nearest=150, progress=True)
    for path in options.output:
        image.save(path, white="E")     # the spot's spectrum is flat: let it look white
    print(f"{image}: {image.stats['seconds_total']:.1f} s, left out: {', '.join(image.stats['left_out'])}")


if __name__ == "__main__":
    main()
