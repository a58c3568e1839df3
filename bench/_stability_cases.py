"""The cases of `bench stability`: media, rays, what each is held against, and within which bound."""
import sys
from dataclasses import dataclass, field

import numpy as np
from _results import ROOT

sys.path.insert(0, str(ROOT / "tests"))
from oracles import closed_forms, fields, rays, shells, splines, tanh_step
from scipy.interpolate import CubicSpline

import cpm

RTOL = {"double": 1e-9, "single": 1e-6}
WAVELENGTH = 550.0
Status = cpm.RayStatus
EARTH, FAR = 6.4e6, 5e5  # m
ROAD = dict(N=2.77e-4, e=0.1, d=0.01)


@dataclass
class Case:
    """`run(precision)` gives (statuses, error, evaluations of the dearest ray, the library's own estimate or NaN)."""

    group: str
    name: str
    oracle: str
    run: object
    status: tuple = (Status.ARRIVED,)
    bounds: dict = field(default_factory=lambda: RTOL)  # of the error, by precision
    refused: bool = False  # a ValueError is what is wanted


def trace(precision, medium, origin, direction, **options):
    options.setdefault("rtol", RTOL[precision])
    return cpm.trace(medium, [origin], [direction], wavelength=WAVELENGTH, precision=precision, **options)


def outcome(found, error, estimate=np.nan):
    return sorted({Status(s).name for s in found.status}), float(error), int(found.evaluations.max()), float(estimate)


def end(medium, origin, direction, reference, **options):
    """A case's run: the end against that of `reference()`, a `Ray`, relative to its length."""
    known = []

    def run(precision):
        if not known:
            known.append(reference())
        found = trace(precision, medium, origin, direction, **options)
        judged = trace(precision, medium, origin, direction, error="global", **options)
        return outcome(
            found,
            np.linalg.norm(found.position[0] - known[0].position) / options["length"],
            judged.error_estimate[0] / options["length"],
        )

    return run


def slope(px, n=1.5):
    return px / n, np.sqrt(1 - (px / n) ** 2), 0.0


# --- layers ---


def tanh_medium(kind, width):
    if kind == "formula":
        return cpm.media.Expression("1.25 - 0.25*tanh(y/w)", w=width)
    heights = width * np.linspace(-20, 20, 3201)  # tanh to 3e-10
    return cpm.media.Layered(heights, 1.25 - 0.25 * np.tanh(heights / width), interpolation="cubic")


def tanh_case(kind, width, delta, length=2.0):
    ray = lambda: tanh_step.trace(width, 1.5, 1.0, delta, 0.5, length)  # noqa: E731
    return end(tanh_medium(kind, width), (0, -0.5, 0), slope(1.0 - delta), ray, length=length)


def from_afar(rtol):
    def run(precision):
        distance = np.random.default_rng(3).uniform(0.1, 10.0, 200)
        d = np.array([0.5, np.sqrt(0.75), 0.0])
        found = cpm.trace(
            tanh_medium("formula", 1e-9),
            np.outer(-distance, (0, 1, 0)),
            np.tile(d, (200, 1)),
            wavelength=WAVELENGTH,
            rtol=rtol,
            precision=precision,
            length=distance / d[1] + 1.0,
        )
        return outcome(found, np.max(np.abs(found.direction[:, 0] - 0.75)))

    return run


