"""The Sun in air, measured in pictures that cpm.render makes of examples/*.toml, against rays of our own.

The reference follows rays by an ODE in polar coordinates (SciPy's DOP853 at 1e-12) in the profile's n; `limb` finds the
apparent altitude at which the true direction is that of the disc's edge.
"""

from functools import cache
from pathlib import Path

import numpy as np
import pytest
from oracles.atmosphere import bend
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline
from scipy.optimize import brentq

import cpm

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
R = 6371e3
SECOND = 1 / 3600


def load(name):
    return cpm.load_scene(EXAMPLES / f"{name}.toml")


@cache
def spline(profile, wavelength):
    """n − 1 and its slope by a spline of the profile's, which is thousands of times quicker to ask than the profile; its
    knots are half a metre apart near the ground, and at the kinks."""
    knots = np.unique(np.concatenate([np.arange(-50, 300, 0.5), np.arange(300, 11e3, 20), np.arange(11e3, profile.top, 100)]))
    n1 = CubicSpline(knots, profile.refractivity(knots, wavelength))
    return n1, n1.derivative()


def true_altitude(profile, height, apparent, wavelength):
    """Degrees, of what is seen at an apparent altitude (degrees)."""
    n1, slope = spline(profile, wavelength)
    bent = bend(lambda r: (float(n1(r - R)), float(slope(r - R))), R + height, 90.0 - apparent, R + profile.top - 1.0)
    return apparent - np.degrees(bent)


def limb(profile, height, true, wavelength, low, high):
    """Apparent altitude (degrees) at which a true one is seen, between two."""
    return brentq(lambda a: true_altitude(profile, height, a, wavelength) - true, low, high, xtol=1e-6)


def column(scene, altitudes, wavelengths):
    """One pixel wide, centred at the Sun's azimuth: radiance (rows, bins), top row first; rows at equal steps of tangent."""
    middle, half = 0.5 * (altitudes[0] + altitudes[1]), 0.5 * (altitudes[1] - altitudes[0])
    rows = round(2 * half / SECOND)
    x, y, z = scene.camera.origin
    m = np.radians(middle)
    aim = (x, y + 1e3 * np.sin(m), z - 1e3 * np.cos(m))
    scene.camera = cpm.Camera.look_at((x, y, z), aim, (0, 1, 0), fov=2 * np.degrees(np.arctan(np.tan(np.radians(half)) / rows)))
    image = cpm.render(scene, size=(1, rows), wavelengths=wavelengths, photons=0, samples=1, progress=False)
    offset = np.tan(np.radians(half)) * (1 - (2 * np.arange(rows) + 1) / rows)
    return middle + np.degrees(np.arctan(offset)), image.data[:, 0]


def edges(altitude, values):
    """Altitudes at which the disc begins and ends, to half a row: highest and lowest lit row."""
    lit = np.flatnonzero(values > 0)
    half = 0.5 * np.abs(np.diff(altitude[:2]))[0]
    return altitude[lit[0]] + half, altitude[lit[-1]] - half


@pytest.mark.parametrize(("name", "low", "high"), [("sunset_standard", -0.05, 0.6), ("sunset_inversion", -0.09, 0.5)])
def test_flattening(name, low, high):
    """Both limbs to an arc second (pixels are one); vertical over horizontal diameter to 0.001."""
    scene = load(name)
    sun, profile, height = scene.lights[0], scene.medium.profile, scene.camera.origin[1]
    altitude, data = column(scene, (low, high), [550.0])
    top, bottom = edges(altitude, data[:, 0])
    wanted = [limb(profile, height, sun.elevation + side * sun.angular_radius, 550.0, low, high) for side in (1, -1)]
    assert abs(top - wanted[0]) < 1.0 * SECOND and abs(bottom - wanted[1]) < 1.0 * SECOND
    flattening = (top - bottom) / (2 * sun.angular_radius)
    assert flattening == pytest.approx((wanted[0] - wanted[1]) / (2 * sun.angular_radius), abs=1e-3)
    assert flattening < (0.86 if name == "sunset_standard" else 0.70)


def test_green_rim():
    """The upper limb by wavelength: its altitude, and how far each colour's rim stands over that of 650 nm, to 1"."""
    scene = load("green_flash")
    scene_sun, profile, height = scene.lights[0], scene.medium.profile, scene.camera.origin[1]
    wavelengths = [450.0, 550.0, 650.0]
    raised = cpm.Scene(medium=scene.medium, rtol=1e-9)
    raised.add_light(cpm.lights.Sun(scene_sun.elevation + 0.05, 0.0))  # a little higher: all colours are up
    raised.camera = scene.camera
    altitude, data = column(raised, (-0.09, 0.0), wavelengths)
    found = np.array([edges(altitude, data[:, b])[0] for b in range(3)])
    true = scene_sun.elevation + 0.05 + scene_sun.angular_radius
    wanted = np.array([limb(profile, height, true, w, -0.09, 0.0) for w in wavelengths])
    assert np.max(np.abs(found - wanted)) < 1.0 * SECOND
    rim = (found - found[-1]) / SECOND
    assert np.all(np.diff(rim) < 0) and 15 < rim[0] < 40


