"""Background-oriented schlieren (docs/gallery/schlieren.md): dots' displacements in the pictures against the path integral."""

import runpy
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import cpm

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
GLADSTONE_DALE, AMBIENT = 2.26e-4, 1.204


@pytest.fixture(scope="module")
def bos():
    return runpy.run_path(str(EXAMPLES / "bos.py"))


def path_integral(bos, size):
    """Displacements (ROWS, COLUMNS, 2), pixels right and down, to first order: ∫ (∇n)⊥/n (1 − t) dl along the straight
    line from the eye (t = 0) to each dot (t = 1), by Gauss–Legendre over the field's formula itself, not its samples.

    A ray that is bent by an angle at t reaches the dot if it starts apart from the straight line by (1 − t) of it.
    """
    eye = np.array([0, 0, 2.0])
    nodes, weights = np.polynomial.legendre.leggauss(200)
    moved = []
    for x, y in bos["dot_centers"]():
        way = np.array([x, y, -2.0]) - eye
        length = np.linalg.norm(way)
        t = 0.5 + 0.04 * nodes  # |z| < 0.16 of 4 m
        at = eye + t[:, None] * way
        h = 1e-5 * np.eye(3)
        rho = bos["plume"]
        slope = GLADSTONE_DALE * np.stack([(rho(*(at + e).T) - rho(*(at - e).T)) / 2e-5 for e in h], axis=1)
        slope -= np.outer(slope @ way, way) / length**2
        n = 1 + GLADSTONE_DALE * rho(*at.T)
        angle = np.sum((slope.T / n) * (1 - t) * weights * 0.04 * length, axis=1)
        seen = way - angle * length
        moved.append((seen[:2] / -seen[2] - way[:2] / 4) * (1, -1))
    return size[0] / 0.2 * np.array(moved).reshape(bos["ROWS"], bos["COLUMNS"], 2)[::-1]


def test_displacements(bos):
    """A third of a pixel at the most; measured to a hundredth, and in the mean to 2 %."""
    size = (320, 240)
    flow = cpm.media.Grid(*bos["plume_grid"]()[:2], 0.01, quantity="density")
    pictures = [bos["picture"](which, size, 16) for which in (flow, None)]
    found = bos["centroids"](pictures[0]) - bos["centroids"](pictures[1])
    expected = path_integral(bos, size)
    assert np.abs(expected).max() > 0.3
    assert np.sqrt(np.mean((found - expected) ** 2)) < 0.01
    assert np.sum(found * expected) / np.sum(expected**2) == pytest.approx(1.0, abs=0.02)


def test_knife_edge(bos):
    """Brightness is the angle of each ray: against the integral of ∂n/∂x along it, where the flow's samples are smooth."""
    flow = cpm.media.Grid(*bos["plume_grid"]()[:2], 0.01, quantity="density")
    shown = bos["schlieren"](flow, (32, 24), cut_off=1e-3)  # centres of pixels are the dots
    rows, columns = shown.shape
    nodes, weights = np.polynomial.legendre.leggauss(200)
    expected = []
    for x, y in bos["dot_centers"]():
        way = np.array([x, y, -4.0])
        at = np.array([0, 0, 2.0]) + (0.5 + 0.04 * nodes)[:, None] * way
        rho = bos["plume"]
        slope = (rho(at[:, 0] + 1e-5, *at[:, 1:].T) - rho(at[:, 0] - 1e-5, *at[:, 1:].T)) / 2e-5
        expected.append(GLADSTONE_DALE * np.sum(slope * weights) * 0.04 * np.linalg.norm(way))
    angle = 1e-3 * (2 * shown - 1)
    expected = np.array(expected).reshape(rows, columns)[::-1]
    assert np.abs(expected).max() > 3e-4
    # The largest differences are the samples': the plume's foot is 2 cm wide and they are 1 cm apart.
    assert np.sqrt(np.mean((angle - expected) ** 2)) < 0.02 * np.abs(expected).max()


def test_script(tmp_path):
    """An array of one's own, as in its help; a bad size is one line."""
    density = AMBIENT - 0.3 * np.exp(-np.linspace(-2, 2, 9)[:, None, None] ** 2 * np.ones((9, 9, 9)))
    np.save(tmp_path / "flow.npy", density.astype(np.float32))
    command = [sys.executable, EXAMPLES / "bos.py", "--density", tmp_path / "flow.npy", "--spacing", "0.03", "-o", tmp_path]
    done = subprocess.run([*command, "--size", "96x72"], capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("dots moved by up to ")
    assert {path.name for path in tmp_path.iterdir()} == {"flow.npy", "bos.png", "bos_displacement.png", "bos_schlieren.png"}
    done = subprocess.run([*command, "--size", "100x72"], capture_output=True, text=True, timeout=120)
    assert done.returncode == 2 and done.stderr.splitlines()[-1].endswith("multiples of 32x24 are needed, such as 480x360")


def test_files_are_current(bos, tmp_path):
    """plume.npy and the patterns are what their programs write (to rounding)."""
    shipped = np.load(EXAMPLES / "fields" / "plume.npy")
    np.testing.assert_allclose(shipped, bos["plume_grid"]()[0], rtol=1e-6)
    made = runpy.run_path(str(EXAMPLES / "meshes" / "make_patterns.py"))
    for name, pattern in made["PATTERNS"].items():
        made["write_ply"](tmp_path / "fresh.ply", *pattern())
        old, new = (EXAMPLES / "meshes" / f"{name}.ply").read_bytes(), (tmp_path / "fresh.ply").read_bytes()
        start = old.index(b"end_header\n") + 11
        assert old[:start] == new[:start] and len(old) == len(new)
        count = 3 * len(pattern()[0])
        np.testing.assert_allclose(*(np.frombuffer(data, "<f4", count, start) for data in (old, new)), atol=1e-6)
        assert old[start + 4 * count :] == new[start + 4 * count :]


@pytest.mark.parametrize("program", ["room.py", "demo.py"])
def test_a_size_that_is_none_is_one_line(program):
    done = subprocess.run([sys.executable, EXAMPLES / program, "--size", "40"], capture_output=True, text=True, timeout=60)
    assert done.returncode == 2
    assert done.stderr.splitlines()[-1] == f"{program}: error: argument --size: '40' is not a size such as 400x300"
