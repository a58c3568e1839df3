#!/usr/bin/env python3
"""Work-precision of curved rays: achieved end-point error against gradient evaluations and seconds.

Every method on every case, rtol 1e-2 to 1e-12, beside SciPy's RK45, DOP853 and LSODA and SUNDIALS' CVODE (Adams) in the
same run. Error: metres from the reference end over the path's length. Ours are asked for an arc length and end there;
the peers for the same end in sigma, which is given to them exactly (r, p and nothing else as their state).

Figures: gradient evaluations at an achieved error of 1e-6 and 1e-9 of what `auto` takes when `exact` is excluded, over
the best peer's: the least evaluations of any tolerance whose error is small enough, on both sides.
"""
import argparse
import sys
import time
from dataclasses import dataclass

import numpy as np
from _results import ROOT, add_arguments, judge, load_average, new_figure, positive, table, write

sys.path.insert(0, str(ROOT / "tests"))
from scipy.integrate import solve_ivp

import cpm

WAVELENGTH = 550.0
TOLERANCES = [10.0 ** (-k / 2) for k in range(4, 25)]
STEPS = [2.0**-k for k in range(1, 15)]   # of the path, for methods of fixed steps
ADAPTIVE = ("auto", "nystrom", "adams", "dopri5", "euler")
FIXED = ("rk4", "leapfrog", "yoshida6")
PEERS = ("RK45", "DOP853", "LSODA")
MOST = 200_000     # evaluations a ray: beyond, a method has lost
LEVELS = (1e-6, 1e-9)
EARTH, HEIGHT, SURFACE = 6371e3, 8e3, 2.77e-4
FIGURES = ("fibre", "luneburg", "fish-eye", "linear", "atmosphere")   # ANCHORS' five


@dataclass(frozen=True)
class Case:
    """A medium, its field as (n², ½∇n²) of r for the peers, a ray, and how far it goes in σ."""

    name: str
    medium: object
    field: object
    origin: tuple
    direction: tuple
    sigma: float


def fibre_field(r):
    return 2.25 * (1 - r[0] ** 2 - r[1] ** 2), np.array([-2.25 * r[0], -2.25 * r[1], 0.0])


def luneburg_field(r):
    return 2 - r @ r, -r


def fisheye_field(r):
    n = 2 / (1 + r @ r)
    return n * n, -n**3 * r


def linear_field(r):
    n = 1.2 - 0.05 * r[1]
    return n * n, np.array([0.0, -0.05 * n, 0.0])


def atmosphere_field(r):
    """Exponential in height above a sphere whose surface is at the origin, y up; height without cancellation."""
    up = np.array([r[0], r[1] + EARTH, r[2]])
    distance = np.sqrt(up @ up)
    height = (2 * EARTH * r[1] + r @ r) / (distance + EARTH)
    refractivity = SURFACE * np.exp(-height / HEIGHT)
    n = 1 + refractivity
    return n * n, -n * refractivity / HEIGHT / distance * up


def centres_field(r):
    """Two gravity centres, 1 + Σ m/|r − c|²."""
    n, gradient = 1.0, np.zeros(3)
    for centre, strength in (((0.0, 0.0, 0.0), 0.1), ((2.0, 1.0, 0.0), 0.05)):
        d = r - np.array(centre)
        n += strength / (d @ d)
        gradient -= 2 * strength * d / (d @ d) ** 2
    return n * n, n * gradient


def grid_medium(nodes=49, half=1.2):
    """The fibre's n sampled on a cubic grid."""
    axis = np.linspace(-half, half, nodes)
    x, y, _ = np.meshgrid(axis, axis, np.linspace(0, 20, 9), indexing="ij")
    n = np.sqrt(np.maximum(2.25 * (1 - 0.25 * (x * x + y * y)), 0.1))
    return cpm.media.Grid(n, origin=(-half, -half, 0), spacing=(axis[1] - axis[0],) * 2 + (2.5,), interpolation="cubic")


def of_heights(profile, heights):
    return cpm.media.Layered(heights, profile(heights), up=(0, 1, 0), interpolation="cubic")


