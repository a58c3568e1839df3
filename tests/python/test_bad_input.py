"""Bad scenes and bad arguments: one clear message, exit status 2, never a crash (DESIGN sections 9 and 13)."""

import numpy as np
import pytest
from support import scenes

import cpm

BLACK = cpm.materials.Diffuse(0.0)
TRIANGLE = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0)], float)


@pytest.mark.parametrize(
    ("vertices", "faces", "says"),
    [
        ([(0, 0, 0), (1, 0, 0), (0, np.nan, 0)], [(0, 1, 2)], r"\b2\b"),
        ([(0, 0, 0), (np.inf, 0, 0), (0, 1, 0)], [(0, 1, 2)], r"\b1\b"),
        (TRIANGLE, [(0, 1, 3)], r"\b3\b"),
        (TRIANGLE, [(0, 1, -1)], r"-1"),
        (TRIANGLE[:, :2], [(0, 1, 2)], r"vertices"),
        (TRIANGLE, [(0, 1)], r"faces"),
        (TRIANGLE, [(0.5, 1, 2)], r"faces"),
    ],
)
def test_bad_mesh(vertices, faces, says):
    """NaN vertices by index, indices out of range by value, wrong shapes by name."""
    with pytest.raises((ValueError, TypeError), match=says):
        cpm.Scene().add_mesh(vertices, faces, material=BLACK)


def test_degenerate_triangles_do_no_harm():
    """Zero-area triangles beside a good one: skipped (or refused by number), and light lands as without them."""
    vertices = [(0, 0, 0), (0, 0, 2), (2, 0, 0), (1, 0, 1), (1, 0, 1), (0.5, 0, 0.5)]
    good, bad = [(0, 1, 2)], [(3, 4, 5), (0, 0, 0), (0, 3, 3)]
    lights = cpm.lights.Spot((0.4, 1, 0.4), (0.4, 0, 0.4), cutoff=5.0, intensity=1.0)
    scene = cpm.Scene()
    scene.add_light(lights)
    try:
        scene.add_mesh(vertices, good + bad, material=BLACK)
    except ValueError as problem:
        assert "degenerate" in str(problem) or "area" in str(problem)
        return
    stored = cpm.trace_photons(scene, 1000, seed=1, wavelengths=[550.0], projection=False).diffuse
    assert len(stored.power) == 1000
    assert np.all(np.isfinite(stored.position)) and np.all(np.isfinite(stored.direction))


@pytest.mark.parametrize(
    "make",
    [
        lambda: cpm.materials.Diffuse(1.5),
        lambda: cpm.materials.Diffuse(-0.1),
        lambda: cpm.materials.Diffuse(np.nan),
        lambda: cpm.materials.Diffuse("no-such-spectrum"),
        lambda: cpm.materials.Diffuse(([400, 500], [0.1])),
        lambda: cpm.materials.Diffuse(([500, 400], [0.1, 0.2])),
        lambda: cpm.materials.Mirror(2.0),
        lambda: cpm.materials.Dielectric(0.0),
        lambda: cpm.materials.Dielectric(np.nan),
        lambda: cpm.lights.Point((0, 0, np.nan), 1.0),
        lambda: cpm.lights.Point((0, 0, 0), -1.0),
        lambda: cpm.lights.Spot((0, 0, 0), (0, 0, 0), cutoff=10.0, intensity=1.0),
        lambda: cpm.lights.Spot((0, 0, 0), (1, 0, 0), cutoff=0.0, intensity=1.0),
        lambda: cpm.lights.Spot((0, 0, 0), (1, 0, 0), cutoff=181.0, intensity=1.0),
        lambda: cpm.Camera.look_at((0, 0, 0), (0, 0, 0), (0, 1, 0), fov=70.0),
        lambda: cpm.Camera.look_at((0, 0, 0), (0, 1, 0), (0, 1, 0), fov=70.0),
        lambda: cpm.Camera.look_at((0, 0, 0), (1, 0, 0), (0, 1, 0), fov=0.0),
        lambda: cpm.Camera.look_at((0, 0, 0), (1, 0, 0), (0, 1, 0), fov=180.0),
        lambda: cpm.Scene().add_sphere((0, 0, 0), 0.0, material=BLACK),
        lambda: cpm.Scene().add_sphere((0, np.nan, 0), 1.0, material=BLACK),
        lambda: cpm.Scene(medium="glass of water"),
        lambda: cpm.dispersion.Cauchy(np.nan),
        lambda: cpm.dispersion.Sellmeier((1.0, 2.0), (0.1,)),
        lambda: cpm.Box((0, 0, 0), (1, -1, 1)),
        lambda: cpm.Sphere((0, 0, 0), -1.0),
    ],
)
def test_nonsense_is_refused_when_made(make):
    with pytest.raises((ValueError, TypeError)):
        make()


