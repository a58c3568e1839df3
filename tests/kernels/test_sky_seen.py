"""The sky (cl/shared/sky.h): the kernel on PoCL against NumPy written from the definitions."""

import numpy as np
import pyopencl as cl
import pytest
from test_parity import ROOT, build, context  # noqa: F401 - a fixture

SKY = np.dtype([("axis", "f8", 3), ("north", "f8", 3), ("east", "f8", 3), ("sine", "f8"), ("kind", "i4"), ("width", "i4"),
                ("height", "i4"), ("bins", "i4")])
SUN, IMAGE = 1, 3


def seen(context, sky, limb, pixels, bin, directions):  # noqa: F811
    program = build(context, (ROOT / "cl/kernels/sky.cl").read_text())
    queue, flags = cl.CommandQueue(context), cl.mem_flags
    given = [cl.Buffer(context, flags.READ_ONLY | flags.COPY_HOST_PTR, hostbuf=np.ascontiguousarray(x))
             for x in (sky, limb, pixels, directions)]
    out = np.zeros(len(directions))
    buffer = cl.Buffer(context, flags.WRITE_ONLY, out.nbytes)
    cl.Kernel(program, "cpm_sky")(queue, (len(directions),), None, *given[:3], np.int32(bin), given[3], buffer)
    cl.enqueue_copy(queue, out, buffer)
    queue.finish()
    return out


def frame():
    up = np.array((0.2, 0.9, -0.4))
    up /= np.linalg.norm(up)
    north = np.cross(up, (0.3, 0.1, 1.0))
    north /= np.linalg.norm(north)
    return up, north, np.cross(north, up)


def test_sun(context):  # noqa: F811
    axis = frame()[0]
    radius, limb = np.radians(0.2666), np.array((0.3, 1.2, -0.9, 0.8, -0.5, 0.1))
    sky = np.zeros(1, SKY)
    sky["axis"], sky["sine"], sky["kind"] = axis, np.sin(radius), SUN
    rng = np.random.default_rng(1)
    angle, turn = radius * np.sqrt(rng.uniform(0, 1.5, 2000)), rng.uniform(0, 2 * np.pi, 2000)
    s, t = frame()[1:]
    d = np.outer(np.cos(angle), axis) + np.sin(angle)[:, None] * (np.outer(np.cos(turn), s) + np.outer(np.sin(turn), t))
    found = seen(context, sky, limb, np.zeros(1, np.float32), 0, np.concatenate([d, -d]))
    mu = np.sqrt(np.maximum(1 - (np.sin(angle) / np.sin(radius)) ** 2, 0))
    inside = angle < radius * (1 - 1e-9)
    np.testing.assert_allclose(found[:2000][inside], np.polyval(limb[::-1], mu[inside]), rtol=1e-6)
    assert not found[:2000][angle > radius * (1 + 1e-9)].any() and not found[2000:].any()


@pytest.mark.parametrize("shape", [(8, 16, 3), (1, 1, 1), (2, 1, 2), (5, 7, 1)])
def test_image(context, shape):  # noqa: F811
    """Bilinear; columns go around, rows are held at the poles."""
    rng = np.random.default_rng(2)
    pixels = rng.uniform(size=shape).astype(np.float32)
    up, north, east = frame()
    sky = np.zeros(1, SKY)
    sky["axis"], sky["north"], sky["east"], sky["kind"] = up, north, east, IMAGE
    sky["height"], sky["width"], sky["bins"] = shape
    d = rng.normal(size=(4000, 3))
    d /= np.linalg.norm(d, axis=1, keepdims=True)
    d[0], d[1], d[2] = up, -up, -north
    bin = shape[2] - 1
    found = seen(context, sky, np.zeros(6), pixels, bin, d)
    row = np.clip(np.arccos(np.clip(d @ up, -1, 1)) / np.pi * shape[0] - 0.5, 0, shape[0] - 1)
    column = (np.arctan2(d @ east, d @ north) + np.pi) / (2 * np.pi) * shape[1] - 0.5
    r0, c0 = np.floor(row).astype(int), np.floor(column).astype(int)
    r1, dr, dc = np.minimum(r0 + 1, shape[0] - 1), row - r0, column - c0
    image = pixels[..., bin].astype(float)
    expected = ((1 - dr) * ((1 - dc) * image[r0, c0 % shape[1]] + dc * image[r0, (c0 + 1) % shape[1]])
                + dr * ((1 - dc) * image[r1, c0 % shape[1]] + dc * image[r1, (c0 + 1) % shape[1]]))
    np.testing.assert_allclose(found[3:], expected[3:], rtol=1e-9, atol=1e-12)
    assert np.isfinite(found).all() and found.min() >= 0 and found.max() <= image.max()
