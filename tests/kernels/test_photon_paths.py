"""The photon pass's kernels (cl/kernels/start_*.cl, meet.cl, specular.cl): run from pyopencl on arrivals made here, against
NumPy written from the definitions."""
from __future__ import annotations

import numpy as np
import pyopencl as cl
import pytest
from device_world import (
    ARRIVAL,
    BLACK,
    DIELECTRIC,
    DIFFUSE,
    FLIGHT,
    HIT,
    LEFT,
    MIRROR,
    REGION,
    TALLY,
    WALKER,
    World,
    flights,
)
from oracles import photons
from photon_code import EMITTER, PHOTON
from test_parity import ROOT, build, context  # noqa: F401 - a fixture

BINS, SEED, ITEMS, SHARE, STAGE = 3, 0x0123456789ABCDEF, 3, 64, 256
EMITTED, GAIN, ABSORBED, ESCAPED, LOSS, VARIANCE = range(6)
REFLECTANCE = np.array([0.7, 0.35, 0.1], np.float32)


def program(context, name, **values):  # noqa: F811
    return build(context, (ROOT / f"cl/kernels/{name}.cl").read_text(), **values)


class Pass:
    """One side of the pass's buffers, filled; the other, empty; what comes back."""

    def __init__(self, context, share=SHARE):  # noqa: F811
        self.context, self.share = context, share
        self.queue = cl.CommandQueue(context)
        self.flights, self.walkers = np.zeros(ITEMS * share, FLIGHT), np.zeros(ITEMS * share, WALKER)
        self.powers = np.zeros((ITEMS * share, BINS), np.float32)
        self.counts, self.arrivals = np.zeros(ITEMS, np.int32), np.zeros(ITEMS * share, ARRIVAL)
        self.next = {"flights": np.zeros_like(self.flights), "walkers": np.zeros_like(self.walkers),
                     "powers": np.zeros_like(self.powers), "counts": np.zeros(ITEMS, np.int32), "tallies": np.zeros(ITEMS, TALLY),
                     "energies": np.zeros((ITEMS, 6, BINS))}
        self.photons, self.spectra = np.zeros(ITEMS * STAGE, PHOTON), np.zeros(ITEMS * STAGE * BINS, np.uint16)

    def buffer(self, array):
        flags = cl.mem_flags
        return cl.Buffer(self.context, flags.READ_WRITE | flags.COPY_HOST_PTR, hostbuf=np.ascontiguousarray(array))

    def open(self):
        self.to = [self.buffer(a) for a in self.next.values()]
        self.after = [*self.to, np.int32(self.share), np.int32(BINS)]
        self.now = [self.buffer(a) for a in (self.flights, self.walkers, self.powers, self.counts, self.arrivals)]
        steps = [1]
        for _ in range(BINS):
            steps.append(steps[-1] * 747796405 & 0xFFFFFFFF)
        add = [2891336453]
        for _ in range(BINS - 1):
            add.append((add[-1] * 747796405 + 2891336453) & 0xFFFFFFFF)
        shares = np.append(REFLECTANCE / REFLECTANCE.max(), np.float32(1))
        self.surfaces = [self.buffer(a) for a in (REFLECTANCE, shares, REFLECTANCE.max(keepdims=True), np.ones(1, np.float32),
                                                  np.array(steps[1:], np.uint32), np.array(add, np.uint32))]
        self.stage = [self.buffer(self.photons), self.buffer(self.spectra)]

    def close(self):
        for array, buffer in zip(self.next.values(), self.to, strict=True):
            cl.enqueue_copy(self.queue, array, buffer)
        cl.enqueue_copy(self.queue, self.photons, self.stage[0])
        cl.enqueue_copy(self.queue, self.spectra, self.stage[1])
        self.queue.finish()

    def went_on(self):
        """Flights, walkers and powers of all items' next segments."""
        rows = np.concatenate([np.arange(n) + i * self.share for i, n in enumerate(self.next["counts"])]).astype(int)
        return self.next["flights"][rows], self.next["walkers"][rows], self.next["powers"][rows]


