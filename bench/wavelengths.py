#!/usr/bin/env python3
"""Which wavelengths, and how many go one way: error against run time.

Samplings: the upper limb of a setting Sun, 4″ a pixel (a green rim), in 4 to 64 bins of equal width, of equal
refraction and of equal contribution, against 256. Error: of XYZ, root mean square over that of the reference, over the
whole picture and over its rim (pixels that are neither dark nor full); and CIEDE2000, mean over the rim.

Bundles: what `bundle_tolerance` saves, in CPU seconds of a whole render, paths followed and gathers, and what it costs.
"eye": direct light from one photon map with eye rays bundled, against each wavelength its own; "photons": the same with
photons bundled and eye rays apart. All photons within a disc of fixed radius count there, and paints are dim, so that
pictures differ by where paths lie alone. "noise": two seeds' pictures, over √2. All are root mean squares over the
mean, all bins.
"""
import argparse
import time
import warnings

import numpy as np
from _results import add_arguments, judge, load_average, new_figure, positive, table, write
from _wavelength_scenes import EYE, dim, limb, road, room, sunlight

import cpm
from cpm import wavelengths

LOW, HIGH = 400.0, 700.0
BINS = (4, 6, 8, 12, 16, 24, 32, 48, 64)
REFERENCE = 256
TOLERANCES = (0.0, 0.03, 0.1, 0.3, 1.0)
GOOD = 1.0   # CIEDE2000, mean over the rim


def samplers():
    """Name → Bins of a number of bins."""
    profile = cpm.atmosphere.Polytropic(288.15, 101325.0)
    grid = np.arange(LOW, HIGH + 1.0)
    sun = (grid, sunlight(grid))
    return {"equal": lambda n: wavelengths.equal(LOW, HIGH, n),
            "refraction": lambda n: wavelengths.by_refraction(profile, LOW, HIGH, n, height=EYE),
            "contribution": lambda n: wavelengths.by_contribution(LOW, HIGH, n, illuminant=sun)}


def timed_render(scene, rounds=1, **options):
    """An image, and CPU seconds: the least of several."""
    seconds = []
    for _ in range(rounds):
        start = time.process_time()
        image = cpm.render(scene, **options)
        seconds.append(time.process_time() - start)
    return image, min(seconds)


def delta_e(xyz, reference):
    """CIEDE2000 of each pixel; the reference's brightest is white in luminance."""
    import colour

    white = reference[..., 1].max()
    labs = [colour.XYZ_to_Lab(x / white, colour.CCS_ILLUMINANTS["CIE 1931 2 Degree Standard Observer"]["D65"])
            for x in (np.maximum(xyz, 0.0), reference)]
    return colour.delta_E(*labs, method="CIE 2000")


def errors(image, reference, rim):
    xyz = image.to_xyz()
    off, size = xyz - reference, reference
    return {"picture": np.sqrt(np.mean(off**2) / np.mean(size**2)),
            "rim": np.sqrt(np.mean(off[rim] ** 2) / np.mean(size[rim] ** 2)),
            "delta_e": float(delta_e(xyz, reference)[rim].mean())}


