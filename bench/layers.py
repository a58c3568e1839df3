#!/usr/bin/env python3
"""Berger and Trout's discrete layers against the smooth profile: error against the number of layers.

n is constant in each layer and Snell's law holds between them (`Layered(interpolation="step")`): the way mirages are
often drawn. Layers are equally thick; the index of one is that of its middle, or of its lower face, as a table of
heights has it. Cases: the exponential atmosphere along the horizon (spherical layers), and a hot road, by rays that come
down to the ground and by rays that are turned back above it. Error: the end's distance from the reference over the
path's length, median and worst of some rays; the reference is SciPy's DOP853 at 1e-13 on the profile. The order is the
slope of log error over log layers from the second count on. Beside it: what `auto` needs on the smooth profile.
"""
import argparse
import time
from dataclasses import dataclass

import numpy as np
from _ray_cases import EARTH, HEIGHT, SURFACE, WAVELENGTH
from _results import add_arguments, judge, load_average, new_figure, positive, table, write
from scipy.integrate import solve_ivp

import cpm

UP = (0.0, 1.0, 0.0)
ROAD = (2.7e-4, 2.7e-5, 0.05)   # refractivity of the air, what the heat takes away at the ground, metres


@dataclass(frozen=True)
class Case:
    """A profile of refractivity over height (m), its slope, the table's top, and rays (slope and length of each)."""

    name: str
    refractivity: object
    slope: object
    top: float
    start: float
    slopes: np.ndarray
    lengths: np.ndarray
    radius: float | None = None


def air(h):
    return SURFACE * np.exp(-h / HEIGHT)


def road(h):
    return ROAD[0] - ROAD[1] * np.exp(-h / ROAD[2])


def cases(rays):
    """Rays that fall differently on the layers' faces, so that no one of them is lucky."""
    grazing = np.sqrt(2 * ROAD[1])   # turned back at the ground itself, about
    steep = -np.linspace(1.3, 2.5, rays) * grazing
    shallow = -np.linspace(0.5, 0.9, rays) * grazing
    yield Case("atmosphere, 500 km along the horizon", air, lambda h: -air(h) / HEIGHT, 24e3, 2.0,
               np.linspace(0.0, 2e-3, rays), np.full(rays, 500e3), EARTH)
    yield Case("hot road, through to the ground", road, lambda h: ROAD[1] / ROAD[2] * np.exp(-h / ROAD[2]), 1.0, 0.9,
               steep, -0.88 / steep)
    yield Case("hot road, turned back above it", road, lambda h: ROAD[1] / ROAD[2] * np.exp(-h / ROAD[2]), 1.0, 0.5,
               shallow, -0.9 / shallow)


def reference(case, slope, length):
    """End (x, y) after a length: DOP853 in σ, height and distance from the centre without cancellation."""
    def height_and_out(x, y):
        if case.radius is None:
            return y, 0.0, 1.0
        distance = np.hypot(x, y + case.radius)
        return (2 * case.radius * y + x * x + y * y) / (distance + case.radius), x / distance, (y + case.radius) / distance

    def change(_s, state):
        h, out_x, out_y = height_and_out(state[0], state[1])
        n = 1 + case.refractivity(h)
        bend = n * case.slope(h)
        return [state[2], state[3], bend * out_x, bend * out_y, n]

    def arrived(_s, state):
        return state[4] - length

    arrived.terminal = True
    n = 1 + case.refractivity(height_and_out(0.0, case.start)[0])
    d = np.array([1.0, slope]) / np.hypot(1.0, slope)
    solved = solve_ivp(change, (0, 2 * length), [0, case.start, *(n * d), 0.0], "DOP853", rtol=1e-13, atol=1e-13,
                       max_step=length / 400, events=arrived)
    return solved.y_events[0][0][:2]


def layered(case, count, middle):
    """So many equal layers up to the top of the table, of the index in the middle or at the lower face."""
    heights = case.top / count * np.arange(count)
    n = 1 + case.refractivity(heights + (0.5 * case.top / count if middle else 0.0))
    return cpm.media.Layered(heights, n, up=UP, interpolation="step", radius=case.radius)


def smooth(case):
    """The same profile as cubic layers, fine enough to be it."""
    heights = case.top * np.linspace(-0.1, 1.1, 4001)
    return cpm.media.Layered(heights, 1 + case.refractivity(heights), up=UP, radius=case.radius)


