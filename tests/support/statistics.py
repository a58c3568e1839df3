"""χ² and z for fixed seeds.  Thresholds: |z| < 4 and p > 1e-4, so that a right sampler fails once in 1e4 tests."""

from __future__ import annotations

import numpy as np
from scipy import stats

Z_LIMIT = 4.0
P_LIMIT = 1e-4


def chi_square(observed, expected):
    """p-value of counts against expected counts (scaled to the same total); cells of at least 5."""
    observed, expected = np.ravel(observed).astype(float), np.ravel(expected).astype(float)
    expected = expected * observed.sum() / expected.sum()
    assert expected.min() >= 5, "cells too small for χ²"
    return stats.chi2.sf(np.sum((observed - expected) ** 2 / expected), len(observed) - 1)


def assert_uniform(values, low, high, bins=20):
    """Values uniform on [low, high]."""
    values = np.asarray(values)
    assert values.min() >= low - 1e-6 and values.max() <= high + 1e-6, (values.min(), values.max())
    counts = np.histogram(np.clip(values, low, high), bins=bins, range=(low, high))[0]
    p = chi_square(counts, np.ones(bins))
    assert p > P_LIMIT, f"p = {p:.2g}, counts {counts}"


def assert_uniform_pair(u, v, low, high, bins=8):
    """Jointly uniform on a rectangle: independence too."""
    counts = np.histogram2d(u, v, bins=bins, range=[[low[0], high[0]], [low[1], high[1]]])[0]
    p = chi_square(counts, np.ones(counts.size))
    assert p > P_LIMIT, f"p = {p:.2g}"


def z_of_mean(samples, expected):
    """z of the mean of independent samples (K, …) against `expected`."""
    samples = np.asarray(samples, float)
    error = samples.std(axis=0, ddof=1) / np.sqrt(len(samples))
    return (samples.mean(axis=0) - expected) / np.maximum(error, 1e-300)
