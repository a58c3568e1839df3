#!/usr/bin/env python3
"""The hot road: error of mirages against seconds and evaluations, ours beside the two classical ways of drawing them.

Berger, Trout and Levit (IEEE Computer Graphics and Applications 10(3), 36, 1990) cut the hot air into layers of
constant index and let Snell bend rays at each: `Layered(..., interpolation="step")`. Musgrave (ibid. 10(6), 10, 1990)
answered that total reflection is what counts and that a purely reflective model might do: rays are straight, and those
that come flatter than the critical angle are reflected by a plane. That is a step medium of two layers, air above and
the hottest air below, whose face is the mirror; rays that pass it go on to the road. Ours: `Atmosphere` (a cubic spline
of n) by the integrators, and `Layered(..., interpolation="linear-squared")`, a parabola in each layer.

The scene is examples/inferior_mirage.toml. Two errors, in radians at the camera. Vanishing line: the angle under which
rays begin to meet the road, by search with a plane at height 0, off arccos(n(0)/n(camera)). Images: rays that do not
meet the road, from the vanishing line up to 10 mrad above the horizon, to the lorry's distance; the heights that they
reach, off the reference's, over the distance. The reference is the tests' (`tests/oracles/mirage.py`): its own air, and
SciPy's DOP853 at 1e-12. All at 550 nm. Rays within 1e-5 rad of the vanishing line are left out of the images: what a
method makes of them is the other error.

Cost of pictures: examples/inferior_mirage.toml with 16 bins and 150 photons, in turn with the same scene in homogeneous
air; process seconds (CPU time of all threads), the photon pass (once) and the eye pass (in turn) apart.
"""
import argparse
import sys
import time

import numpy as np
from _results import EXAMPLES, ROOT, add_arguments, judge, load_average, new_figure, positive, table, write

sys.path.insert(0, str(ROOT / "tests"))
from oracles import mirage as oracle

import cpm

SCENE = EXAMPLES / "inferior_mirage.toml"
WAVELENGTH, EYE, DISTANCE, HIGHEST = 550.0, 1.2, 430.0, 0.01
COUNTS = (4, 8, 16, 32, 64, 128, 256, 512, 1024)
TOLERANCES = [10.0**-k for k in range(2, 11)]
MIRRORS = (0.005, 0.05, 0.1, 0.15, 0.2)   # heights of Musgrave's plane, metres
GOAL = 1e-6