def layers():
    for kind in ("formula", "table"):
        for width in (1e-2, 1e-4, 1e-6, 1e-9):
            for degrees, what in ((30.0, "refracted"), (60.0, "totally reflected")):
                delta = 1.0 - 1.5 * np.sin(np.radians(degrees))
                yield Case(
                    "tanh step 1.5 → 1",
                    f"{kind}, width {width:.0e} m, {degrees:.0f}°, {what}",
                    "quadrature (Snell's angle)",
                    tanh_case(kind, width, delta),
                )
    for rtol in (1e-2, 1e-4):
        yield Case(
            "tanh step 1.5 → 1",
            f"formula, width 1e-09 m, 30°, 200 distances of 0.1 … 10 m, rtol {rtol:.0e}; worst sine",
            "Snell",
            from_afar(rtol),
            bounds=dict.fromkeys(RTOL, 10 * rtol),
        )
    for delta in (1e-3, 1e-6, 1e-9):
        for sign, what in ((1, "just through"), (-1, "just turned")):
            yield Case(
                "grazing",
                f"width 1 mm, p_x {'below' if sign > 0 else 'above'} n₂ by {delta:.0e}, {what}",
                "quadrature",
                tanh_case("formula", 1e-3, sign * delta, {1e-3: 2.0, 1e-6: 100.0, 1e-9: 2000.0}[delta]),
            )
    yield Case(
        "thermal layer",
        "1 cm of hot air over 1 km of road, turned 2.6 cm above it",
        "DOP853 at 1e-12",
        end(cpm.media.Expression("1 + N*(1 - e*exp(-y/d))", **ROAD), (0, 1, 0), (1, -2e-3, 0), road, length=1000.0),
    )


def road():
    big, drop, d = ROAD["N"], ROAD["e"], ROAD["d"]
    profile = lambda h: (1 + big * (1 - drop * np.exp(-h / d)), big * drop / d * np.exp(-h / d))  # noqa: E731
    return rays.trace(fields.OfHeight(profile, max_step=0.5), (0, 1, 0), (1, -2e-3, 0), length=1000.0)


# --- the Earth ---


def earth():
    heights = np.linspace(-100.0, 9.0e4, 1803)
    refractivity = 2.77e-4 * np.exp(-heights / 8000.0)
    spline = CubicSpline(heights, refractivity, bc_type="natural")
    held = shells.OfHeight(lambda h: (float(spline(h)), float(spline(h, 1))), EARTH, max_step=2000.0)
    reference = lambda: rays.trace(held, (0, 2, 0), (1, 0, 0), length=FAR)  # noqa: E731
    run = end(cpm.media.Layered(heights, 1 + refractivity, radius=EARTH), (0, 2, 0), (1, 0, 0), reference, length=FAR)
    yield Case(
        "Earth",
        "500 km grazing from 2 m above r = 6.4e6 m (1 mm; single 0.1 m)",
        "DOP853, heights in long double",
        run,
        bounds={"double": 1e-3 / FAR, "single": 0.1 / FAR},
    )


# --- long ---


def fibre(periods):
    def run(precision):
        n, omega, part = 1.5, 1.5, 0.13
        origin, direction = np.array([0.3, 0, 0]), np.array([0, 0.15, 1.0])
        p = n * np.sqrt(1 - 0.09) * direction / np.linalg.norm(direction)
        sigma = 2 * np.pi * (periods + part) / omega
        found = trace(
            precision,
            cpm.media.Parabolic(n, alpha=1.0),
            origin,
            direction,
            until=((0, 0, p[2] * sigma), (0, 0, 1)),
            method="yoshida6",
            step=2 * np.pi / omega / 160 * np.linalg.norm(p),
            max_evaluations=10**11,
        )
        energy = lambda r, q: 0.5 * (q[:2] @ q[:2] + omega**2 * (r[:2] @ r[:2]))  # noqa: E731
        r, q = found.position[0], found.momentum[0]
        phase = np.arctan2(-q[0], omega * r[0]) - 2 * np.pi * part
        print(f"          {periods:.0e} periods, {precision}: phase error {phase:.2e} rad")
        return outcome(found, abs(energy(r, q) / energy(origin, p) - 1))

    return run


# --- centres ---


def eaton(impact, method):
    """Back antiparallel, offset to the other side: error of direction and offset."""

    def run(precision):
        found = trace(precision, cpm.media.Eaton(1.0), (-3, impact, 0), (1, 0, 0), length=7.0, method=method)
        if found.status[0] == Status.CAPTURED:
            return outcome(found, np.linalg.norm(found.position[0]))
        return outcome(found, max(np.linalg.norm(found.direction[0] + (1, 0, 0)), abs(found.position[0, 1] + impact)))

    return run


