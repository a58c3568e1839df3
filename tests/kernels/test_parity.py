"""One source, two compilers: every file of cl/ compiles on PoCL, and rays alone in a medium end with the same bits
in the C library and in the kernel (DESIGN section 5), for each medium, method, width and precision.

The C side goes through ctypes (native.py), so that these tests need a libcpm.so and no bindings.
"""
from __future__ import annotations

import os
from pathlib import Path

import native
import numpy as np
import pytest

os.environ.setdefault("PYOPENCL_NO_CACHE", "1")
import pyopencl as cl  # noqa: E402 - reads the environment

ROOT = Path(__file__).resolve().parents[2]
LIBRARY = native.find_library()
FLAGS = "-cl-std=CL1.2 -cl-fp32-correctly-rounded-divide-sqrt -Werror"
START = np.dtype([("r", "f8", 3), ("d", "f8", 3), ("scale", "f8"), ("length", "f8"), ("max_step", "f8")])
END = np.dtype([("r", "f8", 3), ("p", "f8", 3), ("length", "f8"), ("optical_path", "f8"), ("drift", "f8"), ("error", "f8"),
                ("evaluations", "f8"), ("steps", "f8"), ("rejected", "f8"), ("status", "i4"), ("reserved", "i4")])
CONTROL = np.dtype([("method", "i4"), ("order", "i4"), ("dense", "i4"), ("reserved", "i4"), ("rtol", "f8"), ("atol", "f8"),
                    ("step", "f8"), ("max_step", "f8"), ("max_evaluations", "f8"), ("derived", "f8", 5)])
GOAL = np.dtype([("length", "f8"), ("point", "f8", 3), ("normal", "f8", 3), ("max_evaluations", "f8")])


@pytest.fixture(scope="session")
def context():
    platforms = cl.get_platforms()
    assert platforms, "no OpenCL platform: install PoCL (packages-debian.txt); a dialect that nobody compiles rots"
    return cl.Context([platforms[0].get_devices()[0]])


@pytest.fixture(scope="session")
def library():
    assert LIBRARY is not None, "no libcpm.so: build it, or set CPM_LIBRARY"
    return native.Library(LIBRARY)


def build(context, source, **values):
    flags = [*FLAGS.split(), f"-I{ROOT / 'cl'}", *(f"-D{k}={v}" for k, v in values.items())]
    return cl.Program(context, source).build(flags)


# ------------------------------------------------------------------------------------------------------ compiles alone

SHARED = sorted(p.relative_to(ROOT / "cl").as_posix() for d in ("types", "shared") for p in (ROOT / "cl" / d).glob("*.h")
                if not p.name.endswith("_body.h"))
KERNELS = sorted(p.relative_to(ROOT / "cl").as_posix() for p in (ROOT / "cl" / "kernels").glob("*.cl"))


@pytest.mark.parametrize("name", SHARED)
@pytest.mark.parametrize(("width", "single"), [(1, 0), (8, 0), (8, 1)])
def test_header_compiles_alone(context, name, width, single):
    """Each header of cl/ includes what it needs, in OpenCL C as in C."""
    build(context, f'#include "{name}"\n__kernel void nothing(__global int *x) {{ x[0] = 1; }}\n', CPM_WIDTH=width, CPM_SINGLE=single)


@pytest.mark.parametrize("name", KERNELS)
@pytest.mark.parametrize("values", [{}, {"CPM_WIDTH": 4}, {"CPM_WIDTH": 8, "CPM_SINGLE": 1}] +
                         [{"CPM_WIDTH": 8, "CPM_MEDIA": 1 << kind} for kind in range(13)], ids=str)
def test_kernel_compiles(context, name, values):
    """Each kernel file, for every medium compiled in alone and for all together."""
    build(context, (ROOT / "cl" / name).read_text(), **values)


# ----------------------------------------------------------------------------------------------------------- same bits

def heights_and_n():
    h = np.concatenate([np.linspace(-3, -0.5, 6), np.linspace(-0.4, 0.4, 33), np.linspace(0.6, 3, 5)])
    return h, 1.25 + 0.1 * np.tanh(2 * h) + 0.01 * np.sin(5 * h)


