"""Surfaces (cl/shared/scatter.h, store.h, philox.h): the kernels run from pyopencl equal the native code of every
instruction set to the last bit, and both agree with NumPy written from the definitions."""
from __future__ import annotations

import ctypes as ct

import numpy as np
import photon_code
import pyopencl as cl
import pytest
from oracles import photons
from test_emit import codes  # noqa: F401 - a fixture
from test_parity import ROOT, build, context  # noqa: F401 - a fixture

COUNT, SEED, SCALE = 512, 0x0123456789ABCDEF, 2.5


@pytest.fixture(scope="session")
def surface(tmp_path_factory):
    return photon_code.compile_surface(tmp_path_factory.mktemp("surface"))


@pytest.fixture(scope="session", params=[1, 4, 8])
def program(request, context):  # noqa: F811
    return request.param, build(context, (ROOT / "cl/kernels/scatter.cl").read_text(), CPM_WIDTH=request.param)


def on_device(context, program, name, arguments, outputs, items=None):  # noqa: F811
    """Arrays are buffers, the rest scalars; the outputs come last."""
    width, built = program
    queue, flags = cl.CommandQueue(context), cl.mem_flags
    given = [cl.Buffer(context, flags.READ_ONLY | flags.COPY_HOST_PTR, hostbuf=np.ascontiguousarray(x))
             if isinstance(x, np.ndarray) else x for x in arguments]
    made = [cl.Buffer(context, flags.READ_WRITE | flags.COPY_HOST_PTR, hostbuf=x) for x in outputs]
    cl.Kernel(built, name)(queue, (items or COUNT // width,), None, *given, *made)
    for array, buffer in zip(outputs, made, strict=True):
        cl.enqueue_copy(queue, array, buffer)
    queue.finish()
    return outputs


def units(rng, count=COUNT):
    v = rng.normal(size=(count, 3))
    return v / np.linalg.norm(v, axis=1)[:, None]


def dot(a, b):
    return np.sum(a * b, axis=1)


def vectors(count=1):
    return [np.zeros((COUNT, 3)) for _ in range(count)]


# -------------------------------------------------------------------------------------------------------- random numbers

@pytest.mark.parametrize(("counter", "key", "wanted"), [
    ((0, 0, 0, 0), (0, 0), (0x6627E8D5, 0xE169C58D, 0xBC57AC4C, 0x9B00DBD8)),
    ((0xFFFFFFFF,) * 4, (0xFFFFFFFF,) * 2, (0x408F276D, 0x41C83B0E, 0xA20BC7C6, 0x6D5451FD)),
    ((0x243F6A88, 0x85A308D3, 0x13198A2E, 0x03707344), (0xA4093822, 0x299F31D0), (0xD16CFE09, 0x94FDCCEB, 0x5001E420, 0x24126EA1)),
])
def test_philox_reference(counter, key, wanted):
    """The oracle itself against the known answers that come with Random123."""
    assert tuple(photons.philox(counter, key)) == wanted


# ---------------------------------------------------------------------------------------------------------------- diffuse

def encounters():
    rng = np.random.default_rng(11)
    came, normal = units(rng), units(rng) * rng.uniform(0.1, 30, (COUNT, 1))
    came[:3], normal[:6:2] = [[0, 0, -1], [1, 0, 0], [0, -1, 0]], [[0, 0, 2], [0, -1, 0], [1e-3, 0, 0]]
    hit = rng.uniform(-2, 2, (COUNT, 3))
    start = hit - came * rng.choice([3e-13, 1.0], (COUNT, 1))  # some began a hair before
    return {"came": came, "start": start, "hit": hit, "normal": normal, "factor": 1 / dot(normal, normal),
            "path": rng.integers(0, 2**32, COUNT, dtype=np.uint32), "block": rng.integers(0, 2**32, COUNT, dtype=np.uint32),
            "bin": rng.integers(0, 257, COUNT, dtype=np.uint32)}


def native_meetings(code, given):
    parts = []
    for first in range(0, COUNT, photon_code.BLOCK):
        m = np.zeros(1, photon_code.MEETINGS)
        for name, values in given.items():
            m[name][0] = values[first:first + photon_code.BLOCK].T
        code.meet(ct.c_uint64(SEED), ct.c_double(SCALE), ct.c_size_t(photon_code.BLOCK), photon_code.address(m))
        parts.append(m[0])
    return {name: np.concatenate([part[name] for part in parts], axis=-1).T for name in photon_code.MEETINGS.names}


def test_diffuse(context, program, codes):  # noqa: F811
    given = encounters()
    outputs = [*vectors(2), np.zeros(COUNT), np.zeros(COUNT, np.uint32), np.zeros(COUNT, np.uint32)]
    names = ("toward", "from", "chance", "direction_code", "normal_code")
    on_device(context, program, "cpm_scatter_diffuse", [np.uint64(SEED), np.float64(SCALE), *given.values()], outputs)
    made = dict(zip(names, outputs, strict=True))
    for isa, code in codes.items():
        native = native_meetings(code, given)
        for name in names:
            np.testing.assert_array_equal(native[name], made[name], err_msg=f"{isa} {name}")
    came, normal = given["came"], given["normal"] * np.sqrt(given["factor"])[:, None]
    facing = np.where((dot(came, normal) > 0)[:, None], -normal, normal)
    key = (SEED & 0xFFFFFFFF, SEED >> 32)
    bits = np.array([photons.philox((p, b, 1, c), key) for p, b, c in zip(given["path"], given["block"], given["bin"], strict=True)])
    np.testing.assert_array_equal(made["chance"], photons.uniform(bits[:, 2]))
    wanted = photons.about(facing, np.sqrt(1 - photons.uniform(bits[:, 0])), photons.uniform(bits[:, 1]))
    np.testing.assert_allclose(made["toward"], wanted, rtol=0, atol=4e-14)
    size = SCALE + np.abs(given["hit"]).sum(1)
    back = np.minimum(1e-12 * size, 0.5 * np.linalg.norm(given["hit"] - given["start"], axis=1))
    np.testing.assert_allclose(made["from"], given["hit"] - back[:, None] * came, rtol=0, atol=5e-16)
    assert np.sum(back < 0.9e-12 * size) > 100
    for name, of in (("direction_code", came), ("normal_code", facing)):
        angle = np.linalg.norm(np.cross(photons.decode(made[name]), of), axis=1)
        assert np.all(angle < 6.5e-5) and np.all(dot(photons.decode(made[name]), of) > 0)
    assert np.all(photons.decode(made["direction_code"][:3]) == came[:3])  # axes are exact


# ----------------------------------------------------------------------------------------------------- mirrors, boundaries

def tilted(rng, geometric, most):
    """Normals that lean by up to `most` from the geometric ones."""
    v = geometric + most * units(rng)
    return v / np.linalg.norm(v, axis=1)[:, None]


def test_mirror(context, program, surface):  # noqa: F811
    rng = np.random.default_rng(13)
    came, geometric = units(rng), units(rng)
    shading = tilted(rng, geometric, 0.6)
    (toward,) = on_device(context, program, "cpm_scatter_mirror", [came, shading, geometric], vectors())
    (native,) = vectors()
    surface.mirror(ct.c_size_t(COUNT), *[photon_code.address(x) for x in (came, shading, geometric, native)])
    np.testing.assert_array_equal(native, toward)
    side = -np.sign(dot(came, geometric))[:, None] * geometric
    about = came - 2 * dot(came, shading)[:, None] * shading
    plain = came - 2 * dot(came, geometric)[:, None] * geometric
    through = dot(about, side) <= 0
    np.testing.assert_allclose(toward, np.where(through[:, None], plain, about), rtol=0, atol=2e-15)
    assert 10 < through.sum() < COUNT - 10 and np.all(dot(toward, side) > 0)


def test_boundary(context, program, surface):  # noqa: F811
    rng = np.random.default_rng(17)
    came, geometric = units(rng), units(rng)
    shading = tilted(rng, geometric, 0.3)
    shading[::2] = geometric[::2]
    n1, n2 = rng.uniform(1, 2.4, COUNT), rng.uniform(1, 2.4, COUNT)
    outputs = [np.zeros(COUNT), *vectors(2)]
    reflectance, reflected, refracted = on_device(context, program, "cpm_scatter_boundary", [came, shading, geometric, n1, n2], outputs)
    native = [np.zeros(COUNT), *vectors(2)]
    surface.boundary(ct.c_size_t(COUNT), *[photon_code.address(x) for x in (came, shading, geometric, n1, n2, *native)])
    for host, device in zip(native, outputs, strict=True):
        np.testing.assert_array_equal(host, device)
    side = np.sign(dot(came, geometric))[:, None]
    normal = np.where((dot(came, shading)[:, None] * side <= 0), geometric, shading)
    cosine = abs(dot(came, normal))
    wanted = photons.fresnel(cosine, n1, n2)
    np.testing.assert_allclose(reflectance, wanted, rtol=1e-9, atol=1e-12)
    assert np.all(dot(reflected, geometric) * side[:, 0] < 0)
    plain = came - 2 * dot(came, normal)[:, None] * normal
    kept = dot(plain, geometric) * side[:, 0] < 0
    np.testing.assert_allclose(reflected[kept], plain[kept], rtol=0, atol=2e-15)
    passes = reflectance < 1
    assert 50 < passes.sum() < COUNT - 50
    assert np.all(dot(refracted, geometric)[passes] * side[passes, 0] > 0)
    # Snell: n x sine is kept, in the plane of incidence
    before, after = (n[:, None] * np.cross(v, normal) for n, v in ((n1, came), (n2, refracted)))
    turned = passes & (np.linalg.norm(refracted - came, axis=1) > 0)
    np.testing.assert_allclose(after[turned], before[turned], rtol=0, atol=1e-14)


# ------------------------------------------------------------------------------------------------------ roulette, storing

BINS = 19  # whole vectors, and a rest


def bundles():
    rng = np.random.default_rng(23)
    powers = rng.uniform(0, 3, (COUNT, BINS)).astype(np.float32)
    powers[::7] *= np.float32(1e-6)  # halves below their normal range
    powers[::5, 3] = 0
    powers[1, :4] = [6e4, 7e4, 1e30, 2.0**-14]
    reflectance = rng.uniform(0.05, 0.9, (COUNT, BINS)).astype(np.float32)
    share = (reflectance / reflectance.max(1)[:, None]).astype(np.float32)
    alive = rng.integers(0, 2, COUNT, dtype=np.int32)
    bounce, path = rng.integers(0, 65536, COUNT, dtype=np.uint32), rng.integers(0, 2**32, COUNT, dtype=np.uint32)
    return powers, reflectance, share, alive, path, bounce


def native_settle(code, bundle, bins):
    """Powers after, the stored halves, and the energy rows (absorbed, gain, loss, variance)."""
    powers, reflectance, share, alive, path, bounce = bundle
    after, spectra, rows = np.zeros((COUNT, BINS), np.float32), np.zeros((COUNT, BINS), np.uint16), np.zeros((4, BINS))
    state, table = 0, np.zeros((2, 256), np.uint32)
    multiply = 1
    for i in range(256):
        multiply, state = multiply * 747796405 & 0xFFFFFFFF, (state * 747796405 + 2891336453) & 0xFFFFFFFF
        table[:, i] = multiply, state
    record = np.zeros(COUNT, photon_code.POWERS)
    for name, array in (("before", powers), ("reflectance", reflectance), ("share", share), ("after", after), ("spectrum", spectra)):
        record[name] = array.ctypes.data + np.arange(COUNT, dtype=np.uint64) * array.strides[0]
    record["bins"], record["alive"] = bins, alive
    record["dither"] = dither_start(path, bounce)
    pointers = (ct.c_void_p * 4)(*(rows[k].ctypes.data for k in range(4)))
    code.settle(photon_code.address(record), ct.c_size_t(COUNT), photon_code.address(table), pointers)
    return after[:, :bins], spectra[:, :bins], rows[:, :bins]


def dither_start(path, bounce):
    state = path * np.uint32(0x9E3779B9) ^ (bounce << np.uint32(16) ^ np.uint32(65535)) * np.uint32(0x85EBCA6B)
    state ^= state >> np.uint32(15)
    return state * np.uint32(0x2C1B3C6D)


def test_roulette_and_storing(context, program, codes):  # noqa: F811
    bundle = powers, reflectance, share, alive, path, bounce = bundles()
    each = np.repeat(alive, BINS)
    outputs = [np.zeros((COUNT, BINS), np.float32), np.zeros((COUNT, BINS)), np.zeros((COUNT, BINS))]
    after, kept, change = on_device(context, program, "cpm_scatter_roulette", [powers, reflectance, share, each], outputs, COUNT * BINS)
    rng = np.random.default_rng(29)
    at, code_a, code_b = rng.normal(size=(COUNT, 3)), *(rng.integers(0, 2**32, COUNT, dtype=np.uint32) for _ in range(2))
    every = np.full(COUNT, -1, np.int32)
    outputs = [np.zeros(COUNT, photon_code.PHOTON), np.zeros((COUNT, BINS), np.uint16)]
    record, spectra = on_device(context, program, "cpm_scatter_store", [at, code_a, code_b, path, bounce, every, powers, np.uint32(BINS)], outputs, COUNT)
    for isa, code in codes.items():
        for bins in (1, BINS):
            got_after, got_spectra, rows = native_settle(code, bundle, bins)
            np.testing.assert_array_equal(got_after, after[:, :bins], err_msg=isa)
            np.testing.assert_array_equal(got_spectra, spectra[:, :bins], err_msg=isa)
            sums = [(powers.astype(float) - kept), np.where(alive[:, None], change, 0), np.where(alive[:, None], 0, -change), change**2]
            for row, wanted in zip(rows, sums, strict=True):  # in the paths' order: to the last bit
                np.testing.assert_array_equal(row, np.add.accumulate(wanted[:, :bins], axis=0)[-1], err_msg=isa)
    # from the definitions
    np.testing.assert_array_equal(kept, powers.astype(float) * reflectance)
    np.testing.assert_allclose(after, np.where(alive[:, None], powers.astype(float) * reflectance / reflectance.max(1)[:, None], 0), rtol=3e-7)
    np.testing.assert_array_equal(change, after - kept)
    np.testing.assert_array_equal(record["position"], at.astype(np.float32))
    for name, wanted in (("direction", code_a), ("normal", code_b), ("path", path), ("bounce", bounce), ("bin", 65535),
                         ("spectrum", BINS * np.arange(COUNT))):
        np.testing.assert_array_equal(record[name], wanted, err_msg=name)
    half = spectra.view(np.float16).astype(float)
    beyond = powers >= 65520
    assert np.all(np.isinf(half[beyond]))
    fine = (powers >= 2.0**-14) & ~beyond
    assert np.all(abs(half - powers)[fine] <= 2.0**-10 * powers[fine])  # one of the two neighbours
    np.testing.assert_array_equal(half[~fine & ~beyond], powers[~fine & ~beyond].astype(np.float16))
    # the mean is kept: a rounding error is uniform over a step of 2^-10 at most, z within 5 (5.7e-7)
    relative = half[fine] / powers[fine] - 1
    assert abs(relative.mean()) < 5 * relative.std() / np.sqrt(relative.size)
