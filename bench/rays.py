#!/usr/bin/env python3
"""Work-precision of curved rays: achieved end-point error against gradient evaluations and seconds.

Every method on every case, rtol 1e-2 to 1e-12, beside SciPy's RK45, DOP853 and LSODA and SUNDIALS' CVODE (Adams) in the
same run. Error: metres from the reference end over the path's length. Ours are asked for an arc length and end there;
the peers for the same end in sigma, which is given to them exactly (r, p and nothing else as their state). Seconds: of
ours a call of `cpm.trace` with one ray, of the peers' with the field as a Python function: the speed tables compare.

Figures: gradient evaluations at an achieved error of 1e-6 and 1e-9 of what `auto` takes when `exact` is excluded, over
the best peer's: the least evaluations of any tolerance whose error is small enough, on both sides. The peers have four
absolute tolerances (rtol and rtol × path, and 1 % of each) and the best of them counts: which suits a case is not known
before. The other tables and the pictures take the first. Methods stop at
200 000 evaluations a ray; where one does, or ends with another status, the JSON's "failures" says so.
"""
import argparse
import itertools
import time

import numpy as np
from _ray_cases import WAVELENGTH, cases
from _ray_fibre import beside_loop, long_fibre
from _ray_pictures import case_picture, ratio_picture
from _results import add_arguments, judge, load_average, positive, table, write
from scipy.integrate import solve_ivp

import cpm

STEPS = [2.0**-k for k in range(1, 15)]   # of the path, for methods of fixed steps
ADAPTIVE = ("auto", "nystrom", "adams", "dopri5", "euler")
FIXED = ("rk4", "leapfrog", "yoshida6")
PEERS = ("RK45", "DOP853", "LSODA")
MOST = 200_000     # evaluations a ray: beyond, a method has lost
LEVELS = (1e-6, 1e-9)
FIGURES = ("fibre", "luneburg", "fish-eye", "linear", "atmosphere")   # those with goals


class LostError(Exception):
    """A peer took more than MOST evaluations."""


def slope_of(field, counter):
    def slope(_sigma, y):
        counter[0] += 1
        if counter[0] > MOST:
            raise LostError
        return np.concatenate([y[3:], field(y[:3])[1]])
    return slope


def start_of(case):
    origin, d = np.array(case.origin, float), np.array(case.direction, float)
    return np.concatenate([origin, np.sqrt(case.field(origin)[0]) * d / np.linalg.norm(d)])


def reference(case, steps=200):
    """End (6,) at the case's σ and the arc length there: DOP853 at 1e-13 with n and n² as components."""
    def slope(_sigma, y):
        n2, g = case.field(y[:3])
        return np.concatenate([y[3:6], g, [np.sqrt(n2)]])
    y = np.append(start_of(case), 0.0)
    solved = solve_ivp(slope, (0, case.sigma), y, "DOP853", rtol=1e-13, atol=1e-14 * max(1.0, np.abs(y[:3]).max()),
                       max_step=case.sigma / steps)
    return solved.y[:6, -1], float(solved.y[6, -1])


def point(method, rtol, error, evaluations, seconds, **more):
    return {"method": method, "rtol": rtol, "error": float(error), "evaluations": int(evaluations), "seconds": seconds,
            **more}


def ours(case, end, length, options, failures):
    """Points of every method of this library; what did not arrive goes into failures."""
    def run(repeats=1, most=MOST, **how):
        took = []
        for _ in range(repeats):
            begun = time.perf_counter()
            rays = cpm.trace(case.medium, [case.origin], [case.direction], wavelength=WAVELENGTH, length=length,
                             max_evaluations=most, threads=1, **how)
            took.append(time.perf_counter() - begun)
        status = cpm.RayStatus(rays.status[0])
        if status != cpm.RayStatus.ARRIVED:
            failures.append([case.name, how["method"], how.get("rtol"), how.get("step"), how.get("error", "local"),
                             status.name])
            return None
        return rays, np.linalg.norm(rays.position[0] - end[:3]) / length, min(took)

    for method in ADAPTIVE:
        for rtol in options.tolerances:
            found = run(options.repeats, method=method, rtol=rtol, exclude=("exact",))
            if found is None:
                if failures[-1][-1] == "EVALUATIONS_EXHAUSTED":
                    break   # and so would all tighter ones
                continue
            rays, error, seconds = found
            again = run(method=method, rtol=rtol, exclude=("exact",), error="global", most=20 * MOST)
            yield point(method, rtol, error, rays.evaluations[0], seconds, ran=str(rays.method[0]),
                        local=float(rays.error_estimate[0] / length),
                        **{"global": None if again is None else float(again[0].error_estimate[0] / length)})
    for method in FIXED:
        for part in STEPS:
            found = run(options.repeats, method=method, step=part * length)
            if found is None:
                continue
            yield point(method, None, found[1], found[0].evaluations[0], found[2], step=part * length)
            if found[0].evaluations[0] > MOST / 4:
                break


