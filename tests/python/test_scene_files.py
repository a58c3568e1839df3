"""Scene files: what they make, and what they say when they are wrong."""

import subprocess
import sys
import tomllib
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import cpm

EXAMPLES = Path(__file__).parents[2] / "examples"

ROOM = """
format = 1
[materials]
white = { type = "diffuse", reflectance = 0.7 }
[[shapes]]
name = "floor"
type = "quads"
quads = [[[-1,0,-1], [0,0,2], [2,0,0]]]
material = "white"
[[lights]]
type = "spot"
position = [0, 3, 0]
target = [0, 0, 0]
cutoff = 20.0
intensity = 10.0
[camera]
origin = [0, 2, 2]
target = [0, 0, 0]
"""


def load(folder, text):
    (folder / "scene.toml").write_text(text)
    return cpm.load_scene(folder / "scene.toml")


@pytest.mark.parametrize("path", sorted(EXAMPLES.glob("*.toml")), ids=lambda path: path.stem)
def test_examples_load(path):
    scene = cpm.load_scene(path)
    assert scene.shapes
    assert scene.lights
    assert scene.camera is not None


@pytest.mark.parametrize("name", ["hot_road", "cold_sea"])
def test_mirages_meshes_are_current(name, tmp_path):
    """Text to the millimetre: sines that differ in the last bit between machines do not show."""
    generator, shipped = EXAMPLES / "meshes" / f"make_{name}.py", EXAMPLES / "meshes" / name
    subprocess.run([sys.executable, generator, tmp_path / name], check=True, timeout=60)
    fresh = {path.name: path.read_text() for path in (tmp_path / name).iterdir()}
    assert fresh == {path.name: path.read_text() for path in shipped.iterdir()}


def test_cross_rooms_differ_in_their_medium_alone():
    straight, curved = (
        tomllib.loads((EXAMPLES / f"cross_room_{name}.toml").read_text()) for name in ("homogeneous", "curved")
    )
    assert curved.pop("medium") == {"type": "linear-squared", "n_squared": 1.69, "gradient": [0, -0.10, 0]}
    assert straight == curved


def test_cross_room_is_the_paper_s():
    scene = cpm.load_scene(EXAMPLES / "cross_room_curved.toml")
    n, _ = scene.medium.evaluate([[0, 0, 0], [0, 4, 0]])
    np.testing.assert_allclose(n, [1.30, 1.136], atol=5e-4)
    assert sum(len(shape.faces) for shape in scene.shapes) == 26
    # The left wall is 16 m² less the cross: 0.6 × 2.4 and twice 0.9 × 0.6.
    wall = next(shape for shape in scene.shapes if shape.name == "left wall")
    a, b, c = np.moveaxis(wall.vertices[wall.faces], 1, 0)
    areas = 0.5 * np.cross(b - a, c - a)
    assert areas[:, 0].sum() == pytest.approx(16 - 0.6 * 2.4 - 2 * 0.9 * 0.6)
    for paint, at_620 in (("left wall", 0.75), ("back wall", 0.60), ("front wall", 0.15)):
        shape = next(shape for shape in scene.shapes if shape.name == paint)
        assert shape.material.reflectance.at(620.0) == pytest.approx(at_620)


def test_room_s_quads_face_inward():
    scene = cpm.load_scene(EXAMPLES / "cross_room_homogeneous.toml")
    for shape in scene.shapes:
        a, b, c = np.moveaxis(shape.vertices[shape.faces], 1, 0)
        towards_middle = np.array([0.0, 2.0, 0.0]) - a
        assert (np.einsum("ij,ij->i", np.cross(b - a, c - a), towards_middle) > 0).all()


