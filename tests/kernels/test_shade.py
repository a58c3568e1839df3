"""Eye rays and what they see (cl/shared/shade.h): the kernels run from pyopencl equal the C compiler's code to the last
bit, and both agree with NumPy written from the definitions."""
from __future__ import annotations

import ctypes as ct

import numpy as np
import photon_code
import pytest
from oracles import photons
from test_parity import ROOT, build, context  # noqa: F401 - a fixture
from test_scatter import COUNT, dot, on_device, surface, tilted, units, vectors  # noqa: F401 - a fixture

SEED, WIDTH, HEIGHT = 0xFEDCBA9876543210, 24, 10


@pytest.fixture(scope="session", params=[1, 4])
def program(request, context):  # noqa: F811
    return request.param, build(context, (ROOT / "cl/kernels/shade.cl").read_text(), CPM_WIDTH=request.param)


def view(fov=60.0):
    """Forward, right and up, the last two scaled to half the picture."""
    forward, up = np.array([0.4, -0.3, -0.8]), np.array([0.1, 1.0, 0.0])
    forward /= np.linalg.norm(forward)
    right = np.cross(forward, up)
    right /= np.linalg.norm(right)
    half = np.tan(np.radians(fov / 2))
    return np.stack([forward, half * right, half * HEIGHT / WIDTH * np.cross(right, forward)])


@pytest.mark.parametrize(("sample", "samples"), [(0, 1), (0, 7), (3, 7), (5, 7)])
def test_eye(context, program, surface, sample, samples):  # noqa: F811
    """One sample in the pixel's middle; more are Sobol points, scrambled pixel by pixel."""
    v = view()
    outputs = [np.zeros((WIDTH * HEIGHT, 3))]
    (device,) = on_device(context, program, "cpm_shade_eye", [v, np.uint64(SEED), *map(np.int32, (WIDTH, HEIGHT, sample, samples))], outputs, WIDTH * HEIGHT)
    native = np.zeros_like(device)
    surface.eye(photon_code.address(v), ct.c_uint64(SEED), *map(ct.c_int32, (WIDTH, HEIGHT, sample, samples)), photon_code.address(native))
    np.testing.assert_array_equal(native, device)
    row, column = np.divmod(np.arange(WIDTH * HEIGHT), WIDTH)
    place = np.full((WIDTH * HEIGHT, 2), 0.5)
    if samples > 1:
        key = (SEED & 0xFFFFFFFF, SEED >> 32)
        point = photons.sobol(3)[sample]
        shifts = [photons.philox((p, 0, 2, 0), key)[:2] for p in range(WIDTH * HEIGHT)]
        place = np.array([[photons.uniform(photons.owen(point[k], int(shift[k])))[0] for k in range(2)] for shift in shifts])
    wanted = v[0] + (2 * (column + place[:, 0]) / WIDTH - 1)[:, None] * v[1] + (1 - 2 * (row + place[:, 1]) / HEIGHT)[:, None] * v[2]
    np.testing.assert_allclose(device, wanted / np.linalg.norm(wanted, axis=1)[:, None], rtol=0, atol=5e-16)


def test_normal(context, program, surface):  # noqa: F811
    rng = np.random.default_rng(31)
    geometric = units(rng)
    normals = np.stack([tilted(rng, geometric, 0.5) for _ in range(3)], 1).astype(np.float32)
    normals[::4] *= -1          # given for the other side
    normals[:3] = 0             # none
    normals[3] = [[1, 0, 0], [-1, 0, 0], [0, 0, 0]]
    u = rng.uniform(0, 1, COUNT)
    v = rng.uniform(0, 1, COUNT) * (1 - u)
    u[3] = v[3] = 0.5           # they cancel: 0 of the first, half of two opposite ones
    normals[3] = [[1, 0, 0], [0, 1, 0], [0, -1, 0]]
    (device,) = on_device(context, program, "cpm_shade_normal", [normals, u, v, geometric], vectors(), COUNT)
    (native,) = vectors()
    surface.normal(ct.c_size_t(COUNT), *[photon_code.address(x) for x in (normals, u, v, geometric, native)])
    np.testing.assert_array_equal(native, device)
    n = normals.astype(float)
    mixed = (1 - u - v)[:, None] * n[:, 0] + u[:, None] * n[:, 1] + v[:, None] * n[:, 2]
    length = np.linalg.norm(mixed, axis=1)
    assert np.all(length[:4] < 1e-9) and np.all(length[4:] > 0.1)
    np.testing.assert_array_equal(device[:4], geometric[:4])
    wanted = mixed[4:] / length[4:, None] * np.sign(dot(mixed, geometric))[4:, None]
    np.testing.assert_allclose(device[4:], wanted, rtol=0, atol=1e-15)


def test_bins(context, program, surface):  # noqa: F811
    """Basic radiance: L n_c^2 of a light, rho E n_c^2/(pi n_s^2) of a surface."""
    rng = np.random.default_rng(37)
    weight, reflectance = (rng.uniform(0, 1, COUNT).astype(np.float32) for _ in range(2))
    radiance, irradiance, squared = rng.uniform(0, 50, (3, COUNT))
    n = rng.uniform(0.2, 2, COUNT)
    outputs = [np.zeros(COUNT), np.zeros(COUNT), np.zeros(COUNT, np.float32)]
    given = [weight, reflectance, radiance, irradiance, squared, n]
    light, diffuse, branch = on_device(context, program, "cpm_shade_bins", given, outputs, COUNT)
    native = [np.zeros(COUNT), np.zeros(COUNT), np.zeros(COUNT, np.float32)]
    surface.bins(ct.c_size_t(COUNT), *[photon_code.address(np.ascontiguousarray(x)) for x in given], *[photon_code.address(x) for x in native])
    for host, device in zip(native, outputs, strict=True):
        np.testing.assert_array_equal(host, device)
    np.testing.assert_allclose(light, weight.astype(float) * radiance * squared, rtol=5e-16)
    np.testing.assert_allclose(diffuse, weight.astype(float) * reflectance * irradiance * squared / (np.pi * n**2), rtol=1e-15)
    np.testing.assert_allclose(branch, weight.astype(float) * n * reflectance, rtol=3e-7)
