"""The cross room's direct light against its closed form (DESIGN sections 12 and 13).

Black walls: `photons.diffuse.irradiance` on the floor, straight and curved, through every medium
that can hold n² = 1.69 − 0.10 y.  White floor: the picture too, through curved eye rays.
A k-NN estimate (k−1)/(π r²) of Poisson points has relative variance 1/(k−2).
"""

import numpy as np
import pytest
from oracles import camera, closed_forms, cross_room
from support import scenes

import cpm

NEAREST, PHOTONS = 100, 400_000
Y = np.linspace(-0.5, 7.0, 121)
N_OF_Y = np.sqrt(1.69 - 0.10 * Y)


def layered(interpolation):
    return cpm.media.Layered(Y, N_OF_Y, up=(0, 1, 0), interpolation=interpolation)


def grid():
    values = np.broadcast_to(N_OF_Y[None, :, None], (6, len(Y), 6)).copy()
    return cpm.media.Grid(values, origin=(-6, Y[0], -5), spacing=(2, Y[1] - Y[0], 2), interpolation="cubic")


#: name → (medium, method of the scene).
MEDIA = {
    "homogeneous": (lambda: cpm.media.Homogeneous(1.0), "auto"),
    "linear-squared": (scenes.curved_medium, "auto"),
    "linear-squared-dopri5": (scenes.curved_medium, "dopri5"),
    "linear-squared-euler": (scenes.curved_medium, "euler"),
    "layered-linear-squared": (lambda: layered("linear-squared"), "auto"),
    "layered-cubic": (lambda: layered("cubic"), "auto"),
    "grid-cubic": (grid, "auto"),
}


def oracle_of(name):
    return cross_room.STRAIGHT if name == "homogeneous" else cross_room.CURVED


@pytest.fixture(scope="module", params=MEDIA)
def traced(request):
    """(oracle, photons) of the black room in each medium."""
    make, method = MEDIA[request.param]
    scene = scenes.room(make(), method=method)
    return oracle_of(request.param), cpm.trace_photons(scene, PHOTONS, seed=11, wavelengths=[550.0])


def floor(photon_map):
    """Mask of the photons that lie on the floor inside the room."""
    r = photon_map.position
    return (np.abs(r[:, 1]) < 1e-4) & (np.abs(r[:, 0]) < 2) & (np.abs(r[:, 2]) < 2)


def test_irradiance(traced):
    """z-test at each point away from the edge, and no bias beyond 2 % over all of them."""
    oracle, photons = traced
    points = oracle.lit_points(0.1, 0.14)
    assert len(points) > 60
    expected = oracle.irradiance(points[:, 0], points[:, 1])
    at = cross_room.floor_points(points[:, 0], points[:, 1])
    found = photons.diffuse.irradiance(at, np.tile((0.0, 1.0, 0.0), (len(at), 1)), nearest=NEAREST)[:, 0]
    z = (found / expected - 1) * np.sqrt(NEAREST - 2)
    assert np.max(np.abs(z)) < 4.5, f"z up to {np.max(np.abs(z)):.2f}"
    assert np.std(z) < 1.2  # emission may be stratified: less noise than Poisson is welcome
    assert abs(np.mean(found / expected) - 1) < 0.02


def test_dark_side(traced):
    """Nothing arrives from below the floor, nor where the cross throws no light."""
    oracle, photons = traced
    points = oracle.lit_points(0.2, 0.2)
    at = cross_room.floor_points(points[:, 0], points[:, 1])
    below = photons.diffuse.irradiance(at, np.tile((0.0, -1.0, 0.0), (len(at), 1)), nearest=NEAREST, max_radius=0.1)
    np.testing.assert_array_equal(below, 0.0)
    dark = cross_room.floor_points(np.array([1.8, 1.8, -1.8]), np.array([-1.8, 1.8, 1.8]))
    up = np.tile((0.0, 1.0, 0.0), (3, 1))
    np.testing.assert_array_equal(photons.diffuse.irradiance(dark, up, nearest=NEAREST, max_radius=0.1), 0.0)


def test_power_on_the_floor(traced):
    """Total direct power against the closed form's integral, within 4σ of the photon count."""
    oracle, photons = traced
    on_floor = floor(photons.diffuse)
    power = photons.diffuse.power[on_floor, 0].sum()
    assert power == pytest.approx(oracle.floor_power(1500), rel=4 / np.sqrt(on_floor.sum()) + 1e-3)
    assert np.all(photons.diffuse.bounce == 0)