def test_generated_mesh_is_current(tmp_path):
    import runpy

    made = runpy.run_path(str(EXAMPLES / "meshes" / "make_trefoil.py"))
    made["write_ply"](tmp_path / "trefoil.ply", *made["tube"]())
    shipped, fresh = ((path / "trefoil.ply").read_bytes() for path in (EXAMPLES / "meshes", tmp_path))
    assert len(shipped) == len(fresh)
    header = shipped.index(b"end_header\n") + len(b"end_header\n")
    assert shipped[:header] == fresh[:header]
    vertices = [np.frombuffer(data, "<f4", 3 * 8000, header) for data in (shipped, fresh)]
    np.testing.assert_allclose(*vertices, atol=1e-6)  # sines differ in the last bit between machines


def test_render_table_is_the_scene_s_defaults(tmp_path):
    scene = load(
        tmp_path,
        ROOM
        + """
[render]
size = [20, 10]
photons = 1e3
nearest = 20
seed = 7
wavelengths = { from = 400, to = 700, bins = 3 }
""",
    )
    image = cpm.render(scene)
    assert image.data.shape == (10, 20, 3)
    np.testing.assert_allclose(image.wavelengths, [450, 550, 650])
    assert image.stats["photons_emitted"] == 1000
    np.testing.assert_array_equal(image.data, cpm.render(scene, seed=7, photons=1000).data)
    assert cpm.render(scene, size=(4, 5)).data.shape == (5, 4, 3)


def test_defaults_without_a_render_table(tmp_path):
    from cpm.settings import resolve

    found = resolve(load(tmp_path, ROOM).render_defaults)
    assert (found.width, found.height, found.photons, found.nearest) == (400, 300, 3_000_000, 150)
    assert (found.samples, found.seed) == (1, 0)
    np.testing.assert_allclose(found.wavelengths, 409.375 + 18.75 * np.arange(16))


@pytest.mark.parametrize(
    "text, kind",
    [
        ('type = "homogeneous"\nn = 1.5', cpm.media.Homogeneous),
        ('type = "homogeneous"\nn = "BK7"', cpm.media.Homogeneous),
        ('type = "homogeneous"\nn = { cauchy = [1.5, 0.004] }', cpm.media.Homogeneous),
        ('type = "homogeneous"\nn = { sellmeier = { B = [1.0], C = [0.01] } }', cpm.media.Homogeneous),
        (
            'type = "homogeneous"\nn = { tabulated = { wavelengths = [300, 800], n = [1.6, 1.5] } }',
            cpm.media.Homogeneous,
        ),
        ('type = "linear"\nn = 1.3\ngradient = [0, -0.01, 0]', cpm.media.Linear),
        (
            'type = "linear-squared"\nn_squared = 1.69\ngradient = [0, -0.1, 0]\ndispersion = "BK7"',
            cpm.media.LinearSquared,
        ),
        ('type = "layered"\nheights = [0, 1, 2]\nn = [1.3, 1.2, 1.1]\ninterpolation = "step"', cpm.media.Layered),
        ('type = "layered"\nheights = [0, 1, 2]\nn = [1.3, 1.2, 1.1]\nradius = 6371e3', cpm.media.Layered),
        ('type = "expression"\ntext = "1 + N*exp(-y/d)"\nconstants = { N = 1e-4, d = 2 }', cpm.media.Expression),
        (
            'type = "sum"\nterms = [{ type = "linear", n = 1.2, gradient = [0, 0.01, 0] }, '
            '{ type = "expression", text = "1.1" }]',
            cpm.media.Sum,
        ),
        ('type = "grid"\nvalues = "n.npy"\nspacing = [1, 1, 1]\ninterpolation = "linear"', cpm.media.Grid),
        ('type = "parabolic"\nn = 1.5\nalpha = 0.2\naxis = [1, 0, 0]\norigin = [0, 1, 0]', cpm.media.Parabolic),
        ('type = "luneburg"\nradius = 0.5\ncenter = [0, 1, 0]\ndispersion = "BK7"', cpm.media.Luneburg),
        ('type = "fisheye"\nn = 2\nradius = 1.5', cpm.media.Fisheye),
        ('type = "eaton"\nradius = 1', cpm.media.Eaton),
        ('type = "sources"\ncenters = [[0, 1, 0]]\nstrengths = 0.1', cpm.media.Sources),
        (
            'type = "sources"\ncenters = [[0, 1, 0], [1, 1, 0]]\nstrengths = [0.1, -0.02]\nexponent = [2, 1.5]\n'
            "directions = [[0, 0, 0], [0, 0, 1]]",
            cpm.media.Sources,
        ),
    ],
)
def test_media(tmp_path, text, kind):
    np.save(tmp_path / "n.npy", np.full((2, 3, 4), 1.2))
    assert type(load(tmp_path, f"{ROOM}\n[medium]\n{text}\n").medium) is kind


