"""A scene in the buffers of cl/kernels/world.h, built here from the definitions of cl/types, and its brute-force rays."""
from __future__ import annotations

import numpy as np
import pyopencl as cl
from photon_code import TRIANGLE

SPHERE = np.dtype([("center", "f8", 3), ("radius", "f8")])
FRAME = np.dtype([("low", "f8", 3), ("high", "f8", 3), ("box_low", "f8", 3), ("box_high", "f8", 3), ("center", "f8", 3),
                  ("reach", "f8"), ("bins", "i4"), ("middle", "i4"), ("bounded", "i4"), ("coarse", "i4"), ("nudge", "f8"),
                  ("media", "i4"), ("padding", "i4")])
TREE_FRAME = np.dtype([("center", "f8", 3), ("unit", "f8"), ("scale", "f8"), ("sagitta", "f8"), ("low", "f8", 3),
                       ("high", "f8", 3), ("triangles", "i4"), ("spheres", "i4"), ("padding", "i8")])
NODE = np.dtype([("box", "f4", (6, 8)), ("face", "f4", (12, 8)), ("child", "i4", 8), ("leaves", "u4"), ("unused", "u4", 7)])
MEDIUM = np.dtype([("kind", "i4"), ("interpolation", "i4"), ("size", "i4", 3), ("uniform", "i4"), ("origin", "f8", 3),
                   ("axis", "f8", 3), ("value", "f8"), ("feature", "f8"), ("kink", "f8"), ("jump", "f8"), ("low", "f8"),
                   ("high", "f8"), ("bucket", "f8"), ("heights", "i8"), ("guide", "i8"), ("records", "i8"), ("radius", "f8")])
PLACE = np.dtype([("way", "i4"), ("method", "i4"), ("also", "i4"), ("disperses", "i4"), ("is_sphere", "i4"), ("first", "i4"),
                  ("count", "i4"), ("padding", "i4"), ("low", "f8", 3), ("high", "f8", 3)])
SURFACE = np.dtype([("kind", "i4"), ("material", "i4"), ("medium", "i4"), ("has_normals", "i4")])
REGION = np.dtype([("media", "u2", 8), ("count", "u2")])
FLIGHT = np.dtype({"names": ["position", "direction", "region", "left", "bin", "exact", "crossing"],
                   "formats": [("f8", 3), ("f8", 3), REGION, "i4", "i4", "i4", "i4"],
                   "offsets": [0, 24, 48, 68, 72, 76, 80], "itemsize": 88})
ARRIVAL = np.dtype({"names": ["status", "method", "primitive", "t", "u", "v", "position", "direction", "n", "behind", "length",
                              "optical_path", "drift", "error", "evaluations", "steps", "rejected"],
                    "formats": ["i4", "i4", "i4", "f8", "f8", "f8", ("f8", 3), ("f8", 3), "f8", REGION] + ["f8"] * 7,
                    "offsets": [0, 4, 8, 16, 24, 32, 40, 64, 88, 96, 120, 128, 136, 144, 152, 160, 168], "itemsize": 176})
WALKER = np.dtype([("path", "u4"), ("bounce", "u2"), ("crossings", "u2"), ("specular", "u1"), ("direct", "u1"), ("padding", "u2")])
TALLY = np.dtype([("next", "u8"), ("end", "u8"), ("segments", "u8"), ("lost", "u8"), ("emitted", "u8"), ("evaluations", "f8"),
                  ("photons", "i4"), ("halves", "i4")])
assert (FRAME.itemsize, TREE_FRAME.itemsize, NODE.itemsize, MEDIUM.itemsize, PLACE.itemsize) == (160, 112, 640, 160, 80)
assert (WALKER.itemsize, TALLY.itemsize, REGION.itemsize) == (12, 56, 18)
HIT, LEFT = 1, 2
BLACK, DIFFUSE, MIRROR, DIELECTRIC, BOUNDS = range(5)
STRAIGHT, EXACT, INTEGRATED = range(3)
LINEAR_SQUARED = 1


