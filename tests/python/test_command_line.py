"""The commands of DESIGN section 9, run as a user would, and what `import cpm` may not pull in."""

import pathlib
import signal
import subprocess
import sys

import pytest

import cpm

ROOT = pathlib.Path(__file__).resolve().parents[2]
EXAMPLES = sorted((ROOT / "examples").glob("*.toml"))
COMMAND = str(pathlib.Path(sys.executable).parent / "cpm")
ROOM = str(ROOT / "examples" / "cross_room_curved.toml")


INTERRUPTED = """
import sys, cpm
said = False
def progress(stage, fraction):
    global said
    if not said:
        said = True
        print("photons", flush=True)
try:
    cpm.render(cpm.load_scene(sys.argv[1]), photons=1_000_000_000, progress=progress).save("out.exr")
except KeyboardInterrupt:
    sys.exit(130)
"""


def run(*arguments, cwd):
    return subprocess.run(
        [COMMAND, *map(str, arguments)], cwd=cwd, capture_output=True, text=True, timeout=300, check=False
    )


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda p: p.stem)
def test_examples_load(path):
    """Every shipped scene loads, has a camera, and renders small."""
    scene = cpm.load_scene(path)
    assert scene.camera is not None
    image = cpm.render(
        scene, size=(16, 12), photons=20_000, nearest=30, wavelengths=[450.0, 600.0], seed=1, progress=False
    )
    assert image.data.shape == (12, 16, 2) and image.data.max() > 0


def test_there_are_examples():
    names = {p.stem for p in EXAMPLES}
    assert {"cross_room_homogeneous", "cross_room_curved", "glass_caustic", "mirror_room"} <= names


def test_render_to_several_files(tmp_path):
    small = ("--size", "20x15", "--photons", "5000", "--nearest", "30", "--seed", "1")
    done = run("render", ROOM, *small, "-o", "a.exr", "-o", "b.png", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert {p.name for p in tmp_path.iterdir()} == {"a.exr", "b.png"}


@pytest.mark.parametrize("command", ["photons", "rays"])
def test_pictures(command, tmp_path):
    """The photon map, and curved paths in a section, as PNG files."""
    options = ("--photons", "5000") if command == "photons" else ()
    done = run(command, ROOM, *options, "-o", "out.png", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    files = list(tmp_path.glob("*.png"))
    assert files and all(f.stat().st_size > 1000 for f in files)


def test_info_and_explain(tmp_path):
    done = run("info", cwd=tmp_path)
    assert done.returncode == 0 and "native" in done.stdout
    done = run("explain", ROOM, cwd=tmp_path)
    assert done.returncode == 0 and done.stdout.strip(), done.stderr


def test_version_and_help(tmp_path):
    """Help of every command, and the version somewhere in `info`."""
    for command in ((), ("render",), ("photons",), ("rays",), ("explain",), ("info",)):
        assert run(*command, "--help", cwd=tmp_path).returncode == 0
    assert cpm.__version__ in run("info", cwd=tmp_path).stdout


def test_interrupt_leaves_what_was_there(tmp_path):
    """Ctrl-C: exit status 130, the older picture untouched, nothing half-written."""
    (tmp_path / "out.exr").write_bytes(b"older")
    process = subprocess.Popen(
        [sys.executable, "-c", INTERRUPTED, ROOM], cwd=tmp_path, stdout=subprocess.PIPE, text=True
    )
    try:
        assert process.stdout.readline().strip() == "photons"  # the pass is under way
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=60)
    finally:
        process.kill()
    assert process.returncode == 130
    assert (tmp_path / "out.exr").read_bytes() == b"older"
    assert {p.name for p in tmp_path.iterdir()} == {"out.exr"}


def test_import_is_lean():
    """`import cpm` loads none of the heavy packages (DESIGN section 5)."""
    heavy = ("colour", "matplotlib", "trimesh", "sympy", "scipy", "pyopencl")
    code = f"import sys, cpm; print(sorted(m for m in {heavy} if m in sys.modules))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