def test_media_of_a_file_are_those_of_python(tmp_path):
    """A sum of spherical layers and a formula, by file and by Python: the same n."""
    text = """
[medium]
type = "sum"
[[medium.terms]]
type = "layered"
heights = [0, 10, 20]
n = [1.0003, 1.0002, 1.0001]
radius = 6371e3
[[medium.terms]]
type = "expression"
text = "1 + e*exp(-y/d)"
constants = { e = -1e-5, d = 0.05 }
"""
    made = cpm.media.Layered([0, 10, 20], [1.0003, 1.0002, 1.0001], radius=6371e3) + cpm.media.Expression(
        "1 + e*exp(-y/d)", e=-1e-5, d=0.05)
    points = [(0, 0.01, 0), (100, 5, 3)]
    for a, b in zip(load(tmp_path, ROOM + text).medium.evaluate(points), made.evaluate(points), strict=True):
        np.testing.assert_array_equal(a, b)


def test_lenses_bring_their_bounds(tmp_path):
    """[[media]] of a Luneburg or Eaton lens need no bounds; their numbers arrive where they belong."""
    scene = load(tmp_path, ROOM + '[[media]]\ntype = "luneburg"\nradius = 0.5\ncenter = [0, 1, 0]\n'
                                  '[[media]]\ntype = "eaton"\nradius = 0.2\ncenter = [0, 1.2, 2]\n')
    assert [type(medium) for medium in scene.media] == [cpm.media.Luneburg, cpm.media.Eaton]
    n, _ = scene.media[0].evaluate([(0, 1, 0), (0, 1.25, 0), (0, 2, 0)])
    np.testing.assert_allclose(n, [np.sqrt(2), np.sqrt(1.75), 1])
    # parallel light down the axis of the lens meets the floor through its focus, the antipode
    rays = cpm.trace(scene, [(0.1, 2, 0), (0.2, 2, 0.1)], [(0, -1, 0)] * 2, wavelength=550.0, until=((0, 0.5, 0), (0, 1, 0)))
    np.testing.assert_allclose(rays.position, [(0, 0.5, 0)] * 2, rtol=0, atol=1e-12)


def test_sources_from_a_file(tmp_path):
    scene = load(tmp_path, ROOM + '[medium]\ntype = "sources"\ncenters = [[0, 1, 0], [1, 1, 0]]\nstrengths = [0.1, -0.02]\n'
                                  'exponent = [2, 1.5]\ndirections = [[0, 0, 0], [0, 0, 1]]\n')
    n, _ = scene.medium.evaluate([(0, 1.5, 7)])
    assert n[0] == pytest.approx(1 + 0.1 / (0.25 + 49) - 0.02 / np.sqrt(1.25) ** 1.5)


def test_grid_of_densities_by_gladstone_dale(tmp_path):
    np.save(tmp_path / "rho.npy", np.full((4, 4, 4), 1.2))
    scene = load(
        tmp_path,
        ROOM
        + """
[[media]]
type = "grid"
values = "rho.npy"
origin = [-1, 0, -1]
spacing = [0.5, 0.5, 0.5]
quantity = "density"
gladstone_dale = 2.26e-4
""",
    )
    n, gradient = scene.media[0].evaluate([[0.1, 0.4, 0.2]])
    assert n[0] - 1 == pytest.approx(1.2 * 2.26e-4, rel=1e-9)
    np.testing.assert_allclose(gradient, 0, atol=1e-12)