def quads():
    """A room of side 2 without a lid: corner, two edges; normals inward."""
    return [((-1, -1, -1), (0, 0, 2), (2, 0, 0)), ((-1, -1, -1), (0, 2, 0), (0, 0, 2)), ((1, -1, -1), (0, 0, 2), (0, 2, 0)),
            ((-1, -1, -1), (2, 0, 0), (0, 2, 0)), ((-1, -1, 1), (0, 2, 0), (2, 0, 0))]


class World:
    """The room and a sphere; shapes: 0 to 4 its walls, 5 the sphere."""

    def __init__(self, n_squared=1.0, gradient=(0, 0, 0), way=STRAIGHT, method=1, bins=3, kinds=(DIFFUSE,) * 6, ball_medium=0,
                 center=(0.2, -0.4, 0.1), radius=0.3):
        corners = [(np.array(c, float), np.array(c, float) + a, np.array(c, float) + np.add(a, b)) for c, a, b in quads()]
        others = [(np.array(c, float), np.array(c, float) + np.add(a, b), np.array(c, float) + b) for c, a, b in quads()]
        self.corners = np.array([t for pair in zip(corners, others, strict=True) for t in pair])
        self.n_squared, self.gradient, self.bins = n_squared, np.array(gradient, float), bins
        t = self.triangles = np.zeros(len(self.corners), TRIANGLE)
        t["corner"], t["edge1"] = self.corners[:, 0], self.corners[:, 1] - self.corners[:, 0]
        t["edge2"] = self.corners[:, 2] - self.corners[:, 0]
        t["normal"] = np.cross(t["edge1"], t["edge2"])
        t["normal_length"] = np.linalg.norm(t["normal"], axis=1)
        t["inverse_area2"] = 1.0 / t["normal_length"]**2
        t["tolerance"], t["near_edge"] = 1e-12, 1e-6
        self.sphere = np.zeros(1, SPHERE)
        self.sphere["center"], self.sphere["radius"] = center, radius
        f = self.frame = np.zeros(1, FRAME)
        f["low"], f["high"], f["box_low"], f["box_high"] = -4.0, 4.0, -1.0, 1.0
        f["reach"], f["bins"], f["middle"], f["bounded"], f["nudge"] = np.sqrt(12.0), bins, bins // 2, 1, 1e-9
        f["media"] = 2 if ball_medium else 1
        tree = self.tree_frame = np.zeros(1, TREE_FRAME)
        tree["unit"], tree["scale"], tree["sagitta"], tree["low"], tree["high"] = 1.0, 1.0, 0.05, -1.0, 1.0
        tree["triangles"], tree["spheres"] = len(t), 1
        self.nodes = self.tree()
        m = self.media = np.zeros(2, MEDIUM)
        m["kind"][0] = LINEAR_SQUARED if way != STRAIGHT else 0
        m["uniform"], m["value"][0], m["axis"][0] = [way == STRAIGHT, 1], n_squared - 1.0, self.gradient
        m["feature"] = np.inf
        p = self.places = np.zeros(2, PLACE)
        p["way"], p["method"] = [way, STRAIGHT], [method, 1]
        p["is_sphere"][1], p["first"][1], p["count"][1] = 1, 0, 1
        p["low"][1], p["high"][1] = np.array(center) - radius, np.array(center) + radius
        self.index = np.array([[np.sqrt(n_squared)] * bins, [1.5] * bins])
        self.scale = np.ones((2, bins))
        s = self.surfaces = np.zeros(6, SURFACE)
        s["kind"], s["material"] = kinds, [-1 if k == BOUNDS else 0 for k in kinds]
        s["medium"][5] = ball_medium
        self.triangle_shape, self.sphere_shape = np.repeat(np.arange(5), 2).astype(np.int32), np.array([5], np.int32)

    def tree(self):
        """A root over two nodes of leaves."""
        nodes = np.zeros(3, NODE)
        nodes["box"][:, :3], nodes["box"][:, 3:] = 1e30, -1e30
        numbers = [list(range(8)), list(range(8, len(self.triangles) + 1))]
        for at, group in enumerate(numbers, start=1):
            for slot, number in enumerate(group):
                if number < len(self.triangles):
                    low, high = self.corners[number].min(0), self.corners[number].max(0)
                    t = self.triangles[number]
                    slopes = (t["normal"] / t["normal_length"], np.cross(t["edge2"], t["normal"]) * t["inverse_area2"],
                              np.cross(t["normal"], t["edge1"]) * t["inverse_area2"])
                    nodes["face"][at, :, slot] = np.concatenate([[*s, -s @ t["corner"]] for s in slopes])
                else:
                    c, r = self.sphere["center"][0], self.sphere["radius"][0]
                    low, high = c - r, c + r
                nodes["box"][at, :3, slot], nodes["box"][at, 3:, slot] = low, high
                nodes["child"][at, slot] = ~number
                nodes["leaves"][at] |= 1 << slot
            nodes["box"][0, :3, at - 1] = nodes["box"][at, :3, :len(group)].min(1)
            nodes["box"][0, 3:, at - 1] = nodes["box"][at, 3:, :len(group)].max(1)
            nodes["child"][0, at - 1] = at
        return nodes

    def buffers(self, context):
        parts = [self.frame, self.tree_frame, self.nodes, self.triangles, self.sphere, self.media, np.zeros(1), np.zeros(2, np.int64),
                 self.places, self.scale, self.index, self.triangle_shape, self.sphere_shape, self.surfaces, np.zeros(1, np.float32)]
        flags = cl.mem_flags.READ_ONLY | cl.mem_flags.COPY_HOST_PTR
        return [cl.Buffer(context, flags, hostbuf=np.ascontiguousarray(p)) for p in parts]

    def first_hit(self, r, p, leaving=-1):
        """Brute force: the least sigma > 0 at which r + p s + g s^2/2 is on a triangle or the sphere: (sigma, primitive)."""
        half = 0.25 * self.gradient  # g/2, g = grad n^2/2
        best = (np.inf, -1)
        for i, (a, b, c) in enumerate(self.corners):
            normal = np.cross(b - a, c - a)
            for s in real_roots([half @ normal, p @ normal, (r - a) @ normal], 1e-9 if i == leaving else 0.0):
                q = r + s * p + s * s * half
                inside = [np.cross(y - x, q - x) @ normal for x, y in ((a, b), (b, c), (c, a))]
                if min(inside) >= 0.0 and s < best[0]:
                    best = (s, i)
        d, radius = r - self.sphere["center"][0], self.sphere["radius"][0]
        quartic = [half @ half, 2 * half @ p, p @ p + 2 * half @ d, 2 * d @ p, d @ d - radius**2]
        for s in real_roots(quartic, 0.0):
            if s < best[0]:
                best = (s, len(self.corners))
        return best

    def at(self, r, p, s):
        """Position, unit direction and n at sigma."""
        q = p + 0.5 * s * self.gradient
        return r + s * p + 0.25 * s * s * self.gradient, q / np.linalg.norm(q), np.linalg.norm(q)


