"""Bad scene files: one line with file, key, value and what is allowed; exit 2; nothing written (DESIGN section 9)."""

import pathlib
import subprocess
import sys

import pytest

import cpm

GOOD = """
format = 1
[medium]
type = "linear-squared"
n_squared = 1.69
gradient = [0, -0.10, 0]
[materials]
white = { type = "diffuse", reflectance = 0.75 }
[[shapes]]
type = "quads"
quads = [[[-2,0,-2], [0,0,4], [4,0,0]]]
material = "white"
[[lights]]
type = "spot"
position = [-1, 3, 0]
target = [0, 0, 0]
cutoff = 14.0
intensity = 100.0
[camera]
origin = [1.85, 3.0, 1.85]
target = [-1.2, 0.6, -0.9]
up = [0, 1, 0]
fov = 70.0
[render]
size = [16, 12]
photons = 500
nearest = 20
wavelengths = [450, 550, 650]
"""

#: name → (text to replace, replacement, words the message must hold).
BAD = {
    "unknown key": ("cutoff = 14.0", "cutof = 14.0", ["cutof"]),
    "unknown table": ("[render]", "[rendering]", ["rendering"]),
    "unknown type": ('type = "spot"', 'type = "spott"', ["spott"]),
    "unknown material": ('material = "white"', 'material = "whyte"', ["whyte"]),
    "unknown spectrum": ("reflectance = 0.75", 'reflectance = "mauve"', ["mauve"]),
    "number too large": ("reflectance = 0.75", "reflectance = 1.75", ["reflectance", "1.75"]),
    "not a number": ("fov = 70.0", 'fov = "wide"', ["fov", "wide"]),
    "nan": ("fov = 70.0", "fov = nan", ["fov", "nan"]),
    "fov out of range": ("fov = 70.0", "fov = 190.0", ["fov", "190"]),
    "negative photons": ("photons = 500", "photons = -5", ["photons", "-5"]),
    "short vector": ("up = [0, 1, 0]", "up = [0, 1]", ["up"]),
    "missing key": ("cutoff = 14.0\n", "", ["cutoff"]),
    "format": ("format = 1", "format = 99", ["format", "99"]),
    "missing mesh": (
        'type = "quads"\nquads = [[[-2,0,-2], [0,0,4], [4,0,0]]]',
        'type = "mesh"\nfile = "no-such.ply"',
        ["no-such.ply"],
    ),
    "code": ("fov = 70.0", "fov = \"__import__('os').system('touch owned')\"", ["fov"]),
    "bad medium": ("n_squared = 1.69", "n_squared = -1.69", ["n_squared", "-1.69"]),
}


def write(folder, old="", new="", name="scene.toml"):
    assert old in GOOD
    path = pathlib.Path(folder) / name
    path.write_text(GOOD.replace(old, new, 1) if old else GOOD)
    return path


def cli(*arguments, cwd):
    """Exit status and stderr of the command line."""
    command = pathlib.Path(sys.executable).parent / "cpm"
    done = subprocess.run(
        [str(command), *map(str, arguments)], cwd=cwd, capture_output=True, text=True, timeout=120, check=False
    )
    return done.returncode, done.stderr


def test_good_file_renders(tmp_path):
    """The template itself is good: both pictures, here, under the scene's stem."""
    write(tmp_path)
    status, message = cli("render", "scene.toml", cwd=tmp_path)
    assert status == 0, message
    assert {p.name for p in tmp_path.iterdir()} == {"scene.toml", "scene.exr", "scene.png"}


@pytest.mark.parametrize("name", BAD)
def test_load_scene(name, tmp_path):
    """The Python side: ValueError (or cpm.Error, FileNotFoundError) whose text names file, key and value."""
    old, new, words = BAD[name]
    path = write(tmp_path, old, new)
    with pytest.raises((ValueError, OSError, cpm.Error)) as caught:
        cpm.load_scene(path)
    for word in ["scene.toml", *words]:
        assert word in str(caught.value), str(caught.value)


@pytest.mark.parametrize("name", ["unknown key", "number too large", "missing mesh", "not a number"])
def test_command_line(name, tmp_path):
    """One line on stderr, exit status 2, no file half-written."""
    old, new, words = BAD[name]
    write(tmp_path, old, new)
    status, message = cli("render", "scene.toml", cwd=tmp_path)
    assert status == 2, message
    lines = [line for line in message.splitlines() if line.strip()]
    assert len(lines) == 1, message
    for word in ["scene.toml", *words]:
        assert word in message
    assert {p.name for p in tmp_path.iterdir()} == {"scene.toml"}


def test_allowed_values_are_said(tmp_path):
    """An unknown type or key lists what is known."""
    _, message = cli("render", write(tmp_path, 'type = "spot"', 'type = "spott"').name, cwd=tmp_path)
    assert "spot" in message.replace("spott", "") and "point" in message
    _, message = cli("render", write(tmp_path, "cutoff = 14.0", "cutof = 14.0").name, cwd=tmp_path)
    assert "cutoff" in message


@pytest.mark.parametrize(
    ("text", "word"), [("not toml [", "scene.toml"), ("", "scene.toml"), ("\x00\x01", "scene.toml")]
)
def test_not_a_scene(text, word, tmp_path):
    (tmp_path / "scene.toml").write_text(text)
    status, message = cli("render", "scene.toml", cwd=tmp_path)
    assert status == 2 and word in message and len(message.strip().splitlines()) == 1, message


def test_missing_scene(tmp_path):
    status, message = cli("render", "nowhere.toml", cwd=tmp_path)
    assert status == 2 and "nowhere.toml" in message


@pytest.mark.parametrize(
    ("arguments", "word"),
    [
        (["--size", "0x10"], "size"),
        (["--size", "wide"], "size"),
        (["--photons", "-3"], "photons"),
        (["--nearest", "0"], "nearest"),
        (["-o", "picture.bmp"], "picture.bmp"),
        (["--backend", "abacus"], "abacus"),
        (["--no-such-option"], "no-such-option"),
    ],
)
def test_bad_arguments(arguments, word, tmp_path):
    write(tmp_path)
    status, message = cli("render", "scene.toml", *arguments, cwd=tmp_path)
    assert status == 2 and word in message, message
    assert {p.name for p in tmp_path.iterdir()} == {"scene.toml"}