def samples():
    x, y, z = np.meshgrid(np.linspace(-1, 1, 9), np.linspace(-1, 1, 11), np.linspace(-1, 1, 8), indexing="ij")
    return 1.2 + 0.2 * np.exp(-(x * x + 1.5 * y * y + z * z + 0.3 * x * y))


def every_operation(weight=0.01):
    """A program that runs each operation once; N = 0.3 + 0.1 x + weight times their sum, the gradient that of 0.1 x."""
    lines = [(6, 5, 0, 0, 0, 0.2, 0), (7, 6, 1, 0, 0, 0.1, 1.5), (1, 7, 0, 0, 0, 0.75, 0), (7, 8, 2, 0, 0, 0.2, 0.1)]  # -0.8..0.8, 1.1..1.9
    two = [(2, 5, 6), (3, 5, 6), (4, 5, 8), (5, 5, 6), (28, 5, 8), (33, 5, 8), (34, 5, 8), (36, 5, 8), (37, 6, 8)]
    lines += [(op, 10 + i, a, b, 0, 0, 0) for i, (op, a, b) in enumerate(two)]
    lines += [(8, 19, 5, 8, 7, 0, 0), (9, 20, 6, 0, 0, 0.5, 0)]
    one = {20: 6, 21: 5, 22: 6, 23: 5, 24: 8, 25: 5, 26: 5, 27: 5, 29: 5, 30: 6, 31: 8, 32: 5, 35: 8}
    lines += [(op, 21 + i, a, 0, 0, 0, 0) for i, (op, a) in enumerate(one.items())]
    last = 20 + len(one)
    lines += [(2, 10, 10, i, 0, 0, 0) for i in range(11, last + 1)] + [(2, 10, 10, 3, 0, 0, 0), (7, 9, 10, 0, 0, weight, 0.3)]
    return lines + [(6, 11, 0, 0, 0, 0.1, 0), (2, 9, 9, 11, 0, 0, 0), (1, 12, 0, 0, 0, 0.1, 0), (6, 13, 10, 0, 0, weight, 0),
                    (2, 12, 12, 13, 0, 0, 0)], (9, 12, 13, 13)


def mixed(library):
    """A sum of what has tables, kinks and a formula."""
    return library.sum(library.layered(*heights_and_n(), 1, up=(0.1, 1, 0.2), radius=3.5), library.expression(*every_operation(1e-10)),
                       library.layered(*heights_and_n(), 2, up=(0.1, 1, 0.2)), library.grid(samples(), (-1, -1, -1), SPACING, 0),
                       library.linear(1.1, (0.03, -0.1, 0.02)))


SPACING = (2 / 8, 2 / 10, 2 / 7)
MEDIA = {
    "homogeneous": lambda L: L.homogeneous(1.33),
    "linear-squared": lambda L: L.linear_squared(1.69, (0.03, -0.1, 0.02), (0.1, 0.2, -0.3)),
    "linear": lambda L: L.linear(1.3, (0.03, -0.1, 0.02), (0.1, 0.2, -0.3)),
    "layered-cubic": lambda L: L.layered(*heights_and_n(), 1, up=(0.1, 1, 0.2)),
    "layered-linear-squared": lambda L: L.layered(*heights_and_n(), 2, up=(0.1, 1, 0.2)),
    "layered-step": lambda L: L.layered(*heights_and_n(), 3, up=(0.1, 1, 0.2)),
    "shells-cubic": lambda L: L.layered(*heights_and_n(), 1, up=(0.1, 1, 0.2), origin=(0.3, 0, 0.1), radius=3.5),
    "shells-linear-squared": lambda L: L.layered(*heights_and_n(), 2, up=(0.1, 1, 0.2), radius=3.5),
    "shells-step": lambda L: L.layered(*heights_and_n(), 3, up=(0.1, 1, 0.2), radius=3.5),
    "expression": lambda L: L.expression(*every_operation(1e-10)),
    "sum": mixed,
    "grid-linear": lambda L: L.grid(samples(), (-1, -1, -1), SPACING, 0),
    "grid-cubic": lambda L: L.grid(samples(), (-1, -1, -1), SPACING, 1),
    "parabolic": lambda L: L.parabolic(1.5, 0.15, (0.2, 1, 0.3), (0.1, 0.2, -0.3)),
    "luneburg": lambda L: L.luneburg(0.9, (0.1, 0.2, -0.3)),
    "fisheye": lambda L: L.fisheye(1.8, 1.2, (0.1, 0.2, -0.3)),
    "eaton": lambda L: L.eaton(0.9, (0.1, 0.2, -0.3)),
    "sources": lambda L: L.sources([(2, 2, 2), (-2, 2.5, 1), (0, -3, 0)], (0.3, 0.2, -0.1), (2, 1.7, 1),
                                   [(0, 0, 0), (0.6, 0, 0.8), (0, 0, 0)]),
}
METHODS = {"exact": {}, "euler": {"rtol": 1e-2}, "rk4": {"step": 0.1, "rtol": 1e-6}, "dopri5": {"rtol": 1e-7}, "fixed": {"step": 0.2, "rtol": 1e-6},
           "nystrom6": {"rtol": 1e-3}, "nystrom8": {"rtol": 1e-8}, "nystrom-fixed": {"step": 0.3, "rtol": 1e-6},
           "adams": {"rtol": 1e-6}, "leapfrog": {"step": 0.1}, "yoshida6": {"step": 0.2}}