def fill(p, world, kind, status=HIT, seed=4, bounce=2):
    """Arrivals on the floor (primitives 0, 1), from above; the number of them."""
    rng = np.random.default_rng(seed)
    total = 0
    world.surfaces["kind"][0] = kind
    for item in range(ITEMS):
        count = p.counts[item] = 20 + 7 * item
        rows = slice(item * p.share, item * p.share + count)
        start, at = rng.uniform(-0.8, 0.8, (count, 3)), rng.uniform(-0.8, 0.8, (count, 3))
        at[:, 1] = -1.0
        f = flights(start, at - start)
        p.flights[rows] = f
        p.walkers["path"][rows] = total + 1000 + np.arange(count)
        p.walkers["bounce"][rows], p.walkers["crossings"][rows], p.walkers["direct"][rows] = bounce, 1, bounce == 0
        p.powers[rows] = rng.uniform(0.5, 2.0, (count, BINS)).astype(np.float32)
        a = p.arrivals[rows]
        a["status"], a["position"], a["direction"], a["n"], a["u"], a["v"] = status, at, f["direction"], 1.0, 0.3, 0.3
        a["behind"]["count"] = 1
        p.arrivals[rows] = a
        total += count
    return total


def rows_of(p):
    return np.concatenate([np.arange(n) + i * p.share for i, n in enumerate(p.counts)]).astype(int)


def chances(p, rows):
    """The four uniform numbers of each path there."""
    block = p.walkers["bounce"][rows].astype(int) << 16 | p.walkers["crossings"][rows]
    key = (SEED & 0xFFFFFFFF, SEED >> 32)
    return np.array([photons.uniform(photons.philox((path, b, 1, 0), key)) for path, b in zip(p.walkers["path"][rows], block, strict=True)])


def run_meet(context, p, world, width=8):  # noqa: F811
    p.open()
    cl.Kernel(program(context, "meet", CPM_WIDTH=width), "cpm_meet")(
        p.queue, (ITEMS,), (1,), *world.buffers(context), *p.after, *p.now, *p.surfaces, *p.stage, np.int32(STAGE),
        np.int32(STAGE * BINS), np.uint64(SEED), np.float64(0.25), np.float64(0.0), np.float64(0.0))
    p.close()


@pytest.mark.parametrize("width", [1, 8])
def test_diffuse(context, width):  # noqa: F811
    """Stored before roulette; survivors leave by Malley's cosine about the floor's normal; the books balance."""
    world, p = World(bins=BINS), Pass(context)
    total = fill(p, world, DIFFUSE)
    run_meet(context, p, world, width)
    rows, tallies = rows_of(p), p.next["tallies"]
    u = chances(p, rows)
    alive = u[:, 2] < REFLECTANCE.max()
    assert list(tallies["segments"]) == list(p.counts) and list(tallies["photons"]) == list(p.counts)
    assert tallies["halves"].sum() == total * BINS and not tallies["lost"].any()

    went, walkers, powers = p.went_on()
    assert len(went) == alive.sum() and 0 < len(went) < total
    assert np.array_equal(walkers["path"], p.walkers["path"][rows][alive])
    assert np.all(walkers["bounce"] == 3) and not walkers["crossings"].any() and not walkers["direct"].any()
    cosine, turn = np.sqrt(1 - u[alive, 0]), u[alive, 1]
    wanted = photons.about(np.tile([0.0, 1.0, 0.0], (len(went), 1)), cosine, turn)
    np.testing.assert_allclose(went["direction"], wanted, atol=1e-12)
    np.testing.assert_allclose(went["position"], p.arrivals["position"][rows][alive], atol=1e-11)
    np.testing.assert_array_equal(powers, p.powers[rows][alive] * (REFLECTANCE / REFLECTANCE.max()))

    stored = np.concatenate([p.photons[i * STAGE:i * STAGE + n] for i, n in enumerate(tallies["photons"])])
    np.testing.assert_allclose(stored["position"], p.arrivals["position"][rows] - [0.25, 0, 0], atol=1e-7)
    np.testing.assert_allclose(photons.decode(stored["direction"]), p.arrivals["direction"][rows], atol=1e-4)
    assert np.all(stored["spectrum"] >> 30 == 1) and np.all(stored["bin"] == 65535) and np.all(stored["bounce"] == 2)
    halves = np.concatenate([p.spectra[i * STAGE * BINS:i * STAGE * BINS + n] for i, n in enumerate(tallies["halves"])])
    np.testing.assert_allclose(halves.view(np.float16).reshape(-1, BINS), p.powers[rows], rtol=1e-3)

    energy = p.next["energies"].sum(0)
    before, kept = p.powers[rows].astype(float), powers.astype(float).sum(0)
    np.testing.assert_allclose(energy[ABSORBED], (before * (1 - REFLECTANCE.astype(float))).sum(0), rtol=1e-12)
    np.testing.assert_allclose(energy[GAIN] - energy[LOSS], kept - (before * REFLECTANCE.astype(float)).sum(0), rtol=1e-9, atol=1e-9)


