"""Dispersion formulas (λ in µm inside, nm outside) and what they do to refraction.

Oracles: the textbook formulas in `oracles.radiometry`, SCHOTT's data sheet, Snell.
"""

import numpy as np
import pytest
from oracles import closed_forms, radiometry
from support.scenes import photons_of

import cpm

WAVELENGTHS = np.array([404.66, 486.1327, 587.5618, 656.2725, 706.52])


def test_constant():
    np.testing.assert_array_equal(cpm.dispersion.Constant(1.5).n(WAVELENGTHS), 1.5)


def test_cauchy():
    """A + B/λ² + C/λ⁴ with λ in µm."""
    model = cpm.dispersion.Cauchy(1.5046, 0.00420, 1e-5)
    np.testing.assert_allclose(model.n(WAVELENGTHS), radiometry.cauchy(WAVELENGTHS, 1.5046, 0.00420, 1e-5), rtol=1e-14)


def test_sellmeier():
    model = cpm.dispersion.Sellmeier(radiometry.BK7_B, radiometry.BK7_C)
    np.testing.assert_allclose(model.n(WAVELENGTHS), radiometry.bk7(WAVELENGTHS), rtol=1e-14)
    for line, n in radiometry.BK7_LINES.items():
        assert float(model.n(line)) == pytest.approx(n, abs=6e-6)


def test_catalogue_bk7():
    """The shipped BK7 is SCHOTT's."""
    np.testing.assert_allclose(cpm.dispersion.catalogue("BK7").n(WAVELENGTHS), radiometry.bk7(WAVELENGTHS), rtol=1e-9)


def test_homogeneous_takes_a_dispersion():
    """|p| = n(λ) and optical path n(λ) l for each ray's own wavelength."""
    medium = cpm.media.Homogeneous(cpm.dispersion.Sellmeier(radiometry.BK7_B, radiometry.BK7_C))
    count = len(WAVELENGTHS)
    rays = cpm.trace(
        medium, np.zeros((count, 3)), np.tile((1.0, 2.0, 3.0), (count, 1)), wavelength=WAVELENGTHS, length=2.0
    )
    n = radiometry.bk7(WAVELENGTHS)
    np.testing.assert_allclose(np.linalg.norm(rays.momentum, axis=1), n, rtol=1e-13)
    np.testing.assert_allclose(rays.optical_path, 2 * n, rtol=1e-13)


def test_dispersive_slab_refracts_by_snell():
    """A bounded slab of Cauchy glass: each colour's offset behind it is that of Snell at its n(λ)."""
    thickness, angle = 0.5, np.radians(50)
    scene = cpm.Scene()
    model = cpm.dispersion.Cauchy(1.5, 0.02)
    scene.add_medium(cpm.media.Homogeneous(model, bounds=cpm.Box((-10, -thickness, -10), (10, 0, 10))))
    d = np.array([np.sin(angle), -np.cos(angle), 0.0])
    count = len(WAVELENGTHS)
    start = np.tile(np.array((0.0, 0.0, 0.3)) - d, (count, 1))
    rays = cpm.trace(scene, start, np.tile(d, (count, 1)), wavelength=WAVELENGTHS, until=((0, -2, 0), (0, 1, 0)))
    inside = np.arcsin(np.sin(angle) / radiometry.cauchy(WAVELENGTHS, 1.5, 0.02))
    expected = thickness * np.tan(inside) + (2 - thickness) * np.tan(angle)
    np.testing.assert_allclose(rays.position[:, 0], expected, rtol=0, atol=1e-9)
    np.testing.assert_allclose(rays.direction, np.tile(d, (count, 1)), rtol=0, atol=1e-12)


def test_prism_deviation_per_wavelength(threads):
    """Photons through a closed BK7 prism: deviation of each colour against two refractions by Snell."""
    apex, incidence, wavelengths = np.radians(60.0), np.radians(50.0), [420.0, 550.0, 680.0]
    scene = cpm.Scene()
    half, depth = np.tan(apex / 2), 1.0
    corners = np.array([(0, 1), (-half, 0), (half, 0)])  # apex up, (x, y)
    vertices = np.concatenate([np.column_stack([corners, np.full(3, z)]) for z in (-depth, depth)])
    faces = [(0, 2, 1), (3, 4, 5), (0, 1, 4), (0, 4, 3), (2, 0, 3), (2, 3, 5), (1, 2, 5), (1, 5, 4)]
    glass = cpm.dispersion.Sellmeier(radiometry.BK7_B, radiometry.BK7_C)
    scene.add_mesh(vertices, outward(vertices, faces), material=cpm.materials.Dielectric(glass))
    normal = np.array([-np.cos(apex / 2), np.sin(apex / 2), 0])  # of the left face
    tilt = np.arctan2(-normal[1], -normal[0]) + incidence
    d = np.array([np.cos(tilt), np.sin(tilt), 0.0])
    target = np.array([-half / 2, 0.5, 0.0])
    screen = cpm.materials.Diffuse(0.0)
    low, high = np.array([4.0, -20.0, -3.0]), np.array([4.0, 20.0, 3.0])
    scene.add_mesh([low, (4, 20, -3), high, (4, -20, 3)], [(0, 1, 2), (0, 2, 3)], material=screen)
    scene.add_light(cpm.lights.Spot(target - 2 * d, target, cutoff=0.01, intensity=1.0))
    photons = cpm.trace_photons(scene, 4000, seed=1, wavelengths=wavelengths, threads=threads)
    caustic = photons.caustic
    for wavelength in wavelengths:
        here = photons_of(caustic, wavelength) > 0
        deviation = np.arctan2(caustic.direction[here, 1], caustic.direction[here, 0])
        straight = radiometry.prism_deviation(float(radiometry.bk7(wavelength)), apex, incidence)
        assert here.sum() > 100
        assert np.median(tilt - deviation) == pytest.approx(straight, abs=2e-4)


def outward(vertices, faces):
    """Faces of a convex body turned so that (b−a)×(c−a) points away from its centre."""
    centre, turned = vertices.mean(axis=0), []
    for a, b, c in faces:
        normal = np.cross(vertices[b] - vertices[a], vertices[c] - vertices[a])
        turned.append((a, b, c) if normal @ (vertices[a] - centre) > 0 else (a, c, b))
    return np.array(turned)


def test_no_dispersion_no_colour():
    """A medium without dispersion bends every wavelength alike, onto the closed form."""
    medium = cpm.media.LinearSquared(1.69, gradient=(0, -0.1, 0))
    rays = cpm.trace(medium, [(0, 1, 0)] * 2, [(1, 0.2, 0)] * 2, wavelength=[450.0, 650.0], length=3.0)
    expected = closed_forms.linear_squared(1.69, (0, -0.1, 0), (0, 0, 0), (0, 1, 0), (1, 0.2, 0), length=3.0)
    np.testing.assert_allclose(rays.position, [expected.position] * 2, rtol=0, atol=1e-13)
