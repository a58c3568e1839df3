#!/usr/bin/env python3
"""The curved cross room: error against seconds of the integrators, and their cost over the homogeneous room.

Error is told in two ways. "to exact": the difference of a picture to the exact one made with the same random numbers,
so that photon noise cancels and the integrator's error stays. "to converged": to the mean of exact pictures with other
seeds, whose noise is taken out; the seed's own photon noise stays in, as a user sees it. Both are medians over seeds.
Not all of "to exact" is the size of the error: a single photon that passes an edge which the exact one met changes the
probes that set the radius of direct light, and with it the picture by 0.002.

Two media with a closed form. n² = 1.69 − 0.10 y, the design's: paths are parabolas in σ, on which every method of
order 2 or more (and the extrapolated Euler step) is exact but for rounding, so tolerance buys nothing. And
n = 1.30 − 0.041 y, the same index at floor and ceiling: catenaries, on which the methods have errors to show. And one
that has none: the design's with hot air over the floor, n lower by 0.1 there and by 1/e of it 15 cm higher, as cubic
layers; "exact" is then nystrom at 1e-11. Which tolerance a picture needs: the loosest from which on, down to the
tightest, the difference to exact is a tenth of the photon noise at most.

Cost: the same n(y) as Layered("cubic") and as a cubic Grid, `auto` without `exact`, at the paper's setting (3 000 000
photons, 150 nearest, 16 bins), in turn with the homogeneous room.
"""
import argparse
import sys
import time

import numpy as np
from _results import CURVED, HOMOGENEOUS, ROOT, add_arguments, judge, load_average, new_figure, positive, table, write

sys.path.insert(0, str(ROOT / "bench" / "peers"))
from regions import NAMES, regions, relative_rmse

import cpm

WAVELENGTH = 620.0
# Room, spot and camera; what leaves it does not come back. A table or a grid must hold inside it, and reaches MARGIN
# further, where a spline's ends no longer show.
EXTENT = cpm.Box((-5.5, -0.5, -2.5), (2.5, 7.0, 2.5))
MARGIN = 1.0
LAYERS = 129
NOTHING = 1e-9   # where a picture equal to the exact one to the last bit is drawn on a logarithmic axis
LONG = 10.0      # seconds; what takes longer is timed once: its ratio is far from any other
GRID = (9, 33, 9)
EULER = (1e-1, 1e-2, 1e-3, 1e-4)
TOLERANCES = tuple(10.0**-k for k in range(1, 9))
HEAT, DEPTH = 0.1, 0.15   # of n at the floor, metres
SHARE = 0.1               # of the photon noise that an integrator's error may be
FIRST_SEED = 1000   # of the converged picture: none that a point has
EXACT = ("exact", None, {"method": "exact"})
ALMOST = ("reference", 1e-11, {"method": "nystrom", "rtol": 1e-11})   # where nothing is exact


def index(y):
    """n at height y (m) in the curved room."""
    return np.sqrt(1.69 - 0.10 * np.asarray(y))


def linear():
    """n = 1.30 − 0.041 y, whose paths are catenaries."""
    return cpm.media.Linear(1.30, gradient=(0.0, -0.041, 0.0))


def hot_floor():
    """The curved room's n less the heat over the floor, as a cubic table of height."""
    low, high = EXTENT.low[1] - MARGIN, EXTENT.high[1] + MARGIN
    heights = np.concatenate([np.linspace(low, 0.0, 16)[:-1], np.linspace(0.0, 2.0, 257), np.linspace(2.0, high, 65)[1:]])
    return cpm.media.Layered(heights, index(heights) - HEAT * np.exp(-np.maximum(heights, 0.0) / DEPTH), interpolation="cubic",
                             kinks=(0.0,))


def layered():
    """The curved room's n as a cubic table of height."""
    heights = np.linspace(EXTENT.low[1] - MARGIN, EXTENT.high[1] + MARGIN, LAYERS)
    return cpm.media.Layered(heights, index(heights), interpolation="cubic")


def grid():
    """The curved room's n as samples on a cubic grid."""
    low, high = np.subtract(EXTENT.low, MARGIN), np.add(EXTENT.high, MARGIN)
    heights = np.linspace(low[1], high[1], GRID[1])
    values = np.broadcast_to(index(heights)[None, :, None], GRID)
    return cpm.media.Grid(values, origin=low, spacing=(high - low) / (np.array(GRID) - 1), interpolation="cubic")