def test_no_banding():
    """At an arc second a pixel, and a tenth, the sky's limb-darkened disc is as smooth as its law: second differences of
    radiance over 200 rows in the middle of the disc stay below 2e-6 of it, with the scene's own tolerance."""
    scene = load("green_flash")
    clear = cpm.Scene(medium=cpm.media.Atmosphere(scene.medium.profile), rtol=1e-9)
    clear.add_light(cpm.lights.Sun(-0.35, 0.0, radiance=1.0))
    clear.camera = scene.camera
    _, data = column(clear, (0.10, 0.10 + 200 * SECOND), [550.0])
    values = data[:, 0].astype(float)
    second = np.diff(values, 2) / values[1:-1]
    assert np.max(np.abs(second)) < 5e-6  # the film's floats have 6e-8, four of them a second difference; the law 1e-6


# ------------------------------------------------------------------------------------------ ducts, and cold air


def flat_path(profiles, until, height, apparent, wavelength):
    """A ray in the plane from the eye towards the Sun: d(n t)/ds = ∇n in Cartesian coordinates from the Earth's centre.
    `profiles` hold in turn, up to each distance of `until` (metres), the last one to the top of the air. Position and unit
    direction at the end."""
    angle = np.radians(apparent)
    state = np.array((0.0, R + height, np.cos(angle), np.sin(angle)))
    for profile, distance in zip(profiles, until, strict=True):
        n1, derivative = spline(profile, wavelength)

        def slope(_, y, n1=n1, derivative=derivative):
            r = np.hypot(y[0], y[1])
            n, bend_by = 1 + float(n1(r - R)), float(derivative(r - R))
            p = y[2:] / np.hypot(y[2], y[3])
            return np.concatenate([p, (bend_by * y[:2] / r - bend_by * (y[:2] @ p / r) * p) / n])

        def far(_, y, distance=distance):
            return y[0] - distance

        def out(_, y):
            return np.hypot(y[0], y[1]) - R - STANDARD_TOP

        far.terminal = out.terminal = True
        state = solve_ivp(slope, (0, 3e6), state, method="DOP853", rtol=1e-11, atol=(1e-6, 1e-6, 1e-13, 1e-13),
                          events=(far, out), max_step=3e3).y[:, -1]
    return state[:2] - (0, R), state[2:] / np.hypot(*state[2:])


STANDARD_TOP = 85e3


def test_novaya_zemlya():
    """The Sun, 3.05° under the level, in stripes: each border of each stripe to 2", asked on both sides of it."""
    scene = load("novaya_zemlya")
    sun, inside, outside = scene.lights[0], scene.media[0].profile, scene.medium.profile
    altitude, data = column(scene, (-0.13, 0.13), [550.0])
    lit = data[:, 0] > 0
    borders = np.flatnonzero(lit[1:] != lit[:-1])
    assert len(borders) >= 6 and lit.sum() > 200  # several stripes, minutes of arc in all
    asked = 0
    for i in borders:
        for above, is_lit in ((2.0, lit[i]), (-2.0, lit[i + 1])):
            a = 0.5 * (altitude[i] + altitude[i + 1]) + above * SECOND
            _, d = flat_path((inside, outside), (250e3, np.inf), 30.0, a, 550.0)
            off = abs(np.degrees(np.arctan2(d[1], d[0])) - sun.elevation)
            if np.sum(np.abs(borders - i) <= 5) == 1:  # of stripes wider than the question
                assert (off < sun.angular_radius) == is_lit, (a * 60, off)
                asked += 1
    assert asked >= 8


def test_looming():
    """Tops of the coast, 45 km away and hidden behind the curve of the Earth, to a pixel (4") where the curved rays say."""
    scene = load("looming")
    profile, tops = scene.medium.profile, np.array((81, 111, 96, 131, 101)) - 200.0
    image = cpm.render(scene, wavelengths=[550.0], progress=False)
    height, width = image.data.shape[:2]
    half = np.tan(np.radians(0.2)) * height / width
    tilt = np.degrees(np.arctan(0.05 / 100))
    altitude = np.degrees(np.arctan(half * (1 - (2 * np.arange(height) + 1) / height))) - tilt
    focal = width / 2 / np.tan(np.radians(0.2))
    pixel = 4.0 * SECOND
    horizon = altitude[np.flatnonzero(image.data[:, 2, 0] == 0)[0]]
    for x, top in zip((-100, -60, -10, 30, 85), tops, strict=True):
        dark = np.flatnonzero(image.data[:, int(width / 2 + focal * x / 45e3), 0] == 0)[0]
        wanted = brentq(lambda a, top=top: flat_path((profile,), (45e3,), 5.0, a, 550.0)[0][1] - top, -0.1, 0.15, xtol=1e-6)
        assert abs(altitude[dark] + 0.5 * pixel - wanted) < pixel
        assert altitude[dark] > horizon
    straight = np.degrees(np.arctan((tops - 5) / 45e3))
    assert np.all(straight < -np.degrees(np.arccos(R / (R + 5))))  # without air none would be seen
