"""The k nearest photons (cl/shared/map_search.h): the kernel run from pyopencl on a map that is built here in Python,
against NumPy that sorts all distances."""

from __future__ import annotations

import numpy as np
import pyopencl as cl
import pytest
from photon_code import PHOTON
from test_parity import ROOT, build, context  # noqa: F401 - a fixture

PAD, LEAF, WIDE, FACING = 16, 32, 8, 126
NODE = np.dtype(
    [
        ("low", "f4", (3, WIDE)),
        ("high", "f4", (3, WIDE)),
        ("first", "u4", WIDE),
        ("count", "u4", WIDE),
        ("facing_low", "i1", (WIDE, 3)),
        ("facing_high", "i1", (WIDE, 3)),
        ("padding", "u1", 16),
    ]
)
NUMBERS = np.dtype(
    [
        ("scale", "f8"),
        ("count", "u8"),
        ("unit", "f4"),
        ("extent", "f4"),
        ("top", "u4"),
        ("depth", "i4"),
        ("unsplit", "i4"),
        ("bins", "u4"),
    ]
)
ALL, SCALE = 65535, 1e-3
AXES = np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]], float)


@pytest.fixture(scope="session")
def program(context):  # noqa: F811
    return build(context, (ROOT / "cl/kernels/gather.cl").read_text()).cpm_gather


def octahedral(normals):
    """Codes of axes: exact."""
    u, v = np.zeros(len(normals), int), np.zeros(len(normals), int)
    for i, (x, y, z) in enumerate(normals):
        u[i], v[i] = round(32767 * x), round(32767 * y)
        if z < 0:
            u[i] = v[i] = 32767
    return ((u & 0xFFFF) | (v & 0xFFFF) << 16).astype(np.uint32)