def medium_field(medium):
    """The library's own n and ∇n as a field: for peers on a table, so that all solve one problem."""
    def field(r):
        n, gradient = medium.evaluate(r, WAVELENGTH)
        return float(n[0]) ** 2, float(n[0]) * gradient[0]
    return field


def cases():
    """The cases whose media this version has."""
    media = cpm.media
    if hasattr(media, "Parabolic"):
        yield Case("fibre", media.Parabolic(1.5, alpha=1.0), fibre_field, (0.3, 0, 0),
                   (0, 0.2, np.sqrt(2.25 * 0.91 - 0.04)), 20.0)
    if hasattr(media, "Luneburg"):
        yield Case("luneburg", media.Luneburg(1.0), luneburg_field, (0.5, 0, -np.sqrt(0.75)), (0, 0, 1),
                   np.pi / 2 * (1 - 1e-9))
    if hasattr(media, "Fisheye"):
        # One circle: through 0.5 and its conjugate −2 on the axis, radius 1.25 about −0.75; σ = ∮ dl/n in closed form.
        yield Case("fish-eye", media.Fisheye(2.0, radius=1.0), fisheye_field, (0.5, 0, 0), (0, 1, 0.3), circle_sigma())
    yield Case("linear", media.Linear(1.2, gradient=(0, -0.05, 0)), linear_field, (0, 0, 0), (1, 0.4, 0.2), 8 / 1.1)
    spherical = atmosphere()
    if spherical is not None:
        yield Case("atmosphere", spherical, atmosphere_field, (0, 2, 0), (1, 0, 0), 500e3)
    heights = np.concatenate([np.linspace(0, 0.5, 201), np.linspace(0.51, 4, 60)])
    road = of_heights(lambda h: 1 + 2.7e-4 - 2.7e-5 * np.exp(-h / 0.05), heights)
    yield Case("hot road", road, medium_field(road), (0, 1.0, 0), (1, -0.004, 0), 500.0)
    grid = grid_medium()
    yield Case("cubic grid", grid, medium_field(grid), (0.3, 0.1, 0.5), (0, 0.2, 1.4), 10.0)
    if hasattr(media, "Sources"):
        yield Case("gravity centres", media.Sources([(0, 0, 0), (2, 1, 0)], [0.1, 0.05], 2), centres_field,
                   (-3, 0.8, 0), (1, 0, 0.05), 6.0)


def atmosphere():
    """The spherical exponential atmosphere as an Expression, else as spherical layers; None where neither exists."""
    if hasattr(cpm.media, "Expression"):
        height = f"(2*{EARTH}*y + x*x + y*y + z*z)/(sqrt(x*x + (y+{EARTH})**2 + z*z) + {EARTH})"
        return cpm.media.Expression(f"1 + {SURFACE}*exp(-({height})/{HEIGHT})")
    try:
        heights = np.linspace(-1e3, 60e3, 1221)
        return cpm.media.Layered(heights, 1 + SURFACE * np.exp(-heights / HEIGHT), up=(0, 1, 0), origin=(0, 0, 0),
                                 radius=EARTH, interpolation="cubic")
    except (TypeError, ValueError, cpm.Error):
        return None


def circle_sigma():
    """σ of one turn in the fish-eye n = 2/(1 + r²) from (0.5, 0, 0) at right angles: ∮ (1 + r²)/2 dl, radius 1.25."""
    radius, offset = 1.25, 0.75
    return 2 * np.pi * radius * (1 + radius**2 + offset**2) / 2


def slope_of(field, counter):
    def slope(_sigma, y):
        counter[0] += 1
        return np.concatenate([y[3:], field(y[:3])[1]])
    return slope


def start_of(case):
    origin, d = np.array(case.origin, float), np.array(case.direction, float)
    return np.concatenate([origin, np.sqrt(case.field(origin)[0]) * d / np.linalg.norm(d)])


def reference(case):
    """End (6,) at the case's σ and the arc length there: DOP853 at 1e-13 with n and n² as components."""
    def slope(_sigma, y):
        n2, g = case.field(y[:3])
        return np.concatenate([y[3:6], g, [np.sqrt(n2)]])
    y = np.append(start_of(case), 0.0)
    solved = solve_ivp(slope, (0, case.sigma), y, "DOP853", rtol=1e-13, atol=1e-14 * max(1.0, np.abs(y[:3]).max()),
                       max_step=case.sigma / 200)
    return solved.y[:6, -1], float(solved.y[6, -1])


