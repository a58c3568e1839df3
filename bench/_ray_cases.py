"""The cases of rays.py: media, the same fields written again for the peers, and their rays."""
from dataclasses import dataclass

import numpy as np

import cpm

WAVELENGTH = 550.0
EARTH, HEIGHT, SURFACE = 6371e3, 8e3, 2.77e-4


@dataclass(frozen=True)
class Case:
    """A medium, its field as (n², ½∇n²) of r for the peers, a ray, and how far it goes in σ."""

    name: str
    medium: object
    field: object
    origin: tuple
    direction: tuple
    sigma: float


def fibre_field(r):
    return 2.25 * (1 - r[0] ** 2 - r[1] ** 2), np.array([-2.25 * r[0], -2.25 * r[1], 0.0])


def luneburg_field(r):
    return 2 - r @ r, -r


def fisheye_field(r):
    n = 2 / (1 + r @ r)
    return n * n, -n**3 * r


def linear_field(r):
    n = 1.2 - 0.05 * r[1]
    return n * n, np.array([0.0, -0.05 * n, 0.0])


def atmosphere_field(r):
    """Exponential in height above a sphere whose surface is at the origin, y up; height without cancellation."""
    up = np.array([r[0], r[1] + EARTH, r[2]])
    distance = np.sqrt(up @ up)
    height = (2 * EARTH * r[1] + r @ r) / (distance + EARTH)
    refractivity = SURFACE * np.exp(-height / HEIGHT)
    n = 1 + refractivity
    return n * n, -n * refractivity / HEIGHT / distance * up


def centres_field(r):
    """Two gravity centres, 1 + Σ m/|r − c|²."""
    n, gradient = 1.0, np.zeros(3)
    for centre, strength in (((0.0, 0.0, 0.0), 0.1), ((2.0, 1.0, 0.0), 0.05)):
        d = r - np.array(centre)
        n += strength / (d @ d)
        gradient -= 2 * strength * d / (d @ d) ** 2
    return n * n, n * gradient


def grid_medium(nodes=49, half=1.2):
    """The fibre's n sampled on a cubic grid."""
    axis = np.linspace(-half, half, nodes)
    x, y, _ = np.meshgrid(axis, axis, np.linspace(0, 20, 9), indexing="ij")
    n = np.sqrt(np.maximum(2.25 * (1 - 0.25 * (x * x + y * y)), 0.1))
    return cpm.media.Grid(n, origin=(-half, -half, 0), spacing=(axis[1] - axis[0],) * 2 + (2.5,), interpolation="cubic")


def of_heights(profile, heights):
    return cpm.media.Layered(heights, profile(heights), up=(0, 1, 0), interpolation="cubic")


def medium_field(medium):
    """The library's own n and ∇n as a field: for peers on a table, so that all solve one problem."""
    def field(r):
        n, gradient = medium.evaluate(r, WAVELENGTH)
        return float(n[0]) ** 2, float(n[0]) * gradient[0]
    return field


def cases():
    """All of them. Where there is a formula the peers have it, written again; on tables they ask ours for n and ∇n."""
    media = cpm.media
    yield Case("fibre", media.Parabolic(1.5, alpha=1.0), fibre_field, (0.3, 0, 0),
               (0, 0.2, np.sqrt(2.25 * 0.91 - 0.04)), 20.0)
    yield Case("luneburg", media.Luneburg(1.0), luneburg_field, (0.5, 0, -np.sqrt(0.75)), (0, 0, 1),
               np.pi / 2 * (1 - 1e-9))
    # One circle: through 0.5 and its conjugate −2 on the axis, radius 1.25 about −0.75; σ = ∮ dl/n in closed form.
    yield Case("fish-eye", media.Fisheye(2.0, radius=1.0), fisheye_field, (0.5, 0, 0), (0, 1, 0.3), circle_sigma())
    yield Case("linear", media.Linear(1.2, gradient=(0, -0.05, 0)), linear_field, (0, 0, 0), (1, 0.4, 0.2), 8 / 1.1)
    for name, medium in (("atmosphere", atmosphere()), ("atmosphere in layers", atmosphere_in_layers())):
        yield Case(name, medium, atmosphere_field, (0, 2, 0), (1, 0, 0), 500e3)
    heights = np.concatenate([np.linspace(0, 0.5, 201), np.linspace(0.51, 4, 60)])
    road = of_heights(lambda h: 1 + 2.7e-4 - 2.7e-5 * np.exp(-h / 0.05), heights)
    yield Case("hot road", road, medium_field(road), (0, 1.0, 0), (1, -0.004, 0), 500.0)
    grid = grid_medium()
    yield Case("cubic grid", grid, medium_field(grid), (0.3, 0.1, 0.5), (0, 0.2, 1.4), 10.0)
    yield Case("gravity centres", media.Sources([(0, 0, 0), (2, 1, 0)], [0.1, 0.05], 2), centres_field,
               (-3, 0.8, 0), (1, 0, 0.05), 6.0)


def atmosphere():
    """The spherical exponential atmosphere as a formula."""
    height = f"(2*{EARTH}*y + x*x + y*y + z*z)/(sqrt(x*x + (y+{EARTH})**2 + z*z) + {EARTH})"
    return cpm.media.Expression(f"1 + {SURFACE}*exp(-({height})/{HEIGHT})")


def atmosphere_in_layers():
    """The same as cubic spherical layers, 50 m apart: their n is off by less than 1e-14 where the ray goes."""
    heights = np.linspace(-1e3, 60e3, 1221)
    return cpm.media.Layered(heights, 1 + SURFACE * np.exp(-heights / HEIGHT), up=(0, 1, 0), radius=EARTH)


def circle_sigma():
    """σ of one turn in the fish-eye n = 2/(1 + r²) from (0.5, 0, 0) at right angles: ∮ (1 + r²)/2 dl, radius 1.25."""
    radius, offset = 1.25, 0.75
    return 2 * np.pi * radius * (1 + radius**2 + offset**2) / 2