NAMES = {"fixed": "dopri5", "nystrom6": "nystrom", "nystrom8": "nystrom", "nystrom-fixed": "nystrom"}  # the method of a variant
EXACT = {"homogeneous", "linear-squared", "linear", "layered-linear-squared", "layered-step", "shells-linear-squared", "shells-step",
         "parabolic", "luneburg", "fisheye", "eaton"}
ONLY_EXACT = {"homogeneous", "layered-step", "shells-step"}
CASES = [(m, k) for m in MEDIA for k in METHODS if (k == "exact" and m in EXACT) or (k != "exact" and m not in ONLY_EXACT)]
# Rays that miss the plane run to the bound on evaluations: two integrated media are enough.
TO_A_PLANE = [(m, "exact") for m in sorted(EXACT)] + [("linear", "dopri5"), ("layered-cubic", "dopri5"),
                                                           ("linear", "nystrom6"), ("layered-cubic", "nystrom8"),
                                                           ("linear", "adams"), ("layered-cubic", "adams"), ("linear", "yoshida6")]
COUNT = 61


def rays():
    rng = np.random.default_rng(7)
    return rng.uniform(-1, 1, (COUNT, 3)), rng.normal(size=(COUNT, 3)), rng.uniform(0.5, 4, COUNT)


def on_device(context, program, medium, library, method, bundle, until=None, single=False, rtol=1e-6, step=0.0, path=0):
    """What the kernel gives for a bundle (origins, directions, lengths or None), and the samples of the paths."""
    data, table = library.inside(medium)
    o, d, lengths = bundle
    starts, control, goal = np.zeros(COUNT, START), np.zeros(1, CONTROL), np.zeros(1, GOAL)
    starts["r"], starts["scale"] = o, 1.0
    starts["d"] = d / np.sqrt(d[:, 0] * d[:, 0] + d[:, 1] * d[:, 1] + d[:, 2] * d[:, 2])[:, None]
    starts["length"] = -1.0 if lengths is None else lengths
    if until is not None:
        goal["point"], goal["normal"] = until
    control["method"], control["rtol"], control["step"] = native.METHODS[NAMES.get(method, method)], rtol, step
    control["max_step"], control["dense"] = 1e38 if single else 1e300, path > 0
    control["max_evaluations"] = goal["max_evaluations"] = 1e6
    queue, flags = cl.CommandQueue(context), cl.mem_flags
    ends, positions = np.zeros(COUNT, END), np.zeros((COUNT, max(path, 1), 3))
    buffers = [cl.Buffer(context, flags.READ_ONLY | flags.COPY_HOST_PTR, hostbuf=x) for x in (np.frombuffer(bytes(data), np.uint8), table, control, goal, starts)]
    out, samples_out = (cl.Buffer(context, flags.READ_WRITE | flags.COPY_HOST_PTR, hostbuf=x) for x in (ends, positions))
    share, kernel = 24, cl.Kernel(program, "cpm_trace")
    for count in (0, path) if path else (0,):  # the second time for the samples, whose spacing the first has found
        kernel(queue, (-(-COUNT // share),), None, *buffers, out, samples_out, np.int64(count), np.int64(COUNT), np.int64(share))
    cl.enqueue_copy(queue, ends, out)
    cl.enqueue_copy(queue, positions, samples_out)
    queue.finish()
    return ends, positions


@pytest.fixture(scope="session")
def programs(context):
    made = {}

    def get(width, single=0):
        key = width, single
        if key not in made:
            made[key] = build(context, (ROOT / "cl/kernels/trace.cl").read_text(), CPM_WIDTH=width, CPM_SINGLE=single)
        return made[key]

    return get


def same(device, host, exact):
    np.testing.assert_array_equal(device["r"], host.position)
    np.testing.assert_array_equal(device["p"], host.momentum)
    for name in ("length", "optical_path", "evaluations", "steps", "rejected", "status") + (() if exact else ("drift",)):
        np.testing.assert_array_equal(device[name], getattr(host, name), err_msg=name)


@pytest.mark.parametrize(("medium", "method"), CASES)
@pytest.mark.parametrize(("width", "single"), [(8, 0), (1, 0), (8, 1)])
def test_same_bits_by_length(request, context, programs, library, medium, method, width, single):
    """Position, momentum, lengths, counts and status, to the last bit, over an arc length of each ray's own."""
    if single and method == "nystrom8" and medium in ("luneburg", "fisheye"):
        request.node.add_marker(pytest.mark.xfail(strict=True, reason="6e-8 apart in float lanes: cause not found yet"))
    options = METHODS[method]
    m = MEDIA[medium](library)
    o, d, lengths = rays()
    device, _ = on_device(context, programs(width, single), m, library, method, (o, d, lengths), single=single, **options)
    host = library.trace(m, o, d, length=lengths, method=NAMES.get(method, method), single=single, **options)
    same(device, host, method == "exact")
    captured = host.status == 13
    assert np.all((host.status == 0) | captured)
    # some rays fall into sources; in lanes of float a few come too near Eaton's centre for their coordinates
    assert not captured.any() or medium == "sources" or (medium == "eaton" and method != "exact" and np.mean(captured) < 0.1)


@pytest.mark.parametrize(("medium", "method"), TO_A_PLANE)
def test_same_bits_to_a_plane(context, programs, library, medium, method):
    """The same to the first crossing of a plane, with samples of the paths; rays that never cross it end alike too."""
    options = METHODS[method]
    m = MEDIA[medium](library)
    o, d, _ = rays()
    d[:, 1] = np.where(o[:, 1] > 0, -1, 1) * (np.abs(d[:, 1]) + 0.5)
    plane = np.array([0.1, 0.05, 0.0]), np.array([0.0, 1.0, 0.0])
    device, positions = on_device(context, programs(8), m, library, method, (o, d, None), until=plane, path=5, **options)
    host = library.trace(m, o, d, until=plane, method=NAMES.get(method, method), path=5, **options)
    same(device, host, method == "exact")
    np.testing.assert_array_equal(positions, host.paths)
    assert np.mean(host.status == 0) > 0.5


@pytest.mark.parametrize("isa", ["baseline", "v3", "v4"])
@pytest.mark.parametrize("medium", ["linear", "layered-cubic", "grid-linear", "grid-cubic", "parabolic", "luneburg", "eaton", "sources",
                                    "shells-cubic", "expression", "sum"])
def test_instruction_sets_agree(library, medium, isa, tmp_path):
    """CPM_ISA=... in a process of its own, one thread: the bits of this process."""
    import subprocess
    import sys

    script = ("import sys, numpy as np; sys.path.insert(0, sys.argv[1]); import native, test_parity as t\n"
              "L = native.Library(native.find_library(), threads=1); o, d, l = t.rays()\n"
              "for single in (0, 1):\n"
              "    r = L.trace(t.MEDIA[sys.argv[2]](L), o, d, length=l, method='dopri5', rtol=1e-7, single=single)\n"
              "    np.save(sys.argv[3] + str(single), np.hstack([r.position, r.momentum, r.evaluations[:, None]]))")
    out = str(tmp_path / "out")
    subprocess.run([sys.executable, "-c", script, str(Path(__file__).parent), medium, out], check=True,
                   env={**os.environ, "CPM_ISA": isa, "CPM_LIBRARY": LIBRARY})
    o, d, lengths = rays()
    for single in (0, 1):
        r = library.trace(MEDIA[medium](library), o, d, length=lengths, method="dopri5", rtol=1e-7, single=single)
        np.testing.assert_array_equal(np.load(f"{out}{single}.npy"), np.hstack([r.position, r.momentum, r.evaluations[:, None]]))


FIELDS = {m: make for m, make in MEDIA.items() if not m.endswith("-step")} | {"operations": lambda L: L.expression(*every_operation(1.0))}


@pytest.mark.parametrize("medium", FIELDS)  # discrete layers have no field
@pytest.mark.parametrize("width", [1, 8])
def test_field_same_bits(context, programs, library, medium, width):
    """n at random points, inside and outside tables: kernel and cpm_medium_evaluate."""
    m = FIELDS[medium](library)
    data, table = library.inside(m)
    points = np.random.default_rng(3).uniform(-4, 4, (64, 3))
    packed, out = np.hstack([points, np.ones((64, 1))]), np.zeros((64, 4))
    queue, flags = cl.CommandQueue(context), cl.mem_flags
    buffers = [cl.Buffer(context, flags.READ_ONLY | flags.COPY_HOST_PTR, hostbuf=x) for x in (np.frombuffer(bytes(data), np.uint8), table, packed)]
    result = cl.Buffer(context, flags.WRITE_ONLY, out.nbytes)
    cl.Kernel(programs(width), "cpm_evaluate")(queue, (64 // width,), None, *buffers, result)
    cl.enqueue_copy(queue, out, result)
    queue.finish()
    n, gradient = library.evaluate(m, points)
    np.testing.assert_array_equal(out[:, 0], n)
    np.testing.assert_array_equal(out[:, 1:] / n[:, None], gradient)


# ---------------------------------------------------------------------------------------------------------- dispersion

DISPERSIONS = {"constant": [1.5], "cauchy": [1.5046, 0.0042, 1e-5], "sellmeier": [1.04, 0.006, 0.23, 0.02, 1.01, 103.6],
               "tabulated": [400.0, 1.5, 500.0, 1.48, 700.0, 1.46],
               "gas": [1e-5, 2e-6, -3e-7, 4e-8, 0.0579, 238.0, 0.00168, 57.4]}


@pytest.mark.parametrize("kind", DISPERSIONS)
def test_dispersion_has_the_same_bits(context, kind):
    """n(λ) of the shared formulas, on the device and in the library as a homogeneous medium's index."""
    cpm = pytest.importorskip("cpm")
    source = """#include "shared/dispersion.h"
        __kernel void index(int kind, int count, __global const double *c, __global const double *w, __global double *n) {
            n[get_global_id(0)] = cpm_dispersion_n(kind, count, c, w[get_global_id(0)]);
        }"""
    wavelengths, coefficients = np.linspace(400.0, 700.0, 301), np.array(DISPERSIONS[kind])
    queue, flags = cl.CommandQueue(context), cl.mem_flags
    inputs = [cl.Buffer(context, flags.READ_ONLY | flags.COPY_HOST_PTR, hostbuf=a) for a in (coefficients, wavelengths)]
    found = np.empty_like(wavelengths)
    out = cl.Buffer(context, flags.WRITE_ONLY, found.nbytes)
    number = 1 + list(DISPERSIONS).index(kind)
    build(context, source, CPM_WIDTH=1, CPM_SINGLE=0).index(queue, wavelengths.shape, None, np.int32(number),
                                                            np.int32(coefficients.size), *inputs, out)
    cl.enqueue_copy(queue, found, out)
    expected = cpm._core.Dispersion(kind, list(coefficients), 0.0, 0.0).n(wavelengths)
    # The library stores n − 1 and gives 1 + (n − 1) back.
    np.testing.assert_array_equal(1 + (found - 1), expected)