def room(medium=None, **integrator):
    """The curved room with another medium or method."""
    scene = cpm.load_scene(CURVED).copy(medium=medium, **integrator)
    scene.extent = EXTENT
    return scene


def cases(exact=True):
    """(name, rtol or None, arguments of the integrator) of each point, the one that others are held against first."""
    if exact:
        yield EXACT
        yield "auto", None, {}
    else:
        yield ALMOST
    for rtol in TOLERANCES:
        yield "nystrom", rtol, {"method": "nystrom", "rtol": rtol}
    for rtol in EULER:
        yield "euler", rtol, {"method": "euler", "rtol": rtol}
    for rtol in TOLERANCES:
        yield "dopri5", rtol, {"method": "dopri5", "rtol": rtol}


def render(scene, options, seed=0):
    """Radiance (H, W) of one bin, the image's stats, seconds of the whole call."""
    start = time.perf_counter()
    image = cpm.render(scene, photons=options.photons, nearest=options.nearest, wavelengths=[WAVELENGTH], seed=seed,
                       threads=options.threads)
    return image.data[..., 0].astype(float), image.stats, time.perf_counter() - start


def converged(scene, options):
    """Mean of exact pictures with seeds of their own, and the variance of that mean."""
    pictures = np.array([render(scene, options, FIRST_SEED + i)[0] for i in range(options.reference_seeds)])
    return pictures.mean(axis=0), pictures.var(axis=0, ddof=1) / len(pictures)


def sweep(name, medium, options, has_exact=True):
    """Every case in one medium in turn, `rounds` times with a seed each: fastest seconds, median error to exact."""
    chosen = list(cases(has_exact))
    scenes = [room(medium, **arguments) for _, _, arguments in chosen]
    straight = cpm.load_scene(HOMOGENEOUS)
    reference, variance = converged(scenes[0], options)
    masks = regions(reference)
    seconds = np.full((options.rounds, len(scenes) + 1), np.nan)
    errors = [{"to_exact": [], "to_converged": []} for _ in scenes]
    stats, exact = [None] * len(scenes), None
    for i in range(options.rounds):
        seconds[i, -1] = render(straight, options, i)[2]
        for j, scene in enumerate(scenes):
            if i and seconds[0, j] > LONG:
                continue
            picture, stats[j], seconds[i, j] = render(scene, options, i)
            exact = picture if j == 0 else exact
            errors[j]["to_exact"].append([relative_rmse(picture, exact, masks[region]) for region in NAMES])
            errors[j]["to_converged"].append([relative_rmse(picture, reference, masks[region], variance)
                                              for region in NAMES])
    least = np.nanmin(seconds, axis=0)
    points = [{"medium": name, "method": method, "rtol": rtol, "seconds": float(took),
               "over_homogeneous": float(took / least[-1]), "over_exact": float(took / least[0]), **counted(stat),
               **{kind: dict(zip(NAMES, np.median(values, axis=0).tolist(), strict=True))
                  for kind, values in error.items()}}
              for (method, rtol, _), error, stat, took in zip(chosen, errors, stats, least[:-1], strict=True)]
    print_points(name, points, float(least[-1]))
    return {"points": points, "homogeneous_seconds": float(least[-1])}


def counted(stats):
    """Gradient evaluations a ray, and paths that ended by neither hit nor exit."""
    rays = stats["photon_segments"] + stats["eye_segments"]
    return {"evaluations_per_ray": (stats["photon_evaluations"] + stats["eye_evaluations"]) / rays,
            "photons_lost": stats["photons_lost"]}


def print_points(name, points, straight):
    table(f"{name}: relative RMSE by region; homogeneous room {straight:.3f} s",
          ["method", "rtol", "seconds", "x straight", "evaluations/ray", "lost",
           *(f"{region} to exact" for region in ("picture", "shade")),
           *(f"{region} to conv." for region in ("picture", "shade"))],
          [[point["method"], "" if point["rtol"] is None else f"{point['rtol']:.0e}", point["seconds"],
            point["over_homogeneous"], point["evaluations_per_ray"], point["photons_lost"],
            *(f"{point[kind][region]:.2e}" for kind in ("to_exact", "to_converged") for region in ("picture", "shade"))]
           for point in points])


