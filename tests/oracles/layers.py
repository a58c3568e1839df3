"""Planar layers in closed form: a parabola per layer (n² linear in height), and discrete steps.

Table: heights h₀ < h₁ < …, indices n₀, n₁, …; h = up·(r − origin).
"linear-squared": n² linear in h between the heights, so each layer is `closed_forms.parabola`.
"step" (Berger and Trout's discrete layers): n constant between interfaces, Snell at each,

    p − (p·up) up conserved,   (p·up)² = n² − |p − (p·up) up|²,

total reflection where that is negative.
"""

from __future__ import annotations

import numpy as np

from . import closed_forms as forms
from .fields import vector
from .rays import Ray


def _layer(heights, h, vertical, pull):
    """Index i of the layer h_i ≤ h ≤ h_{i+1} that a ray at h enters (−1 below all, M−1 above all)."""
    if np.any(h == heights):
        i = int(np.nonzero(h == heights)[0][0])
        return i if (vertical or pull) > 0 else i - 1
    return int(np.searchsorted(heights, h)) - 1


def linear_squared(heights, n, up, base, origin, direction, *, length, turns=10_000) -> Ray:
    """March parabolas layer by layer until `length` metres of arc; n held beyond the table.

    Heights at the interfaces are set exactly, so that rounding cannot put the ray on the wrong side.
    """
    heights, n2 = np.asarray(heights, float), np.asarray(n, float) ** 2
    up, base, r = vector(up), vector(base), vector(origin)
    h = up @ (r - base)
    d = vector(direction) / np.linalg.norm(direction)
    p = np.sqrt(np.interp(h, heights, n2)) * d
    slopes = np.concatenate([[0.0], np.diff(n2) / np.diff(heights), [0.0]])
    edges = np.concatenate([[-np.inf], heights, [np.inf]])
    arc = optical = sigma_total = 0.0
    i = _layer(heights, h, p @ up, 0.0)
    for _ in range(turns):
        g = slopes[i + 1] * up
        vertical, curve = p @ up, slopes[i + 1] / 4
        exits = []
        for side, edge in enumerate(edges[i + 1 : i + 3]):
            if np.isfinite(edge):
                # start on this edge: one root is σ = 0, the other −vertical/curve
                if h == edge:
                    root = -vertical / curve if curve and -vertical / curve > 0 else np.inf
                else:
                    root = forms.smallest_positive_root(curve, vertical, h - edge)
                exits.append((root, side, edge))
        sigma, side, edge = min(exits, default=(np.inf, 0, 0.0))
        reach = forms.parabola_arc_length(p, g, sigma) if np.isfinite(sigma) else np.inf
        if arc + reach >= length:
            sigma = forms.parabola_sigma_of_length(p, g, length - arc)
            end_r, end_p = forms.parabola(r, p, g, sigma)
            optical += forms.parabola_optical_path(p, g, sigma)
            return Ray(end_r, end_p, length, optical, sigma_total + sigma)
        arc += reach
        optical += forms.parabola_optical_path(p, g, sigma)
        sigma_total += sigma
        r, p = forms.parabola(r, p, g, sigma)
        h, i = edge, i + (1 if side else -1)
    raise RuntimeError("too many layers")


def step(edges, n, up, base, origin, direction, *, length, turns=10_000) -> Ray:
    """Discrete layers: n[i] between edges[i−1] and edges[i]; len(n) = len(edges) + 1."""
    edges, n = np.asarray(edges, float), np.asarray(n, float)
    up, base, r = vector(up), vector(base), vector(origin)
    d = vector(direction) / np.linalg.norm(direction)
    h = up @ (r - base)
    i = int(np.searchsorted(edges, h, side="right" if d @ up >= 0 else "left"))
    p = n[i] * d
    arc = optical = 0.0
    for _ in range(turns):
        vertical = p @ up / n[i]
        j = i + 1 if vertical > 0 else i - 1
        edge = None
        if vertical and 0 <= j < len(n):
            edge = edges[i] if vertical > 0 else edges[i - 1]
        reach = np.inf if edge is None else (edge - h) / vertical
        if arc + reach >= length:
            rest = length - arc
            return Ray(r + p / n[i] * rest, p, length, optical + n[i] * rest)
        arc, optical = arc + reach, optical + n[i] * reach
        r, h = r + p / n[i] * reach, edge
        across = p - (p @ up) * up
        square = n[j] ** 2 - across @ across
        if square >= 0:  # refraction
            p, i = across + np.sign(vertical) * np.sqrt(square) * up, j
        else:  # total reflection
            p = p - 2 * (p @ up) * up
    raise RuntimeError("too many layers")
