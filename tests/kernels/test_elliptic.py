"""cl/shared/elliptic.h and arctangent.h on the device, against SciPy and NumPy."""
from __future__ import annotations

import numpy as np
import pyopencl as cl
import pytest
from scipy.special import ellipeinc
from test_parity import build

SOURCE = """
#include "shared/elliptic.h"
__kernel void arcs(__global const double *in, __global double *out) {
    size_t i = get_global_id(0);
    __global const double *a = in + 4 * i;
    out[2 * i] = cpm_elliptic_arc(a[0], a[1], a[2], a[3]);
    out[2 * i + 1] = cpm_elliptic_inverse(a[0], a[1], a[2], out[2 * i]);
}
__kernel void angles(__global const double *in, __global double *out) {
    size_t i = get_global_id(0);
    out[i] = cpm_atan2(in[2 * i], in[2 * i + 1]);
}
"""


@pytest.fixture(scope="module")
def context():
    return cl.Context([cl.get_platforms()[0].get_devices()[0]])


def run(context, name, rows, width):
    queue, flags = cl.CommandQueue(context), cl.mem_flags
    rows = np.ascontiguousarray(rows)
    out = np.zeros((len(rows), width))
    source = cl.Buffer(context, flags.READ_ONLY | flags.COPY_HOST_PTR, hostbuf=rows)
    result = cl.Buffer(context, flags.WRITE_ONLY, out.nbytes)
    getattr(build(context, SOURCE), name)(queue, (len(rows),), None, source, result)
    cl.enqueue_copy(queue, out, result)
    return out


def expected_arc(q2, k2, u, du):
    """∫√(q² + k² sin²): Q (E(v₁ | m) − E(v₀ | m)) with Q² = q² + k², m = k²/Q², v = u − π/2."""
    m = k2 / (q2 + k2)
    return np.sqrt(q2 + k2) * (ellipeinc(u + du - np.pi / 2, m) - ellipeinc(u - np.pi / 2, m))


def test_arcs(context):
    """Random ones, over ratios q/k from 1e-9 to 1e9, any phase, up to six half turns; the inverse comes back."""
    rng = np.random.default_rng(2)
    q, k = 10 ** rng.uniform(-6, 3, 4000), 10 ** rng.uniform(-3, 3, 4000)
    rows = np.stack([q * q, k * k, rng.uniform(-4, 4, 4000), 10 ** rng.uniform(-2, 1.2, 4000)], axis=1)
    out, expected = run(context, "arcs", rows, 2), expected_arc(*rows.T)
    # SciPy measures from v = 0, a quarter turn away: its rounding is that of the longer arc
    scale = np.sqrt(rows[:, 0] + rows[:, 1]) * (0.5 * np.pi + np.abs(rows[:, 2]) + rows[:, 3])
    assert np.max(np.abs(out[:, 0] - expected) / scale) < 2e-15
    speed = np.sqrt(rows[:, 0] + rows[:, 1] * np.sin(rows[:, 2] + rows[:, 3]) ** 2)
    assert np.max(np.abs(out[:, 1] - rows[:, 3]) * speed / scale) < 4e-15


def test_short_arcs(context):
    """du from 1e-14 on, relative: against Gauss–Legendre where the integrand is smooth, closed forms where q = 0."""
    rng = np.random.default_rng(3)
    u, du = rng.uniform(0.3, 1.2, 2000), 10 ** rng.uniform(-14, -1, 2000)
    x, w = np.polynomial.legendre.leggauss(20)
    t = u[:, None] + 0.5 * du[:, None] * (1 + x)
    rows = np.stack([np.full_like(u, 0.04), np.ones_like(u), u, du], axis=1)
    expected = 0.5 * du * (np.sqrt(0.04 + np.sin(t) ** 2) @ w)
    got = run(context, "arcs", rows, 2)
    np.testing.assert_allclose(got[:, 0], expected, rtol=5e-15)
    np.testing.assert_allclose(got[:, 1], du, rtol=2e-14)
    rows[:, 0], rows[:, 2] = 0.0, 0.0  # from the cusp: 1 − cos du = 2 sin²(du/2)
    np.testing.assert_allclose(run(context, "arcs", rows, 2)[:, 0], 2 * np.sin(du / 2) ** 2, rtol=1e-13, atol=1e-32)


def test_atan2(context):
    """Against NumPy to 2 ulp over all quadrants and ratios; zeros and axes exact."""
    rng = np.random.default_rng(4)
    rows = rng.normal(size=(20000, 2)) * 10 ** rng.uniform(-150, 150, (20000, 2))
    rows[:9] = [(0, 0), (0, 1), (0, -1), (1, 0), (-1, 0), (1, 1), (1, -1), (-1, -1), (-1, 1)]
    got, expected = run(context, "angles", rows, 1)[:, 0], np.arctan2(rows[:, 0], rows[:, 1])
    assert np.max(np.abs(got - expected) / np.spacing(np.abs(expected) + 1e-300)) <= 2
