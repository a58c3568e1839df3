"""Scenes that between them use every medium, way of rays, material and light: what two backends must agree on."""

from __future__ import annotations

import numpy as np
from support.scenes import icosphere, quads_mesh

import cpm

BINS = np.linspace(420.0, 680.0, 5)


def box_room(medium=None, albedo=0.6, half=1.0, lid=True, **integrator):
    """A closed room of side 2, normals inward, with a spot in it."""
    scene = cpm.Scene(medium=medium, **integrator)
    h = half
    walls = [
        ((-h, -h, -h), (0, 0, 2 * h), (2 * h, 0, 0)),
        ((-h, -h, -h), (0, 2 * h, 0), (0, 0, 2 * h)),
        ((h, -h, -h), (0, 0, 2 * h), (0, 2 * h, 0)),
        ((-h, -h, -h), (2 * h, 0, 0), (0, 2 * h, 0)),
        ((-h, -h, h), (0, 2 * h, 0), (2 * h, 0, 0)),
    ]
    if lid:
        walls.append(((-h, h, -h), (2 * h, 0, 0), (0, 0, 2 * h)))
    paint = cpm.materials.Diffuse(([400, 700], [albedo, 0.5 * albedo]))
    scene.add_mesh(*quads_mesh(walls), material=paint)
    return scene


def lit(scene, kind="spot", at=(0.1, 0.7, -0.2)):
    if kind == "spot":
        scene.add_light(cpm.lights.Spot(at, (0.0, -1.0, 0.1), cutoff=50.0, intensity=100.0))
    elif kind == "point":
        scene.add_light(cpm.lights.Point(at, 30.0))
    else:
        lamp = scene.add_mesh(*quads_mesh([((-0.2, 0.9, -0.2), (0.4, 0, 0), (0, 0.05, 0.4))]), material=cpm.materials.Black())
        scene.add_light(cpm.lights.Area(lamp, 20.0))
    return scene


def grid_medium(interpolation, bounds=None):
    x = np.linspace(-1.5, 1.5, 12)
    r2 = x[:, None, None] ** 2 + x[None, :, None] ** 2 + x[None, None, :] ** 2
    return cpm.media.Grid(
        1.2 + 0.1 * np.exp(-r2), (-1.5,) * 3, 3.0 / 11, interpolation=interpolation, bounds=bounds
    )


HEIGHTS = np.linspace(-1.2, 1.2, 7)
PROFILE = 1.3 + 0.05 * np.sin(2.0 * HEIGHTS)


def ball(medium, radius=0.35, center=(0.05, -0.2, 0.1)):
    return medium, cpm.Sphere(center, radius)


def glass_room(interior, light="spot", mesh=False, medium=None):
    scene = lit(box_room(medium), light)
    glass = cpm.materials.Dielectric(interior)
    if mesh:
        vertices, faces = icosphere(0.35, 2)
        scene.add_mesh(vertices + (0.05, -0.2, 0.1), faces, material=glass)
    else:
        scene.add_sphere((0.05, -0.2, 0.1), 0.35, glass)
    return scene


def mirror_room(medium=None):
    scene = lit(box_room(medium))
    scene.add_sphere((0.3, -0.4, 0.1), 0.3, cpm.materials.Mirror(0.9))
    vertices, faces = icosphere(0.25, 2)
    scene.add_mesh(vertices + (-0.4, -0.4, 0.0), faces, material=cpm.materials.Mirror(0.8), normals=vertices / 0.25)
    return scene


def bounded_room(media, outer=None, **integrator):
    scene = lit(box_room(outer, **integrator))
    for medium in media:
        scene.add_medium(medium)
    return scene