def test_later_bounded_media_win_and_glass_wins_over_them(tmp_path):
    # A ball of glass inside a box of n = 1.2, written in either order: a ray to its middle ends up in glass.
    glass = """
[[shapes]]
type = "sphere"
center = [0, 1, 0]
radius = 0.25
material = { type = "dielectric", interior = 1.5 }
"""
    box = """
[[media]]
type = "homogeneous"
n = 1.2
bounds = { type = "box", low = [-0.5, 0.5, -0.5], high = [0.5, 1.5, 0.5] }
"""
    for text in (glass + box, box + glass):
        scene = load(tmp_path, ROOM + text)
        rays = cpm.trace(scene, (0, 2, 0), (0, -1, 0), wavelength=550.0, length=1.0)
        # 0.5 m of n = 1, 0.25 of 1.2, 0.25 of 1.5.
        assert rays.optical_path[0] == pytest.approx(0.5 + 0.25 * 1.2 + 0.25 * 1.5, rel=1e-6)


def test_media_may_be_bounded_by_a_named_shape(tmp_path):
    scene = load(
        tmp_path,
        ROOM
        + """
[[media]]
type = "homogeneous"
n = 1.4
bounds = { shape = "ball" }
[[shapes]]
name = "ball"
type = "sphere"
center = [0, 1, 0]
radius = 0.25
material = { type = "dielectric", interior = 1.0 }
""",
    )
    rays = cpm.trace(scene, (0, 2, 0), (0, -1, 0), wavelength=550.0, length=1.5)
    assert rays.optical_path[0] == pytest.approx(1.0 + 0.5 * 1.4, rel=1e-6)


def test_transform_scales_then_rotates_then_translates(tmp_path):
    (tmp_path / "one.obj").write_text("v 1 0 0\nv 0 2 0\nv 0 0 3\nf 1 2 3\n")
    scene = load(
        tmp_path,
        ROOM
        + """
[[shapes]]
type = "mesh"
file = "one.obj"
transform = { scale = 2.0, rotate = [90, 0, 90], translate = [0, 0, 10] }
material = "white"
""",
    )
    # About x by 90°: y → z, z → −y. Then about z by 90°: x → y, y → −x.
    np.testing.assert_allclose(scene.shapes[-1].vertices, [[0, 2, 10], [0, 0, 14], [6, 0, 10]], atol=1e-12)


@pytest.mark.parametrize("suffix", ["obj", "ply", "stl", "glb"])
def test_mesh_formats(tmp_path, suffix):
    import trimesh

    trimesh.creation.icosphere(subdivisions=2).export(tmp_path / f"ball.{suffix}")
    scene = load(
        tmp_path,
        f"""{ROOM}
[[shapes]]
type = "mesh"
file = "ball.{suffix}"
material = {{ type = "dielectric", interior = "BK7" }}
""",
    )
    assert len(scene.shapes[-1].faces) == 320


def test_smooth_meshes_get_normals(tmp_path):
    import trimesh

    trimesh.creation.icosphere(subdivisions=3).export(tmp_path / "ball.stl")
    from cpm.scene_file.meshes import load_mesh

    vertices, faces, normals = load_mesh(tmp_path / "ball.stl", smooth=True)
    assert len(vertices) == 3 * 1280  # STL has three corners a face; those at one place share a normal
    assert len(faces) == 1280
    np.testing.assert_allclose(normals, vertices / np.linalg.norm(vertices, axis=1, keepdims=True), atol=0.02)


