#!/usr/bin/env python3
"""How a render grows: with threads, photons, triangles and bins, in the homogeneous and the curved room.

Each stage's seconds are the least of several renders, taken in turns; the exponent is the slope of log seconds over
log size between the two largest sizes (1: twice the work takes twice the time). Triangles are those of a sphere that
stands in the room and does not grow: what more of them cost is the tree's depth.
"""
import argparse
import os

import numpy as np
from _results import CURVED, HOMOGENEOUS, add_arguments, judge, load_average, new_figure, positive, table, write

import cpm

ROOMS = {"homogeneous": HOMOGENEOUS, "curved": CURVED}
STAGES = ("project", "trace", "map", "gather")
POPULATIONS = ("direct", "later", "caustic")
FIRST, LAST = 400.0, 700.0   # nm, of the film


def ball_of_triangles(rings, radius=0.5, centre=(0.6, 0.8, 0.6)):
    """A sphere of about 4 rings² triangles.

    Returns
    -------
    vertices (V, 3), faces (F, 3)
    """
    theta = np.linspace(0, np.pi, rings + 1)[:, None]
    phi = np.linspace(0, 2 * np.pi, 2 * rings, endpoint=False)[None, :]
    points = np.stack(np.broadcast_arrays(np.sin(theta) * np.cos(phi), np.cos(theta), np.sin(theta) * np.sin(phi)), -1)
    i, j = np.meshgrid(np.arange(rings), np.arange(2 * rings), indexing="ij")
    a, b = i * 2 * rings + j, i * 2 * rings + (j + 1) % (2 * rings)
    faces = np.concatenate([np.stack([a, b, b + 2 * rings], -1)[1:].reshape(-1, 3),
                            np.stack([a, b + 2 * rings, a + 2 * rings], -1)[:-1].reshape(-1, 3)])
    return radius * points.reshape(-1, 3) + centre, faces


def bins_of(count):
    """Centres of equal bins, nm."""
    width = (LAST - FIRST) / count
    return FIRST + width * (np.arange(count) + 0.5)


class Series:
    """One quantity varied, all else as in `base`; renders of all its sizes take turns."""

    def __init__(self, name, sizes, base, repeats):
        self.name, self.sizes, self.base, self.repeats = name, sizes, base, repeats

    def scene(self, room, size):
        scene = cpm.load_scene(ROOMS[room])
        if self.name == "triangles":
            scene.add_mesh(*ball_of_triangles(max(3, round(np.sqrt(size / 4)))), material=cpm.materials.Diffuse(0.5))
        return scene

    def measure(self, room):
        """Seconds of each stage, least of the repeats.

        Returns
        -------
        list of dict
            One a size, with "size", "photons_stored", "total" and the stages.
        """
        settings = {size: {**self.base, self.name: size} for size in self.sizes}
        scenes = {size: self.scene(room, size) for size in (self.sizes if self.name == "triangles" else self.sizes[:1])}
        best = {size: None for size in self.sizes}
        for turn in range(self.repeats + 1):
            for size in self.sizes[::-1] if turn % 2 else self.sizes:
                s = settings[size]
                image = cpm.render(scenes.get(size, scenes[self.sizes[0]]), size=s["size"], photons=s["photons"],
                                   nearest=s["nearest"], wavelengths=bins_of(s["bins"]), threads=s["threads"])
                seconds = {stage: image.stats[f"seconds_{stage}"] for stage in STAGES}
                seconds |= {"total": sum(seconds.values()), "size": size,
                            "photons_stored": sum(image.stats[f"photons_stored_{kind}"] for kind in POPULATIONS)}
                if turn and (best[size] is None or seconds["total"] < best[size]["total"]):   # the first one warms up
                    best[size] = seconds
        return [best[size] for size in self.sizes]


def exponent(rows, stage):
    """Slope of log seconds over log size between the two largest sizes; NaN where the stage did not run."""
    a, b = rows[-2], rows[-1]
    if min(a[stage], b[stage]) <= 0:
        return np.nan
    return float(np.log(b[stage] / a[stage]) / np.log(b["size"] / a["size"]))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--photons", type=positive, default=1_000_000, metavar="N", help="where they are not varied")
    parser.add_argument("--repeats", type=positive, default=3, metavar="N", help="renders of each after a first")
    add_arguments(parser)
    options = parser.parse_args()
    load = load_average()
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    threads = [1 << k for k in range(cores.bit_length()) if 1 << k <= cores]
    base = {"size": (400, 300), "photons": options.photons, "nearest": 150, "bins": 16, "threads": cores}
    series = [Series("threads", threads, base, options.repeats),
              Series("photons", [30_000, 100_000, 300_000, 1_000_000, 3_000_000, 10_000_000], base, options.repeats),
              Series("triangles", [100, 1_000, 10_000, 100_000, 1_000_000], base, options.repeats),
              Series("bins", [1, 4, 16, 64], base, options.repeats)]

    results, figures = {}, []
    figure, axes = new_figure(2, len(series), (4.2 * len(series), 7.5))
    for column, one in enumerate(series):
        results[one.name] = {}
        for row, room in enumerate(ROOMS):
            rows = results[one.name][room] = one.measure(room)
            table(f"{room} room, by {one.name}: seconds of each stage", [one.name, *STAGES, "total"],
                  [[r["size"], *(r[stage] for stage in STAGES), r["total"]] for r in rows])
            axis = axes[row][column]
            for stage in (*STAGES, "total"):
                if all(r[stage] > 0 for r in rows):
                    axis.loglog([r["size"] for r in rows], [r[stage] for r in rows], "o-", label=stage,
                                linewidth=2 if stage == "total" else 1)
            axis.set_xlabel(one.name)
            axis.set_title(f"{room} room")
            axis.grid(alpha=0.3)
            figures += figures_of(one.name, room, rows, cores)
    axes[0][-1].legend(fontsize=8)
    axes[0][0].set_ylabel("seconds")
    axes[1][0].set_ylabel("seconds")
    write(options.results, "scaling", {"base": base, "repeats": options.repeats, "load": load, "results": results},
          figures, figure)


def figures_of(name, room, rows, cores):
    """What a series comes to; none has a goal."""
    first, last = rows[0], rows[-1]
    if name == "threads":
        return [judge(f"{room}: speed-up of {stage} by {last['size']} threads", first[stage] / last[stage], None)
                for stage in ("trace", "map", "gather", "total")] if cores > 1 else []
    if name == "triangles":
        return [judge(f"{room}: seconds with {last['size']} triangles over those with {first['size']}",
                      last["total"] / first["total"], None)]
    return [judge(f"{room}: exponent of {stage} over {name}", exponent(rows, stage), None,
                  note=f"{rows[-2]['size']} to {last['size']}") for stage in ("trace", "map", "gather", "total")]


if __name__ == "__main__":
    main()
