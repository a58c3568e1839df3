"""Interpolated fields: a C² cubic spline of height, trilinear and tricubic B-spline grids.

The spline of height is `scipy.interpolate.CubicSpline`; the grid's coefficients are
`scipy.ndimage.spline_filter(order=3)` and the basis is written out here, since SciPy gives
no gradients.  End conditions are a choice of each implementation: tests use tables that
are flat at their ends, or rays that stay many cells inside (an end condition decays by
√3 − 2 = −0.268 a cell).
"""

from __future__ import annotations

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.ndimage import spline_filter

from .fields import OfHeight, OfIndex, vector


def layered_cubic(heights, n, up=(0, 1, 0), origin=(0, 0, 0), bc_type="natural"):
    """n(h) as a C² cubic spline; the oracle's steps are bounded by half a layer, since n‴ jumps at the knots."""
    spline = CubicSpline(heights, n, bc_type=bc_type)
    slope = spline.derivative()
    return OfHeight(lambda h: (float(spline(h)), float(slope(h))), up, origin, max_step=np.max(np.diff(heights)) / 2)


def _cell(values, origin, spacing, r):
    """Cell index (3,) and fraction (3,) of a point inside the grid."""
    at = (r - origin) / spacing
    cell = np.clip(np.floor(at).astype(int), 0, np.array(values.shape) - 2)
    return cell, at - cell


def grid_linear(values, origin, spacing):
    """Trilinear n; the gradient jumps at the cells' faces, so steps are kept short."""
    values, origin, spacing = np.asarray(values, float), vector(origin), vector(spacing)

    def index(r):
        (i, j, k), (x, y, z) = _cell(values, origin, spacing, r)
        block = values[i : i + 2, j : j + 2, k : k + 2]
        wx, wy, wz = np.array([1 - x, x]), np.array([1 - y, y]), np.array([1 - z, z])
        d = np.array([-1.0, 1.0])
        n = np.einsum("ijk,i,j,k", block, wx, wy, wz)
        gradient = np.array(
            [
                np.einsum("ijk,i,j,k", block, d, wy, wz),
                np.einsum("ijk,i,j,k", block, wx, d, wz),
                np.einsum("ijk,i,j,k", block, wx, wy, d),
            ]
        )
        return n, gradient / spacing

    return OfIndex(index, max_step=float(np.min(spacing)) / 10)


def _basis(t):
    """Uniform cubic B-spline weights and their slopes at fraction t: (4,), (4,)."""
    u = 1 - t
    weights = np.array([u**3, 3 * t**3 - 6 * t**2 + 4, 3 * u**3 - 6 * u**2 + 4, t**3]) / 6
    slopes = np.array([-(u**2), 3 * t**2 - 4 * t, -(3 * u**2) + 4 * u, t**2]) / 2
    return weights, slopes


def grid_cubic(values, origin, spacing):
    """Tricubic interpolating B-spline (C²), mirror ends; for points at least two cells inside."""
    values, origin, spacing = np.asarray(values, float), vector(origin), vector(spacing)
    coefficients = spline_filter(values, order=3, output=np.float64, mode="mirror")

    def index(r):
        cell, fraction = _cell(values, origin, spacing, r)
        if np.any(cell < 1) or np.any(cell > np.array(values.shape) - 3):
            raise ValueError("oracle asked too near the grid's edge")
        i, j, k = cell - 1
        block = coefficients[i : i + 4, j : j + 4, k : k + 4]
        (wx, dx), (wy, dy), (wz, dz) = (_basis(t) for t in fraction)
        n = np.einsum("ijk,i,j,k", block, wx, wy, wz)
        gradient = np.array(
            [
                np.einsum("ijk,i,j,k", block, dx, wy, wz),
                np.einsum("ijk,i,j,k", block, wx, dy, wz),
                np.einsum("ijk,i,j,k", block, wx, wy, dz),
            ]
        )
        return n, gradient / spacing

    return OfIndex(index, max_step=float(np.min(spacing)) / 4)