def point(method, rtol, error, evaluations, seconds, **more):
    return {"method": method, "rtol": rtol, "error": float(error), "evaluations": int(evaluations), "seconds": seconds, **more}


def ours(case, end, length, repeats):
    """Points of every method of this library."""
    def run(**options):
        took = []
        for _ in range(repeats):
            begun = time.perf_counter()
            rays = cpm.trace(case.medium, [case.origin], [case.direction], wavelength=WAVELENGTH, length=length,
                             max_evaluations=MOST, threads=1, **options)
            took.append(time.perf_counter() - begun)
        if rays.status[0] != cpm.RayStatus.ARRIVED:
            return None
        error = np.linalg.norm(rays.position[0] - end[:3]) / length
        return rays, error, min(took)

    for method in ADAPTIVE:
        for rtol in TOLERANCES:
            found = run(method=method, rtol=rtol, exclude=("exact",))
            if found is None:
                break
            rays, error, seconds = found
            yield point(method, rtol, error, rays.evaluations[0], seconds, ran=str(rays.method[0]),
                        rejected=int(rays.rejected[0]), estimate=float(rays.error_estimate[0] / length))
    for method in FIXED:
        for part in STEPS:
            found = run(method=method, step=part * length)
            if found is None or found[0].evaluations[0] > MOST / 4:
                break
            yield point(method, None, found[1], found[0].evaluations[0], found[2], step=part * length)


def peers(case, end, length, repeats):
    """Points of SciPy's methods and of CVODE where it is installed."""
    y = start_of(case)
    size = np.abs(y[:3] - end[:3]).max() or length
    for method in PEERS:
        for rtol in TOLERANCES:
            counter, begun = [0], time.perf_counter()
            solved = solve_ivp(slope_of(case.field, counter), (0, case.sigma), y, method, rtol=max(rtol, 3e-14),
                               atol=rtol * min(size, 1e3) * 1e-2)
            if solved.success and counter[0] < MOST:
                yield point(method, rtol, np.linalg.norm(solved.y[:3, -1] - end[:3]) / length, counter[0],
                            time.perf_counter() - begun)
    try:
        from sksundae.cvode import CVODE
    except ImportError:
        return
    counter = [0]

    def rhs(_sigma, state, out):
        counter[0] += 1
        out[:3], out[3:] = state[3:], case.field(np.array(state[:3]))[1]

    for rtol in TOLERANCES:
        counter[0] = 0
        begun = time.perf_counter()
        solver = CVODE(rhs, method="Adams", rtol=rtol, atol=rtol * min(size, 1e3) * 1e-2, max_num_steps=100_000)
        solved = solver.solve(np.array([0.0, case.sigma]), y)
        if solved.success:
            yield point("CVODE", rtol, np.linalg.norm(solved.y[-1][:3] - end[:3]) / length, counter[0],
                        time.perf_counter() - begun)


def least(points, methods, level):
    """Fewest evaluations of any tolerance that reach an error, and whose they are."""
    good = [(p["evaluations"], p["method"]) for p in points if p["method"] in methods and p["error"] <= level]
    return min(good, default=(np.nan, "none"))


def compare(results):
    """Evaluations of auto and of our best method over the best peer's, and the figures to reach."""
    rows, ratios = [], []
    for name, points in results.items():
        for level in LEVELS:
            best, who = least(points, (*PEERS, "CVODE"), level)
            auto, _ = least(points, ("auto",), level)
            mine, method = least(points, ADAPTIVE + FIXED, level)
            rows.append([name, level, best, who, auto, auto / best, mine / best, method])
            if name in FIGURES:
                ratios.append(auto / best)
    table("gradient evaluations at an achieved error", ["case", "error", "best peer", "which", "auto", "auto / peer",
                                                        "best of ours / peer", "which"], rows)
    figures = [judge("auto's evaluations over the best peer's, geometric mean", float(np.exp(np.mean(np.log(ratios)))), 0.6,
                     note=f"{len(ratios) // len(LEVELS)} of the five cases"),
               judge("the worst of them", float(np.max(ratios)), 0.9)]
    return rows, figures


