#!/usr/bin/env python3
"""Error against run time in the cross room: homogeneous beside Mitsuba's path tracer, curved beside homogeneous.

Homogeneous: one bin at 620 nm, as the peer has one wavelength, swept over photons, nearest neighbours and eye rays a
pixel. Seconds are those of the whole cpm.render call, after one warm-up that builds the scene, as the peer's are; error
is the relative RMSE by region (peers/regions.py) against the reference in bench/data, whose own noise is taken out.
With several seeds the error is also split: what stays in the mean of the pictures is bias, the rest is noise.

Curved: the paper's setting (3 000 000 photons, 150 nearest, 16 bins), exact, in turn with the homogeneous room.

    cpm bench room -- --peer-python venv/bin/python       # Mitsuba from another environment, see peers/mitsuba_room.py
"""
import argparse
import sys
import time
from itertools import product
from pathlib import Path

import numpy as np
from _results import CURVED, HOMOGENEOUS, ROOT, add_arguments, judge, load_average, new_figure, positive, table, write

sys.path.insert(0, str(ROOT / "bench" / "peers"))
from _peer_room import curve, error_at, run_peer
from mitsuba_room import load_reference
from regions import NAMES, regions, relative_rmse

import cpm

WAVELENGTH = 620.0          # nm, of the reference
WINDOW = (1.0, 30.0)        # seconds in which the figures count
LONG, ENOUGH = 10.0, 2      # a picture that takes more seconds than LONG gets ENOUGH seeds
EDGE_LIMIT = ("discs that hold enough direct photons reach over the outline of the lit cross and blur it; one eye ray "
              "at a pixel's middle makes a staircase of it besides")
PAPER = (3_000_000, 150)    # photons, nearest
MARKERS = "o^sDv"
COLOURS = ("tab:blue", "tab:orange", "tab:green", "tab:purple", "tab:brown")   # red is the peer's


def render_seconds(scene, **settings):
    """A picture, and the wall seconds of the whole call."""
    start = time.perf_counter()
    image = cpm.render(scene, **settings)
    return image, time.perf_counter() - start


def split_error(pictures, reference, variance, mask):
    """Relative RMSE over a region, all of it and its bias.

    Parameters
    ----------
    pictures : ndarray, shape (S, H, W)
        With S seeds.
    reference, variance : ndarray, shape (H, W)
    mask : ndarray of bool, shape (H, W)

    Returns
    -------
    error, bias : float
        The mean picture's square error has noise of scatter / S and of the reference, both taken out; NaN for one seed.
    """
    error = float(np.sqrt(np.mean([relative_rmse(picture, reference, mask, variance) ** 2 for picture in pictures])))
    if len(pictures) < 2:
        return error, float("nan")
    scatter = pictures.var(axis=0, ddof=1) / len(pictures)
    return error, relative_rmse(pictures.mean(axis=0), reference, mask, variance + scatter)


def measure(scene, photons, nearest, samples, options, reference, masks):
    """One point of the sweep."""
    pictures, seconds = [], []
    for seed in range(options.seeds):
        if seed >= ENOUGH and seconds[0] > LONG:
            break
        image, took = render_seconds(scene, photons=photons, nearest=nearest, wavelengths=[WAVELENGTH], seed=seed,
                                     samples=samples, threads=options.threads)
        pictures.append(image.data[..., 0].astype(float))
        seconds.append(took)
    pictures = np.array(pictures)
    parts = {name: split_error(pictures, reference["mean"], reference["variance"], masks[name]) for name in NAMES}
    stages = {key.removeprefix("seconds_"): value for key, value in image.stats.items() if key.startswith("seconds_")}
    return {"photons": photons, "nearest": nearest, "samples": samples, "pictures": len(pictures),
            "seconds": float(np.median(seconds)),
            "error": {name: part[0] for name, part in parts.items()},
            "bias": {name: part[1] for name, part in parts.items()},
            "mean_ratio": {name: float(pictures[:, mask].mean() / reference["mean"][mask].mean(dtype=float))
                           for name, mask in masks.items()},
            "stages": stages}


def sweep(scene, options, reference, masks):
    """Every point, fewest photons first."""
    points = []
    for photons, nearest, samples in product(options.photons, options.nearest, options.samples):
        points.append(measure(scene, photons, nearest, samples, options, reference, masks))
        progress(describe(points[-1]))
    return points


def progress(text):
    """A line that is written over on a terminal; nothing elsewhere."""
    if sys.stderr.isatty():
        print(f"\r{text:<60}", end="", file=sys.stderr, flush=True)


def front(points, region):
    """The points that no other beats in both seconds and error, by seconds."""
    kept, best = [], np.inf
    for point in sorted(points, key=lambda point: point["seconds"]):
        if point["error"][region] < best:
            kept.append(point)
            best = point["error"][region]
    return kept