def test_black_absorbs_all(context):  # noqa: F811
    world, p = World(bins=BINS), Pass(context)
    fill(p, world, BLACK, bounce=0)
    run_meet(context, p, world)
    assert not p.next["counts"].any() and np.array_equal(p.next["tallies"]["photons"], p.counts)
    assert not np.any(p.photons["spectrum"][:p.counts[0]] >> 30)  # direct light
    np.testing.assert_allclose(p.next["energies"].sum(0)[ABSORBED], p.powers[rows_of(p)].astype(float).sum(0), rtol=1e-12)


@pytest.mark.parametrize(("status", "lost"), [(LEFT, 0), (10, 1)])
def test_what_meets_nothing_escapes(context, status, lost):  # noqa: F811
    world, p = World(bins=BINS), Pass(context)
    total = fill(p, world, DIFFUSE, status)
    run_meet(context, p, world)
    assert not p.next["counts"].any() and not p.next["tallies"]["photons"].any()
    assert p.next["tallies"]["lost"].sum() == lost * total
    np.testing.assert_allclose(p.next["energies"].sum(0)[ESCAPED], p.powers[rows_of(p)].astype(float).sum(0), rtol=1e-12)


def run_specular(context, p, world):  # noqa: F811
    p.open()
    cl.Kernel(program(context, "specular", CPM_WIDTH=1, CPM_MEDIA=1), "cpm_specular")(
        p.queue, (ITEMS,), (1,), *world.buffers(context), *p.after, *p.now, *p.surfaces, np.uint64(SEED))
    p.close()


def test_mirrors(context):  # noqa: F811
    world, p = World(bins=BINS), Pass(context)
    fill(p, world, MIRROR, bounce=0)
    run_specular(context, p, world)
    rows = rows_of(p)
    alive = chances(p, rows)[:, 2] < REFLECTANCE.max()
    went, walkers, _ = p.went_on()
    assert np.array_equal(walkers["path"], p.walkers["path"][rows][alive]) and np.all(walkers["specular"] == 1)
    np.testing.assert_allclose(went["direction"], p.arrivals["direction"][rows][alive] * [1, -1, 1], atol=1e-12)


def test_snell_and_fresnel(context):  # noqa: F811
    """From n = 1 into 1.5 across the floor: reflected where the random number is below Fresnel's reflectance, else refracted."""
    world, p = World(bins=BINS, ball_medium=1), Pass(context)
    total = fill(p, world, DIELECTRIC, bounce=0)
    p.arrivals["behind"]["count"], p.arrivals["behind"]["media"][:, 1] = 2, 1
    run_specular(context, p, world)
    rows = rows_of(p)
    came = p.arrivals["direction"][rows]
    cosine = -came[:, 1]
    reflected = chances(p, rows)[:, 3] < photons.fresnel(cosine, 1.0, 1.5)
    went, walkers, powers = p.went_on()
    assert len(went) == total and 0 < reflected.sum() < total
    wanted = came * [1, -1, 1]
    sine = came[~reflected][:, [0, 2]] / 1.5
    wanted[~reflected] = np.stack([sine[:, 0], -np.sqrt(1 - (sine**2).sum(1)), sine[:, 1]], 1)
    np.testing.assert_allclose(went["direction"], wanted, atol=1e-12)
    assert np.array_equal(went["region"]["count"], np.where(reflected, 1, 2))
    np.testing.assert_array_equal(powers, p.powers[rows])