def estimates(results):
    """How far the local error estimate is off: share within 0.3 to 30 of the truth, and the median ratio."""
    rows = []
    for method in ADAPTIVE:
        ratios = [p["estimate"] / p["error"] for points in results.values() for p in points
                  if p["method"] == method and p["error"] > 1e-12]
        if ratios:
            inside = np.mean([0.3 <= r <= 30 for r in ratios])
            rows.append([method, len(ratios), float(np.median(ratios)), float(min(ratios)), float(max(ratios)), float(inside)])
    table('error="local": estimate over truth', ["method", "points", "median", "least", "most", "within 0.3-30"], rows)
    return rows


def speed(options):
    """Rays per second, one thread, rtol 1e-6, no geometry."""
    rows, count = [], options.rays
    rng = np.random.default_rng(3)
    for case in cases():
        end, length = reference(case)
        directions = np.array(case.direction) + 0.02 * np.linalg.norm(case.direction) * rng.normal(size=(count, 3)) * 0.1
        begun = time.perf_counter()
        evaluations = [0]
        solve_ivp(slope_of(case.field, evaluations), (0, case.sigma), start_of(case), "DOP853", rtol=1e-6, atol=1e-8)
        peer = 1 / (time.perf_counter() - begun)
        for method in ("auto", "nystrom", "adams", "dopri5"):
            took = []
            for _ in range(options.repeats):
                begun = time.perf_counter()
                cpm.trace(case.medium, [case.origin] * count, directions, wavelength=WAVELENGTH, length=length,
                          method=method, exclude=("exact",), rtol=1e-6, threads=1, max_evaluations=MOST)
                took.append(time.perf_counter() - begun)
            rows.append([case.name, method, count / min(took), peer, count / min(took) / peer])
    table("rays per second, one thread, rtol 1e-6", ["case", "method", "rays/s", "DOP853 rays/s", "ratio"], rows)
    return rows


def draw(results):
    """A row a case: error over evaluations, error over seconds."""
    figure, axes = new_figure(len(results), 2, (12, 4.2 * len(results)))
    for row, (name, points) in zip(axes, results.items(), strict=True):
        for axis, key, label in zip(row, ("evaluations", "seconds"), ("gradient evaluations", "seconds a ray"), strict=True):
            for method in dict.fromkeys(p["method"] for p in points):
                chosen = [p for p in points if p["method"] == method]
                peer = method in (*PEERS, "CVODE")
                axis.plot([p[key] for p in chosen], [max(p["error"], 1e-17) for p in chosen], "--" if peer else "-",
                          marker="." if peer else "o", ms=3, lw=2.5 if method == "auto" else 1, label=method)
            axis.set(xscale="log", yscale="log", xlabel=label, ylabel="end-point error / path", title=name)
            axis.grid(which="both", lw=0.3)
        row[0].legend(fontsize=7)
    return figure


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--repeats", type=positive, default=3, metavar="N", help="timings of each (default: %(default)s)")
    parser.add_argument("--rays", type=positive, default=4000, metavar="N", help="of the speed table (default: %(default)s)")
    add_arguments(parser)
    return parser.parse_args()


def main():
    options, load = parse_arguments(), load_average()
    results, lengths = {}, {}
    for case in cases():
        end, length = reference(case)
        lengths[case.name] = length
        results[case.name] = [*ours(case, end, length, options.repeats), *peers(case, end, length, options.repeats)]
        print(f"{case.name}: {len(results[case.name])} points, path {length:.6g} m", flush=True)
    compared, figures = compare(results)
    content = {"load_at_start": load, "lengths": lengths, "compared": compared, "local_estimates": estimates(results),
               "speed": speed(options), "points": results}
    for name, points in results.items():
        write_picture(options, name, points)
    write(options.results, "rays", content, figures, draw(results), ["scipy", "scikit-sundae"])


def write_picture(options, name, points):
    """One picture a case, docs/results/rays-NAME.png."""
    options.results.mkdir(parents=True, exist_ok=True)
    draw({name: points}).savefig(options.results / f"rays-{name.replace(' ', '-')}.png", dpi=110)


if __name__ == "__main__":
    main()