def test_spectra_of_the_file_come_before_shipped_ones(tmp_path):
    scene = load(
        tmp_path,
        ROOM.replace("0.7", '"paint"')
        + """
[spectra]
paint = { name = "D65", scale = 0.5 }
D65 = { wavelengths = [400, 600], values = [0.2, 0.6] }
""",
    )
    assert scene.shapes[0].material.reflectance.at(500.0) == pytest.approx(0.2)


def test_spectra_may_be_files(tmp_path):
    (tmp_path / "paint.csv").write_text("# nm, reflectance\n400, 0.2\n\n600, 0.6\n")
    scene = load(tmp_path, ROOM.replace("0.7", '{ file = "paint.csv" }'))
    assert scene.shapes[0].material.reflectance.at(500.0) == pytest.approx(0.4)


def changed(old, new):
    assert old in ROOM
    return ROOM.replace(old, new)


#: What is wrong; the key that the message must name; the value; what it says is allowed.
WRONG = [
    (changed("cutoff = 20.0", "cutof = 20.0"), "lights[0].cutof", "unknown key", "cutoff"),
    (changed("cutoff = 20.0", "cutoff = 200.0"), "lights[0].cutoff", "200.0", "less than or equal to 180"),
    (changed("cutoff = 20.0", "cutoff = '20'"), "lights[0].cutoff", "'20'", "number"),
    (changed("cutoff = 20.0", "cutoff = nan"), "lights[0].cutoff", "nan", "finite"),
    (changed("cutoff = 20.0", "cutoff = true"), "lights[0].cutoff", "True", "number"),
    (changed("cutoff = 20.0", ""), "lights[0].cutoff", "missing", ""),
    (changed('type = "spot"', 'type = "laser"'), "lights[0].type", "'laser'", "point, spot, area"),
    (changed('type = "spot"', ""), "lights[0].type", "missing", ""),
    (changed("[0, 3, 0]", "[0, 3]"), "lights[0].position[2]", "missing", ""),
    (changed("[0, 3, 0]", "[0, inf, 0]"), "lights[0].position[1]", "inf", "finite"),
    (changed("intensity = 10.0", "intensity = -1.0"), "lights[0]", "-1", ">= 0"),
    (changed("intensity = 10.0", 'intensity = "sunshine"'), "lights[0].intensity", "'sunshine'", "cornell-white"),
    (changed("intensity = 10.0", "intensity = [1, 2]"), "lights[0].intensity", "[1, 2]", "a number, a name or a table"),
    (changed("intensity = 10.0", "intensity = { scale = 2 }"), "lights[0].intensity", "scale", "exactly one of name"),
    (
        changed("intensity = 10.0", 'intensity = { file = "sun.csv" }'),
        "lights[0].intensity.file",
        "'sun.csv'",
        "no such file",
    ),
    (changed("reflectance = 0.7", "reflectance = 1.7"), "materials.white", "1.7", "0 to 1"),
    (changed("reflectance = 0.7", "colour = 0.7"), "materials.white.colour", "unknown key", "reflectance"),
    (changed('material = "white"', 'material = "whit"'), "shapes[0].material", "'whit'", "white"),
    (changed('material = "white"', "material = 3"), "shapes[0].material", "3", "name or table"),
    (changed("[2,0,0]", "[2,0,'a']"), "shapes[0].quads[0][2][2]", "'a'", "number"),
    (changed("origin = [0, 2, 2]", "origin = [0, 0, 0]"), "camera", "(0.0, 0.0, 0.0)", "no direction"),
    (ROOM + "fov = 180\n", "camera.fov", "180", "less than 180"),
    (ROOM + "[render]\nsize = [0, 10]\n", "render.size[0]", "0", "greater than or equal to 1"),
    (ROOM + "[render]\nphotons = 1.5\n", "render.photons", "1.5", "integer"),
    (ROOM + "[render]\nphotons = -1\n", "render.photons", "-1", "greater than or equal to 0"),
    (ROOM + "[render]\nwavelengths = { from = 700, to = 400, bins = 4 }\n", "render.wavelengths", "700", "low < high"),
    (ROOM + "[render]\nwavelengths = [500, 400]\n", "render.wavelengths", "400", "increase"),
    (ROOM + "[render]\nquality = 11\n", "render.quality", "unknown key", "nearest"),
    (ROOM + '[medium]\ntype = "homogeneous"\nn = -1.0\n', "medium", "-1", ""),
    (ROOM + '[medium]\ntype = "homogeneous"\nn = "cheese"\n', "medium", "'cheese'", "BK7"),
    (ROOM + '[medium]\ntype = "grid"\nvalues = "no.npy"\n', "medium.values", "'no.npy'", "no such file"),
    (
        ROOM + '[medium]\ntype = "linear"\nn = 1.3\ngradient = [0,0,0]\nbounds = { low = [0,0,0], high = [1,1,1] }\n',
        "medium.bounds",
        "",
        "[[media]]",
    ),
    (ROOM + '[medium]\ntype = "parabolic"\nn = 1.5\nalpha = -1.0\n', "medium", "-1", "alpha"),
    (ROOM + '[medium]\ntype = "luneburg"\nradius = 0\n', "medium.radius", "0", "greater than 0"),
    (ROOM + '[medium]\ntype = "eaton"\nradius = 1\nmass = 2\n', "medium.mass", "unknown key", "center"),
    (ROOM + '[medium]\ntype = "sources"\ncenters = [[0,0,0]]\nstrengths = [1, 2]\n', "medium", "strengths", "(1,)"),
    (ROOM + '[medium]\ntype = "sources"\ncenters = [[0,0,0]]\nstrengths = "big"\n', "medium.strengths", "'big'", "number"),
    (ROOM + '[medium]\ntype = "sources"\ncenters = []\nstrengths = 1\n', "medium.centers", "", "at least 1"),
    (ROOM + '[[media]]\ntype = "fisheye"\nn = 2\nradius = 1\n', "media[0].bounds", "missing", ""),
    (ROOM + '[[media]]\ntype = "linear"\nn = 1.3\ngradient = [0,0,0]\n', "media[0].bounds", "missing", ""),
    (
        ROOM + '[[media]]\ntype = "homogeneous"\nbounds = { shape = "roof" }\n',
        "media[0].bounds.shape",
        "'roof'",
        "floor",
    ),
    (
        ROOM + '[[media]]\ntype = "homogeneous"\nbounds = { type = "box", low = [0,0,0], high = [1,0,1] }\n',
        "media[0].bounds",
        "",
        "low < high",
    ),
    (ROOM + '[[lights]]\ntype = "area"\nshape = "roof"\nradiance = 1\n', "lights[1].shape", "'roof'", "floor"),
    (
        ROOM + '[[shapes]]\ntype = "mesh"\nfile = "no.ply"\nmaterial = "white"\n',
        "shapes[1].file",
        "'no.ply'",
        "no such file",
    ),
    (
        ROOM + '[[shapes]]\ntype = "mesh"\nfile = "scene.toml"\nmaterial = "white"\n',
        "shapes[1].file",
        "'.toml'",
        ".ply",
    ),
    (
        ROOM + '[[shapes]]\ntype = "sphere"\ncenter = [0,0,0]\nradius = 0\nmaterial = "white"\n',
        "shapes[1].radius",
        "0",
        "greater than 0",
    ),
    (ROOM + '[medium]\ntype = "expression"\ntext = "1 + q"\n', "medium", "'q'", "x, y, z, r, wavelength"),
    (ROOM + '[medium]\ntype = "expression"\ntext = "1"\nconstants = { x = 1.0 }\n', "medium", "'x'", "formula's own"),
    (
        ROOM + '[medium]\ntype = "expression"\ntext = "1"\nconstants = { n = "2" }\n',
        "medium.constants.n",
        "'2'",
        "number",
    ),
    (ROOM + '[medium]\ntype = "sum"\nterms = []\n', "medium.terms", "[]", "at least 1"),
    (
        ROOM + '[medium]\ntype = "sum"\nterms = [{ type = "expression", text = "log(-1)" }]\n',
        "medium.terms[0]",
        "log of -1",
        "finite",
    ),
    (
        ROOM + '[medium]\ntype = "layered"\nheights = [0, 1]\nn = [1.1, 1.0]\nradius = -1.0\n',
        "medium.radius",
        "-1.0",
        "greater than 0",
    ),
    (ROOM + '[integrator]\nmethod = "magic"\n', "integrator", "'magic'", "auto, exact"),
    (changed("format = 1", "format = 2"), "format", "2", "1"),
    (changed("format = 1", "lihgts = 1"), "lihgts", "unknown key", "lights"),
]


