"""A ray through n = (n₁ + n₂)/2 − (n₁ − n₂)/2 · tanh(y/w) by quadrature: any width, grazing or not.

p_x is conserved, so x and the arc length are integrals over y,

    dx = p_x/p_y dy,   dl = n/p_y dy,   p_y² = (n − p_x)(n + p_x),

taken in t = y/w as differences from the two straight legs of the sharp step; n − p_x is formed without cancellation
from δ = n₂ − p_x. δ > 0: refracted (Snell). δ < 0: turned, at 1 + e^{2t} = (n₁ − n₂)/(−δ), where t = t_turn − u²
makes the integrand smooth.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from scipy.integrate import quad

from .rays import Ray

FAR = 40.0  # widths: beyond, the layer is over to e^(−80)


def trace(width, n1, n2, delta, depth, length) -> Ray:
    """From (0, −depth, 0), the denser side n₁, upwards with p_x = n₂ − delta; ends after `length` metres of arc.

    Start and end must be at least FAR widths from y = 0. The optical path is not computed (NaN).
    """
    drop, px = n1 - n2, n2 - delta
    across = [px, np.sqrt((n1 - px) * (n1 + px))]
    assert depth >= FAR * width

    def integral(f, low, high):
        edges = np.linspace(low, high, 33)
        return sum(
            quad(f, a, b, epsabs=1e-11, epsrel=1e-12, limit=200)[0] for a, b in pairwise(edges)
        )

    if delta < 0:
        top = 0.5 * np.log(drop / -delta - 1)
        most = np.sqrt(FAR + top)

        def at(u):
            t = top - u * u
            n = n2 + drop / (1 + np.exp(2 * t))
            above = drop * -np.expm1(-2 * u * u) / ((1 + np.exp(2 * t)) * (1 + np.exp(-2 * top)))
            return n, np.sqrt(above * (n + px))

        limit = np.sqrt(drop * 2 / (1 + np.exp(2 * top)) / (1 + np.exp(-2 * top)) * 2 * px)  # p_y/u at u → 0
        slim = lambda u, k: 2 * (px if k else at(u)[0]) * (u / at(u)[1] if u > 1e-9 else 1 / limit)  # noqa: E731
        shift = [
            width * (integral(lambda u, k=k: slim(u, k), 0, most) - FAR * leg / across[1])
            for k, leg in ((1, px), (0, n1))
        ]
        rest = length - 2 * (depth * n1 / across[1] + shift[1])
        assert rest >= FAR * width * n1 / across[1] - depth * n1 / across[1]
        return Ray(
            np.array([2 * (depth * px / across[1] + shift[0]) + rest * px / n1, -depth - rest * across[1] / n1, 0.0]),
            np.array([px, -across[1], 0.0]),
            length,
            np.nan,
        )

    up = np.sqrt(delta * (n2 + px))

    def of(t, k, leg):
        over = drop / (1 + np.exp(2 * t))
        n = n2 + over
        return (px if k else n) / np.sqrt((delta + over) * (n + px)) - leg

    shift = [
        width
        * (
            integral(lambda t, k=k, leg=below / across[1]: of(t, k, leg), -FAR, 0)
            + integral(lambda t, k=k, leg=above / up: of(t, k, leg), 0, FAR)
        )
        for k, below, above in ((1, px, px), (0, n1, n2))
    ]
    rest = length - depth * n1 / across[1] - shift[1]
    assert rest * up / n2 >= FAR * width
    return Ray(
        np.array([depth * px / across[1] + shift[0] + rest * px / n2, rest * up / n2, 0.0]),
        np.array([px, up, 0.0]),
        length,
        np.nan,
    )
