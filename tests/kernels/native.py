"""The C library through ctypes: for tests that must not wait for the bindings, or that need its internal functions.

Internal functions (medium.h's struct) are reached by layout, so this file follows libcpm/medium/medium.h.
"""
from __future__ import annotations

import ctypes as ct
import os
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
METHODS = {"auto": 0, "exact": 1, "euler": 2, "rk4": 3, "dopri5": 4}
F64P = ct.POINTER(ct.c_double)


def find_library() -> str | None:
    """CPM_LIBRARY, else the newest libcpm.so of a build directory."""
    if os.environ.get("CPM_LIBRARY"):
        return os.environ["CPM_LIBRARY"]
    found = [p for pattern in ("build*/libcpm.so*", "build*/*/libcpm.so*", "python/cpm/libcpm.so*", ".venv/lib/python*/site-packages/cpm/libcpm.so*")
             for p in ROOT.glob(pattern) if p.is_file()]
    return str(max(found, key=lambda p: p.stat().st_mtime)) if found else None


class Dispersion(ct.Structure):
    _fields_ = [("struct_size", ct.c_size_t), ("kind", ct.c_int32), ("count", ct.c_int32),
                ("coefficients", ct.c_double * 64), ("low", ct.c_double), ("high", ct.c_double)]


class LayeredDesc(ct.Structure):
    _fields_ = [("struct_size", ct.c_size_t), ("heights", F64P), ("n", F64P), ("count", ct.c_size_t),
                ("up", ct.c_double * 3), ("origin", ct.c_double * 3), ("interpolation", ct.c_int32), ("reserved", ct.c_int32),
                ("radius", ct.c_double)]


class GridDesc(ct.Structure):
    _fields_ = [("struct_size", ct.c_size_t), ("values", F64P), ("size", ct.c_size_t * 3), ("stride", ct.c_ssize_t * 3),
                ("origin", ct.c_double * 3), ("spacing", ct.c_double * 3), ("interpolation", ct.c_int32), ("reserved", ct.c_int32)]


class Instruction(ct.Structure):
    _fields_ = [("operation", ct.c_int32), ("target", ct.c_int32), ("a", ct.c_int32), ("b", ct.c_int32), ("c", ct.c_int32),
                ("reserved", ct.c_int32), ("k", ct.c_double), ("l", ct.c_double)]


class ExpressionDesc(ct.Structure):
    _fields_ = [("struct_size", ct.c_size_t), ("instructions", ct.POINTER(Instruction)), ("count", ct.c_size_t),
                ("results", ct.c_int32 * 4), ("feature", ct.c_double)]


class MediumData(ct.Structure):
    _fields_ = [("kind", ct.c_int32), ("interpolation", ct.c_int32), ("size", ct.c_int32 * 3), ("uniform", ct.c_int32),
                ("origin", ct.c_double * 3), ("axis", ct.c_double * 3), ("value", ct.c_double), ("feature", ct.c_double),
                ("kink", ct.c_double), ("jump", ct.c_double), ("low", ct.c_double), ("high", ct.c_double), ("bucket", ct.c_double),
                ("heights", ct.c_int64), ("guide", ct.c_int64), ("records", ct.c_int64),
                ("radius", ct.c_double)]


class MediumInside(ct.Structure):
    """libcpm/medium/medium.h: struct cpm_medium."""
    _fields_ = [("references", ct.c_int32), ("dispersive", ct.c_int32), ("data", MediumData), ("table", F64P),
                ("table_count", ct.c_size_t)]


class Request(ct.Structure):
    _fields_ = [("struct_size", ct.c_size_t), ("count", ct.c_size_t), ("origins", F64P), ("directions", F64P),
                ("wavelengths", F64P), ("wavelength_stride", ct.c_ssize_t), ("lengths", F64P), ("length_stride", ct.c_ssize_t),
                ("plane_point", F64P), ("plane_normal", F64P), ("method", ct.c_int32), ("exclude", ct.c_uint32),
                ("rtol", ct.c_double), ("atol", ct.c_double), ("step", ct.c_double), ("max_step", ct.c_double),
                ("max_evaluations", ct.c_int64), ("error_mode", ct.c_int32), ("single_precision", ct.c_int32),
                ("path_samples", ct.c_size_t)]


RESULTS = [("position", 3, np.float64), ("direction", 3, np.float64), ("momentum", 3, np.float64), ("length", 1, np.float64),
           ("optical_path", 1, np.float64), ("drift", 1, np.float64), ("error_estimate", 1, np.float64),
           ("evaluations", 1, np.int64), ("steps", 1, np.int64), ("rejected", 1, np.int64), ("error_evaluations", 1, np.int64),
           ("status", 1, np.int32), ("method", 1, np.int32), ("shape", 1, np.int32)]


class Result(ct.Structure):
    _fields_ = [("struct_size", ct.c_size_t)] + [(name, ct.c_void_p) for name, _, _ in RESULTS] + [("paths", ct.c_void_p)]


class Rays:
    """Arrays by name, as cpm.trace gives them."""


class Failure(ValueError):
    """A status other than CPM_OK, with the context's message."""


def pointer(array):
    return array.ctypes.data_as(F64P)