def scenes():
    """Name: (a function that makes the scene, its media are free of transcendental functions)."""
    m = cpm.media
    linear2 = lambda: m.LinearSquared(1.69, (0.05, -0.20, 0.02))  # noqa: E731
    ball_of = lambda: cpm.Sphere((0.0, -0.2, 0.0), 0.5)  # noqa: E731
    return {
        "homogeneous": (lambda: lit(box_room()), True),
        "homogeneous_area": (lambda: lit(box_room(), "area"), True),
        "homogeneous_point_open": (lambda: lit(box_room(lid=False), "point"), True),
        "linear_squared": (lambda: lit(box_room(linear2())), True),
        "linear_squared_area": (lambda: lit(box_room(linear2()), "area"), True),
        "linear_squared_open": (lambda: lit(box_room(linear2(), lid=False), at=(0.1, 2.0, -0.2)), True),
        "linear_squared_rk4": (lambda: lit(box_room(linear2(), method="rk4", step=0.05)), True),
        "linear_squared_dopri5": (lambda: lit(box_room(linear2(), method="dopri5")), True),
        "linear_squared_adams": (lambda: lit(box_room(linear2(), method="adams")), True),
        "linear": (lambda: lit(box_room(m.Linear(1.3, (0.02, -0.08, 0.0)))), False),
        "parabolic": (lambda: lit(box_room(m.Parabolic(1.5, 0.4))), False),
        "parabolic_nystrom": (lambda: lit(box_room(m.Parabolic(1.5, 0.4), exclude=("exact",))), True),
        "layered_step": (lambda: lit(box_room(m.Layered(HEIGHTS, PROFILE, interpolation="step"))), True),
        "layered_squared": (lambda: lit(box_room(m.Layered(HEIGHTS, PROFILE, interpolation="linear-squared"))), True),
        "layered_cubic": (lambda: lit(box_room(m.Layered(HEIGHTS, PROFILE))), True),
        "shells": (
            lambda: lit(box_room(m.Layered(HEIGHTS, PROFILE, radius=20.0, interpolation="linear-squared"))),
            False,
        ),
        "grid_cubic": (lambda: lit(box_room(grid_medium("cubic"))), True),
        "grid_linear": (lambda: lit(box_room(grid_medium("linear"))), True),
        "luneburg": (lambda: bounded_room([m.Luneburg(0.5, (0.0, -0.2, 0.0))]), False),
        "eaton": (lambda: bounded_room([m.Eaton(0.4, (0.0, -0.2, 0.0))]), False),
        "fisheye": (lambda: lit(box_room(m.Fisheye(1.6, 2.0))), False),
        "sources": (lambda: lit(box_room(m.Sources([(0.3, -1.6, 0.0)], [0.05]))), False),
        "expression": (lambda: lit(box_room(m.Expression("1.2 + 0.05*exp(-(x**2 + y**2))"))), False),
        "sum": (lambda: lit(box_room(m.Linear(1.2, (0.0, -0.05, 0.0)) + grid_medium("cubic"))), True),
        "bounded_parabola": (lambda: bounded_room([m.LinearSquared(1.69, (0, -0.2, 0), bounds=ball_of())]), True),
        "bounded_three": (
            lambda: bounded_room(
                [grid_medium("cubic", ball_of()), m.Homogeneous(1.4, bounds=cpm.Box((-0.2, -0.6, -0.2), (0.3, 0.1, 0.4)))],
                m.LinearSquared(1.44, (0.0, -0.1, 0.0)),
            ),
            True,
        ),
        "glass": (lambda: glass_room("BK7"), True),
        "glass_mesh_area": (lambda: glass_room("BK7", "area", mesh=True), True),
        "dispersion_curved": (lambda: glass_room("SF11", medium=m.LinearSquared(1.21, (0, -0.1, 0))), True),
        "dispersive_area": (lambda: lit(box_room(m.LinearSquared(1.69, (0, -0.2, 0), dispersion="BK7")), "area"), True),
        "dispersive_air": (lambda: lit(box_room(m.LinearSquared(1.69, (0, -0.2, 0), dispersion="BK7"))), True),
        "mirrors": (lambda: mirror_room(), True),
        "mirrors_curved": (lambda: mirror_room(linear2()), True),
        "fine_mesh": (lambda: fine_room(), True),
        "fine_mesh_curved": (lambda: fine_room(linear2()), True),
    }


def fine_room(medium=None):
    scene = lit(box_room(medium))
    vertices, faces = icosphere(0.5, 4)
    scene.add_mesh(vertices + (0.0, -0.4, 0.0), faces, material=cpm.materials.Diffuse(0.5))
    return scene


def columns(photons):
    """Both maps' columns in one order: sorted by all of them, whatever order the photons are stored in."""
    rows = []
    for photon_map in (photons.diffuse, photons.caustic):
        parts = [photon_map.position.view(np.int32), photon_map.direction.view(np.int32), photon_map.bounce[:, None],
                 photon_map.power.view(np.int32)]
        table = np.hstack([np.asarray(p).reshape(len(photon_map), -1) for p in parts]) if len(photon_map) else np.zeros((0, 1))
        rows.append(table[np.lexsort(table.T)] if len(table) else table)
    return rows
