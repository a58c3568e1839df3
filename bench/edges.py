#!/usr/bin/env python3
"""What the correction at edges does (docs/decisions/0005): mean radiance and error in the homogeneous room, with it and
without, and its share of a render.

The reference is that of `bench room` (620 nm, peers/mitsuba_room.py); its own noise is taken out of the errors. Pictures
with and without take turns; seconds are those of the gather, medians.
"""
import argparse
import sys

import numpy as np
from _results import HOMOGENEOUS, ROOT, add_arguments, judge, load_average, new_figure, positive, table, write

sys.path.insert(0, str(ROOT / "bench" / "peers"))
from mitsuba_room import load_reference
from regions import NAMES, regions, relative_rmse

import cpm

WAVELENGTH = 620.0     # nm, of the reference
DARK = 0.5             # of the reference: how dark the darkest line along an edge may be drawn in the picture of ratios


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--photons", type=positive, default=3_000_000, metavar="N", help="paths emitted")
    parser.add_argument("--nearest", type=positive, default=150, metavar="K", help="photons in an estimate")
    parser.add_argument("--seeds", type=positive, default=3, metavar="S", help="pictures with and without each")
    parser.add_argument("--reference", default=ROOT / "bench" / "data" / "room_homogeneous_620nm.npz", metavar="FILE")
    add_arguments(parser)
    options = parser.parse_args()
    load = load_average()
    reference = load_reference(options.reference)
    masks = regions(reference["mean"])
    scene = cpm.load_scene(HOMOGENEOUS)
    cpm.render(scene, size=(16, 12), photons=1000, wavelengths=[WAVELENGTH])  # builds what is kept

    pictures, seconds, totals = {True: [], False: []}, {True: [], False: []}, {True: [], False: []}
    for seed in range(options.seeds):
        photons = cpm.trace_photons(scene, options.photons, wavelengths=[WAVELENGTH], seed=seed)
        for corrected in (True, False) if seed % 2 else (False, True):
            image = cpm.render(scene, photons=photons, nearest=options.nearest, seed=seed, edge_correction=corrected)
            pictures[corrected].append(image.data[..., 0].astype(float))
            seconds[corrected].append(image.stats["seconds_gather"])
            totals[corrected].append(image.stats["seconds_gather"] + sum(
                photons.stats[f"seconds_{stage}"] for stage in ("project", "trace", "map")))

    rows, results = [], {}
    for corrected, name in ((True, "with"), (False, "without")):
        drawn = np.array(pictures[corrected])
        ratio = {region: float(drawn[:, mask].mean() / reference["mean"][mask].mean(dtype=float))
                 for region, mask in masks.items()}
        error = {region: float(np.sqrt(np.mean([relative_rmse(picture, reference["mean"], masks[region],
                                                              reference["variance"]) ** 2 for picture in drawn])))
                 for region in NAMES}
        results[name] = {"mean_ratio": ratio, "error": error, "seconds_gather": float(np.median(seconds[corrected])),
                         "seconds": float(np.median(totals[corrected]))}
        rows.append([name, *(100 * (ratio[region] - 1) for region in NAMES), *(error[region] for region in NAMES),
                     results[name]["seconds_gather"]])
    table("mean radiance less the reference's, %, and relative RMSE, by region; seconds of the gather",
          ["correction", *(f"{region}, %" for region in NAMES), *NAMES, "s"], rows)
    share = float(np.median(np.subtract(seconds[True], seconds[False]) / np.array(totals[True])))
    figures = [judge("mean radiance with the correction over the reference's", results["with"]["mean_ratio"]["picture"], None),
               judge("without", results["without"]["mean_ratio"]["picture"], None),
               judge("the correction's share of a render", share, None)]

    figure, axes = new_figure(1, 2, (11, 4.2))
    for axis, (corrected, name) in zip(axes[0], ((True, "with"), (False, "without")), strict=True):
        lit = reference["mean"] > 1e-6
        ratio = np.where(lit, np.mean(pictures[corrected], axis=0) / np.where(lit, reference["mean"], 1.0), np.nan)
        shown = axis.imshow(ratio, vmin=DARK, vmax=2 - DARK, cmap="RdBu_r")
        axis.set_title(f"{name} the correction")
        axis.set_axis_off()
    figure.colorbar(shown, ax=list(axes[0]), label="radiance over the reference's")
    write(options.results, "edges", {"wavelength": WAVELENGTH, "photons": options.photons, "nearest": options.nearest,
                                     "seeds": options.seeds, "load": load, "results": results}, figures, figure)


if __name__ == "__main__":
    main()
