"""Scenes built through the public API."""

from __future__ import annotations

import numpy as np
from oracles import cross_room

import cpm


def icosphere(radius=1.0, subdivisions=3, inward=False):
    """Vertices (V, 3) and faces (F, 3) of a subdivided icosahedron, normals outward or inward."""
    t = (1 + 5**0.5) / 2
    v = [
        (-1, t, 0),
        (1, t, 0),
        (-1, -t, 0),
        (1, -t, 0),
        (0, -1, t),
        (0, 1, t),
        (0, -1, -t),
        (0, 1, -t),
        (t, 0, -1),
        (t, 0, 1),
        (-t, 0, -1),
        (-t, 0, 1),
    ]
    f = [
        (0, 11, 5), (0, 5, 1), (0, 1, 7), (0, 7, 10), (0, 10, 11), (1, 5, 9), (5, 11, 4), (11, 10, 2), (10, 7, 6),
        (7, 1, 8), (3, 9, 4), (3, 4, 2), (3, 2, 6), (3, 6, 8), (3, 8, 9), (4, 9, 5), (2, 4, 11),
        (6, 2, 10), (8, 6, 7), (9, 8, 1),
    ]  # fmt: skip
    v = [np.array(x) / np.linalg.norm(x) for x in v]
    for _ in range(subdivisions):
        known, finer = {}, []
        for a, b, c in f:
            middle = []
            for i, j in ((a, b), (b, c), (c, a)):
                key = (min(i, j), max(i, j))
                if key not in known:
                    m = v[i] + v[j]
                    known[key] = len(v)
                    v.append(m / np.linalg.norm(m))
                middle.append(known[key])
            x, y, z = middle
            finer += [(a, x, z), (b, y, x), (c, z, y), (x, y, z)]
        f = finer
    faces = np.array(f, dtype=np.int64)
    return radius * np.array(v), faces[:, ::-1].copy() if inward else faces


def quads_mesh(quads):
    """Vertices and faces of (corner, a, b) parallelograms, normals a × b."""
    vertices, faces = [], []
    for corner, a, b in quads:
        corner, a, b = (np.array(x, float) for x in (corner, a, b))
        k = len(vertices)
        vertices += [corner, corner + a, corner + a + b, corner + b]
        faces += [(k, k + 1, k + 2), (k, k + 2, k + 3)]
    return np.array(vertices), np.array(faces, dtype=np.int64)


def box_mesh(low, high):
    """A closed box whose normals point inward."""
    (x0, y0, z0), (x1, y1, z1) = low, high
    x, y, z = x1 - x0, y1 - y0, z1 - z0
    return quads_mesh(
        [
            ((x0, y0, z0), (0, 0, z), (x, 0, 0)),
            ((x0, y1, z0), (x, 0, 0), (0, 0, z)),
            ((x0, y0, z0), (0, y, 0), (0, 0, z)),
            ((x1, y0, z0), (0, 0, z), (0, y, 0)),
            ((x0, y0, z0), (x, 0, 0), (0, y, 0)),
            ((x0, y0, z1), (0, y, 0), (x, 0, 0)),
        ]
    )


def rectangle(center, a, b):
    """A parallelogram about `center` with half-edges a, b: normal a × b."""
    center, a, b = (np.array(v, float) for v in (center, a, b))
    return quads_mesh([(center - a - b, 2 * a, 2 * b)])


def room(medium=None, paint=None, intensity=cross_room.INTENSITY, **integrator):
    """The cross room; `paint` maps white, red, green to a reflectance (default: black diffuse).

    `intensity`: the spot's. `integrator`: method, rtol and the like, for the scene.
    """
    paint = paint or {"white": 0.0, "red": 0.0, "green": 0.0}
    scene = cpm.Scene(medium=medium, **integrator)
    for name, reflectance in paint.items():
        vertices, faces = cross_room.mesh((name,))
        scene.add_mesh(vertices, faces, material=cpm.materials.Diffuse(reflectance))
    scene.add_light(cpm.lights.Spot(cross_room.SPOT, cross_room.TARGET, cutoff=14.0, intensity=intensity))
    scene.camera = cpm.Camera.look_at((1.85, 3.0, 1.85), (-1.2, 0.6, -0.9), (0, 1, 0), fov=70.0)
    return scene


PAINTED = {"white": 0.75, "red": 0.60, "green": 0.15}


def curved_medium():
    """n² = 1.69 − 0.10 y."""
    return cpm.media.LinearSquared(1.69, gradient=(0, -0.10, 0))


def furnace(medium=None, albedo=0.5, radiance=0.5):
    """A closed sphere, radius 1, that emits `radiance` (basic) inside and reflects `albedo`; camera off centre."""
    scene = cpm.Scene(medium=medium) if medium is not None else cpm.Scene()
    shape = scene.add_mesh(*icosphere(1.0, 3, inward=True), material=cpm.materials.Diffuse(albedo))
    scene.add_light(cpm.lights.Area(shape, radiance))
    scene.camera = cpm.Camera.look_at((0.1, 0.3, 0.2), (0.5, -0.2, -0.6), (0, 1, 0), fov=80.0)
    return scene


def photons_of(photon_map, wavelength):
    """(N,) power of each photon at one wavelength: its column, or zero for split photons of other colours."""
    power = np.asarray(photon_map.power)
    wavelengths = np.broadcast_to(np.asarray(photon_map.wavelength), power.shape)
    return np.sum(np.where(np.isclose(wavelengths, wavelength), power, 0.0), axis=1)