def peers(case, end, length, options, failures):
    """Points of SciPy's methods and of CVODE where it is installed."""
    y = start_of(case)
    absolute = [1.0, length, 0.01, 0.01 * length]
    counter = [0]
    slope = slope_of(case.field, counter)

    def scipy_end(method, rtol, atol):
        solved = solve_ivp(slope, (0, case.sigma), y, method, rtol=max(rtol, 3e-14), atol=atol)
        return solved.y[:3, -1] if solved.success else None

    def cvode_end(_method, rtol, atol):
        def rhs(sigma, state, out):
            out[:] = slope(sigma, np.array(state))

        solver = CVODE(rhs, method="Adams", rtol=rtol, atol=atol, max_num_steps=100_000)
        solved = solver.solve(np.array([0.0, case.sigma]), y)
        return solved.y[-1][:3] if solved.success else None

    methods = dict.fromkeys(PEERS, scipy_end)
    try:
        from sksundae.cvode import CVODE
        methods["CVODE"] = cvode_end
    except ImportError:
        print("scikit-sundae is not installed: no CVODE")
    for method, scale in itertools.product(methods, absolute):
        for rtol in options.tolerances:
            counter[0] = 0
            begun = time.perf_counter()
            try:
                at = methods[method](method, rtol, rtol * scale)
            except LostError:
                failures.append([case.name, method, rtol, None, "", "EVALUATIONS_EXHAUSTED"])
                break
            if at is None:
                failures.append([case.name, method, rtol, None, "", "no success"])
                continue
            yield point(method, rtol, np.linalg.norm(at - end[:3]) / length, counter[0], time.perf_counter() - begun,
                        atol=rtol * scale)


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
            mine, method = least(points, ADAPTIVE[1:] + FIXED, level)
            rows.append([name, level, best, who, auto, auto / best, mine / best, method])
            if name in FIGURES:
                ratios.append(auto / best)
    table("gradient evaluations at an achieved error", ["case", "error", "best peer", "which", "auto", "auto / peer",
                                                        "best of ours / peer", "which"], rows)
    mean = float(np.exp(np.mean(np.log(ratios))))
    figures = [judge("auto's evaluations over the best peer's, geometric mean", mean, 0.6,
                     note=f"{len(ratios) // len(LEVELS)} of the five cases"),
               judge("the worst of them", float(np.max(ratios)), 0.9)]
    return rows, figures


def estimates(results, kind, unsure):
    """How far an error estimate is off: its ratio to the truth, and the share within 0.3 to 30.

    Of rays whose error exceeds 1e-12 of the path and ten times what the reference is unsure of.
    """
    rows = []
    for method in ADAPTIVE:
        ratios = [p[kind] / p["error"] for name, points in results.items() for p in points
                  if p["method"] == method and p["error"] > max(1e-12, 10 * unsure[name]) and p[kind] is not None]
        if ratios:
            inside = np.mean([0.3 <= r <= 30 for r in ratios])
            rows.append([method, len(ratios), float(np.median(ratios)), float(min(ratios)), float(max(ratios)),
                         float(inside)])
    table(f'error="{kind}": estimate over truth', ["method", "points", "median", "least", "most", "within 0.3-30"],
          rows)
    return rows