@pytest.mark.parametrize("text, key, value, allowed", WRONG, ids=[f"{case[1]}-{i}" for i, case in enumerate(WRONG)])
def test_one_line_names_file_key_value_and_what_is_allowed(tmp_path, text, key, value, allowed):
    with pytest.raises(cpm.SceneFileError) as refused:
        load(tmp_path, text)
    message = str(refused.value)
    assert "\n" not in message
    assert message.startswith(f"{tmp_path / 'scene.toml'}: {key}: ")
    assert value in message
    assert allowed in message


def test_not_toml_says_where(tmp_path):
    with pytest.raises(cpm.SceneFileError, match="line 2"):
        load(tmp_path, "format = 1\n= 3\n")
    (tmp_path / "binary.toml").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(cpm.SceneFileError, match="UTF-8"):
        cpm.load_scene(tmp_path / "binary.toml")


def test_missing_file_is_file_not_found(tmp_path):
    with pytest.raises(FileNotFoundError):
        cpm.load_scene(tmp_path / "none.toml")


def test_broken_meshes_are_refused_by_name(tmp_path):
    (tmp_path / "broken.ply").write_bytes(b"ply\nformat binary_little_endian 1.0\nelement vertex 99\n")
    (tmp_path / "empty.obj").write_text("# nothing\n")
    for name in ("broken.ply", "empty.obj"):
        with pytest.raises(cpm.SceneFileError, match=rf"shapes\[1\]\.file: '{name}'"):
            load(tmp_path, f'{ROOM}[[shapes]]\ntype = "mesh"\nfile = "{name}"\nmaterial = "white"\n')