def whole(scene, seed, threads):
    start = time.perf_counter()
    image = cpm.render(scene, seed=seed, threads=threads)
    return image, time.perf_counter() - start


def cost(options):
    """Layered and Grid beside homogeneous and exact, whole renders at the scene file's own setting."""
    scenes = {"homogeneous": cpm.load_scene(HOMOGENEOUS), "exact": room(),
              "auto without exact": room(exclude=("exact",)),
              "Layered cubic": room(layered(), exclude=("exact",)), "Grid cubic": room(grid(), exclude=("exact",))}
    for scene in scenes.values():
        cpm.render(scene, photons=10_000, threads=options.threads)
    names = list(scenes)
    seconds = np.zeros((options.pairs, len(names)))
    first, exact = {}, []
    for i in range(options.pairs):
        for j, name in enumerate(names):
            image, seconds[i, j] = whole(scenes[name], i, options.threads)
            if i == 0:
                first[name] = image.data.astype(float)
            if name == "exact":
                exact.append(image.data.astype(float))
    ratios = np.median(seconds / seconds[:, :1], axis=0)
    # Noise of one exact picture, from pairs of seeds.
    scatter = np.var(exact, axis=0, ddof=1).mean(axis=-1)
    masks = regions(np.mean(exact, axis=(0, -1)))
    rows, result = [], {}
    for j, name in enumerate(names):
        difference = (first[name] - first["exact"]).mean(axis=-1)
        level = {region: first["exact"][masks[region]].mean() for region in NAMES}
        noise = {region: float(np.sqrt(scatter[masks[region]].mean()) / level[region]) for region in NAMES}
        apart = {region: float(np.sqrt((difference[masks[region]] ** 2).mean()) / level[region]) for region in NAMES}
        offset = float(difference.mean() / level["picture"])
        least = float(seconds[:, j].min() / seconds[:, 0].min())
        result[name] = {"seconds": seconds[:, j], "over_homogeneous": float(ratios[j]), "least_over_least": least}
        if name != "homogeneous":
            result[name] |= {"difference": apart, "noise": noise, "mean_offset": offset}
        rows.append([name, float(np.median(seconds[:, j])), float(ratios[j]), least,
                     *(["", "", ""] if name == "homogeneous" else
                       [f"{apart['picture']:.2e}", f"{apart['shade']:.2e}", f"{offset:+.1e}"])])
    table(f"whole renders at the paper's setting, in turn, {options.pairs} times "
          f"(noise of one picture: {noise['picture']:.3f}, in the shade {noise['shade']:.3f})",
          ["room", "seconds", "x homogeneous", "x, least", "picture to exact", "shade to exact", "mean offset"], rows)
    figures = [judge(f"{name}, auto without exact: seconds over the homogeneous room",
                     result[name]["over_homogeneous"], 2.5)
               for name in ("Layered cubic", "Grid cubic")]
    figures.append(judge("parabolas integrated (auto without exact): seconds over the homogeneous room",
                         result["auto without exact"]["over_homogeneous"], None))
    for name in ("Layered cubic", "Grid cubic"):
        worst = max(NAMES, key=lambda region: result[name]["difference"][region] / noise[region])
        figures.append(judge(f"{name}: difference to the exact picture over its noise, worst region",
                             result[name]["difference"][worst] / noise[worst], 1.0, note=worst))
    return result, figures


def needed(result):
    """Of each method with tolerances, the loosest rtol from which on the picture's error is SHARE of the noise at most."""
    noise, found = result["points"][0]["to_converged"]["picture"], {}
    for method in ("nystrom", "dopri5", "euler"):
        enough = None
        for point in reversed([point for point in result["points"] if point["method"] == method]):
            if not point["to_exact"]["picture"] <= SHARE * noise:
                break
            enough = point["rtol"]
        found[method] = enough
    return found


