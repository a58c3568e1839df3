"""Rays through a prism by Snell's law with the local n of both sides, in the plane across its edges.

Outside, any field of `fields` (curved paths by SciPy's DOP853, `rays.trace`); inside, a homogeneous glass. Points and
directions are (3,); the faces are upright planes (point, outward normal).
"""

from __future__ import annotations

import numpy as np

from . import rays


def faces_of(side, turn):
    """Faces of `make_patterns.py`'s prism: side (m), turned about +y by `turn` degrees; (3, 2, 3) of point and normal.

    In the order of its edges: between edges 0 and 1, 1 and 2, 2 and 0, where edge 0 starts at -z.
    """
    angle = np.radians([-90, 30, 150])
    x, z = side / np.sqrt(3) * np.array([np.cos(angle), np.sin(angle)])
    c, s = np.cos(np.radians(turn)), np.sin(np.radians(turn))
    edges = np.stack([x * c + z * s, 0 * x, -x * s + z * c], axis=1)
    middles = 0.5 * (edges + np.roll(edges, -1, axis=0))
    return [(m, m / np.linalg.norm(m)) for m in middles]


def refract(direction, normal, before, after):
    """Unit direction after a face; `normal` either way."""
    d = direction / np.linalg.norm(direction)
    m = -normal if d @ normal > 0 else normal
    cosine, ratio = -(d @ m), before / after
    return ratio * d + (ratio * cosine - np.sqrt(1 - ratio**2 * (1 - cosine**2))) * m


def through(field, glass, faces, origin, direction, screen):
    """Where a ray meets `screen` (point, normal), after the first and the second face of `faces`."""
    (first, first_normal), (second, second_normal) = faces
    ray = rays.trace(field, origin, direction, until=(first, first_normal))
    inside = refract(ray.direction, first_normal, np.sqrt(field(ray.position)[0]), glass)
    at = ray.position + inside * ((second - ray.position) @ second_normal / (inside @ second_normal))
    after = refract(inside, second_normal, glass, np.sqrt(field(at)[0]))
    return rays.trace(field, at, after, until=screen).position


def sellmeier(B, C):
    """n(λ/nm) of SCHOTT's formula."""

    def n(wavelength):
        square = (wavelength / 1e3) ** 2
        return np.sqrt(1 + sum(b * square / (square - c) for b, c in zip(B, C, strict=True)))

    return n


#: SCHOTT SF11 785258, catalogue of 2017.
SF11 = sellmeier((1.73848403, 0.311168974, 1.17490871), (0.0136068604, 0.0615960463, 121.922711))
