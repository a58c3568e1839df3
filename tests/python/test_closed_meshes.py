"""Closed meshes as people make them, turned and moved: all may be filled with glass; one face less, and none may."""

import itertools

import numpy as np
import pytest

import cpm

trimesh = pytest.importorskip("trimesh")

SHAPES = {
    "torus": lambda: trimesh.creation.torus(1.0, 0.3),
    "uv sphere": lambda: trimesh.creation.uv_sphere(1.0),
    "cylinder": lambda: trimesh.creation.cylinder(1.0, 0.3),
    "capsule": lambda: trimesh.creation.capsule(1.0, 0.3),
    "cone": lambda: trimesh.creation.cone(1.0, 1.0),
    "icosphere": lambda: trimesh.creation.icosphere(3),
}
#: Right angles leave coordinates like 6e-17 beside zeros.
ANGLES = (0.0, 0.5 * np.pi, np.pi, 0.3)
OFFSETS = (0.0, 3.3, 1000.0)


def moved(name, axis, angle, offset):
    mesh = SHAPES[name]()
    mesh.apply_transform(trimesh.transformations.rotation_matrix(angle, axis))
    mesh.apply_translation((offset, 0.7 * offset, -offset))
    return mesh.vertices, mesh.faces


@pytest.mark.parametrize("name", SHAPES)
def test_closed_in_any_place(name):
    """Watertight in every orientation and position."""
    for axis, angle, offset in itertools.product(np.eye(3), ANGLES, OFFSETS):
        cpm.Scene().add_mesh(*moved(name, axis, angle, offset), material=cpm.materials.Dielectric(1.5))


@pytest.mark.parametrize("name", SHAPES)
def test_open_is_refused(name):
    """One face less."""
    vertices, faces = moved(name, (1.0, 0.0, 0.0), 0.3, 3.3)
    with pytest.raises(ValueError, match="open"):
        cpm.Scene().add_mesh(vertices, faces[:-1], material=cpm.materials.Dielectric(1.5))


def test_stored_power_is_what_was_absorbed():
    """Sixteen bits a power, rounded so that the sum keeps its mean: all photons of a lamp have one power."""
    scene = cpm.Scene()
    floor = [[-9, 0, -9], [-9, 0, 9], [9, 0, 9], [9, 0, -9]]
    scene.add_mesh(floor, [[0, 1, 2], [0, 2, 3]], material=cpm.materials.Black())
    scene.add_light(cpm.lights.Point((0, 1, 0), 1.0))
    photons = cpm.trace_photons(scene, 200_000, wavelengths=[550.0], projection=True)
    stored = photons.diffuse.power.sum(dtype=float)
    # each rounding is off by at most 2^-10, uniformly: 5 sigma of the mean over 1e5 photons is 3e-6
    assert stored == pytest.approx(photons.energy["absorbed"][0], rel=5e-6)


def test_extent_is_said():
    """The default: what is in the scene grown by its diagonal; infinite where nothing bends."""
    assert np.isinf(cpm.Scene().extent.high).all()
    scene = cpm.Scene(medium=cpm.media.LinearSquared(2.0, gradient=(0, -0.1, 0)))
    scene.add_sphere((0, 0, 0), 1.0, cpm.materials.Black())
    grown = 1.0 + np.sqrt(12.0)
    assert np.allclose(scene.extent.high, grown) and np.allclose(scene.extent.low, -grown)
