"""Fibres over very many periods (DESIGN section 13): the symplectic methods keep the transverse energy.

n² = n₀²(1 − α²ρ²): in σ each transverse coordinate is an oscillator of frequency ω = n₀α, and
E = |p_⊥|²/2 + ω²ρ²/2 is conserved, whatever the ray does along the axis.
"""
import numpy as np
import pytest

import cpm

N, ALPHA = 1.5, 1.0
ORIGIN, DIRECTION = (0.3, 0.0, 0.0), (0.0, 0.15, 1.0)
PER_PERIOD = 160   # steps
PART = 0.13        # of a period, beyond the whole ones: where the energy error is far from its zeros


def run(periods, method="yoshida6"):
    """Relative error of the transverse energy, and of the phase (radians), after many periods."""
    omega = N * ALPHA
    n = N * np.sqrt(1 - (ALPHA * ORIGIN[0]) ** 2)
    p = n * np.array(DIRECTION) / np.linalg.norm(DIRECTION)
    sigma = 2 * np.pi * (periods + PART) / omega   # at whole periods the energy error hides
    rays = cpm.trace(cpm.media.Parabolic(N, alpha=ALPHA), [ORIGIN], [DIRECTION], wavelength=550.0,
                     until=((0, 0, p[2] * sigma), (0, 0, 1)), method=method,
                     step=2 * np.pi / omega / PER_PERIOD * n, max_evaluations=10**10)
    assert rays.status[0] == cpm.RayStatus.ARRIVED
    energy = lambda r, q: 0.5 * (q[0] ** 2 + q[1] ** 2 + omega**2 * (r[0] ** 2 + r[1] ** 2))  # noqa: E731
    start = energy(ORIGIN, p)
    found = rays.position[0], rays.momentum[0]
    phase = np.arctan2(-found[1][0], omega * found[0][0]) - 2 * np.pi * PART   # x = 0.3 cos ωσ
    return abs(energy(*found) / start - 1), phase


@pytest.mark.parametrize("periods", [10, 1000])
def test_energy_is_kept(periods):
    """1e-9 of the transverse energy, however many periods; the phase error grows in proportion, as it must."""
    energy, phase = run(periods)
    assert energy < 1e-9
    assert abs(phase) < 1e-8 * periods


def test_rk4_loses_what_the_symplectic_keeps():
    """The same steps by rk4 lose energy in proportion to the length: what the symplectic methods are for."""
    assert run(1000, "rk4")[0] > 100 * run(1000)[0]


def test_single_precision_counts_beyond_2_to_24():
    """16 000 periods are 1.8e7 evaluations, fewer than the 1e9 allowed."""
    rays = cpm.trace(cpm.media.Parabolic(N, alpha=ALPHA), [ORIGIN], [DIRECTION], wavelength=550.0, length=16_000 * 2 * np.pi / ALPHA,
                     method="yoshida6", step=2 * np.pi / ALPHA / PER_PERIOD, max_evaluations=10**9, precision="single")
    assert rays.status[0] == cpm.RayStatus.ARRIVED


@pytest.mark.long
def test_a_million_periods(record_property):
    """10⁶ periods: bounded by the same 1e-9, phase error reported."""
    energy, phase = run(10**6)
    record_property("energy", energy)
    record_property("phase", phase)
    print(f"10^6 periods: energy {energy:.2e}, phase {phase:.2e} rad")
    assert energy < 1e-9