class Library:
    def __init__(self, path: str, threads: int = 0):
        self.lib = ct.CDLL(path)
        self.lib.cpm_context_last_error.restype = ct.c_char_p
        self.context = ct.c_void_p()
        options = (ct.c_int64 * 2)(16, threads)
        assert self.lib.cpm_context_create(options, ct.byref(self.context)) == 0

    def call(self, name, *arguments):
        if getattr(self.lib, name)(self.context, *arguments):
            raise Failure(self.lib.cpm_context_last_error(self.context).decode())

    def _made(self, name, *arguments):
        medium = ct.c_void_p()
        self.call(name, *arguments, ct.byref(medium))
        return medium

    @staticmethod
    def vector(v):
        return (ct.c_double * 3)(*v)

    def homogeneous(self, n):
        return self._made("cpm_medium_create_homogeneous", ct.c_double(n), None)

    def linear_squared(self, n_squared, gradient, origin=(0, 0, 0), dispersion=None):
        return self._made("cpm_medium_create_linear_squared", ct.c_double(n_squared), self.vector(gradient), self.vector(origin), dispersion)

    def linear(self, n, gradient, origin=(0, 0, 0), dispersion=None):
        return self._made("cpm_medium_create_linear", ct.c_double(n), self.vector(gradient), self.vector(origin), dispersion)

    def layered(self, heights, n, interpolation, up=(0, 1, 0), origin=(0, 0, 0), dispersion=None, radius=0.0):
        h, v = np.ascontiguousarray(heights, float), np.ascontiguousarray(n, float)
        desc = LayeredDesc(ct.sizeof(LayeredDesc), pointer(h), pointer(v), len(h), tuple(up), tuple(origin), interpolation, 0, radius)
        return self._made("cpm_medium_create_layered", ct.byref(desc), dispersion)

    def grid(self, values, origin, spacing, interpolation, dispersion=None):
        v = np.asarray(values, float)
        desc = GridDesc(ct.sizeof(GridDesc), v.ctypes.data_as(F64P), v.shape, v.strides, tuple(origin), tuple(spacing), interpolation, 0)
        return self._made("cpm_medium_create_grid", ct.byref(desc), dispersion)

    def expression(self, program, results, dispersion=None):
        """program: (operation, target, a, b, c, k, l) each."""
        code = (Instruction * len(program))(*(Instruction(*line[:5], 0, *line[5:]) for line in program))
        desc = ExpressionDesc(ct.sizeof(ExpressionDesc), code, len(program), tuple(results), 0.0)
        return self._made("cpm_medium_create_expression", ct.byref(desc), dispersion)

    def sum(self, *terms):
        return self._made("cpm_medium_create_sum", (ct.c_void_p * len(terms))(*terms), ct.c_size_t(len(terms)))

    @staticmethod
    def inside(medium):
        """The shared struct and the table (a copy) of a medium."""
        m = ct.cast(medium, ct.POINTER(MediumInside)).contents
        table = np.ctypeslib.as_array(m.table, (m.table_count,)).copy() if m.table_count else np.zeros(1)
        return m.data, table

    def evaluate(self, medium, points, wavelength=587.5618):
        points = np.ascontiguousarray(points, float).reshape(-1, 3)
        n, gradient = np.zeros(len(points)), np.zeros((len(points), 3))
        self.call("cpm_medium_evaluate", medium, pointer(points), ct.c_size_t(len(points)), ct.c_double(wavelength), pointer(n), pointer(gradient))
        return n, gradient

    def trace(self, medium, origins, directions, *, length=None, until=None, wavelength=550.0, method="auto", exclude=(), rtol=0.0, atol=0.0,
              step=0.0, max_step=0.0, max_evaluations=0, error="local", single=False, path=0):
        o = np.ascontiguousarray(origins, float).reshape(-1, 3)
        d = np.ascontiguousarray(np.broadcast_to(np.asarray(directions, float), o.shape))
        w = np.ascontiguousarray(np.atleast_1d(np.asarray(wavelength, float)))
        q = Request(ct.sizeof(Request), len(o), pointer(o), pointer(d), pointer(w), int(len(w) > 1))
        if length is not None:
            lengths = np.ascontiguousarray(np.atleast_1d(np.asarray(length, float)))
            q.lengths, q.length_stride = pointer(lengths), int(len(lengths) > 1)
        if until is not None:
            point, normal = (np.ascontiguousarray(x, float) for x in until)
            q.plane_point, q.plane_normal = pointer(point), pointer(normal)
        q.method, q.exclude = METHODS[method], sum(1 << METHODS[m] for m in exclude)
        q.rtol, q.atol, q.step, q.max_step, q.max_evaluations = rtol, atol, step, max_step, max_evaluations
        q.error_mode, q.single_precision, q.path_samples = int(error == "global"), int(single), path
        rays, result = Rays(), Result(ct.sizeof(Result))
        for name, width, kind in RESULTS:
            array = np.zeros((len(o), width) if width > 1 else len(o), kind)
            setattr(rays, name, array)
            setattr(result, name, array.ctypes.data)
        if path:
            rays.paths = np.zeros((len(o), path, 3))
            result.paths = rays.paths.ctypes.data
        self.call("cpm_rays_trace", medium, None, ct.byref(q), ct.byref(result))
        return rays
