"""The photon pass's native code for each instruction set, called directly, and the memory that it works on.

libcpm/photon/pass_lanes.c is compiled here as the library compiles it (CMakeLists.txt: the same flags), into a library
of its own, because the real one exports the public interface alone.
"""
from __future__ import annotations

import ctypes as ct
import subprocess
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
BLOCK = 16
FLAGS = ["-std=c11", "-O3", "-fPIC", "-shared", "-D_POSIX_C_SOURCE=200809L", "-Wno-psabi", "-ffp-contract=off",
         "-fno-math-errno", "-fno-trapping-math", f"-I{ROOT}", f"-I{ROOT / 'libcpm'}", f"-I{ROOT / 'libcpm/include'}"]
ISAS = {"baseline": [], "v3": ["-march=x86-64-v3"], "v4": ["-march=x86-64-v4", "-mprefer-vector-width=512"]}
NEEDS = {"baseline": set(), "v3": {"avx2", "fma", "bmi2"}, "v4": {"avx512f", "avx512dq", "avx512vl", "avx512bw", "avx512cd"}}

EMITTER = np.dtype([("position", "f8", 3), ("axis", "f8", 3), ("cutoff", "f8"), ("radius", "f8"), ("count", "f8"),
                    ("shift", "u4", 4), ("rows", "i4"), ("columns", "i4"), ("primitive", "i4"), ("triangles", "i4"),
                    ("low", "f8", 3), ("high", "f8", 3)])
TRIANGLE = np.dtype([("corner", "f8", 3), ("edge1", "f8", 3), ("edge2", "f8", 3), ("normal", "f8", 3),
                     ("inverse_area2", "f8"), ("tolerance", "f8"), ("near_edge", "f8"), ("normal_length", "f8")])
PHOTON = np.dtype([("position", "f4", 3), ("direction", "u4"), ("normal", "u4"), ("spectrum", "u4"), ("path", "u4"),
                   ("bin", "u2"), ("bounce", "u2")])
EMISSIONS = np.dtype([("position", "f8", (3, BLOCK)), ("normal", "f8", (3, BLOCK)), ("direction", "f8", (3, BLOCK)),
                      ("weight", "f8", BLOCK), ("primitive", "i4", BLOCK)])
MEETINGS = np.dtype([(name, "f8", (3, BLOCK)) for name in ("came", "start", "hit", "normal")] +
                    [("factor", "f8", BLOCK)] + [(name, "u4", BLOCK) for name in ("path", "block", "bin")] +
                    [("toward", "f8", (3, BLOCK)), ("from", "f8", (3, BLOCK)), ("chance", "f8", BLOCK),
                     ("direction_code", "u4", BLOCK), ("normal_code", "u4", BLOCK)])
POWERS = np.dtype([(name, "u8") for name in ("before", "reflectance", "share", "after", "spectrum")] +
                  [("dither", "u4"), ("first", "u4"), ("bins", "u4"), ("alive", "i4")])
FUNCTIONS = ("emit_delta", "emit_area", "meet", "power", "settle", "emit_far")


def supported():
    """Instruction sets of this machine."""
    info = Path("/proc/cpuinfo")
    words = set(info.read_text().split()) if info.exists() else set()
    return [isa for isa, needs in NEEDS.items() if needs <= words]


def address(array):
    return ct.c_void_p(array.ctypes.data)


class Code:
    """cpm_pass_code of one instruction set."""

    def __init__(self, isa, folder):
        path = folder / f"pass_lanes_{isa}.so"
        march = ISAS[isa] if isa != "baseline" or not supported()[1:] else ["-march=x86-64"]
        subprocess.run(["cc", *FLAGS, *march, f"-DCPM_ISA={isa}", "-o", path, ROOT / "libcpm/photon/pass_lanes.c", "-lm"],
                       check=True)
        self.library = ct.CDLL(str(path))
        table = (ct.c_void_p * len(FUNCTIONS)).in_dll(self.library, f"cpm_pass_code_{isa}")
        self.call = {name: ct.CFUNCTYPE(None)(pointer) for name, pointer in zip(FUNCTIONS, table, strict=True)}

    def __getattr__(self, name):
        return self.call[name]


def compile_surface(folder):
    """surface.c: single rays at mirrors and boundaries, as trace.c and cross.c have them."""
    path = folder / "surface.so"
    subprocess.run(["cc", *FLAGS, "-o", path, Path(__file__).with_name("surface.c"), "-lm"], check=True)
    return ct.CDLL(str(path))


def triangles_of(corners):
    """Records of triangles (N, 3, 3)."""
    made = np.zeros(len(corners), TRIANGLE)
    made["corner"], made["edge1"], made["edge2"] = corners[:, 0], corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    made["normal"] = np.cross(made["edge1"], made["edge2"])
    made["inverse_area2"] = 1 / np.sum(made["normal"]**2, axis=1)
    return made