def capture(medium, far, impact, n_far, length):
    """Bouguer's n r sin φ = b is kept, relative error; the wanted status is the oracle."""
    sine = impact / (n_far * far)

    def run(precision):
        found = trace(precision, medium, (-far, 0, 0), (np.sqrt(1 - sine**2), sine, 0), length=length)
        return outcome(found, abs(np.linalg.norm(np.cross(found.position[0], found.momentum[0])) / impact - 1))

    return run


def turn(medium, radius):
    def run(precision):
        found = trace(precision, medium, (radius, 0, 0), (0, 1, 0), length=2 * np.pi * radius)
        return outcome(found, np.linalg.norm(found.position[0] - (radius, 0, 0)) / found.length[0])

    return run


def centres():
    for impact in (1e-1, 1e-3, 1e-6):
        for method in ("auto", "dopri5"):
            yield Case(
                "Eaton lens",
                f"passed at {impact:.0e} R, {method}; direction and offset",
                "antiparallel, offset −b",
                eaton(impact, method),
            )
    yield Case(
        "Eaton lens",
        "straight at the centre, dopri5; distance from it",
        "the centre",
        eaton(0.0, "dopri5"),
        (Status.CAPTURED,),
        {"double": 1e-6, "single": 1e-3},
    )
    point = cpm.media.Sources([(0, 0, 0)], 1.0, 2)
    for excess in (-1e-3, -1e-6, 1e-6, 1e-3):
        inward = excess < 0
        yield Case(
            "gravity centre 1 + m/r²",
            f"impact 2√m (1 {excess:+.0e}); n r sin φ",
            "captured below 2√m; Bouguer",
            capture(point, 2000.0, 2 * (1 + excess), 1 + 1 / 2000.0**2, 3000.0),
            (Status.CAPTURED if inward else Status.ARRIVED,),
        )
    yield Case(
        "gravity centre 1 + m/r²",
        "unstable orbit r = √m, one turn (errors grow by e^2π)",
        "the circle",
        turn(point, 1.0),
        bounds={k: v * np.exp(2 * np.pi) for k, v in RTOL.items()},
    )
    hole = cpm.media.Expression("(1 + M/(2*r))**3/(1 - M/(2*r))", M=1.0)
    far = 200.0
    index = (1 + 0.5 / far) ** 3 / (1 - 0.5 / far)
    yield Case(
        "Schwarzschild, isotropic",
        "unstable orbit r = (1 + √3/2) M, one turn (e^2π)",
        "the circle",
        turn(hole, 1 + np.sqrt(3) / 2),
        bounds={k: v * np.exp(2 * np.pi) for k, v in RTOL.items()},
    )
    for excess in (1e-3, 1e-6):
        yield Case(
            "Schwarzschild, isotropic",
            f"impact 3√3 M (1 {excess:+.0e}), escapes; n r sin φ",
            "Bouguer",
            capture(hole, far, 3 * np.sqrt(3) * (1 + excess), index, 400.0),
        )
    stuck = (Status.STEP_UNDERFLOW, Status.EVALUATIONS_EXHAUSTED, Status.CUTOFF, Status.CAPTURED)
    for excess in (-1e-1, -1e-3):
        yield Case(
            "Schwarzschild, isotropic",
            f"impact 3√3 M (1 {excess:+.0e}), falls to the horizon; r/(M/2) − 1",
            "the horizon r = M/2",
            horizon(hole, far, 3 * np.sqrt(3) * (1 + excess), index),
            stuck,
            {"double": 1e-6, "single": 1e-3},
        )


def horizon(medium, far, impact, n_far):
    sine = impact / (n_far * far)

    def run(precision):
        found = trace(precision, medium, (-far, 0, 0), (np.sqrt(1 - sine**2), sine, 0), length=400.0)
        return outcome(found, abs(np.linalg.norm(found.position[0]) / 0.5 - 1))

    return run


# --- n → 0 ---


