"""Snell, Fresnel, and the dispersion formulas, as in any optics text (Born and Wolf, 1.5.2).

Wavelengths are nanometres in the interface and micrometres inside the formulas (DESIGN section 6).
"""

from __future__ import annotations

import numpy as np

#: SCHOTT N-BK7 data sheet: n² − 1 = Σ B λ²/(λ² − C), λ in µm, C in µm².
BK7_B = (1.03961212, 0.231792344, 1.01046945)
BK7_C = (0.00600069867, 0.0200179144, 103.560653)
#: SCHOTT N-BK7 data sheet: n at the lines i, F, d, C (nm).
BK7_LINES = {365.0146: 1.53627, 486.1327: 1.52238, 587.5618: 1.51680, 656.2725: 1.51432}


def sellmeier(wavelength, b, c):
    """n(λ nm): n² = 1 + Σ B λ²/(λ² − C)."""
    square = (np.asarray(wavelength, float)[..., None] / 1000) ** 2
    return np.sqrt(1 + np.sum(np.asarray(b) * square / (square - np.asarray(c)), axis=-1))


def bk7(wavelength):
    """n of N-BK7 in air, λ in nm."""
    return sellmeier(wavelength, BK7_B, BK7_C)


def cauchy(wavelength, *coefficients):
    """n(λ nm) = A + B/λ² + C/λ⁴ + …, λ in µm."""
    um = np.asarray(wavelength, float) / 1000
    return sum(c / um ** (2 * i) for i, c in enumerate(coefficients))


def snell(direction, normal, n1, n2):
    """Refracted unit direction (3,), or None under total reflection; `normal` on either side."""
    d, m = np.asarray(direction, float), np.asarray(normal, float)
    cosine = -(d @ m)
    if cosine < 0:
        m, cosine = -m, -cosine
    ratio = n1 / n2
    square = 1 - ratio**2 * (1 - cosine**2)
    if square < 0:
        return None
    return ratio * d + (ratio * cosine - np.sqrt(square)) * m


def fresnel(cosine, n1, n2):
    """Unpolarised reflectance for the cosine of the angle of incidence in n1."""
    cosine = np.clip(np.abs(np.asarray(cosine, float)), 0, 1)
    square = 1 - (n1 / n2) ** 2 * (1 - cosine**2)
    inside = np.sqrt(np.maximum(square, 0))
    s = ((n1 * cosine - n2 * inside) / (n1 * cosine + n2 * inside)) ** 2
    p = ((n2 * cosine - n1 * inside) / (n2 * cosine + n1 * inside)) ** 2
    return np.where(square < 0, 1.0, 0.5 * (s + p))


def prism_deviation(n, apex, incidence):
    """Deviation (radians) of a ray through a prism of apex angle `apex` in n = 1 (both radians)."""
    inner = np.arcsin(np.sin(incidence) / n)
    out = np.arcsin(n * np.sin(apex - inner))
    return incidence + out - apex