def paired(scenes, pairs, threads):
    """Seconds of whole renders of several scenes at their own settings, in turn.

    Returns
    -------
    ndarray, shape (pairs, scenes)
    """
    seconds = np.zeros((pairs, len(scenes)))
    for scene in scenes:
        cpm.render(scene, photons=10_000, threads=threads)
    for i in range(pairs):
        for j, scene in enumerate(scenes):
            seconds[i, j] = render_seconds(scene, seed=i, threads=threads)[1]
            progress(f"pair {i + 1} of {pairs}: {seconds[i, j]:.2f} s")
    return seconds


def best_ratio(points, peer, region):
    """The point in the window where our error is smallest beside the peer's at equal time, and that ratio."""
    inside = [point for point in points if WINDOW[0] <= point["seconds"] <= WINDOW[1]]
    ratios = [point["error"][region] / error_at(peer, region, point["seconds"]) for point in inside]
    return (inside[int(np.argmin(ratios))], min(ratios)) if inside else (None, float("nan"))


def rays(samples):
    """How many eye rays a pixel, in words."""
    return f"{samples} eye ray{'' if samples == 1 else 's'}"


def describe(point):
    """A point's settings and seconds, in words."""
    if point is None:
        return "none"
    return (f"{point['photons']:g} photons, {point['nearest']} nearest, {rays(point['samples'])}, "
            f"{point['seconds']:.2f} s")


def judge_sweep(points, peer):
    """Print the figures of the homogeneous room."""
    figures, chosen = [], []
    if peer:
        for region, goal in (("shade", 0.3), ("picture", 1.5), ("lit", None), ("edge", None)):
            point, ratio = best_ratio(points, peer, region)
            note = f"at {describe(point)}"
            if goal is not None and point:
                chosen.append(point)
            if region == "edge" and point:
                error, bias = point["error"]["edge"], point["bias"]["edge"]
                note += f"; error {error:.3g}, {bias:.3g} of it bias: {EDGE_LIMIT}"
            what = f"{region}: our error over Mitsuba's at equal time, best of {WINDOW[0]:g} to {WINDOW[1]:g} s"
            figures.append(judge(what, ratio, goal, note=note))
    paper = [point for point in points if (point["photons"], point["nearest"]) == PAPER]
    for where, group, goal in (("worst of the points above that have goals and the paper's", chosen + paper, 0.01),
                               ("worst of the sweep", points, 0.01)):
        if group:
            worst = max(group, key=lambda point: abs(point["mean_ratio"]["picture"] - 1.0))
            mean = worst["mean_ratio"]["picture"]
            figures.append(judge(f"mean radiance off the reference's, {where}", abs(mean - 1.0), goal,
                                 note=f"ratio {mean:.5f} at {describe(worst)}"))
    return figures


def print_points(points, peer):
    table("homogeneous room, 620 nm, relative RMSE (bias) by region",
          ["photons", "nearest", "eye rays", "seconds", *NAMES, "mean ratio"],
          [[f"{point['photons']:g}", point["nearest"], point["samples"], point["seconds"],
            *(f"{point['error'][name]:.4f} ({point['bias'][name]:.4f})" for name in NAMES),
            f"{point['mean_ratio']['picture']:.4f}"] for point in points])
    if peer:
        table("Mitsuba's path tracer", ["spp", "seconds", *NAMES],
              [[point["spp"], point["seconds"], *(point["error"][name] for name in NAMES)] for point in peer])