def test_values_are_data_never_code(tmp_path):
    class Payload:
        def __reduce__(self):
            return (Path.touch, (tmp_path / "executed",))

    np.save(tmp_path / "evil.npy", np.array([Payload()], dtype=object), allow_pickle=True)
    with pytest.raises(cpm.SceneFileError, match=r"medium\.values: 'evil\.npy'"):
        load(tmp_path, f'{ROOM}[medium]\ntype = "grid"\nvalues = "evil.npy"\n')
    assert not (tmp_path / "executed").exists()


def test_open_dielectrics_are_refused_by_name(tmp_path):
    with pytest.raises(cpm.SceneFileError, match=r"shapes\[1\].*pane"):
        load(
            tmp_path,
            ROOM
            + """
[[shapes]]
name = "pane"
type = "quads"
quads = [[[0,1,0], [1,0,0], [0,1,0]]]
material = { type = "dielectric", interior = 1.5 }
""",
        )


# Any value anywhere: a scene or one line, never another exception.

VALUES = st.one_of(
    st.integers(-3, 3),
    st.floats(),
    st.text(max_size=4),
    st.booleans(),
    st.lists(st.floats(-2, 2), max_size=4),
    st.dictionaries(st.text("abn", max_size=2), st.integers()),
    st.just({"type": "sphere"}),
    st.just([[]]),
    st.just(10**30),
)