def compare_samplings(options):
    scene, made = limb(), samplers()
    reference = cpm.render(scene, wavelengths=made["equal"](REFERENCE), bundle_tolerance=0).to_xyz()
    y = reference[..., 1] / reference[..., 1].max()
    rim = (y > 1e-3) & (y < 0.95)
    other = cpm.render(scene, wavelengths=made["refraction"](REFERENCE), bundle_tolerance=0)
    content = {"rim_pixels": int(rim.sum()), "reference_to_refraction_256": errors(other, reference, rim), "points": []}
    rows = []
    for n in BINS:
        for name, bins_of in made.items():
            bins = bins_of(n)
            image, seconds = timed_render(scene, options.rounds, wavelengths=bins, bundle_tolerance=0)
            point = {"sampling": name, "bins": n, "seconds": seconds, "evaluations": image.stats["eye_evaluations"],
                     **errors(image, reference, rim)}
            content["points"].append(point)
            rows.append([n, name, seconds, point["picture"], point["rim"], point["delta_e"]])
        print(f"{n} bins", flush=True)
    table(f"the last limb: error against {REFERENCE} equal bins ({rim.sum()} pixels of rim; 256 by refraction: "
          f"{content['reference_to_refraction_256']['rim']:.1e} there)",
          ["bins", "sampling", "CPU s", "XYZ, picture", "XYZ, rim", "ΔE2000, rim"], rows)
    fewest = {name: next((p["bins"] for p in content["points"] if p["sampling"] == name and p["delta_e"] <= GOOD), None)
              for name in made}
    content["fewest_bins_for_delta_e_1"] = fewest
    figures = [judge(f"bins for a mean CIEDE2000 of {GOOD:g} on the rim, {name}", fewest[name] or np.inf, None)
               for name in made]
    at = {(p["sampling"], p["bins"]): p for p in content["points"]}
    for name in ("refraction", "contribution"):
        ratio = np.exp(np.mean([np.log(at[name, n]["rim"] / at["equal", n]["rim"]) for n in BINS]))
        figures.append(judge(f"XYZ error on the rim over that of equal steps, {name}, geometric mean", ratio, None))
    return content, figures


SCENES = {   # how to make it, bins, and the disc (m) in which photons are counted for errors; None: nothing but the Sun
    "limb, 4″ a pixel, 64 bins": (limb, wavelengths.equal(LOW, HIGH, 64), None),
    "hot road, 10″ a pixel": (road, None, 0.25),
    "room in air": (lambda: room("air", 1.00056, -2e-5), None, 0.1),
    "room in F2": (lambda: room("F2"), None, 0.1),
}


def relative(image, other):
    return float(np.sqrt(np.mean((image.data.astype(float) - other.data) ** 2)) / other.data.mean(dtype=float))


def noise_of(scene, image, tolerance):
    """Of one picture, by another seed's."""
    return relative(image, cpm.render(scene, seed=99, bundle_tolerance=tolerance)) / np.sqrt(2)


def costs_of_sharing(scene, disc, tolerances):
    """Errors of bundled eye rays, and of bundled photons, in direct light: lists."""
    scene, fixed = dim(scene), {"nearest": 1_000_000, "max_radius": disc}
    apart = cpm.trace_photons(scene, bundle_tolerance=0)
    exact = cpm.render(scene, photon_map=apart, bundle_tolerance=0, **fixed)
    eye = [relative(cpm.render(scene, photon_map=apart, bundle_tolerance=t, **fixed), exact) for t in tolerances]
    photons = [relative(cpm.render(scene, photon_map=cpm.trace_photons(scene, bundle_tolerance=t), bundle_tolerance=0,
                                   **fixed), exact) for t in tolerances]
    return eye, photons