def cut_off(precision):
    found = trace(
        precision,
        cpm.media.LinearSquared(1.0, gradient=(0, -1, 0)),
        (0, 0, 0),
        (0, 1, 0),
        length=3.0,
        exclude=("exact",),
    )
    return outcome(found, np.linalg.norm(found.position[0] - (0, 1, 0)))


def vanishing():
    medium = cpm.media.LinearSquared(1.0, gradient=(0, -1, 0))
    yield Case(
        "n → 0",
        "n² = 1 − y straight up, integrated; distance from y = 1",
        "n = 0 there",
        cut_off,
        (Status.CUTOFF,),
        {"double": 1e-6, "single": 1e-4},
    )
    for degrees in (1e-3, 1e-2, 1.0):
        a = np.radians(degrees)
        d = (np.sin(a), np.cos(a), 0)
        reference = lambda d=d: closed_forms.linear_squared(1.0, (0, -1, 0), (0, 0, 0), (0, 0, 0), d, length=1.8)  # noqa: E731
        for exclude, what in (((), "exact"), (("exact",), "integrated")):
            yield Case(
                "n → 0",
                f"{degrees:g}° off it, {what}: turns where n = sin θ",
                "the parabola",
                end(medium, (0, 0, 0), d, reference, length=1.8, exclude=exclude),
            )
        yield Case(
            "n → 0",
            f"{degrees:g}° off it, adams",
            "the parabola",
            end(medium, (0, 0, 0), d, reference, length=1.8, method="adams"),
        )
    yield Case(
        "n → 0",
        "0.001° off it, integrated, rtol 1e-12",
        "the parabola",
        end(
            medium,
            (0, 0, 0),
            (np.sin(np.radians(1e-3)), np.cos(np.radians(1e-3)), 0),
            lambda: closed_forms.linear_squared(
                1.0,
                (0, -1, 0),
                (0, 0, 0),
                (0, 0, 0),
                (np.sin(np.radians(1e-3)), np.cos(np.radians(1e-3)), 0),
                length=1.8,
            ),
            length=1.8,
            exclude=("exact",),
            rtol=1e-12,
        ),
    )


# --- grids ---


def grids():
    values = np.random.default_rng(5).uniform(1.2, 1.4, (40, 40, 40))
    origin, spacing, start, d = (-1.95,) * 3, (0.1,) * 3, (0.01, 0.02, 0.03), (1, 0.3, -0.2)
    for kind in ("linear", "cubic"):
        make = splines.grid_linear if kind == "linear" else splines.grid_cubic
        reference = lambda make=make: rays.trace(make(values, origin, spacing), start, d, length=0.3)  # noqa: E731
        grid = cpm.media.Grid(values, origin=origin, spacing=spacing, interpolation=kind)
        yield Case(
            "noisy grid",
            f"white noise in 1.2 … 1.4, {kind}, 3 cells",
            "DOP853 at 1e-12 on SciPy's spline",
            end(grid, start, d, reference, length=0.3),
        )
    x, y, z = np.meshgrid([0, 1], [0, 1], [0, 1], indexing="ij")
    grid = cpm.media.Grid(
        1.3 + 0.1 * x - 0.2 * y + 0.05 * z, origin=(0, 0, 0), spacing=(1, 1, 1), interpolation="linear"
    )
    reference = lambda: closed_forms.linear(1.3, (0.1, -0.2, 0.05), (0, 0, 0), (0.1, 0.2, 0.3), (1, 1, 0.5), length=0.7)  # noqa: E731
    yield Case(
        "one-cell grid",
        "2 × 2 × 2 samples of a linear n",
        "the catenary",
        end(grid, (0.1, 0.2, 0.3), (1, 1, 0.5), reference, length=0.7),
    )


# --- ends, starts, places ---


def nothing(precision):
    found = trace(precision, cpm.media.Linear(1.3, gradient=(0, -0.05, 0)), (0.1, 0.2, 0.3), (1, 2, 2), length=0.0)
    return outcome(found, np.linalg.norm(found.position[0] - (0.1, 0.2, 0.3)))


