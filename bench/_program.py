"""Builds the C programs of bench/ from this checkout, as the library itself is built."""
import shutil
import subprocess
import sys

from _results import ROOT

BUILD = ROOT / "build" / "bench"


def program(name):
    """Path of a benchmark program, built where it is not current.

    Parameters
    ----------
    name : str
        The C file's: "gather", "embree".

    Returns
    -------
    Path
    """
    cmake = shutil.which("cmake")
    if cmake is None:
        sys.exit(f"bench {name}: cmake is not installed; it builds bench/{name}.c")
    generator = ["-G", "Ninja"] if shutil.which("ninja") else []
    if not (BUILD / "CMakeCache.txt").exists():
        _run([cmake, "-S", ROOT, "-B", BUILD, *generator, "-DCPM_BUILD_BENCH=ON"], name)
    _run([cmake, "--build", BUILD, "--target", f"bench_{name}", "--parallel"], name)
    return BUILD / "bench" / f"bench_{name}"


def _run(command, name):
    run = subprocess.run(command, capture_output=True, text=True, check=False)
    if run.returncode:
        sys.exit(f"bench {name}: its program cannot be built:\n{run.stdout[-4000:]}{run.stderr[-4000:]}")
