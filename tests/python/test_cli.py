"""The command line: what it writes, what it says, how it ends."""

import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import cpm
from cpm.cli.program import run

EXAMPLES = Path(__file__).parents[2] / "examples"
SMALL = ["--size", "16x12", "--photons", "2000"]
HOMOGENEOUS, CURVED = (str(EXAMPLES / f"cross_room_{name}.toml") for name in ("homogeneous", "curved"))


@pytest.fixture(autouse=True)
def in_an_empty_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


def files():
    return sorted(path.name for path in Path().iterdir())


def test_render_writes_both_formats_here_by_default(capsys):
    assert run(["render", CURVED, *SMALL]) == 0
    assert files() == ["cross_room_curved.exr", "cross_room_curved.png"]
    printed = capsys.readouterr().out
    for word in ("photons emitted", "2,000", "gradient evaluations", "left out", "wrote cross_room_curved.exr"):
        assert word in printed


def test_output_may_repeat(tmp_path):
    (tmp_path / "out").mkdir()
    assert run(["render", HOMOGENEOUS, *SMALL, "-o", "a.png", "-o", "out/b.exr", "--quiet"]) == 0
    assert files() == ["a.png", "out"]
    assert (tmp_path / "out" / "b.exr").stat().st_size > 0


def test_options_reach_the_render():
    assert run(["render", CURVED, *SMALL, "--nearest", "20", "--seed", "3", "-o", "a.exr", "-q"]) == 0
    import colour

    components = colour.read_spectral_image_Fichet2021("a.exr")
    image = cpm.render(cpm.load_scene(CURVED), size=(16, 12), photons=2000, nearest=20, seed=3)
    np.testing.assert_array_equal(components["S0"][1], image.data)


def test_photons_draws_the_map():
    assert run(["photons", HOMOGENEOUS, *SMALL, "-q"]) == 0
    assert files() == ["cross_room_homogeneous_photons.exr", "cross_room_homogeneous_photons.png"]


@pytest.mark.parametrize("suffix", ["png", "svg", "pdf"])
def test_rays_draws_paths(suffix, capsys):
    assert run(["rays", CURVED, "--rays", "5", "-o", f"a.{suffix}"]) == 0
    assert files() == [f"a.{suffix}"]
    assert "wrote" in capsys.readouterr().out


def test_rays_draws_the_room_s_section():
    from cpm.ray_picture import ray_picture

    lines = {each.get_label(): each for each in ray_picture(cpm.load_scene(CURVED), rays=5).axes[0].collections}
    edges = lines["surfaces"]
    paths = [path for name, each in lines.items() if name.startswith("550 nm") for path in each.get_segments()]
    assert len(paths) == 5
    # z = 0 cuts floor, ceiling, right wall, and the left wall below and above the upright of its cross.
    ends = np.round(np.concatenate(edges.get_segments()), 6)
    assert ends[:, 0].min() == -2
    assert ends[:, 0].max() == 2
    wall = ends[ends[:, 0] == -2]
    assert set(wall[:, 1]) >= {0.0, 0.8, 3.2, 4.0}
    assert not ((wall[:, 1] > 0.8) & (wall[:, 1] < 3.2)).any()


def test_explain_says_what_is_in_and_out(capsys):
    assert run(["explain", HOMOGENEOUS, "--no-measure"]) == 0
    found, left_out = capsys.readouterr().out.split("left out")
    assert "meshes" in found
    assert "delta_lights" in found
    for name in ("curved", "integrator", "dispersion", "specular", "spheres"):
        assert name in left_out


def test_explain_measures(capsys):
    assert run(["explain", HOMOGENEOUS]) == 0
    printed = capsys.readouterr().out
    assert "0 gradient evaluations" in printed
    assert "0 caustic photons, 0 bytes, 0 projection cells" in printed
    assert "measured on" in printed


def test_info_names_versions(capsys):
    assert run(["info"]) == 0
    printed = capsys.readouterr().out
    for word in (f"cpm {cpm.__version__}", "embree", "python 3", "numpy", "native"):
        assert word in printed