class Map:
    """Photons in the form of cl/types/map.h: leaves of at most 32, or in one point, by halving the longest side."""

    def __init__(self, positions, normals, spectra, bins_of=None, path=None):
        self.position, self.normal, self.given = positions.astype(np.float32), normals, spectra
        count, bins = spectra.shape
        self.nodes, self.order, self.points = [], [], []
        exponent = np.frexp(np.abs(self.position).max())[1]
        self.unit = np.float32(2.0 ** -int(exponent))
        self.scaled = self.position * self.unit
        self.path = np.arange(count) if path is None else path
        top, depth = self.grow(np.arange(count))
        self.order = np.array(self.order)
        self.bin = np.full(count, ALL) if bins_of is None else bins_of
        records = np.zeros(count, PHOTON)
        records["position"], records["normal"] = self.position, octahedral(normals)
        records["path"], records["bin"] = self.path, self.bin
        records = records[self.order]
        halves, at = [], 0
        for row, i in enumerate(self.order):
            values = spectra[i] if self.bin[i] == ALL else spectra[i, self.bin[i] : self.bin[i] + 1]
            records["spectrum"][row] = at
            halves.append(values), (at := at + len(values))
        self.records = records
        self.halves = np.concatenate([*halves, np.zeros(PAD)]).astype(np.float16).view(np.uint16)
        self.points = np.concatenate([*self.points, np.zeros(PAD, np.float32)]).astype(np.float32)
        self.numbers = np.zeros(1, NUMBERS)
        extent = (self.scaled.max(0) - self.scaled.min(0)).max()
        self.numbers[0] = (SCALE, count, self.unit, extent, top, depth, bins_of is None, bins)
        self.nodes = np.array(self.nodes, NODE)

    def grow(self, chosen):
        """Node over these photons, children before parents: its number and depth."""
        parts = [chosen]
        while len(parts) < WIDE and max(map(len, parts)) > LEAF:
            largest = parts.pop(int(np.argmax([len(p) for p in parts])))
            box = self.position[largest]
            axis = np.argmax(box.max(0) - box.min(0))
            if box[:, axis].max() == box[:, axis].min():
                parts.append(largest)
                break
            order = largest[np.argsort(box[:, axis], kind="stable")]
            parts += [order[: len(order) // 2], order[len(order) // 2 :]]
        node, depth = np.zeros((), NODE), 1
        node["low"], node["high"] = np.inf, np.inf
        for i, part in enumerate(parts):
            part = part[np.argsort(self.path[part])]
            p = self.scaled[part]
            node["low"][:, i], node["high"][:, i] = p.min(0), p.max(0)
            node["facing_low"][i] = np.floor(self.normal[part].min(0) * FACING)
            node["facing_high"][i] = np.ceil(self.normal[part].max(0) * FACING)
            if len(part) <= LEAF or np.all(p == p[0]):
                node["first"][i], node["count"][i] = len(self.order), len(part)
                self.order.extend(part)
                self.points.extend([p[:, 0], p[:, 1], p[:, 2]])
            else:
                node["first"][i], below = self.grow(part)
                depth = max(depth, 1 + below)
        self.nodes.append(node)
        return len(self.nodes) - 1, depth

    def ask(self, context, kernel, points, normals, k, max_radius, k_th=0, share=7, room=None):  # noqa: F811
        count, bins, numbers = len(points), int(self.numbers["bins"][0]), self.numbers
        items = -(-count // share)
        capacity = room or 3 * min(k, len(self.records)) + 1024
        irradiance, radii, found = np.zeros((count, bins)), np.zeros(count), np.zeros(count, np.uint32)
        ids = np.zeros((count, k), np.uint32)
        queue = cl.CommandQueue(context)
        flags = cl.mem_flags

        def read(a):
            return cl.Buffer(context, flags.READ_ONLY | flags.COPY_HOST_PTR, hostbuf=np.ascontiguousarray(a))

        def both(a):
            return cl.Buffer(context, flags.READ_WRITE | flags.COPY_HOST_PTR, hostbuf=a)

        def scratch(n):
            return cl.Buffer(context, flags.READ_WRITE, int(n))

        out = [both(a) for a in (irradiance, radii, found, ids)]
        kernel(
            queue,
            (items,),
            (1,),
            *map(
                read,
                (
                    self.nodes,
                    self.points,
                    self.records,
                    self.halves,
                    numbers,
                    points.astype(np.float32),
                    normals.astype(np.float32),
                ),
            ),
            *out,
            scratch(4 * items * (capacity + PAD)),
            scratch(4 * items * (capacity + PAD)),
            scratch(8 * items * capacity),
            scratch(8 * items * (numbers["depth"][0] + 1)),
            scratch(8 * items * (bins + PAD)),
            np.uint64(capacity),
            np.float64(max_radius),
            np.uint32(k),
            np.int32(k_th),
            np.int32(1),
            np.int64(count),
            np.int64(share),
        )
        for array, buffer in zip((irradiance, radii, found, ids), out, strict=True):
            cl.enqueue_copy(queue, array, buffer)
        return irradiance, radii, [set(self.order[row[:n]]) for row, n in zip(ids, found, strict=True)]


def oracle(m, point, normal, k, max_radius):
    """All distances, sorted: in single precision as the map rounds them, ties by path; sums in double."""
    unit = m.unit
    d = m.position * unit - point.astype(np.float32) * unit
    d2 = ((d[:, 0] * d[:, 0] + d[:, 1] * d[:, 1]) + d[:, 2] * d[:, 2]).astype(np.float32)
    fits = (m.normal @ normal >= 0.5) & (d2 <= np.float32(min((max_radius * float(unit)) ** 2, 3e38)))
    near = np.flatnonzero(fits)
    near = near[np.lexsort((m.bin[near], m.path[near], d2[near]))]
    enough = len(near) >= k
    chosen = near[: k - 1] if enough else near
    r2 = float(d2[near[k - 1]]) / float(unit) ** 2 if enough else max_radius**2
    floor = 2.0**-24 * max(float(np.abs(point.astype(np.float32) * unit).max()), 2.0**-24) / float(unit)
    values = m.given.astype(np.float16).astype(float)
    total = np.zeros(values.shape[1])
    for i in chosen:
        if m.bin[i] == ALL:
            total += values[i]
        else:
            total[m.bin[i]] += values[i, m.bin[i]]
    return set(chosen), SCALE / (np.pi * max(r2, floor**2)) * total if len(chosen) else total, np.sqrt(r2)


def cloud(kind, count, bins, rng):
    p = rng.random((count, 3))
    normals = AXES[rng.integers(0, 6, count)]
    if kind == "walls":  # of a cube, facing inward
        face = rng.integers(0, 6, count)
        p[np.arange(count), face // 2] = face % 2 == 0
        normals = -AXES[face]
    if kind == "lattice":  # many equal distances
        p = rng.integers(0, 8, (count, 3)) / 8.0
    if kind == "point":  # more than a leaf of photons in one point
        p[: count // 2] = p[0]
    bins_of = rng.choice([ALL, *range(bins)], count) if kind == "split" else None
    return Map(p, normals, rng.uniform(0.1, 2, (count, bins)), bins_of, rng.permutation(count))


@pytest.mark.parametrize("kind", ["volume", "walls", "lattice", "point", "split"])
@pytest.mark.parametrize(
    ("k", "max_radius", "room"),
    [(20, np.inf, None), (150, 0.2, None), (2, np.inf, None), (700, 2.0, 760), (5000, 0.5, None)],
)
def test_nearest(context, program, kind, k, max_radius, room):  # noqa: F811
    """Ids; radii to the last bit; irradiance to rounding. A room of 760 has to cut lists."""
    rng = np.random.default_rng(7)
    m = cloud(kind, 3000, 5 if kind == "split" else 19, rng)
    points, normals = rng.random((60, 3)), AXES[rng.integers(0, 6, 60)]
    points[::3] = m.position[rng.integers(0, 3000, 20)]
    irradiance, _, found = m.ask(context, program, points, normals, k, max_radius, room=room)
    _, radii, _ = m.ask(context, program, points, normals, k, max_radius, k_th=1, share=60)
    for i in range(60):
        chosen, wanted, radius = oracle(m, points[i], normals[i], k, max_radius)
        assert found[i] == chosen, f"query {i}: {sorted(found[i] ^ chosen)}"
        assert radii[i] == radius
        np.testing.assert_allclose(irradiance[i], wanted, rtol=1e-14)


def test_nothing(context, program):  # noqa: F811
    """An empty radius, a point at infinity: nothing is added."""
    m = cloud("volume", 100, 3, np.random.default_rng(1))
    points, normals = np.array([[0.5, 0.5, 0.5], [3e38, 0, 0]]), AXES[:2]
    for radius in (0.0, -1.0, np.nan):
        irradiance, radii, found = m.ask(context, program, points, normals, 5, radius)
        assert not irradiance.any() and not radii.any() and not any(found)
