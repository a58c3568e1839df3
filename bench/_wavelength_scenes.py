"""Scenes of bench wavelengths: the last limb of a setting Sun, a hot road, a room in air and one in glass."""
import numpy as np
from _results import CURVED

import cpm

#: Sun: 5778 K seen through a horizon's worth of molecules. Optical depth of the whole air by C. Fröhlich and G. E. Shaw
#: (Appl. Opt. 19, 1773 (1980)), 0.00838/λ^(3.916 + 0.074 λ + 0.050/λ), λ in µm; AIR_MASS of them.
TEMPERATURE, AIR_MASS = 5778.0, 30.0
DISTANCE = 3e6        # m: beyond the air, where rays are straight
SUN_RADIUS = 959.63   # arc seconds
EYE = 15.0            # m above the sea
PIXEL = 4.0 / 3600    # degrees


def depth(wavelength):
    """Rayleigh's optical depth of the whole air, upright."""
    um = 1e-3 * np.asarray(wavelength)
    return 0.00838 / um ** (3.916 + 0.074 * um + 0.050 / um)


def sunlight(wavelength):
    """Radiance of the Sun at the horizon, W/m²/sr/nm."""
    metres = 1e-9 * np.asarray(wavelength)
    planck = 1.1910429724e-16 / metres**5 / np.expm1(1.438776877e-2 / (metres * TEMPERATURE)) * 1e-9
    return planck * np.exp(-AIR_MASS * depth(wavelength))


def limb(height=60, width=4):
    """The upper limb of the Sun as it sets, 4″ a pixel, 8 eye rays each: violet stands the highest.

    A ball of the Sun's angular radius beyond the air shines with sunlight().
    """
    profile = cpm.atmosphere.Polytropic(288.15, 101325.0)
    air = cpm.media.Atmosphere(profile, radius=6371e3)
    scene = cpm.Scene(air, extent=cpm.Box((-4e6, -1.3e7, -7e6), (4e6, 1e6, 7e6)), rtol=1e-9)
    sea = scene.add_sphere((0, -6371e3, 0), 6371e3, material=cpm.materials.Black())
    assert sea is not None
    middle = cpm.atmosphere.refraction(profile, 90.0, 560.0, EYE)   # the limb's true altitude is about minus that
    altitude = np.radians(-middle - SUN_RADIUS / 3600 + 55 / 3600)
    where = DISTANCE * np.array([np.cos(altitude), np.sin(altitude), 0.0]) + (0, EYE, 0)
    w = np.arange(380.0, 781.0, 1.0)
    sun = scene.add_sphere(where, DISTANCE * np.tan(np.radians(SUN_RADIUS / 3600)), material=cpm.materials.Black())
    scene.add_light(cpm.lights.Area(sun, (w, sunlight(w))))
    tilt = np.radians(-0.02)
    scene.camera = cpm.Camera.look_at((0, EYE, 0), (np.cos(tilt), EYE + np.sin(tilt), 0), fov=width * PIXEL)
    scene.render_defaults = cpm.RenderSettings(size=(width, height), photons=0, samples=8)
    return scene


def road():
    """A painted wall 600 m down a hot road, lamps before it, seen through a telephoto lens: an inferior mirage."""
    profile = cpm.atmosphere.HotSurface(cpm.atmosphere.USStandard1976(), 25.0, 0.05)
    scene = cpm.Scene(cpm.media.Atmosphere(profile, radius=None), extent=cpm.Box((-50, -1, -50), (800, 60, 50)))
    for low, high, paint in ((0.0, 1.0, "cornell-red"), (1.0, 2.0, "cornell-white"), (2.0, 4.0, "cornell-green")):
        corners = [(600, low, -8), (600, low, 8), (600, high, 8), (600, high, -8)]
        scene.add_mesh(corners, [(0, 1, 2), (0, 2, 3)], material=cpm.materials.Diffuse(paint))
    scene.add_mesh([(-20, 0, -9), (-20, 0, 9), (700, 0, 9), (700, 0, -9)], [(0, 1, 2), (0, 2, 3)],
                   material=cpm.materials.Diffuse(0.1))
    for z in (-5.0, 0.0, 5.0):
        scene.add_light(cpm.lights.Spot((590, 3.0, z), (600, 1.2, z), cutoff=35.0, intensity="A"))
    scene.camera = cpm.Camera.look_at((0, 1.2, 0), (600, 0.5, 0), fov=100 * 10 / 3600)
    scene.render_defaults = cpm.RenderSettings(size=(100, 50), photons=50_000, nearest=150)
    return scene


def room(dispersion, n_squared=1.69, gradient=-0.10):
    """The curved room with a dispersion."""
    scene = cpm.load_scene(CURVED)
    scene.render_defaults = cpm.RenderSettings(size=(60, 45), photons=50_000, nearest=150)
    return scene.copy(medium=cpm.media.LinearSquared(n_squared, (0, gradient, 0), dispersion=dispersion))


def dim(scene):
    """The same shapes and lights, all paints at 0.001: direct light is all there is."""
    made = cpm.Scene(scene.medium, extent=scene.extent)
    for shape in scene.shapes:
        made.add_mesh(shape.vertices, shape.faces, material=cpm.materials.Diffuse(1e-3))
    for light in scene.lights:
        made.add_light(light)
    made.camera, made.render_defaults = scene.camera, scene.render_defaults
    return made