def test_bench_lists_and_refuses(capsys, monkeypatch):
    monkeypatch.chdir(EXAMPLES.parent)
    assert run(["bench"]) == 0
    listed = capsys.readouterr().out.split()
    assert run(["bench", "no-such-bench"]) == 2
    message = capsys.readouterr().err
    assert "no-such-bench" in message
    assert all(name in message for name in listed)


def test_bench_passes_arguments_and_status(tmp_path, monkeypatch, capfd):
    for folder in ("bench", "libcpm"):
        (tmp_path / folder).mkdir()
    (tmp_path / "bench" / "echo.py").write_text("import sys; print(sys.argv[1:]); sys.exit(3)")
    monkeypatch.setattr("cpm._data.checkout", lambda: None)
    assert run(["bench", "echo", "--", "--seconds", "1"]) == 3
    assert "['--seconds', '1']" in capfd.readouterr().out


def test_no_arguments_is_help(capsys):
    assert run([]) == 0
    assert "Usage: cpm" in capsys.readouterr().out


@pytest.mark.parametrize(
    "arguments, words",
    [
        (["render"], ["SCENE"]),
        (["rendr", CURVED], ["rendr"]),
        (["render", "none.toml"], ["none.toml", "no such file"]),
        (["render", CURVED, "--sise", "4x3"], ["--sise"]),
        (["render", CURVED, "--size", "400"], ["--size", "'400'", "400x300"]),
        (["render", CURVED, "--size", "0x300"], ["--size", "'0x300'"]),
        (["render", CURVED, "--photons", "many"], ["--photons", "'many'"]),
        (["render", CURVED, "--photons", "1.5"], ["--photons", "'1.5'"]),
        (["render", CURVED, "--photons", "5e9"], ["photons", "5000000000", "4294967295"]),
        (["render", CURVED, "--nearest", "1"], ["nearest", "1", "2 to"]),
        (["render", CURVED, "--threads", "-1"], ["threads", "-1", "0 to 1024"]),
        (["render", CURVED, "--backend", "cuda"], ["backend", "'cuda'", "native"]),
        (["render", CURVED, "-o", "a.jpg"], ["a.jpg", ".exr, .png"]),
        (["render", CURVED, "-o", "none/a.png"], ["none", "no such folder"]),
        (["render", CURVED, "-o", "a.png", "-o", "./a.png"], ["a.png", "twice"]),
        (["render", CURVED, "--white", "chalk"], ["white", "'chalk'"]),
        (["render", CURVED, "--gamut", "cut"], ["gamut", "'cut'", "clip, desaturate, keep"]),
        (["render", CURVED, "--exposure", "0"], ["exposure", "0", "> 0"]),
        (["photons", CURVED, "--white", "chalk"], ["white", "'chalk'"]),
        (["photons", CURVED, "--exposure", "-1"], ["exposure", "-1", "> 0"]),
        (["render", CURVED, "-o", "/proc/a.png"], ["/proc/a.png: cannot be written"]),
        (["rays", CURVED, "-o", "/proc/a.png"], ["/proc/a.png: cannot be written"]),
        (["rays", CURVED, "--light", "1"], ["light", "1"]),
    ],
)
def test_bad_input_is_one_line_and_status_2(arguments, words, capsys):
    assert run(arguments) == 2
    printed = capsys.readouterr()
    assert printed.err.startswith("cpm: ")
    assert printed.err.count("\n") == 1
    for word in words:
        assert word in printed.err
    assert files() == []


@pytest.mark.parametrize("options", [["--white", "chalk"], ["-o", "/proc/a.png"]])
def test_refused_before_the_work(options, monkeypatch):
    monkeypatch.setattr("cpm.cli.render.render_scene", lambda *_, **__: pytest.fail("rendered first"))
    assert run(["render", CURVED, *options]) == 2


def test_a_folder_that_closes_meanwhile_is_named_as_the_user_did(capsys, monkeypatch):
    """Writable when asked, not when the picture is there: the message has the user's path, not that of the file beside."""
    monkeypatch.setattr("cpm.cli.options.refuse_unwritable", lambda path: None)
    assert run(["render", HOMOGENEOUS, *SMALL, "-q", "-o", "/proc/a.png"]) == 2
    assert capsys.readouterr().err == "cpm: /proc/a.png: no such file\n"