def asked(results):
    """Achieved error over what was asked: the median, the worst, and where the worst was."""
    rows = []
    for method in (*ADAPTIVE, *PEERS, "CVODE"):
        found = [(p["error"] / p["rtol"], name, p["rtol"]) for name, points in results.items() for p in points
                 if p["method"] == method and p["rtol"] >= 1e-11 and p.get("atol", p["rtol"]) == p["rtol"]]
        if found:
            over = [f[0] for f in found]
            kept = float(np.mean([o <= 1 for o in over]))
            rows.append([method, len(found), float(np.median(over)), *max(found), kept])
    table("achieved error over rtol, rtol >= 1e-11",
          ["method", "points", "median", "worst", "where", "rtol", "at most 1"], rows)
    return rows


def speed(options):
    """Rays per second, one thread, rtol 1e-6, no geometry; DOP853's field is a Python function."""
    rows, count = [], options.rays
    rng = np.random.default_rng(3)
    for case in cases():
        _, length = reference(case)
        directions = np.array(case.direction) + 0.002 * np.linalg.norm(case.direction) * rng.normal(size=(count, 3))
        took = []
        for _ in range(max(options.repeats, 3)):
            begun = time.perf_counter()
            solve_ivp(slope_of(case.field, [0]), (0, case.sigma), start_of(case), "DOP853", rtol=1e-6, atol=1e-8)
            took.append(time.perf_counter() - begun)
        peer = 1 / min(took)
        for method in ("auto", "nystrom", "adams", "dopri5"):
            took = []
            for _ in range(options.repeats):
                begun = time.perf_counter()
                cpm.trace(case.medium, [case.origin] * count, directions, wavelength=WAVELENGTH, length=length,
                          method=method, exclude=("exact",), rtol=1e-6, threads=1, max_evaluations=MOST)
                took.append(time.perf_counter() - begun)
            rows.append([case.name, method, count / min(took), peer, count / min(took) / peer])
    table("rays per second, one thread, rtol 1e-6", ["case", "method", "rays/s", "DOP853 rays/s", "ratio"], rows)
    fibre = next(row for row in rows if row[:2] == ["fibre", "auto"])
    return rows, judge("fibre, rays per second over DOP853's, one thread, rtol 1e-6", fibre[-1], 500, at_most=False)


def grid_speed(options):
    """Rays across a 64³ cubic grid of n² = 2.25 (1 − 2.25 ρ²), radius 0.3, two threads.

    MitsubaER does 3.6e3 rays/s at an error of 2.7e-5 there.

    From the plane z = −0.285 to z = 0.285: there the closed form has its σ in closed form too. Error: the worst ray's,
    over its path.
    """
    axis = np.linspace(-0.3, 0.3, 64)
    x, y, _ = np.meshgrid(axis, axis, axis, indexing="ij")
    grid = cpm.media.Grid(np.sqrt(2.25 * (1 - 2.25 * (x * x + y * y))), origin=(-0.3,) * 3,
                          spacing=(axis[1] - axis[0],) * 3, interpolation="cubic")
    rng = np.random.default_rng(4)
    count = 10 * options.rays
    r = np.column_stack([rng.uniform(-0.06, 0.06, (count, 2)), np.full(count, -0.285)])
    d = np.column_stack([rng.uniform(-0.25, 0.25, (count, 2)), np.ones(count)])
    p = d / np.linalg.norm(d, axis=1)[:, None] * np.sqrt(2.25 * (1 - 2.25 * (r[:, 0] ** 2 + r[:, 1] ** 2)))[:, None]
    rate, sigma = 2.25, 0.57 / p[:, 2]
    end = r[:, :2] * np.cos(rate * sigma)[:, None] + p[:, :2] / rate * np.sin(rate * sigma)[:, None]
    rows = []
    for rtol in 10.0 ** -np.arange(2, 9):
        took = []
        for _ in range(options.repeats):
            begun = time.perf_counter()
            rays = cpm.trace(grid, r, d, wavelength=WAVELENGTH, until=((0, 0, 0.285), (0, 0, 1)), rtol=float(rtol),
                             threads=2)
            took.append(time.perf_counter() - begun)
        arrived = np.isin(rays.status, (int(cpm.RayStatus.ARRIVED), int(cpm.RayStatus.HIT)))
        error = np.linalg.norm(rays.position[:, :2] - end, axis=1) / 0.57
        rows.append([float(rtol), str(rays.method[0]), float(np.mean(arrived)), float(rays.evaluations.mean()),
                     float(error.max()), count / min(took), count / min(took) / 3.6e3])
    table("64³ cubic grid, 0.57 m, two threads",
          ["rtol", "ran", "arrived", "evaluations a ray", "worst error", "rays/s", "over MitsubaER's"], rows)
    best = max((row[-1] for row in rows if row[4] <= 2.7e-5 and row[2] == 1), default=np.nan)
    return rows, judge("64³ cubic grid, rays per second over MitsubaER's 3.6e3, error ≤ 2.7e-5, two threads", best, 100,
                       at_most=False, note="MitsubaER's figure is another run's, on the same kind of machine")