def refused(origin, direction):
    def run(precision):
        trace(precision, cpm.media.Linear(1.3, gradient=(0, -0.05, 0)), origin, direction, length=1.0)
        return ["ARRIVED"], np.nan, 0, np.nan

    return run


def bounded(height, n):
    """Down through a box of index 1.5, from `height`: optical path of 0.1 m; n on the side that the ray enters."""

    def run(precision):
        scene = cpm.Scene()
        scene.add_medium(cpm.media.Homogeneous(1.5, bounds=cpm.Box((-1, -0.5, -1), (1, 0.5, 1))))
        found = trace(precision, scene, (0.137, height, 0.211), (0, -1, 0), length=0.1)
        return outcome(found, abs(found.optical_path[0] / (0.1 * n) - 1))

    return run


def places():
    yield Case("nothing to do", "length 0", "the start", nothing)
    for name, origin, direction in (
        ("direction 0", (0, 0, 0), (0, 0, 0)),
        ("direction NaN", (0, 0, 0), (np.nan, 0, 0)),
        ("origin NaN", (0, np.nan, 0), (1, 0, 0)),
        ("start where n < 0", (0, 30, 0), (1, 0, 0)),
    ):
        yield Case("refused", name, "a ValueError that names the ray", refused(origin, direction), refused=True)
    for name, height, n in (("outside", 0.7, 1.0), ("on a face", 0.5, 1.5), ("inside", 0.1, 1.5)):
        yield Case(
            "starts by a bound", f"{name}, box of n = 1.5; optical path", "n of the side entered", bounded(height, n)
        )
    far, d = np.array([1e9, -1e9, 1e9]), (1, -0.3, 0.2)
    for exclude, what in (((), "exact"), (("exact",), "integrated")):

        def run(precision, exclude=exclude):
            medium = cpm.media.Linear(1.3, gradient=(0.02, -0.05, 0), origin=far)
            found = trace(precision, medium, far + np.array((0, 1, 0)), d, length=5.0, exclude=exclude)
            true = closed_forms.linear(1.3, (0.02, -0.05, 0), (0, 0, 0), (0, 1, 0), d, length=5.0)
            return outcome(found, np.linalg.norm(found.position[0] - far - true.position) / 5.0)

        # A coordinate of 1e9 m is a multiple of 1.2e-7 m: three of them, rounded at the start and the end.
        yield Case(
            "huge coordinates",
            f"medium and ray 1e9 m away, {what}",
            "the catenary at 0",
            run,
            bounds={"double": 6 * np.spacing(1e9) / 5, "single": 1e-6},
        )


# --- photons asked ---


class Enough(Exception):  # noqa: N818
    """Raised by the progress call-back."""


def photons(count):
    def run(_precision):
        scene = cpm.load_scene(ROOT / "examples" / "cross_room_homogeneous.toml")

        def progress(_stage, fraction):
            if fraction > 0:
                raise Enough

        if count == 0:
            found = cpm.trace_photons(scene, 0, wavelengths=[620.0])
            return ["ARRIVED"], float(len(found.diffuse.position)), 0, np.nan
        try:
            cpm.trace_photons(scene, count, wavelengths=[620.0], progress=progress)
        except Enough:
            return ["ARRIVED"], 0.0, 0, np.nan
        return ["ARRIVED"], np.inf, 0, np.nan

    return run


def asked():
    yield Case("photons asked", "0: none stored", "0 photons", photons(0))
    yield Case(
        "photons asked", "1e9, stopped by its progress call-back after the first batch", "ends at once", photons(10**9)
    )
    yield Case("photons asked", "1e13", "a ValueError that names the bound", photons(10**13), refused=True)


def cases(periods):
    yield from layers()
    yield from earth()
    yield Case(
        "long fibre",
        f"{periods:.0e} periods by yoshida6, 160 steps each; transverse energy",
        "energy kept",
        fibre(periods),
        bounds={"double": 1e-9, "single": 1e-5},
    )
    yield from centres()
    yield from vanishing()
    yield from grids()
    yield from places()
    yield from asked()