def places(table, path=()):
    """Every place in nested tables and lists."""
    items = table.items() if isinstance(table, dict) else enumerate(table) if isinstance(table, list) else ()
    for key, value in items:
        yield (*path, key)
        yield from places(value, (*path, key))


SOURCE = tomllib.loads((EXAMPLES / "cross_room_curved.toml").read_text())
PLACES = list(places(SOURCE))


@settings(max_examples=150, deadline=None, derandomize=True, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(place=st.sampled_from(PLACES), value=VALUES)
def test_any_value_anywhere_is_a_scene_or_one_line(tmp_path, place, value):
    import copy

    from pydantic import ValidationError

    from cpm.scene_file.build import build
    from cpm.scene_file.models import SceneTable
    from cpm.scene_file.read import described

    data = copy.deepcopy(SOURCE)
    inside = data
    for key in place[:-1]:
        inside = inside[key]
    inside[place[-1]] = value
    try:
        table = SceneTable.model_validate(data)
    except ValidationError as error:
        key, problem = described(error, data)
        assert key
        assert "\n" not in key + problem
        return
    try:
        scene = build(table, tmp_path / "scene.toml")
    except cpm.SceneFileError as error:
        assert "\n" not in str(error)
    else:
        assert isinstance(scene, cpm.Scene)


INTERIORS = [
    ("1.5", lambda w: 1.5 + 0 * w),
    ('"BK7"', lambda w: cpm.dispersion.catalogue("BK7").n(w)),
    ("{ cauchy = [1.5, 0.004] }", lambda w: 1.5 + 0.004 / (1e-3 * w) ** 2),
    ("{ sellmeier = { B = [1.0, 0.2], C = [0.01, 100.0] } }",
     lambda w: np.sqrt(1 + sum(b * (1e-3 * w) ** 2 / ((1e-3 * w) ** 2 - c) for b, c in ((1.0, 0.01), (0.2, 100.0))))),
    ("{ n = 1.5 }", lambda w: 1.5 + 0 * w),
    ('{ n = "BK7" }', lambda w: cpm.dispersion.catalogue("BK7").n(w)),
    ('{ type = "homogeneous", n = { cauchy = [1.5, 0.004] } }', lambda w: 1.5 + 0.004 / (1e-3 * w) ** 2),
]


@pytest.mark.parametrize("interior, index", INTERIORS, ids=[text for text, _ in INTERIORS])
def test_interiors(tmp_path, interior, index):
    """Each way of DESIGN section 9 to say what glass is."""
    path = tmp_path / "a.toml"
    path.write_text('[[shapes]]\ntype = "sphere"\ncenter = [0, 0, 0]\nradius = 1\n'
                    f'material = {{ type = "dielectric", interior = {interior} }}\n')
    medium = cpm.load_scene(path).shapes[0].material.interior
    for wavelength in (450.0, 650.0):
        assert medium.evaluate((0, 0, 0), wavelength)[0][0] == pytest.approx(index(wavelength), rel=1e-12)


def test_an_interior_that_is_none(tmp_path):
    path = tmp_path / "a.toml"
    start = '[[shapes]]\ntype = "sphere"\ncenter = [0, 0, 0]\nradius = 1\nmaterial = { type = "dielectric", interior = '
    for text, problem in (('"glass"', "interior is 'glass'; a number, a catalogue name (BK7,|'glass'; BK7,"),
                          ("[1.5]", "must be a number, a catalogue name, a dispersion or a medium"),
                          ("{ cauchi = [1.5] }", "unknown key (allowed: constant, cauchy, sellmeier"),
                          ("{ n = 1.5, m = 2 }", "unknown key (allowed: dispersion, bounds, n)")):
        path.write_text(f"{start}{text} }}\n")
        with pytest.raises(cpm.SceneFileError) as refused:
            cpm.load_scene(path)
        assert any(part in str(refused.value) for part in problem.split("|")), refused.value