def horizon():
    """Metres off after 500 km along the horizon, in double and in single precision."""
    rows, figures = [], []
    for case in cases():
        if not case.name.startswith("atmosphere"):
            continue
        end, length = reference(case)
        for precision, goal in (("double", 1e-3), ("single", 0.1)):
            rays = cpm.trace(case.medium, [case.origin], [case.direction], wavelength=WAVELENGTH, length=length,
                             exclude=("exact",), rtol=1e-9, precision=precision)
            off = float(np.linalg.norm(rays.position[0] - end[:3]))
            rows.append([case.name, precision, str(rays.method[0]), int(rays.evaluations[0]), off])
            figures.append(judge(f"{case.name}, 500 km, rtol 1e-9, {precision}: metres off", off, goal))
    return rows, figures


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--repeats", type=positive, default=3, metavar="N", help="timings of each (%(default)s)")
    parser.add_argument("--rays", type=positive, default=4000, metavar="N", help="of the speed table (%(default)s)")
    parser.add_argument("--periods", type=positive, default=1_000_000, metavar="N",
                        help="of the fibre by yoshida6 (%(default)s)")
    parser.add_argument("--per-decade", type=positive, default=2, metavar="N", help="tolerances a decade (%(default)s)")
    add_arguments(parser)
    options = parser.parse_args()
    options.tolerances = [10.0 ** -(2 + k / options.per_decade) for k in range(10 * options.per_decade + 1)]
    return options


def main():
    options, load = parse_arguments(), load_average()
    results, lengths, unsure, failures = {}, {}, {}, []
    for case in cases():
        end, length = reference(case)
        lengths[case.name] = length
        unsure[case.name] = float(np.linalg.norm(reference(case, steps=517)[0][:3] - end[:3])) / length
        begun = time.perf_counter()
        results[case.name] = [*ours(case, end, length, options, failures), *peers(case, end, length, options, failures)]
        print(f"{case.name}: {len(results[case.name])} points, path {length:.6g} m, reference sure to "
              f"{unsure[case.name]:.1e}, {time.perf_counter() - begun:.1f} s", flush=True)
    compared, figures = compare(results)
    speeds, fibre = speed(options)
    grid, mitsuba = grid_speed(options)
    loop, straight = beside_loop(options)
    periods, long = long_fibre(options)
    earth, horizons = horizon()
    content = {"load_at_start": load, "tolerances_per_decade": options.per_decade, "lengths": lengths,
               "reference_unsure": unsure, "compared": compared,
               "local_estimates": estimates(results, "local", unsure),
               "global_estimates": estimates(results, "global", unsure),
               "achieved_over_asked": asked(results), "speed": speeds, "grid_speed": grid, "straight_loop": loop,
               "long_fibre": periods, "horizon": earth,
               "failures": failures, "points": {name: columns(points) for name, points in results.items()}}
    options.results.mkdir(parents=True, exist_ok=True)
    for name, points in results.items():
        shown = [p for p in points if p.get("atol", p["rtol"]) == p["rtol"]]
        picture = case_picture(name, shown, (*PEERS, "CVODE"))
        picture.savefig(options.results / f"rays-{name.replace(' ', '-')}.png", dpi=110)
    write(options.results, "rays", content, [*figures, fibre, straight, mitsuba, *long, *horizons], ratio_picture(compared),
          ["scipy", "scikit-sundae"])


def columns(points):
    """Points as a dict of columns a method."""
    found = {}
    for p in points:
        for key, value in p.items():
            if key != "method":
                found.setdefault(p["method"], {}).setdefault(key, []).append(value)
    return found


if __name__ == "__main__":
    main()
