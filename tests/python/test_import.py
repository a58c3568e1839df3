"""What ``import cpm`` brings in, and that names in Python and in the core are the same ones."""

import subprocess
import sys
from pathlib import Path

import pytest

import cpm
from cpm import _core

#: Heavy, and only needed by some: each takes longer to import than the whole package.
LATE = ("colour", "matplotlib", "trimesh", "sympy", "pydantic", "typer", "rich", "scipy", "pyopencl")


def modules_after(code):
    """Top-level modules that a fresh interpreter has after running ``code``."""
    script = f"{code}; import sys; print(*{{name.split('.')[0] for name in sys.modules}})"
    finished = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    return set(finished.stdout.split())


@pytest.mark.parametrize("code", ["import cpm", "import cpm, cpm.cli", "import cpm; cpm.Scene(1.5)"])
def test_heavy_packages_are_not_imported(code):
    assert not modules_after(code) & set(LATE)


def test_illuminants_import_colour_when_they_are_named():
    assert "colour" in modules_after("import cpm; cpm.spectra.as_spectrum('D65')")


def test_everything_that_is_offered_is_there():
    assert [name for name in cpm.__all__ if not hasattr(cpm, name)] == []


def test_the_package_is_typed():
    assert (Path(cpm.__file__).parent / "py.typed").is_file()


def test_ray_status_is_the_core_s():
    assert {status.name.lower(): status.value for status in cpm.RayStatus} == _core.RAY_STATUS


def test_error_is_one_class():
    assert cpm.Error is _core.Error
    assert cpm.Error.__module__ == "cpm"
    assert issubclass(cpm.Error, RuntimeError)


def test_devices_name_the_processor():
    native = cpm.devices()[0]
    assert native.backend == "native"
    assert native.usable
    assert native.units >= 1
    assert "embree" in native.detail