def layered(profile, count, interpolation):
    """n(h) as about `count` layers of the heat and a fifth as many above, to where no ray comes.

    Steps of equal difference of n, each with the n of its middle; but the lowest has the road's, else the vanishing
    line would be off by half a step whatever else is done. Lines of equal error: thinner where n bends more.
    """
    part = np.linspace(0.0, 1.0, count, endpoint=False)
    if interpolation == "step":
        heights = -profile.thickness * np.log(1.0 - part * (1.0 - 1e-4))
    else:
        heights = -2.0 * profile.thickness * np.log(1.0 - part * (1.0 - 1e-2))
    above = np.linspace(heights[-1], EYE + 1.05 * HIGHEST * DISTANCE, max(2, count // 5) + 1)
    heights = np.concatenate([heights, above[1:]])
    n = 1.0 + profile.refractivity(heights, WAVELENGTH)
    if interpolation == "step":
        n[1:-1] = 0.5 * (n[1:-1] + n[2:])
        return cpm.media.Layered(np.concatenate([[-1.0], heights[1:]]), n, interpolation="step")
    return cpm.media.Layered(heights, n, interpolation="linear-squared")


def musgrave(profile, height):
    """A mirror at `height` for what is flatter than the critical angle of the air at the road."""
    n = 1.0 + profile.refractivity(np.array([0.0, EYE]), WAVELENGTH)
    return cpm.media.Layered([-1.0, height], n, interpolation="step")


def forward(angles):
    return np.column_stack([np.cos(angles), np.sin(angles), 0 * angles])


def vanishing(medium, how):
    """Angle under which rays begin to meet the road, rad, by 24-fold division."""
    scene = cpm.Scene(medium, extent=cpm.Box((-1, -1, -1), (3000, 50, 1)), **how)
    scene.add_mesh([(0, 0, -1), (3000, 0, -1), (3000, 0, 1), (0, 0, 1)], [(0, 2, 1), (0, 3, 2)], cpm.materials.Black())
    low, high = -0.05, 0.0
    for _ in range(9):
        angles = np.linspace(low, high, 25)
        rays = cpm.trace(scene, np.tile((0.0, EYE, 0.0), (25, 1)), forward(angles), wavelength=WAVELENGTH)
        landed = np.flatnonzero(rays.status == cpm.RayStatus.HIT)
        if not landed.size:
            return low
        i = min(landed[-1], 23)
        low, high = angles[i], angles[i + 1]
    return 0.5 * (low + high)


def measure(name, label, medium, how, angles, reference, line, options):
    """One point: both errors, evaluations and process seconds for a ray."""
    origins, directions = np.tile((0.0, EYE, 0.0), (angles.size, 1)), forward(angles)
    took = []
    for _ in range(options.repeats):
        begun = time.process_time()
        rays = cpm.trace(medium, origins, directions, wavelength=WAVELENGTH,
                         until=((DISTANCE, 0, 0), (1, 0, 0)), threads=1, **how)
        took.append(time.process_time() - begun)
    arrived = rays.status == cpm.RayStatus.ARRIVED
    off = np.abs(rays.position[arrived, 1] - reference[arrived]) / DISTANCE
    return {"name": name, "label": label, "vanishing": abs(vanishing(medium, how) - line),
            "images_rms": float(np.sqrt(np.mean(off**2))), "images_median": float(np.median(off)),
            "images_worst": float(off.max()),
            "lost": int((~arrived).sum()), "evaluations": float(rays.evaluations.mean()),
            "seconds": min(took) / angles.size}


def points(options):
    """Every method's points."""
    profile = cpm.load_scene(SCENE).medium.profile
    air = oracle.Air(oracle.hot_surface(profile.excess, profile.thickness), wavelength=WAVELENGTH, top=60.0)
    line = oracle.vanishing(air, EYE)
    angles = np.linspace(line + 1e-5, HIGHEST, options.rays)
    reference = oracle.curve(air, EYE, angles, DISTANCE)
    atmosphere = cpm.media.Atmosphere(profile, radius=None)
    found = []

    def add(name, label, medium, **how):
        found.append(measure(name, label, medium, how, angles, reference, line, options))

    for height in MIRRORS:
        add("Musgrave's mirror", f"at {100 * height:g} cm", musgrave(profile, height))
    for count in COUNTS:
        add("Berger and Trout's layers", f"{count} layers", layered(profile, count, "step"))
    for count in COUNTS:
        add("layers of linear n²", f"{count} layers", layered(profile, count, "linear-squared"))
    for rtol in TOLERANCES:
        add("spline of n, auto", f"rtol {rtol:.0e}", atmosphere, rtol=rtol)
    table("hot road, 550 nm: errors in rad at the camera; a ray's cost",
          ["method", "", "vanishing line", "images rms", "median", "worst", "evaluations", "us/ray", "lost"],
          [[p["name"], p["label"], f"{p['vanishing']:.1e}", f"{p['images_rms']:.1e}", f"{p['images_median']:.1e}",
            f"{p['images_worst']:.1e}", round(p["evaluations"], 1), 1e6 * p["seconds"], p["lost"]] for p in found])
    return found


def best(found, name, key="images_rms"):
    return min(p[key] for p in found if p["name"] == name)


def cheapest(found, name, error):
    """Least seconds a ray whose images' rms is at most `error`; None: none."""
    return min((p["seconds"] for p in found if p["name"] == name and p["images_rms"] <= error), default=None)


def cost(options):
    """Process seconds of both passes, curved and homogeneous in turn."""
    scene = cpm.load_scene(SCENE)
    air = scene.medium
    layers = cpm.media.Layered(air.heights, air.n)
    media = {"homogeneous": cpm.media.Homogeneous(float(1 + air.profile.refractivity(EYE, WAVELENGTH))),
             "one index for all wavelengths": layers, "air": air}
    seconds, maps = {name: {"photons": [], "eye": []} for name in media}, {}
    for name, medium in media.items():
        begun = time.process_time()
        maps[name] = cpm.trace_photons(scene.copy(medium=medium), options.photons)
        seconds[name]["photons"].append(time.process_time() - begun)
    for _ in range(options.pairs):
        for name, medium in media.items():
            begun = time.process_time()
            image = cpm.render(scene.copy(medium=medium), photons=maps[name])
            seconds[name]["eye"].append(time.process_time() - begun)
            seconds[name]["stats"] = {key: image.stats[key] for key in ("eye_segments", "eye_evaluations", "gathers")}
    base = seconds["homogeneous"]
    rows, result = [], {}
    for name, s in seconds.items():
        ratios = {"eye": float(np.median(np.divide(s["eye"], base["eye"]))),
                  "photons": float(np.median(np.divide(s["photons"], base["photons"]))),
                  "whole": sum(map(np.median, (s["photons"], s["eye"])))
                  / sum(map(np.median, (base["photons"], base["eye"])))}
        result[name] = {**s, "over_homogeneous": ratios}
        rows.append([name, float(np.median(s["photons"])), ratios["photons"], float(np.median(s["eye"])), ratios["eye"],
                     ratios["whole"]])
    table(f"inferior_mirage.toml, {options.photons} photons, process seconds; {options.pairs} eye passes each, in turn",
          ["n", "photons s", "x", "eye s", "x", "whole x"], rows)
    return result


def transfer():
    """(title, apparent angle mrad, height m by the reference, by the library) of the two scenes over the sea."""
    lids = {"superior_mirage": [(25.0, 8.0, 12.0)], "fata_morgana": [(15.0, 3.0, 4.0), (30.0, 6.0, 5.0)]}
    angles = np.linspace(-2.3e-3, 4.3e-3, 700)
    for name, layers in lids.items():
        scene = cpm.load_scene(EXAMPLES / f"{name}.toml")
        eye, medium, distance = scene.camera.origin[1], scene.medium, 20e3
        air = oracle.Air(*[oracle.inversion(*lid) for lid in layers], wavelength=WAVELENGTH, finest=0.25, top=400.0)
        seen = oracle.curve(air, eye, angles, distance, medium.radius)
        rays = cpm.trace(medium, np.tile((0.0, eye, 0.0), (angles.size, 1)), forward(angles), wavelength=WAVELENGTH,
                         until=((distance, 0, 0), (1, 0, 0)), rtol=1e-9)
        y = rays.position[:, 1]
        height = (2 * medium.radius * y + y**2 + distance**2) / (medium.radius + np.hypot(distance, medium.radius + y))
        yield name, eye, 1e3 * angles, seen, np.where(np.isnan(seen), np.nan, height)


def pictures(options):
    """A figure of the same road by the three ways, from the horizon down: what each loses is at the vanishing line."""
    scene = cpm.load_scene(SCENE)
    profile = scene.medium.profile
    media = {"curved rays: a spline of n": cpm.media.Layered(scene.medium.heights, scene.medium.n),
             "Berger and Trout: 8 layers": layered(profile, 8, "step"),
             "Musgrave: a mirror under the critical angle": musgrave(profile, MIRRORS[0])}
    figure, axes = new_figure(len(media), 1, (10.0, 6.6))
    exposure = None
    for axis, (name, medium) in zip(axes[:, 0], media.items(), strict=True):
        image = cpm.render(scene.copy(medium=medium), photons=max(1, options.photons // 10))
        xyz = image.to_xyz()[..., 1]
        exposure = 1.0 / np.quantile(xyz[xyz > 0], 0.99) if exposure is None else exposure
        axis.imshow(np.clip(image.to_rgb(exposure=exposure)[150:330], 0, 1), interpolation="nearest")
        axis.set(xticks=[], yticks=[])
        axis.set_title(name, fontsize=9)
    return figure


def draw(found, curves):
    """Both errors over seconds; the transfer curves."""
    figure, axes = new_figure(1, 4, (20.0, 4.8))
    names = list(dict.fromkeys(p["name"] for p in found))
    for axis, key, title in ((axes[0, 0], "images_rms", "images, rms"), (axes[0, 1], "vanishing", "vanishing line")):
        for name, mark in zip(names, "xs+o", strict=True):
            chosen = [p for p in found if p["name"] == name]
            axis.plot([1e6 * p["seconds"] for p in chosen], [max(p[key], 1e-12) for p in chosen], f"{mark}-", ms=5,
                      label=name)
        axis.axhline(GOAL, color="0.5", ls=":", label="1e-6 rad")
        axis.set(xscale="log", yscale="log", xlabel="process microseconds a ray", ylabel="error, rad at the camera",
                 title=f"hot road: {title}")
        axis.grid(which="both", lw=0.3)
    axes[0, 0].legend(fontsize=7)
    for axis, (name, eye, angles, seen, ours) in zip(axes[0, 2:], curves, strict=True):
        axis.plot(angles, seen, color="0.6", lw=4, label="reference")
        axis.plot(angles, ours, color="tab:blue", lw=1, label="cpm.trace")
        axis.set(xlabel="apparent, mrad above the horizontal", ylabel="height at 20 km, m", ylim=(0, 60),
                 title=f"{name}, camera at {eye:g} m")
        axis.grid(lw=0.3)
        axis.legend(fontsize=7)
    return figure


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rays", type=positive, default=2000, metavar="N", help="of each point (default: %(default)s)")
    parser.add_argument("--repeats", type=positive, default=3, metavar="N", help="(default: %(default)s)")
    parser.add_argument("--photons", type=positive, default=3_000_000, metavar="N",
                        help="of the pictures (default: %(default)s)")
    parser.add_argument("--pairs", type=positive, default=3, metavar="N",
                        help="pictures of each medium (default: %(default)s)")
    add_arguments(parser)
    return parser.parse_args()


def main():
    options = parse_arguments()
    load = load_average()
    found = points(options)
    curves = list(transfer())
    costs = cost(options)
    figures = [judge("images by the spline, default tolerance: worst error, rad",
                     next(p["images_worst"] for p in found if p["label"] == "rtol 1e-06"), GOAL),
               judge("vanishing line likewise, rad",
                     next(p["vanishing"] for p in found if p["label"] == "rtol 1e-06"), GOAL)]
    for name in ("Musgrave's mirror", "Berger and Trout's layers"):
        reached = best(found, name)
        ours = {other: cheapest(found, other, reached) for other in ("layers of linear n²", "spline of n, auto")}
        theirs = cheapest(found, name, reached)
        figures.append(judge(f"{name}: least rms error of images, rad", reached, None,
                             note=", ".join(f"{other} at that error: {seconds / theirs:.2g} x its seconds"
                                            for other, seconds in ours.items() if seconds is not None)))
    for name, _, _, seen, ours in curves:
        figures.append(judge(f"{name}: heights off the reference over 20 km, worst, rad",
                             float(np.nanmax(np.abs(seen - ours)) / 20e3), GOAL))
    for name in ("one index for all wavelengths", "air"):
        ratios = costs[name]["over_homogeneous"]
        figures.append(judge(f"eye pass over homogeneous, {name}", ratios["eye"], 1.3))
        figures.append(judge(f"photons and eye over homogeneous, {name}", ratios["whole"], None))
    content = {"load_at_start": load, "settings": {"rays": options.rays, "photons": options.photons,
                                                   "distance": DISTANCE, "wavelength": WAVELENGTH},
               "points": found, "costs": costs}
    write(options.results, "mirage", content, figures, draw(found, curves), ["scipy"])
    pictures(options).savefig(options.results / "mirage-pictures.png", dpi=110)


if __name__ == "__main__":
    main()