def test_outline(traced):
    """Every photon on the floor lies in the lit cross, to 2 mm."""
    oracle, photons = traced
    r = photons.diffuse.position[floor(photons.diffuse)].astype(float)
    strays = r[~oracle.lit(r[:, 0], r[:, 2])]
    assert len(strays) < 0.02 * len(r)
    if len(strays):
        assert np.max(oracle.distance_to_edge(strays[:, 0], strays[:, 2])) < 2e-3


def test_directions(traced):
    """Each floor photon travels as the closed form's path does there."""
    oracle, photons = traced
    keep = np.nonzero(floor(photons.diffuse))[0][:2000]
    r = photons.diffuse.position[keep].astype(float)
    r[:, 1] = 0
    p = oracle.momentum_to(r)
    p[:, 1] += oracle.slope * oracle.sigma_to(r) / 2
    d = p / np.linalg.norm(p, axis=1, keepdims=True)
    # A photon record is 32 bytes, so its direction is packed: a degree would show, a milliradian may not.
    assert np.max(np.linalg.norm(photons.diffuse.direction[keep] - d, axis=1)) < 0.02
    assert np.median(np.linalg.norm(photons.diffuse.direction[keep] - d, axis=1)) < 0.005


@pytest.mark.parametrize("name", ["homogeneous", "linear-squared", "layered-cubic"])
def test_picture(name, picture):
    """White floor, black walls: pixels show ρE/π (n_c/n_s)² where the closed-form eye ray meets the lit floor."""
    oracle, size, albedo = oracle_of(name), (80, 60), 0.75
    scene = cpm.Scene(medium=MEDIA[name][0]())
    scene.add_mesh(*scenes.quads_mesh([((-2, 0, -2), (0, 0, 4), (4, 0, 0))]), material=cpm.materials.Diffuse(albedo))
    rest = [q[:3] for q in cross_room.quads()[1:]]
    scene.add_mesh(*scenes.quads_mesh(rest), material=cpm.materials.Diffuse(0.0))
    scene.add_light(cpm.lights.Spot(cross_room.SPOT, cross_room.TARGET, cutoff=14.0, intensity=cross_room.INTENSITY))
    eye = np.array((1.85, 3.0, 1.85))
    view = dict(origin=eye, target=(-1.2, 0.6, -0.9), up=(0, 1, 0), fov=70.0)
    scene.camera = cpm.Camera.look_at(view["origin"], view["target"], view["up"], fov=view["fov"])
    image = cpm.render(
        scene, size=size, photons=PHOTONS, nearest=NEAREST, wavelengths=[550.0], seed=5, max_radius=1.0, progress=False
    )
    assert image.data.shape == (60, 80, 1)
    picture("found", image.data[:, :, 0])

    n_eye = np.sqrt(oracle.n_squared + oracle.slope * eye[1])
    g, floor_at, rays = np.array((0, oracle.slope, 0)), np.full((60, 80, 2), np.nan), camera.directions(size, **view)
    for row, column in np.ndindex(60, 80):
        p = n_eye * rays[row, column]
        sigma = closed_forms.parabola_sigma_of_plane(eye, p, g, np.zeros(3), np.array((0, 1.0, 0)))
        if np.isfinite(sigma):
            r, _ = closed_forms.parabola(eye, p, g, sigma)
            if abs(r[0]) < 2 and abs(r[2]) < 2:
                floor_at[row, column] = r[[0, 2]]
    x, z = floor_at[..., 0].ravel(), floor_at[..., 1].ravel()
    seen = np.isfinite(x)
    far = np.zeros(x.shape, bool)
    far[seen] = oracle.lit(x[seen], z[seen]) & (oracle.distance_to_edge(x[seen], z[seen]) > 0.16)
    ratio = (n_eye**2 / oracle.n_squared) * albedo / np.pi
    expected = ratio * oracle.irradiance(x[far], z[far])
    found = image.data.reshape(-1)[far]
    assert far.sum() > 80
    z_pixels = (found / expected - 1) * np.sqrt(NEAREST - 2)
    assert np.max(np.abs(z_pixels)) < 5
    assert abs(np.mean(found / expected) - 1) < 0.025
