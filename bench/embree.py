#!/usr/bin/env python3
"""Straight photon tracing against bare rtcIntersect1 calls for the same hits, in the homogeneous cross room.

bench/embree.c keeps the rays of one photon pass, then times the pass (emit, trace, scatter, store; no maps), the
tracer alone on those rays, and rtcIntersect1 alone on them: a ROBUST scene of the same triangles, the same order. The
bare calls find what float finds, and nothing else: no hit polished in double, no surface told from the one that the ray
left.
"""
import argparse
import json
import subprocess
import tempfile
from pathlib import Path

from _program import program
from _results import HOMOGENEOUS, add_arguments, judge, load_average, new_figure, positive, table, write

import cpm

WAVELENGTH = 620.0
STAGES = ("pass_seconds", "follow_seconds", "bare_seconds")


def scene_text(scene):
    """The scene as embree.c reads it; meshes of diffuse paint and spots, at one wavelength."""
    def flat(spectrum):
        return float(spectrum.at([WAVELENGTH])[0])

    lines = []
    for shape in scene.shapes:
        for corners in shape.vertices[shape.faces]:
            lines.append(("triangle", flat(shape.material.reflectance), *corners.ravel()))
    for light in scene.lights:
        lines.append(("spot", flat(light.intensity), light.cutoff, *light.position, *light.target))
    return "".join(" ".join([line[0], *(f"{value:.17g}" for value in line[1:])]) + "\n" for line in lines)


def measure(scene, photons, bins, repeats):
    """What the program prints."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "scene.txt"
        path.write_text(scene_text(scene), encoding="utf-8")
        run = subprocess.run([program("embree"), path, str(photons), str(bins), str(repeats)], capture_output=True,
                             text=True, check=True)
    return json.loads(run.stdout)


def where(result, run):
    """A label: bins and threads of a run."""
    return ", ".join(f"{count} {unit}{'' if count == 1 else 's'}"
                     for count, unit in ((result["bins"], "bin"), (run["threads"], "thread")))


def draw(results):
    """Rays a second of each stage, by bins and threads."""
    figure, ((axis,),) = new_figure(1, 1, (7.5, 4))
    runs = [(result, run) for result in results for run in result["runs"]]
    for k, (stage, name) in enumerate(zip(STAGES, ("photon pass", "tracer alone", "bare rtcIntersect1"), strict=True)):
        axis.bar([i + 0.27 * (k - 1) for i in range(len(runs))],
                 [result["rays"] / run[stage] / 1e6 for result, run in runs], 0.25, label=name)
    axis.set_xticks(range(len(runs)), [where(result, run) for result, run in runs])
    axis.set(ylabel="million rays a second", title="straight photon tracing, homogeneous cross room")
    axis.legend()
    return figure


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--photons", type=positive, default=1_000_000, metavar="N", help="default: 1e6")
    parser.add_argument("--bins", type=positive, nargs="+", default=[1, 16], metavar="B", help="default: 1 16")
    parser.add_argument("--repeats", type=positive, default=7, metavar="N",
                        help="the fastest counts (default: %(default)s)")
    add_arguments(parser)
    return parser.parse_args()


def main():
    options = parse_arguments()
    scene = cpm.load_scene(HOMOGENEOUS)
    program("embree")
    load = load_average()
    results = [measure(scene, options.photons, bins, options.repeats) for bins in options.bins]
    table("seconds, fastest of the repeats",
          ["bins", "threads", "rays", "pass", "tracer alone", "bare", "bare/pass", "bare/tracer", "same hits"],
          [[result["bins"], run["threads"], result["rays"], *(run[stage] for stage in STAGES),
            run["bare_seconds"] / run["pass_seconds"], run["bare_seconds"] / run["follow_seconds"],
            f"{result['same_hits'] / result['rays']:.6f}"] for result in results for run in result["runs"]])
    figures = [judge(f"bare rtcIntersect1 over photon pass, {where(result, run)}",
                     run["bare_seconds"] / run["pass_seconds"], 0.5, at_most=False)
               for result in results for run in result["runs"]]
    write(options.results, "embree", {"load_at_start": load, "results": results}, figures, draw(results))


if __name__ == "__main__":
    main()
