"""Extinction by Rayleigh along curved paths, measured from pictures: a camera sees an even sky of radiance 1 dimmed.

Oracles: quadrature of sigma N over the standard atmosphere's own density along straight and curved paths (SciPy at
1e-10), and the optical depths that Bodhaine et al. (1999) publish.
"""

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp

import cpm

R = 6371e3
STANDARD = cpm.atmosphere.USStandard1976()
BOLTZMANN = 1.380649e-23


def scene(zenith, height=0.0, rtol=1e-9, **options):
    """One pixel that looks at a zenith distance."""
    made = cpm.Scene(medium=cpm.media.Atmosphere(STANDARD, extinction="rayleigh"), rtol=rtol, **options)
    made.add_light(cpm.lights.Environment(1.0))
    z = np.radians(zenith)
    aim = np.array((0.0, height, 0.0)) + 100 * np.array((0.0, np.cos(z), -np.sin(z)))
    made.camera = cpm.Camera.look_at((0, height, 0), aim, (0, 0, -1) if zenith < 45 else (0, 1, 0), fov=1e-3)
    return made


def depth(made, wavelengths):
    """Optical depth from the picture; the sky's n² at the camera divided out."""
    image = cpm.render(made, size=(1, 1), wavelengths=wavelengths, photons=0, progress=False)
    height = made.camera.origin[1]
    n = 1 + np.array([STANDARD.refractivity(height, w) for w in wavelengths])
    return -np.log(image.data[0, 0] / n**2)


def number_density(h):
    return STANDARD.pressure(h) / (BOLTZMANN * STANDARD.temperature(h))


def along(zenith, height, wavelength):
    """∫ N ds along the ray that Bouguer's law bends, by an ODE in arc length."""
    index = lambda h: 1 + STANDARD.refractivity(float(h), wavelength)  # noqa: E731

    def slope(_, y):
        r, psi, _ = y
        h, step = r - R, 0.5
        bent = (index(h + step) - index(h - step)) / (2 * step * index(h))
        return np.cos(psi), -np.sin(psi) * (1 / r + bent), number_density(h)

    def out(_, y):
        return y[0] - R - STANDARD.top

    out.terminal, out.direction = True, 1
    start = (R + height, np.radians(zenith), 0.0)
    found = solve_ivp(slope, (0, 4e6), start, method="DOP853", rtol=1e-9, atol=(1e-4, 1e-12, 1e10), events=out, max_step=5e3)
    return found.y[2, -1]


def test_zenith():
    """0.0972 at 550 nm, 0.3611 at 400, 0.0364 at 700: within 1 % of Bodhaine et al.'s table 4, sea level, 45° N."""
    found = depth(scene(0.0), [400.0, 550.0, 700.0])
    np.testing.assert_allclose(found, [0.3601, 0.0973, 0.0365], rtol=0.01)
    column = quad(number_density, 0, STANDARD.top, limit=500, epsrel=1e-7, points=[11e3, 20e3, 32e3, 47e3, 51e3, 71e3])[0]
    np.testing.assert_allclose(found, cpm.air.rayleigh_cross_section([400.0, 550.0, 700.0]) * column, rtol=2e-4)


@pytest.mark.parametrize(("zenith", "height"), [(60.0, 0.0), (85.0, 0.0), (89.5, 0.0), (90.0, 10.0), (90.5, 1000.0)])
def test_slant(zenith, height):
    """Also through a turning point; refraction lengthens the way at the horizon by some 5 %."""
    found = depth(scene(zenith, height), [450.0, 650.0])
    expected = [cpm.air.rayleigh_cross_section(w) * along(zenith, height, w) for w in (450.0, 650.0)]
    np.testing.assert_allclose(found, expected, rtol=5e-4)


def test_to_a_surface():
    """A lamp 20 km away at 1 km height: the way ends within a step of the integrator."""
    made = cpm.Scene(medium=cpm.media.Atmosphere(STANDARD, extinction="rayleigh"), rtol=1e-9)
    wall = made.add_mesh([[-500, 500, -20e3], [500, 500, -20e3], [500, 1500, -20e3], [-500, 1500, -20e3]],
                         [[0, 1, 2], [0, 2, 3]], material=cpm.materials.Black())
    made.add_light(cpm.lights.Area(wall, 1.0))
    made.camera = cpm.Camera.look_at((0, 1000, 0), (0, 1000, -100), (0, 1, 0), fov=1e-3)
    image = cpm.render(made, size=(1, 1), wavelengths=[450.0], photons=0, progress=False)
    n = 1 + STANDARD.refractivity(1000.0, 450.0)
    # at most 8 m off the level: the density there is linear to 1e-7
    way = quad(lambda z: number_density(1000.0 + z * z / (2 * R) - 0.2 * z * z / (2 * R)), 0, 20e3)[0]
    expected = cpm.air.rayleigh_cross_section(450.0) * way
    assert -np.log(image.data[0, 0, 0] / n**2) == pytest.approx(expected, rel=1e-3)


def test_sunlight_on_the_ground():
    """Photons of a sun in the zenith lose what its eye ray loses."""
    made = cpm.Scene(medium=cpm.media.Atmosphere(STANDARD, extinction="rayleigh"))
    made.add_mesh([[-1, 0, -1], [1, 0, -1], [1, 0, 1], [-1, 0, 1]], [[0, 2, 1], [0, 3, 2]], material=cpm.materials.Diffuse(0.5))
    sun = cpm.lights.Sun(60.0, 0.0, radiance=1000.0)
    made.add_light(sun)
    photons = cpm.trace_photons(made, 3000, seed=1, wavelengths=[400.0, 700.0])
    found = photons.diffuse.power.sum(axis=0) / 4 / (1000 * sun.solid_angle * np.sin(np.radians(60.0)))
    expected = [np.exp(-cpm.air.rayleigh_cross_section(w) * along(30.0, 0.0, w)) for w in (400.0, 700.0)]
    np.testing.assert_allclose(found, expected, rtol=0.03)


def test_off_by_default():
    made = cpm.Scene(medium=cpm.media.Atmosphere(STANDARD), rtol=1e-9)
    made.add_light(cpm.lights.Environment(1.0))
    made.camera = cpm.Camera.look_at((0, 0, 0), (0, 1, -1), (0, 1, 0), fov=1e-3)
    image = cpm.render(made, size=(1, 1), wavelengths=[450.0], photons=0, progress=False)
    assert image.data[0, 0, 0] == pytest.approx((1 + STANDARD.refractivity(0.0, 450.0)) ** 2, rel=1e-6)
    assert "extinction" not in image.stats["features"]


def test_refused():
    with pytest.raises(ValueError, match="extinction is 'mie'"):
        cpm.media.Atmosphere(STANDARD, extinction="mie")
