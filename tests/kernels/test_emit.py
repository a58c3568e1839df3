"""Emission (cl/shared/emit.h): the kernels run from pyopencl equal the native code of every instruction set to the last
bit, and both agree with NumPy written from the definitions."""
from __future__ import annotations

import ctypes as ct

import numpy as np
import photon_code
import pyopencl as cl
import pytest
from oracles import photons
from test_parity import ROOT, build, context  # noqa: F401 - a fixture

SHIFT = (0x12345678, 0x9ABCDEF0, 0x0F1E2D3C, 0xC0FFEE11)
COUNT = 1024  # paths of the light; the first of them are 0 .. COUNT - 1


@pytest.fixture(scope="session")
def codes(tmp_path_factory):
    folder = tmp_path_factory.mktemp("pass_lanes")
    return {isa: photon_code.Code(isa, folder) for isa in photon_code.supported()}


@pytest.fixture(scope="session", params=[1, 4, 8])
def program(request, context):  # noqa: F811
    return request.param, build(context, (ROOT / "cl/kernels/emit.cl").read_text(), CPM_WIDTH=request.param)


def emitter(**values):
    e = np.zeros(1, photon_code.EMITTER)
    axis = np.array([0.3, -0.8, 0.5])
    e["axis"], e["cutoff"], e["count"], e["shift"] = axis / np.linalg.norm(axis), 0.7, COUNT, SHIFT
    for name, value in values.items():
        e[name] = value
    return e


def cells(rows, columns):
    """A projection map whose cells differ much, some almost empty: cumulative, guide, weight."""
    rng = np.random.default_rng(5)
    p = rng.uniform(size=rows * columns)**4 + 1e-6
    p /= p.sum()
    cumulative = np.concatenate([[0.0], np.cumsum(p)])
    cumulative[-1] = 1.0
    guide = np.searchsorted(cumulative, np.arange(rows * columns) / (rows * columns), side="right") - 1
    return cumulative, guide.astype(np.int32), (1 / (rows * columns * p)).astype(np.float32)


def numbers(points):
    """Scrambled Sobol numbers of paths 0 .. COUNT - 1, and the walk through what is walked through."""
    index = np.arange(COUNT)
    sobol = photons.sobol(int(np.log2(COUNT)))
    even = [photons.uniform(photons.owen(sobol[:, k], SHIFT[k])) for k in range(points)]
    return even, (index + photons.uniform(SHIFT[0])) / COUNT