def real_roots(coefficients, above):
    coefficients = np.trim_zeros(np.array(coefficients, float), "f")
    roots = np.roots(coefficients) if len(coefficients) > 1 else np.array([])
    real = roots.real[np.abs(roots.imag) < 1e-9 * (1 + np.abs(roots.real))]
    return np.sort(real[real > above])


def flights(positions, directions, bins=None):
    f = np.zeros(len(positions), FLIGHT)
    f["position"], f["direction"] = positions, directions / np.linalg.norm(directions, axis=1)[:, None]
    f["region"]["count"], f["left"], f["bin"] = 1, -1, -1 if bins is None else bins
    return f


def follow(context, kernel, world, given, items, *more):
    """The flights' arrivals, in `items` segments."""
    queue, flags = cl.CommandQueue(context), cl.mem_flags
    share = -(-len(given) // items)
    padded = np.zeros(items * share, FLIGHT)
    padded["region"]["count"] = 1
    padded[:len(given)] = given
    counts = np.array([min(share, max(len(given) - i * share, 0)) for i in range(items)], np.int32)
    out = np.zeros(items * share, ARRIVAL)
    source = [cl.Buffer(context, flags.READ_WRITE | flags.COPY_HOST_PTR, hostbuf=x) for x in (padded, out, counts)]
    kernel(queue, (items,), (1,), *world.buffers(context), *source, np.int32(share), *more)
    cl.enqueue_copy(queue, out, source[1])
    queue.finish()
    return out[:len(given)]
