"""Pinhole camera of DESIGN section 8: row 0 top, column 0 left, right = forward × up, horizontal fov."""

from __future__ import annotations

import numpy as np


def directions(size, origin, target, up, fov):
    """Unit directions (H, W, 3) through the pixels' centres; `size` = (width, height), fov in degrees."""
    width, height = size
    forward = np.subtract(target, origin).astype(float)
    forward /= np.linalg.norm(forward)
    right = np.cross(forward, up)
    right /= np.linalg.norm(right)
    above = np.cross(right, forward)
    half = np.tan(np.radians(fov) / 2)
    x = (2 * (np.arange(width) + 0.5) / width - 1) * half
    y = (1 - 2 * (np.arange(height) + 0.5) / height) * half * height / width
    d = forward + x[None, :, None] * right + y[:, None, None] * above
    return d / np.linalg.norm(d, axis=-1, keepdims=True)