def on_device(context, program, name, inputs, outputs):  # noqa: F811
    width, built = program
    queue, flags = cl.CommandQueue(context), cl.mem_flags
    given = [cl.Buffer(context, flags.READ_ONLY | flags.COPY_HOST_PTR, hostbuf=np.ascontiguousarray(x)) for x in inputs]
    made = [cl.Buffer(context, flags.READ_WRITE | flags.COPY_HOST_PTR, hostbuf=x) for x in outputs]
    cl.Kernel(built, name)(queue, (COUNT // width,), None, *given, np.uint64(0), np.uint64(COUNT), *made)
    for array, buffer in zip(outputs, made, strict=True):
        cl.enqueue_copy(queue, array, buffer)
    queue.finish()
    return outputs


def native(code, name, arguments):
    """Blocks of paths put together: each field as it is in photon_code.EMISSIONS, (3, COUNT) or (COUNT,)."""
    block, parts = np.zeros(1, photon_code.EMISSIONS), []
    for first in range(0, COUNT, photon_code.BLOCK):
        getattr(code, name)(*[photon_code.address(x) for x in arguments], ct.c_uint64(first), ct.c_size_t(photon_code.BLOCK),
                            photon_code.address(block))
        parts.append(block[0].copy())
    return {field: np.concatenate([part[field] for part in parts], axis=-1) for field in photon_code.EMISSIONS.names}


def delta_reference(e, tables):
    (u, v), walked = numbers(2)
    weight = np.ones(COUNT)
    if tables is not None:
        cumulative, _, weights = tables
        cell = np.searchsorted(cumulative, walked, side="right") - 1
        rows, columns = int(e["rows"][0]), int(e["columns"][0])
        u, v = (cell // columns + u) / rows, (cell % columns + v) / columns
        weight = weights[cell].astype(float)
    return photons.about(np.repeat(e["axis"], COUNT, 0), 1 - u * e["cutoff"][0], v), weight


@pytest.mark.parametrize("projected", [False, True])
def test_point_and_spot(context, program, codes, projected):  # noqa: F811
    tables = cells(12, 20) if projected else (np.zeros(1), np.zeros(1, np.int32), np.zeros(1, np.float32))
    e = emitter(rows=12, columns=20) if projected else emitter()
    direction, weight = on_device(context, program, "cpm_emit_delta", [e, *tables], [np.zeros((COUNT, 3)), np.zeros(COUNT)])
    for isa, code in codes.items():
        made = native(code, "emit_delta", [e, *tables])
        np.testing.assert_array_equal(made["direction"].T, direction, err_msg=isa)
        np.testing.assert_array_equal(made["weight"], weight, err_msg=isa)
    wanted, wanted_weight = delta_reference(e, tables if projected else None)
    np.testing.assert_allclose(direction, wanted, rtol=0, atol=4e-15)
    np.testing.assert_array_equal(weight, wanted_weight)


def test_area_of_triangles(context, program, codes):  # noqa: F811
    corners = np.random.default_rng(9).normal(size=(7, 3, 3))
    triangles = photon_code.triangles_of(corners)
    areas = 0.5 * np.linalg.norm(triangles["normal"], axis=1)
    area = np.concatenate([[0.0], np.cumsum(areas)])
    e = emitter(primitive=11, triangles=len(triangles))
    outputs = [np.zeros((COUNT, 3)), np.zeros((COUNT, 3)), np.zeros((COUNT, 3)), np.zeros(COUNT, np.int32)]
    point, normal, direction, primitive = on_device(context, program, "cpm_emit_area", [e, triangles, area], outputs)
    for isa, code in codes.items():
        made = native(code, "emit_area", [e, triangles, area])
        for name, got in (("position", point), ("normal", normal), ("direction", direction)):
            np.testing.assert_array_equal(made[name].T, got, err_msg=f"{isa} {name}")
        np.testing.assert_array_equal(made["primitive"], primitive, err_msg=isa)
    (u, v, s, t), walked = numbers(4)
    which = np.searchsorted(area, walked * area[-1], side="right") - 1
    np.testing.assert_array_equal(primitive, 11 + which)
    b1, b2 = np.sqrt(u) * (1 - v), np.sqrt(u) * v
    a, b, c = (corners[which, k] for k in range(3))
    np.testing.assert_allclose(point, (1 - b1 - b2)[:, None] * a + b1[:, None] * b + b2[:, None] * c, rtol=0, atol=1e-14)
    unit = triangles["normal"] / np.linalg.norm(triangles["normal"], axis=1)[:, None]
    np.testing.assert_allclose(normal, unit[which], rtol=0, atol=4e-15)
    np.testing.assert_allclose(direction, photons.about(unit[which], np.sqrt(1 - s), t), rtol=0, atol=4e-14)


def test_area_of_a_sphere(context, program, codes):  # noqa: F811
    center, radius = np.array([1.0, -2.0, 0.5]), 0.75
    e = emitter(position=center, radius=radius, primitive=3)
    nothing = [np.zeros(1, photon_code.TRIANGLE), np.zeros(1)]
    outputs = [np.zeros((COUNT, 3)), np.zeros((COUNT, 3)), np.zeros((COUNT, 3)), np.zeros(COUNT, np.int32)]
    point, normal, direction, primitive = on_device(context, program, "cpm_emit_area", [e, *nothing], outputs)
    for isa, code in codes.items():
        made = native(code, "emit_area", [e, *nothing])
        for name, got in (("position", point), ("normal", normal), ("direction", direction)):
            np.testing.assert_array_equal(made[name].T, got, err_msg=f"{isa} {name}")
    (u, v, s, t), _ = numbers(4)
    up = np.repeat([[0.0, 0.0, 1.0]], COUNT, 0)
    np.testing.assert_allclose(normal, photons.about(up, 1 - 2 * u, v), rtol=0, atol=4e-15)
    np.testing.assert_allclose(point, center + radius * normal, rtol=0, atol=4e-16)
    np.testing.assert_allclose(direction, photons.about(normal, np.sqrt(1 - s), t), rtol=0, atol=4e-15)
    assert np.all(primitive == 3)


def into_box(e, d, p, v):
    """Entry of direction d into the box, face by face: by the shadow of each, uniform on it."""
    low, high = e["low"][0], e["high"][0]
    size = high - low
    shadows = np.abs(d) * (np.prod(size) / size)
    whole = shadows.sum(axis=1)
    face = (p[:, None] * whole[:, None] >= np.cumsum(shadows, axis=1)[:, :2]).sum(axis=1)
    rows = np.arange(len(d))
    before = np.cumsum(shadows, axis=1)[rows, face] - shadows[rows, face]
    u = (p * whole - before) / shadows[rows, face]
    others = np.array([(1, 2), (0, 2), (0, 1)])[face]
    point = np.zeros_like(d)
    point[rows, face] = np.where(d[rows, face] < 0, 1.0, 0.0)
    point[rows, others[:, 0]], point[rows, others[:, 1]] = u, v
    return low + point * size, whole


@pytest.mark.parametrize("image", [False, True])
def test_sun_and_environment(context, program, codes, image):  # noqa: F811
    rows, columns = (6, 10) if image else (0, 0)
    edges = np.cos(np.linspace(0, np.pi, rows + 1)) if image else np.zeros(0)
    cumulative, _, weight = cells(rows, columns) if image else (np.zeros(1), None, np.zeros(1, np.float32))
    e = emitter(rows=rows, columns=columns, low=(-1, 0, 2), high=(3, 1.5, 9))
    axis = e["axis"][0]
    north = np.cross(axis, (0.0, 0.0, 1.0))
    e["position"] = north = north / np.linalg.norm(north)
    tables = [np.concatenate([cumulative, edges]), weight]
    outputs = [np.zeros((COUNT, 3)), np.zeros((COUNT, 3)), np.zeros(COUNT)]
    point, direction, power = on_device(context, program, "cpm_emit_far", [e, *tables], outputs)
    for isa, code in codes.items():
        made = native(code, "emit_far", [e, *tables])
        np.testing.assert_array_equal(made["position"].T, point, err_msg=isa)
        np.testing.assert_array_equal(made["direction"].T, direction, err_msg=isa)
        np.testing.assert_array_equal(made["weight"], power, err_msg=isa)
    (u, v, p, q), walked = numbers(4)
    if image:
        cell = np.searchsorted(cumulative, walked, side="right") - 1
        top, bottom = edges[cell // columns], edges[cell // columns + 1]
        cosine, azimuth = top + u * (bottom - top), 2 * np.pi * (cell % columns + v) / columns - np.pi
        sine, east = np.sqrt(1 - cosine**2), np.cross(north, axis)
        toward = (np.outer(cosine, axis) + np.outer(sine * np.cos(azimuth), north) + np.outer(sine * np.sin(azimuth), east))
        share = weight[cell].astype(float)
    else:
        toward, share = photons.about(np.repeat(e["axis"], COUNT, 0), 1 - u * e["cutoff"][0], v), np.ones(COUNT)
    np.testing.assert_allclose(direction, -toward, rtol=0, atol=2e-15)
    wanted, shadow = into_box(e, -toward, p, q)
    np.testing.assert_allclose(power, share * shadow, rtol=1e-13)
    near = np.abs(point - wanted).max(axis=1) < 1e-9  # a number on the border of two faces may fall on either
    assert near.sum() >= COUNT - 2
    assert np.all((point >= e["low"][0] - 1e-12) & (point <= e["high"][0] + 1e-12))