@pytest.mark.skipif(len(cpm.devices()) < 2, reason="no OpenCL device")
def test_what_a_device_cannot_do_is_a_failure_that_names_it(capsys):
    text = Path(CURVED).read_text()
    Path("sky.toml").write_text(text + '\n[[lights]]\ntype = "environment"\nradiance = 1.0\n')
    assert run(["render", "sky.toml", "--backend", "opencl", "--size", "8x6", "--photons", "100"]) == 1
    assert "a sun or an environment" in capsys.readouterr().err
    assert files() == ["sky.toml"]


def test_bad_scene_is_status_2(capsys):
    Path("bad.toml").write_text("[camera]\nfov = 400\n")
    assert run(["render", "bad.toml"]) == 2
    assert capsys.readouterr().err == "cpm: bad.toml: camera.origin: is missing\n"
    assert files() == ["bad.toml"]


def test_ctrl_c_is_130_and_leaves_what_was_there(monkeypatch, capsys):
    """The first progress report interrupts: the picture from before stays, and nothing lies beside it."""
    Path("a.png").write_bytes(b"before")
    real = cpm.render

    def interrupted(scene, **options):
        options["progress"] = lambda stage, fraction: signal.raise_signal(signal.SIGINT)
        return real(scene, **options)

    monkeypatch.setattr("cpm.cli.render.render_scene", interrupted)
    assert run(["render", CURVED, "--size", "64x48", "--photons", "1e6", "-o", "a.png", "-o", "a.exr"]) == 130
    assert "interrupted" in capsys.readouterr().err
    assert Path("a.png").read_bytes() == b"before"
    assert files() == ["a.png"]


def test_failed_write_leaves_what_was_there(monkeypatch, capsys):
    Path("a.png").write_bytes(b"before")

    def full(*arguments):
        raise OSError("no space left on device")

    monkeypatch.setattr("cpm.image.Image._write", full)
    assert run(["render", CURVED, *SMALL, "-o", "a.png", "-q"]) == 1
    assert "no space left" in capsys.readouterr().err
    assert Path("a.png").read_bytes() == b"before"
    assert files() == ["a.png"]


def test_exceptions_of_a_callback_cancel_and_come_out():
    class EnoughError(Exception):
        pass

    def report(stage, fraction):
        raise EnoughError(stage)

    scene = cpm.load_scene(CURVED)
    with pytest.raises(EnoughError):
        cpm.trace_photons(scene, 1_000_000, progress=report)
    assert len(cpm.trace_photons(scene, 1000).diffuse) > 0  # and the scene still serves


def test_progress_goes_through_the_stages():
    seen = []
    cpm.render(cpm.load_scene(CURVED), size=(16, 12), photons=200_000, progress=lambda *report: seen.append(report))
    assert {"trace", "gather"} <= {stage for stage, _ in seen}
    assert all(0.0 <= fraction <= 1.0 for _, fraction in seen)


def test_the_console_script_is_the_program():
    command = [sys.executable, "-c", "from cpm.cli import main; main()"]
    finished = subprocess.run(command, capture_output=True, text=True)
    assert finished.returncode == 0
    assert "Usage: cpm" in finished.stdout


def test_version(capsys):
    assert run(["--version"]) == 0
    assert capsys.readouterr().out == f"cpm {cpm.__version__}\n"


def test_bench_writes_here_unless_told(tmp_path, monkeypatch):
    """A benchmark leaves the published results alone."""
    import argparse

    monkeypatch.syspath_prepend(str(EXAMPLES.parent / "bench"))
    results = __import__("_results")
    parser = argparse.ArgumentParser()
    results.add_arguments(parser)
    assert parser.parse_args([]).results == Path("results")
    assert parser.parse_args(["--results", "docs/results"]).results == Path("docs/results")


def test_a_folder_is_no_scene(capsys):
    Path("scenes").mkdir()
    assert run(["render", "scenes"]) == 2
    assert capsys.readouterr().err == "cpm: scenes: is a folder\n"