@pytest.mark.parametrize("apart", [0, 1])
def test_paths_start_once(context, apart):  # noqa: F811
    """A point light's path numbers are shared out over the items and segments: each starts once, in one cone."""
    kernel = cl.Kernel(program(context, "start_delta", CPM_WIDTH=8), "cpm_start_delta")
    light, spectrum = np.zeros(1, EMITTER), np.array([1.0, 0.0, 3.0], np.float32)
    light["axis"], light["cutoff"], light["count"], light["position"] = [0, -1, 0], 0.2, 100, [0.1, 0.2, 0.3]
    region = np.zeros(1, REGION)
    region["count"] = 1
    seen, emitted, p = [], np.zeros(BINS), Pass(context, 32 * BINS)
    p.next["tallies"]["next"], p.next["tallies"]["end"] = [0, 50, 90], [50, 90, 130]
    for _ in range(8):  # the light has paths 20 to 119
        p.next["counts"][:] = 0
        p.open()
        tables = [p.buffer(x) for x in (light, np.zeros(1), np.zeros(1, np.int32), np.zeros(1, np.float32), spectrum, region)]
        p.next["tallies"]["next"] = np.maximum(p.next["tallies"]["next"], 20)
        p.to[4] = p.after[4] = p.buffer(p.next["tallies"])
        kernel(p.queue, (ITEMS,), (1,), *p.after, *tables, np.uint64(20), np.uint64(120), np.int32(16), np.int32(apart))
        p.close()
        went, walkers, powers = p.went_on()
        assert np.all(walkers["direct"] == 1) and not walkers["bounce"].any()
        np.testing.assert_array_equal(went["position"], np.tile(light["position"][0], (len(went), 1)))
        assert np.all(went["direction"][:, 1] <= -0.8 + 1e-12)
        np.testing.assert_allclose(np.linalg.norm(went["direction"], axis=1), 1.0, atol=1e-12)
        if apart:
            assert set(went["bin"]) <= {0, 2}  # bin 1 is dark
            np.testing.assert_array_equal(powers[:, 0], spectrum[went["bin"]])
        elif len(went):
            np.testing.assert_array_equal(powers, np.tile(spectrum, (len(went), 1)))
        assert p.next["counts"].max() <= (16 + 7) * (2 if apart else 1)
        seen += list(walkers["path"])
        emitted = p.next["energies"].sum(0)[EMITTED]
    assert sorted(seen) == sorted(list(range(20, 120)) * (2 if apart else 1))
    np.testing.assert_allclose(emitted, 100 * spectrum)
    assert p.next["tallies"]["emitted"].sum() == 100


def test_area_lights_start_on_their_triangles(context):  # noqa: F811
    """Points on the floor's two triangles, directions above it, power n^2 times the factor."""
    world, p = World(n_squared=2.25, bins=BINS), Pass(context)
    kernel = cl.Kernel(program(context, "start_area", CPM_WIDTH=8, CPM_MEDIA=1), "cpm_start_area")
    light, spectrum = np.zeros(1, EMITTER), np.array([1.0, 2.0, 3.0], np.float32)
    light["count"], light["triangles"] = 120, 2
    p.next["tallies"]["next"], p.next["tallies"]["end"] = [0, 40, 80], [40, 80, 120]
    p.open()
    tables = [p.buffer(x) for x in (light, np.array([0.0, 2.0, 4.0]), spectrum)]
    kernel(p.queue, (ITEMS,), (1,), *world.buffers(context), *p.after, *tables, np.uint64(0), np.uint64(120), np.int32(SHARE),
           np.float64(1 / 2.25))
    p.close()
    went, walkers, powers = p.went_on()
    assert sorted(walkers["path"]) == list(range(120))
    np.testing.assert_allclose(went["position"][:, 1], -1.0, atol=1e-15)
    assert np.all(np.abs(went["position"][:, [0, 2]]) <= 1.0) and np.all(went["direction"][:, 1] > 0)
    for i, (a, b, c) in enumerate(world.corners[:2]):
        on = went["left"] == i
        assert on.sum() == 60
        normal = np.cross(b - a, c - a)
        for x, y in ((a, b), (b, c), (c, a)):
            assert np.all(np.cross(y - x, went["position"][on] - x) @ normal >= -1e-12)
    np.testing.assert_allclose(powers, np.tile(spectrum, (120, 1)), rtol=1e-6)
    assert (went["direction"][:, 1]).mean() == pytest.approx(2 / 3, abs=0.02)  # cosine law