def lit_triangle():
    scene = cpm.Scene()
    scene.add_mesh(*scenes.rectangle((0, 0, 0), (0, 0, 1), (1, 0, 0)), material=cpm.materials.Diffuse(0.5))
    scene.add_light(cpm.lights.Point((0, 1, 0), 1.0))
    scene.camera = cpm.Camera.look_at((0, 2, 2), (0, 0, 0), (0, 1, 0), fov=60.0)
    return scene


@pytest.mark.parametrize(
    "options",
    [
        {"size": (0, 10)},
        {"size": (10, -1)},
        {"photons": -1},
        {"nearest": 0},
        {"wavelengths": []},
        {"wavelengths": [np.nan]},
        {"wavelengths": [-500.0]},
        {"wavelengths": [600.0, 500.0]},
        {"backend": "no-such-backend"},
        {"threads": -1},
        {"samples": 0},
    ],
    ids=str,
)
def test_render_options(options):
    """Each refused by name."""
    arguments = dict(size=(8, 6), photons=100, nearest=10, progress=False) | options
    with pytest.raises((ValueError, TypeError), match=next(iter(options))):
        cpm.render(lit_triangle(), **arguments)


def test_no_camera():
    scene = cpm.Scene()
    scene.add_mesh(*scenes.rectangle((0, 0, 0), (0, 0, 1), (1, 0, 0)), material=BLACK)
    scene.add_light(cpm.lights.Point((0, 1, 0), 1.0))
    with pytest.raises((ValueError, cpm.Error), match="camera"):
        cpm.render(scene, size=(8, 6), photons=100, progress=False)


@pytest.mark.filterwarnings("ignore:the picture is black")
@pytest.mark.parametrize("what", ["nothing", "no shapes", "no lights"])
def test_empty_scenes(what):
    """An empty scene is black, or refused in words; photons asked of it are none; never a crash."""
    scene = cpm.Scene()
    if what == "no lights":
        scene.add_mesh(*scenes.rectangle((0, 0, 0), (0, 0, 1), (1, 0, 0)), material=BLACK)
    if what == "no shapes":
        scene.add_light(cpm.lights.Point((0, 1, 0), 1.0))
    scene.camera = cpm.Camera.look_at((0, 2, 2), (0, 0, 0), (0, 1, 0), fov=60.0)
    try:
        photons = cpm.trace_photons(scene, 1000, seed=1, wavelengths=[550.0])
        image = cpm.render(scene, size=(8, 6), photons=1000, nearest=10, wavelengths=[550.0], progress=False)
    except (ValueError, cpm.Error) as problem:
        assert any(word in str(problem) for word in ("light", "shape", "empty"))
        return
    assert len(photons.diffuse.position) == 0
    np.testing.assert_array_equal(image.data, 0.0)


def test_no_photons():
    """0 photons asked: no photons, a black picture."""
    photons = cpm.trace_photons(lit_triangle(), 0, seed=1, wavelengths=[550.0])
    assert photons.diffuse.position.shape == (0, 3)
    with pytest.warns(UserWarning, match="photons is 0"):
        image = cpm.render(lit_triangle(), size=(8, 6), photons=0, nearest=10, wavelengths=[550.0], progress=False)
    np.testing.assert_array_equal(image.data, 0.0)


def test_open_dielectric_is_refused_by_name():
    """A dielectric needs a closed, well-oriented shape."""
    with pytest.raises((ValueError, cpm.Error), match=r"closed|open|ielectric"):
        scene = lit_triangle()
        scene.add_mesh(TRIANGLE, [(0, 1, 2)], material=cpm.materials.Dielectric(1.5))
        cpm.trace_photons(scene, 10, seed=1, wavelengths=[550.0])


