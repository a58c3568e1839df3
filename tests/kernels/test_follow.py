"""Rays of a scene (cl/kernels/follow_*.cl, behind.cl): run from pyopencl against brute force over all primitives in NumPy."""
from __future__ import annotations

import numpy as np
import pyopencl as cl
import pytest
from device_world import (
    BOUNDS,
    DIFFUSE,
    EXACT,
    FLIGHT,
    HIT,
    INTEGRATED,
    LEFT,
    REGION,
    STRAIGHT,
    World,
    flights,
    follow,
)
from test_parity import CONTROL, ROOT, build, context  # noqa: F401 - a fixture

COUNT = 300
GRADIENT = (0.05, -0.4, 0.03)


def program(context, name, **values):  # noqa: F811
    return build(context, (ROOT / f"cl/kernels/{name}.cl").read_text(), **values)


def cases(seed=1, inside=True):
    rng = np.random.default_rng(seed)
    return rng.uniform(-0.9, 0.9, (COUNT, 3)) + (0 if inside else [0, 2.2, 0]), rng.normal(size=(COUNT, 3))


def check(world, given, arrivals, tolerance):
    """Each arrival is on the primitive that brute force finds, where it finds it; the rest have left."""
    hits = 0
    for flight, a in zip(given, arrivals, strict=True):
        r, d = flight["position"], flight["direction"]
        n = np.sqrt(world.n_squared + world.gradient @ r)
        sigma, primitive = world.first_hit(r, n * d)
        if primitive < 0:
            assert a["status"] == LEFT
            continue
        hits += 1
        position, direction, index = world.at(r, n * d, sigma)
        assert a["status"] == HIT and a["primitive"] == primitive
        np.testing.assert_allclose(a["position"], position, atol=tolerance)
        np.testing.assert_allclose(a["direction"], direction, atol=tolerance)
        assert a["n"] == pytest.approx(index, abs=tolerance)
    assert COUNT / 2 < hits


@pytest.mark.parametrize("inside", [True, False])
def test_straight(context, inside):  # noqa: F811
    positions, directions = cases(inside=inside)
    if not inside:
        directions = cases(seed=2)[0] - positions
    world, given = World(n_squared=1.44), flights(positions, directions)
    kernel = cl.Kernel(program(context, "follow_straight"), "cpm_follow_straight")
    check(world, given, follow(context, kernel, world, given, 7), 1e-12)


@pytest.mark.parametrize("name", ["parabolas", "exact"])
@pytest.mark.parametrize("width", [1, 8])
def test_parabolas(context, name, width):  # noqa: F811
    """Both kernels of closed forms, in lanes and alone: the parabola of a linear n^2."""
    world, given = World(1.69, GRADIENT, EXACT), flights(*cases())
    kernel = cl.Kernel(program(context, f"follow_{name}", CPM_WIDTH=width, CPM_MEDIA=3), f"cpm_follow_{name}")
    check(world, given, follow(context, kernel, world, given, 5, np.int32(0)), 1e-11)


@pytest.mark.parametrize(("method", "step", "rtol", "tolerance"), [(3, 0.02, 1e-5, 1e-6), (4, 0.0, 1e-9, 1e-7), (5, 0.0, 1e-9, 1e-7)])
def test_integrated(context, method, step, rtol, tolerance):  # noqa: F811
    """rk4 of fixed steps, dopri5 and nystrom: the same parabola within their tolerance."""
    world, given = World(1.69, GRADIENT, INTEGRATED, method), flights(*cases())
    control = np.zeros(1, CONTROL)
    control["method"], control["dense"], control["rtol"], control["step"] = method, 1, rtol, step
    control["max_step"], control["max_evaluations"] = 1e300, 1e6
    buffer = cl.Buffer(context, cl.mem_flags.READ_ONLY | cl.mem_flags.COPY_HOST_PTR, hostbuf=control)
    kernel = cl.Kernel(program(context, "follow_integrated", CPM_WIDTH=8, CPM_MEDIA=3, CPM_METHODS=1 << method), "cpm_follow_integrated")
    check(world, given, follow(context, kernel, world, given, 5, np.int32(0), buffer), tolerance)


def test_segments_do_not_change_rays(context):  # noqa: F811
    world, given = World(1.69, GRADIENT, EXACT), flights(*cases())
    kernel = cl.Kernel(program(context, "follow_parabolas", CPM_WIDTH=8, CPM_MEDIA=3), "cpm_follow_parabolas")
    few, many = (follow(context, kernel, world, given, items, np.int32(0)) for items in (1, 100))
    assert few.tobytes() == many.tobytes()


def test_behind_a_boundary(context):  # noqa: F811
    """Into the sphere and out of it: medium 1 is added to what contains a ray, or taken from it; at walls nothing changes."""
    world = World(kinds=(DIFFUSE,) * 5 + (BOUNDS,), ball_medium=1)
    positions, directions = cases()
    center = world.sphere["center"][0]
    outside = np.linalg.norm(positions - center, axis=1) > 0.31
    given = flights(positions[outside], directions[outside])
    inside = flights(center + 0.2 * directions / np.linalg.norm(directions, axis=1)[:, None], np.roll(directions, 1, 0))
    inside["region"]["count"], inside["region"]["media"][:, 1] = 2, 1
    given = np.concatenate([given, inside]).astype(FLIGHT)  # concatenation packs
    straight = cl.Kernel(program(context, "follow_straight"), "cpm_follow_straight")
    arrivals = follow(context, straight, world, given, 3)
    queue, flags = cl.CommandQueue(context), cl.mem_flags
    buffers = [cl.Buffer(context, flags.READ_WRITE | flags.COPY_HOST_PTR, hostbuf=x)
               for x in (given, arrivals, np.array([len(given)], np.int32))]
    cl.Kernel(program(context, "behind"), "cpm_behind")(queue, (1,), (1,), *world.buffers(context), *buffers, np.int32(len(given)))
    cl.enqueue_copy(queue, arrivals, buffers[1])
    queue.finish()
    assert arrivals["behind"].dtype == REGION
    ball = arrivals["primitive"] == len(world.corners)
    before = given["region"]["count"]
    assert set(before[ball]) == {1, 2}
    expected = np.where(ball, 3 - before, before)
    assert np.array_equal(arrivals["behind"]["count"][arrivals["status"] == HIT], expected[arrivals["status"] == HIT])
    assert np.all(arrivals["behind"]["media"][ball & (before == 1), 1] == 1)


def test_straight_has_left_where_nothing_is(context):  # noqa: F811
    world = World(way=STRAIGHT)
    given = flights(np.array([[0, 2.0, 0]]), np.array([[0, 1.0, 0]]))
    kernel = cl.Kernel(program(context, "follow_straight"), "cpm_follow_straight")
    a = follow(context, kernel, world, given, 1)[0]
    assert a["status"] == LEFT and a["position"][1] == pytest.approx(4.0, abs=1e-12)