def draw(points, peer):
    """Four panels, error over seconds."""
    figure, axes = new_figure(2, 2, (11, 9))
    for axis, region in zip(axes.flat, NAMES, strict=True):
        for i, nearest in enumerate(sorted({point["nearest"] for point in points})):
            for marker, samples in zip(MARKERS, sorted({point["samples"] for point in points}), strict=False):
                chosen = [point for point in points if (point["nearest"], point["samples"]) == (nearest, samples)]
                axis.plot([point["seconds"] for point in chosen], [point["error"][region] for point in chosen], marker,
                          color=COLOURS[i % len(COLOURS)], ms=4,
                          label=f"cpm, {nearest} nearest, {rays(samples)}")
        best = front(points, region)
        axis.plot([point["seconds"] for point in best], [point["error"][region] for point in best], "k-", lw=1.5,
                  label="cpm, front")
        if peer:
            axis.plot([point["seconds"] for point in peer], [point["error"][region] for point in peer], "s--",
                      color="tab:red", ms=5, label="Mitsuba 3 path tracer")
        axis.axvspan(*WINDOW, color="0.95", zorder=0)
        axis.set(xscale="log", yscale="log", xlabel="wall seconds", ylabel="relative RMSE", title=region)
        axis.grid(which="both", lw=0.3)
    figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside lower center", ncols=5, fontsize=8)
    counts = [point["photons"] / 1e6 for point in points]
    figure.suptitle(f"Homogeneous cross room, 400 x 300, 620 nm: {min(counts):g} to {max(counts):g} million photons "
                    "(shaded: where the figures count)")
    return figure


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--photons", type=positive, nargs="+", metavar="N",
                        default=[100_000, 300_000, 1_000_000, 3_000_000, 10_000_000, 30_000_000])
    parser.add_argument("--nearest", type=positive, nargs="+", metavar="K", default=[50, 150, 500, 1500])
    parser.add_argument("--samples", type=positive, nargs="+", default=[1, 4], metavar="N", help="eye rays a pixel")
    parser.add_argument("--seeds", type=positive, default=3, metavar="N",
                        help="pictures a point (default: %(default)s)")
    parser.add_argument("--pairs", type=int, default=15, metavar="N",
                        help="curved and homogeneous renders at the paper's setting; 0: none (default: %(default)s)")
    parser.add_argument("--threads", type=int, default=0, metavar="N", help="of both sides (default: all cores)")
    parser.add_argument("--reference", type=Path, default=ROOT / "bench" / "data" / "room_homogeneous_620nm.npz")
    parser.add_argument("--peer-python", default=sys.executable, metavar="PYTHON", help="interpreter that has Mitsuba")
    parser.add_argument("--peer-spp", type=positive, nargs="*", default=[1, 4, 16, 64, 256], metavar="N",
                        help="samples per pixel of the peer's pictures; none: no peer")
    add_arguments(parser)
    return parser.parse_args()


def measure_pairs(options):
    """Curved against homogeneous, and 16 bins against one, in turn."""
    homogeneous, curved, narrow = (cpm.load_scene(path) for path in (HOMOGENEOUS, CURVED, HOMOGENEOUS))
    narrow.render_defaults.wavelengths = [WAVELENGTH]
    seconds = paired([homogeneous, curved, narrow], options.pairs, options.threads)
    ratio, bins = (float(np.median(seconds[:, i] / seconds[:, j])) for i, j in ((1, 0), (0, 2)))
    rows = [[name, *(float(take(seconds[:, i])) for take in (np.min, np.median, np.max))]
            for i, name in enumerate(("homogeneous, 16 bins", "curved (exact), 16 bins", "homogeneous, 1 bin"))]
    print()
    table("whole renders at the paper's setting, seconds", ["room", "least", "median", "most"], rows)
    least = seconds.min(axis=0)
    figures = [judge("curved (exact) over homogeneous, whole render, median of pairs", ratio, 1.3,
                     note=f"least over least {least[1] / least[0]:.3f}; the paper: 1.85"),
               judge("16 bins over one bin, whole render, median of pairs", bins, None)]
    return {"columns": [row[0] for row in rows], "seconds": seconds}, figures


def main():
    options = parse_arguments()
    load = load_average()
    reference = load_reference(options.reference)
    masks = regions(reference["mean"])
    scene = cpm.load_scene(HOMOGENEOUS)
    cpm.render(scene, photons=10_000, wavelengths=[WAVELENGTH], threads=options.threads)

    # The peer before and after: the machine's drift meets both sides alike.
    def peer_run():
        if not options.peer_spp:
            return "not asked for"
        return run_peer(options.peer_python, options.reference, options.peer_spp, options.seeds, options.threads)

    before = peer_run()
    points = sweep(scene, options, reference, masks)
    progress("")
    after = peer_run() if isinstance(before, list) else before
    peer, missing = [], after if isinstance(after, str) else None
    if missing is None:
        peer = curve(before + after)
        drift = sum(line["seconds"] for line in after) / sum(line["seconds"] for line in before)
    print_points(points, peer)
    if missing:
        print(f"no peer: {missing}")
    figures = judge_sweep(points, peer)
    if peer:
        figures.append(judge("Mitsuba after our sweep over Mitsuba before, seconds", drift, None,
                             note="the machine's drift"))
    pairs = None
    if options.pairs:
        pairs, more = measure_pairs(options)
        figures += more
    content = {"load_at_start": load, "wavelength": WAVELENGTH, "seeds": options.seeds, "points": points, "peer": peer,
               "peer_missing": missing, "peer_lines": [] if missing else before + after, "pairs": pairs,
               "reference": {key: reference[key] for key in ("renderer", "spp", "halves")}}
    write(options.results, "room", content, figures, draw(points, peer), ["scipy"])


if __name__ == "__main__":
    main()
