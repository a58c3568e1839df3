"""What happens to one photon, from the definitions, in NumPy: random numbers, low-discrepancy points, directions, codes."""

from __future__ import annotations

import numpy as np
from scipy.stats import qmc

MASK = 0xFFFFFFFF


def philox(counter, key):
    """Philox 4x32-10 of one counter (4 integers) and key (2), as Salmon et al. (2011) write it, in Python's integers."""
    c, k = [int(x) for x in counter], [int(x) for x in key]
    for _ in range(10):
        p0, p1 = 0xD2511F53 * c[0], 0xCD9E8D57 * c[2]
        c = [(p1 >> 32) ^ c[1] ^ k[0], p1 & MASK, (p0 >> 32) ^ c[3] ^ k[1], p0 & MASK]
        k = [(k[0] + 0x9E3779B9) & MASK, (k[1] + 0xBB67AE85) & MASK]
    return c


def uniform(bits):
    """The middles of 2^32 cells of (0, 1)."""
    return (np.asarray(bits, float) + 0.5) / 2**32


def sobol(bits):
    """The first 2^bits points in four dimensions as 32-bit integers, by index (SciPy's come in Gray code's order)."""
    points = qmc.Sobol(4, scramble=False, bits=32).random_base2(bits)
    n = np.arange(2**bits)
    ordered = np.empty_like(points)
    ordered[n ^ (n >> 1)] = points
    return (ordered * 2**32).astype(np.uint64)


def reverse(x):
    """32 bits, the last first."""
    return np.array([int(f"{int(v):032b}"[::-1], 2) for v in np.atleast_1d(x)], np.uint64)


def owen(x, seed):
    """Nested scrambling by a hash of the bits above (Laine and Karras; constants of Vegdahl), on Python's integers."""
    out = []
    for v in reverse(x).tolist():
        v ^= v * 0x3D20ADEA & MASK
        v = (v + seed) & MASK
        v = v * ((seed >> 16) | 1) & MASK
        v ^= v * 0x05526C56 & MASK
        v ^= v * 0x53A22864 & MASK
        out.append(v)
    return reverse(out)


def frame(n):
    """Duff et al.'s two tangents to unit vectors (N, 3)."""
    x, y, z = n.T
    sign = np.where(z < 0, -1.0, 1.0)
    a = -1 / (sign + z)
    b = x * y * a
    return (np.stack([1 + sign * x * x * a, sign * b, -sign * x], 1), np.stack([b, sign + y * y * a, -y], 1))


def about(n, cosine, turn):
    """Unit vectors at an angle from n, at an azimuth in turns."""
    s, t = frame(n)
    sine, phi = np.sqrt(1 - cosine * cosine), 2 * np.pi * turn
    return cosine[:, None] * n + (sine * np.cos(phi))[:, None] * s + (sine * np.sin(phi))[:, None] * t


def decode(code):
    """Directions (N, 3) of octahedral codes, by unfolding."""
    code = np.asarray(code, np.uint32)
    u = (code & 0xFFFF).astype(np.uint16).astype(np.int16) / 32767.0
    v = (code >> 16).astype(np.uint16).astype(np.int16) / 32767.0
    z = 1 - abs(u) - abs(v)
    x = np.where(z < 0, (1 - abs(v)) * np.where(u < 0, -1, 1), u)
    y = np.where(z < 0, (1 - abs(u)) * np.where(v < 0, -1, 1), v)
    d = np.stack([x, y, z], 1)
    return d / np.linalg.norm(d, axis=1)[:, None]


def fresnel(cosine, n1, n2):
    """Reflectance for unpolarised light by the angles themselves (sine and tangent formulas); 1 where it is total."""
    a = np.arccos(np.clip(cosine, -1, 1))
    s = n1 / n2 * np.sin(a)
    b = np.arcsin(np.clip(s, -1, 1))
    with np.errstate(invalid="ignore", divide="ignore"):
        r = 0.5 * ((np.sin(a - b) / np.sin(a + b))**2 + (np.tan(a - b) / np.tan(a + b))**2)
    return np.where(s >= 1, 1.0, r)
