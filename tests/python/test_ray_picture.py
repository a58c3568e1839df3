"""cpm rays: what the picture holds (its look is judged by eye; its numbers here)."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import cpm
from cpm.ray_picture import ray_picture
from cpm.section import Section

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"


def drawn(scene, **options):
    figure = ray_picture(scene, title="name", **options)
    labels = [text.get_text() for text in figure.legends[0].get_texts()]
    return figure.axes, labels


def test_title_units_legend_and_index():
    axes, labels = drawn(cpm.load_scene(EXAMPLES / "cross_room_curved.toml"))
    assert axes[0].get_title() == "name: rays from a light, section z = 0 m"
    assert (axes[0].get_xlabel(), axes[0].get_ylabel()) == ("x, m", "y, m")
    assert {"surfaces", "light"} <= set(labels)
    rays = [label for label in labels if label.startswith("550 nm: ")]
    assert sum(int(label.split()[2]) for label in rays) == 25 and len(rays) == 2  # some hit, some leave
    assert axes[1].get_ylabel() == "refractive index n at 550 nm"


def test_no_background_where_nothing_varies():
    axes, _ = drawn(cpm.load_scene(EXAMPLES / "cross_room_homogeneous.toml"))
    assert len(axes) == 1


def test_three_wavelengths_where_they_part():
    _, labels = drawn(cpm.load_scene(EXAMPLES / "glass_caustic.toml"), rays=9)
    assert [f"{w} nm: 9 hit" in labels for w in (450, 550, 650)] == [True] * 3


def test_index_of_a_section():
    """The last filling wins: layers, a box in them, a ball and a closed mesh of glass in that."""
    scene = cpm.Scene(cpm.media.LinearSquared(2.0, (0, 0.1, 0)))
    scene.add_medium(cpm.media.Homogeneous(1.2, bounds=cpm.Box((-2, -2, -2), (2, 2, 2))))
    scene.add_sphere((1, 0, 0), 0.5, cpm.materials.Dielectric(1.5))
    corners = np.array([(x, y, z) for x in (-1, 0) for y in (-0.5, 0.5) for z in (-1, 1)], dtype=float)
    faces = [(0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1), (2, 3, 7), (2, 7, 6), (0, 2, 6),
             (0, 6, 4), (1, 5, 7), (1, 7, 3)]
    scene.add_mesh(corners, faces, cpm.materials.Dielectric(1.7))
    section = Section(np.zeros(3), np.array((1.0, 0, 0)), np.array((0, 1.0, 0)))
    x, y = np.array([1.1, -0.6, 1.7, 3.0, -3.0]), np.array([0.1, 0.2, 1.9, 4.0, -4.0])
    expected = [1.5, 1.7, 1.2, np.sqrt(2.4), np.sqrt(1.6)]
    np.testing.assert_allclose(section.index(scene, x, y, 550.0), expected, rtol=1e-12)
    assert np.isnan(section.index(scene, np.array([0.0]), np.array([-30.0]), 550.0)[0])  # n² = -1


@pytest.mark.parametrize("light", [1, -1])
def test_a_light_that_is_not_there(light):
    with pytest.raises(ValueError, match=rf"light is {light}; the scene has 1 lights: 0 to 0 are allowed"):
        ray_picture(cpm.load_scene(EXAMPLES / "glass_caustic.toml"), light=light)


def test_many_rays_are_drawn_in_pieces():
    """Ctrl-C is answered between pieces; the legend still has one line for all, and memory a bound."""
    figure = ray_picture(cpm.load_scene(EXAMPLES / "cross_room_homogeneous.toml"), rays=20_000)
    pieces = [each for each in figure.axes[0].collections if each.get_label() != "surfaces"]
    assert max(len(each.get_paths()) for each in pieces) <= 500
    assert sum(len(each.get_paths()) for each in pieces) == 20_000
    assert sum(len(path.vertices) for each in pieces for path in each.get_paths()) <= 1.1 * (1 << 22)
    named = [text.get_text() for text in figure.legends[0].get_texts()]
    assert sum(int(label.split()[2]) for label in named if label.startswith("550 nm: ")) == 20_000 and len(named) == 4


def test_ctrl_c_while_many_rays_are_drawn(tmp_path):
    """A second at most, as everywhere: matplotlib draws no more than a piece before it is answered (issue: it drew all)."""
    code = ("import signal, sys; signal.signal(signal.SIGINT, signal.default_int_handler)\n"
            "import matplotlib.backends.backend_agg as agg, matplotlib.collections as parts\n"
            "drawn, real = [0], parts.LineCollection.draw\n"
            "def draw(self, renderer):\n"
            "    drawn[0] += 1\n"
            "    if drawn[0] == 10: signal.raise_signal(signal.SIGINT)\n"
            "    real(self, renderer)\n"
            "parts.LineCollection.draw = draw\n"
            "from cpm.cli.program import run\n"
            "status = run(sys.argv[1:]); print(drawn[0]); sys.exit(status)")
    scene = EXAMPLES / "cross_room_homogeneous.toml"
    done = subprocess.run([sys.executable, "-c", code, "rays", scene, "--rays", "20000", "-o", tmp_path / "a.png"],
                          capture_output=True, text=True, timeout=120)
    assert done.returncode == 130 and done.stdout.split() == ["10"], done
    assert not list(tmp_path.iterdir())