def traced(case, medium, **how):
    """Ends (N, 2), steps a ray, and seconds."""
    aims = np.column_stack([np.ones(len(case.slopes)), case.slopes, np.zeros(len(case.slopes))])
    begun = time.process_time()
    rays = cpm.trace(medium, [(0.0, case.start, 0.0)] * len(aims), aims, wavelength=WAVELENGTH, length=case.lengths, threads=1,
                     **how)
    seconds = time.process_time() - begun
    assert np.all(rays.status == cpm.RayStatus.ARRIVED), rays.status
    return rays.position[:, :2], rays, seconds


def order_of(counts, errors):
    """Minus the slope of log error over log count, the coarsest left out."""
    return float(-np.polyfit(np.log(counts[1:]), np.log(errors[1:]), 1)[0])


def converge(case, counts):
    """Rows of every count, and the smooth profile's."""
    ends = np.array([reference(case, *of) for of in zip(case.slopes, case.lengths, strict=True)])
    error_of = lambda at: np.linalg.norm(at - ends, axis=1) / case.lengths  # noqa: E731
    found = {}
    for name, middle in (("middle", True), ("lower face", False)):
        rows = []
        for count in counts:
            at, rays, seconds = traced(case, layered(case, int(count), middle))
            errors = error_of(at)
            rows.append([int(count), float(np.median(errors)), float(errors.max()), float(rays.steps.mean()),
                         seconds / len(errors)])
        found[name] = {"rows": rows, "order": order_of(counts, [row[1] for row in rows]),
                       "order_of_worst": order_of(counts, [row[2] for row in rows])}
    medium, rows = smooth(case), []
    for rtol in 10.0 ** -np.arange(2.0, 11.0):
        at, rays, seconds = traced(case, medium, rtol=rtol)
        rows.append([float(rtol), float(np.median(error_of(at))), float(error_of(at).max()), float(rays.evaluations.mean()),
                     seconds / len(case.slopes)])
    found["auto on the smooth profile"] = {"rows": rows, "ran": str(rays.method[0])}
    return found


def draw(results, counts):
    figure, axes = new_figure(1, len(results), (5 * len(results), 4.8))
    for axis, (name, found) in zip(axes[0], results.items(), strict=True):
        for kind, mark, colour in (("middle", "o", "tab:blue"), ("lower face", "s", "tab:orange")):
            rows = found[kind]["rows"]
            axis.plot(counts, [row[1] for row in rows], f"{mark}-", ms=4, color=colour,
                      label=f"n of the {kind}: order {found[kind]['order']:.2f}")
            axis.plot(counts, [row[2] for row in rows], ":", lw=1, color=colour, label="its worst ray")
        for row, rtol in zip(found["auto on the smooth profile"]["rows"][1:8:2], ("1e-3", "1e-5", "1e-7", "1e-9"), strict=True):
            axis.axhline(row[1], color="0.6", lw=0.7, ls="--")
            axis.annotate(f"smooth, rtol {rtol}: {row[3]:.0f} evaluations", (counts[0], row[1]), fontsize=7, color="0.4",
                          va="bottom")
        axis.set(xscale="log", yscale="log", xlabel="layers", title=name, ylim=(None, 1.0))
        axis.grid(which="both", lw=0.2)
        axis.legend(fontsize=7, loc="upper right")
    axes[0, 0].set_ylabel("end-point error / path length, median of the rays")
    return figure


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rays", type=positive, default=41, metavar="N", help="of each case (%(default)s)")
    parser.add_argument("--most", type=positive, default=16384, metavar="N", help="layers, the last count (%(default)s)")
    add_arguments(parser)
    options, load = parser.parse_args(), load_average()
    counts = 2 ** np.arange(3, int(np.log2(options.most)) + 1)
    results, figures = {}, []
    for case in cases(options.rays):
        found = results[case.name] = converge(case, counts)
        for kind in ("middle", "lower face"):
            table(f"{case.name}; n of the {kind}: order {found[kind]['order']:.2f} (worst ray "
                  f"{found[kind]['order_of_worst']:.2f})", ["layers", "median", "worst", "steps a ray", "s a ray"],
                  found[kind]["rows"])
            figures.append(judge(f"{case.name}: order of the median error over layers, n of the {kind}",
                                 found[kind]["order"], None))
        table(f"{case.name}; auto on the smooth profile", ["rtol", "median", "worst", "evaluations", "s a ray"],
              found["auto on the smooth profile"]["rows"])
    write(options.results, "layers", {"load_at_start": load, "cases": results}, figures, draw(results, counts), ["scipy"])


if __name__ == "__main__":
    main()