def test_light_where_there_is_no_medium():
    """A light where n² ≤ 0: refused in words."""
    scene = cpm.Scene(medium=cpm.media.LinearSquared(1.0, gradient=(0, -1.0, 0)))
    scene.add_mesh(*scenes.rectangle((0, 0, 0), (0, 0, 1), (1, 0, 0)), material=BLACK)
    scene.add_light(cpm.lights.Point((0, 5.0, 0), 1.0))
    with pytest.raises((ValueError, cpm.Error), match="light"):
        cpm.trace_photons(scene, 10, seed=1, wavelengths=[550.0])


@pytest.mark.parametrize("where", [0.0, 5.3, -1234.567])
@pytest.mark.parametrize("what", ["tetrahedron", "box", "icosphere", "fine icosphere", "split corners"])
def test_closed_dielectrics_are_accepted(what, where):
    """Closed, outward meshes anywhere: shared vertices, or one set a face (as OBJ and STL files have them)."""
    if what == "tetrahedron":
        vertices, faces = np.eye(4, 3), np.array([(3, 1, 0), (3, 0, 2), (3, 2, 1), (0, 1, 2)])
    elif what == "box":
        vertices, faces = scenes.box_mesh((0, 0.001, 0), (0.7, 1, 1.1))
        faces = faces[:, ::-1].copy()
    else:
        vertices, faces = scenes.icosphere(0.37, 4 if what == "fine icosphere" else 2)
    if what == "split corners":
        vertices, faces = vertices[faces].reshape(-1, 3), np.arange(3 * len(faces)).reshape(-1, 3)
    scene = lit_triangle()
    scene.add_mesh(vertices + where, faces, material=cpm.materials.Dielectric(1.5))
    cpm.trace_photons(scene, 10, seed=1, wavelengths=[550.0])


def test_inverted_dielectric_is_refused():
    with pytest.raises((ValueError, cpm.Error), match=r"inside out|inward|orient"):
        scene = lit_triangle()
        scene.add_mesh(*scenes.icosphere(0.3, 1, inward=True), material=cpm.materials.Dielectric(1.5))
        cpm.trace_photons(scene, 10, seed=1, wavelengths=[550.0])


@pytest.mark.parametrize("value, error", [("glass", ValueError), (None, TypeError), ([1.5], TypeError),
                                          ({"n": 1.5}, TypeError), (1.5j, TypeError)])
def test_what_a_dielectric_takes(value, error):
    with pytest.raises(error, match=r"interior is .*; a number, a catalogue name \(BK7, .*water.*\), a dispersion or a "
                                    r"medium is allowed"):
        cpm.materials.Dielectric(value)


@pytest.mark.parametrize("value", [0.0, -1.5, float("nan"), float("inf")])
def test_a_dielectric_of_impossible_index(value):
    with pytest.raises((ValueError, cpm.Error), match=r"interior|n "):
        cpm.materials.Dielectric(value)


def test_layers_that_do_not_match():
    with pytest.raises(ValueError, match=r"heights has 3 entries and n has 2; one n for each height is needed"):
        cpm.media.Layered([0, 1, 2], [1.0, 1.1])


@pytest.mark.parametrize("name, value, allowed", [("nearest", 1_000_001, "2 to 1000000"),
                                                  ("samples", 1_048_577, "1 to 1048576"),
                                                  ("batch", 1_048_577, "0 to 1048576")])
def test_bounds_are_the_cores(name, value, allowed):
    """The largest is taken by the core too (photons=0: at once), the next is refused with the bound."""
    with pytest.raises(ValueError, match=f"{name} is {value}; {allowed} are allowed"):
        cpm.render(lit_triangle(), photons=0, **{name: value})
    with pytest.warns(UserWarning, match="black"):
        cpm.render(lit_triangle(), size=(1, 1), photons=0, wavelengths=[550.0], **{name: value - 1})


def test_a_medium_by_a_name_that_is_not_there():
    """The message names n, the value, and what is allowed, as `Scene("vacuum")` did not."""
    with pytest.raises(ValueError, match=r"n is 'vacuum'; a number \(1 is vacuum\), a dispersion or a name .*BK7"):
        cpm.Scene("vacuum")
    with pytest.raises(ValueError, match=r"n is 'vacuum'"):
        cpm.media.Homogeneous("vacuum")