def compare_bundles(options):
    content, rows, figures = {}, [], []
    for name, (make, bins, disc) in SCENES.items():
        scene, points, whole = make(), [], None
        for tolerance in TOLERANCES:
            image, seconds = timed_render(scene, options.rounds, wavelengths=bins, bundle_tolerance=tolerance)
            stats = image.stats
            point = {"tolerance": tolerance, "seconds": seconds,
                     "paths": stats["photon_segments"] + stats["eye_segments"], "gathers": stats["gathers"]}
            whole = whole or image
            point["over_apart"] = {k: point[k] / (points or [point])[0][k] if point[k] else None
                                   for k in ("seconds", "paths", "gathers")}
            if disc is None:
                point["eye"] = relative(image, whole)
            else:
                point["noise"] = noise_of(scene, image, tolerance)
            points.append(point)
        if disc is not None:
            for point, eye, photons in zip(points, *costs_of_sharing(scene, disc, TOLERANCES), strict=True):
                point["eye"], point["photons"] = eye, photons
        for point in points:
            over = point["over_apart"]
            rows.append([name, point["tolerance"], over["seconds"], over["paths"], over["gathers"], point["eye"],
                         point.get("photons"), point.get("noise")])
        usual = next(point for point in points if point["tolerance"] == 0.1)
        figures.append(judge(f"bundles, {name}, tolerance 0.1: CPU seconds over each wavelength apart",
                             usual["over_apart"]["seconds"], None))
        if disc is not None:
            figures.append(judge(f"bundles, {name}, tolerance 0.1: error of eye and photons over the picture's noise",
                                 np.hypot(usual["eye"], usual["photons"]) / usual["noise"], 1.0))
        content[name] = points
        print(name, flush=True)
    table("bundles: cost over that of each wavelength apart, and error", ["scene", "tolerance", "CPU s", "paths",
          "gathers", "eye", "photons", "noise"], rows)
    return content, figures


def draw(samplings, bundles):
    figure, axes = new_figure(1, 3, (15.5, 4.6))
    marks = dict(zip(samplers(), "os^", strict=True))
    for axis, key, label in ((axes[0, 0], "rim", "relative RMSE of XYZ on the rim"),
                             (axes[0, 1], "delta_e", "CIEDE2000, mean over the rim")):
        for name, mark in marks.items():
            points = [p for p in samplings["points"] if p["sampling"] == name]
            axis.plot([p["seconds"] for p in points], [p[key] for p in points], f"{mark}-", ms=5, label=name)
            if key == "rim":
                for p in points:
                    if p["bins"] in (4, 16, 64):
                        axis.annotate(p["bins"], (p["seconds"], p[key]), textcoords="offset points", xytext=(4, 4),
                                      fontsize=7)
        axis.set(xscale="log", yscale="log", xlabel="CPU seconds", ylabel=label,
                 title="the last limb of the Sun, 4 to 64 bins")
        axis.set_xticks([0.2, 0.5, 1, 2], ["0.2", "0.5", "1", "2"])
        axis.set_xticks([], minor=True)
        axis.grid(which="both", lw=0.3)
        axis.legend(fontsize=8)
    axis = axes[0, 2]
    for (name, points), colour in zip(bundles.items(), ("tab:blue", "tab:orange", "tab:green", "tab:red"), strict=True):
        if "photons" not in points[0]:
            continue   # the Sun alone, as bright everywhere: no error
        off = [np.hypot(p["eye"], p["photons"]) for p in points]
        axis.plot([p["over_apart"]["seconds"] for p in points[1:]], off[1:], "o-", ms=4, color=colour, label=name)
        axis.plot([p["over_apart"]["seconds"] for p in points], [p["noise"] for p in points], "+:", color=colour,
                  lw=0.8)
        for p, y in zip(points[1:], off[1:], strict=True):
            axis.annotate(f"{p['tolerance']:g}", (p["over_apart"]["seconds"], y), textcoords="offset points",
                          xytext=(4, 4), fontsize=7)
    axis.set(xscale="log", yscale="log", xlabel="CPU seconds over each wavelength apart",
             ylabel="error of eye rays and photons (+: noise)", title="bundle_tolerance 0.03 to 1")
    axis.grid(which="both", lw=0.3)
    axis.legend(fontsize=7)
    return figure


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=positive, default=2, metavar="N", help="renders timed, the least counts "
                        "(default: %(default)s)")
    add_arguments(parser)
    options = parser.parse_args()
    load = load_average()
    warnings.simplefilter("ignore", UserWarning)
    samplings, figures = compare_samplings(options)
    bundles, more = compare_bundles(options)
    write(options.results, "wavelengths", {"load_at_start": load, "samplings": samplings, "bundles": bundles},
          figures + more, draw(samplings, bundles), ["colour-science"])


if __name__ == "__main__":
    main()