def draw(sweeps, costs):
    """Error to exact over seconds, and over rtol, for each medium; and the costs."""
    figure, axes = new_figure(2, len(sweeps) + 1, (4.6 * (len(sweeps) + 1), 8.4))
    style = {"exact": "C0s", "auto": "C1x", "reference": "C0s", "nystrom": "C2+", "euler": "C3o", "dopri5": "C4d"}
    for column, (name, result) in enumerate(sweeps.items()):
        points = result["points"]
        noise = points[0]["to_converged"]["picture"]
        for row, key in enumerate(("seconds", "rtol")):
            axis = axes[row, column]
            for method in dict.fromkeys(point["method"] for point in points):
                chosen = [point for point in points if point["method"] == method and point[key] is not None]
                if row == 0 or len(chosen) > 1:
                    axis.plot([point[key] for point in chosen],
                              [max(point["to_exact"]["picture"], NOTHING) for point in chosen], f"{style[method]}-", ms=5,
                              label=method)
            axis.axhline(noise, color="0.5", ls=":", label="photon noise of one picture")
            axis.axhline(SHARE * noise, color="0.75", ls=":", label="a tenth of it")
            if row == 0:
                axis.axvline(result["homogeneous_seconds"], color="0.5", ls="--", label="homogeneous room")
            else:
                axis.invert_xaxis()
            axis.set(xscale="log", yscale="log", ylim=(NOTHING / 3, 1), xlabel=("wall seconds", "rtol")[row], title=name)
            axis.grid(which=("both", "major")[row], lw=0.3)
    for axis in axes[:, 0]:
        axis.set_ylabel(f"relative RMSE to exact, same seed ({NOTHING:g}: none)")
        axis.legend(fontsize=7)
    axis = axes[0, -1]
    names = list(costs)
    axis.barh(names, [costs[name]["over_homogeneous"] for name in names], color="tab:blue")
    axis.axvline(2.5, color="tab:red", ls="--", label="goal of the two integrated tables")
    axis.invert_yaxis()
    axis.set(xlabel="whole render, seconds over homogeneous", title="3 M photons, 150 nearest, 16 bins")
    axis.legend(fontsize=7)
    axes[1, -1].set_axis_off()
    return figure


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--photons", type=positive, default=300_000, metavar="N",
                        help="of the sweep (default: %(default)s)")
    parser.add_argument("--nearest", type=positive, default=150, metavar="K",
                        help="of the sweep (default: %(default)s)")
    parser.add_argument("--rounds", type=positive, default=3, metavar="N",
                        help="seeds of each point (default: %(default)s)")
    parser.add_argument("--reference-seeds", type=positive, default=16, metavar="N",
                        help="exact pictures in the converged one (default: %(default)s)")
    parser.add_argument("--pairs", type=positive, default=5, metavar="N",
                        help="whole renders of each room for the cost, 2 or more (default: %(default)s)")
    parser.add_argument("--threads", type=int, default=0, metavar="N", help="default: all cores")
    add_arguments(parser)
    return parser.parse_args()


def main():
    options = parse_arguments()
    load = load_average()
    media = {"n² linear in height (parabolas)": None, "n linear in height (catenaries)": linear()}
    sweeps = {name: sweep(name, medium, options) for name, medium in media.items()}
    sweeps["hot air over the floor (cubic layers)"] = sweep("hot floor", hot_floor(), options, has_exact=False)
    costs, figures = cost(options)
    for name, result in sweeps.items():
        euler = next(point for point in result["points"] if point["method"] == "euler" and point["rtol"] == 1e-2)
        figures.append(judge(f"{name}: euler at the paper's threshold 0.01, picture's RMSE to exact",
                             euler["to_exact"]["picture"], None, note=f"{euler['over_exact']:.2f} x exact's seconds"))
    for name, result in sweeps.items():
        result["needed"] = needed(result)
        for method, rtol in result["needed"].items():
            figures.append(judge(f"{name}: loosest rtol of {method} that a picture of this noise needs",
                                 float("nan") if rtol is None else rtol, None))
    content = {"load_at_start": load, "settings": {"photons": options.photons, "nearest": options.nearest,
                                                   "wavelength": WAVELENGTH, "rounds": options.rounds},
               "sweeps": sweeps, "costs": costs, "layers": LAYERS, "grid": GRID}
    write(options.results, "tolerance", content, figures, draw(sweeps, costs), ["scipy"])


if __name__ == "__main__":
    main()
