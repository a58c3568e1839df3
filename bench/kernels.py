#!/usr/bin/env python3
"""The OpenCL kernels against the native backend, in one run: rays, photon pass, eye pass; what building them costs.

Both backends run in turns and are compared by processor seconds, of all threads: PoCL runs on the same cores. Error
against run time: pictures of the curved room against one of far more photons, by each backend. Builds start from empty
caches in a process of their own.

    cpm bench kernels -- --photons 1e6
"""

import argparse
import os
import resource
import subprocess
import sys
import tempfile
import time

import numpy as np
from _results import CURVED, add_arguments, judge, load_average, new_figure, positive, table, write

import cpm

BACKENDS = ("native", "opencl")
#: Kernel files that the homogeneous diffuse room's programs are built from.
HOMOGENEOUS_ROOM = ("start_delta", "follow_straight", "meet", "eye", "eye_gather")
#: One render of nothing much, in a process of its own: what is left is starting and building.
TINY = (
    "import sys, cpm; "
    "cpm.render(cpm.load_scene(sys.argv[1]), size=(2, 2), photons=64, nearest=4, backend=sys.argv[2])"
)


def spent(work):
    """Processor seconds of all threads, and seconds on the clock."""
    cpu, clock = time.process_time(), time.perf_counter()
    work()
    return time.process_time() - cpu, time.perf_counter() - clock


def in_turns(work, repeats):
    """Least processor and clock seconds of each backend, after one run that warms up."""
    best = {}
    for turn in range(repeats + 1):
        for backend in BACKENDS:
            cpu, clock = spent(lambda backend=backend: work(backend))
            if turn:
                old = best.get(backend, (np.inf, np.inf))
                best[backend] = (min(cpu, old[0]), min(clock, old[1]))
    return best


def rays(count, precision):
    """A fibre, 200 steps of RK4 each: no geometry."""
    rng = np.random.default_rng(1)
    medium = cpm.media.Parabolic(1.5, 0.4)
    origins = rng.uniform(-0.2, 0.2, (count, 3))
    directions = np.column_stack([rng.uniform(-0.1, 0.1, (count, 2)), np.ones(count)])
    return lambda backend: cpm.trace(
        medium,
        origins,
        directions,
        wavelength=550.0,
        length=2.0,
        method="rk4",
        step=0.01,
        backend=backend,
        precision=precision,
    )


def builds(scene):
    """Processor seconds that programs take from empty caches, and from full ones, beyond the native backend's start."""
    with tempfile.TemporaryDirectory() as folder:
        env = {**os.environ, "CPM_CACHE_DIR": folder, "POCL_CACHE_DIR": folder}

        def run(backend):
            before = resource.getrusage(resource.RUSAGE_CHILDREN)
            subprocess.run([sys.executable, "-c", TINY, scene, backend], env=env, check=True)
            after = resource.getrusage(resource.RUSAGE_CHILDREN)
            return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime

        native = min(run("native") for _ in range(3))
        return run("opencl") - native, min(run("opencl") for _ in range(3)) - native


def source_bytes():
    """Of the homogeneous diffuse room's programs, and of all that there are."""
    size = {name: len(cpm.kernels.source(name)) for name in cpm.kernels.names()}
    return sum(size[name] for name in HOMOGENEOUS_ROOM), sum(size.values())


def errors(options):
    """Error against processor seconds, both backends: list of (backend, photons, seconds, relative RMSE)."""
    scene = cpm.load_scene(CURVED)
    size = (120, 90)
    reference = cpm.render(scene, size=size, photons=8 * options.photons, nearest=150, seed=99).data.astype(float)
    rows = []
    for photons in (options.photons // 64, options.photons // 16, options.photons // 4, options.photons):
        for backend in BACKENDS:
            made, cpu = {}, np.inf
            for _ in range(2):  # the first one warms up

                def draw(made=made, photons=photons, backend=backend):
                    made["image"] = cpm.render(scene, size=size, photons=photons, nearest=150, seed=1, backend=backend)

                cpu = min(cpu, spent(draw)[0])
            off = made["image"].data - reference
            rows.append((backend, photons, cpu, float(np.sqrt(np.mean(off**2) / np.mean(reference**2)))))
    return rows


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--photons", type=positive, default=1_000_000, metavar="N")
    parser.add_argument("--rays", type=positive, default=100_000, metavar="N")
    parser.add_argument("--repeats", type=positive, default=3, metavar="N")
    add_arguments(parser)
    options = parser.parse_args()
    load = load_average()
    scene = cpm.load_scene(CURVED)
    photons = cpm.trace_photons(scene, options.photons, seed=1)
    work = {
        "rays, double": rays(options.rays, "double"),
        "rays, single": rays(options.rays, "single"),
        "photon pass": lambda backend: cpm.trace_photons(scene, options.photons, seed=1, backend=backend),
        "eye pass": lambda backend: cpm.render(scene, size=(800, 600), photons=photons, nearest=150, backend=backend),
    }
    seconds = {name: in_turns(one, options.repeats) for name, one in work.items()}
    table(
        "processor seconds, curved room",
        ["what", "native", "OpenCL", "OpenCL over native"],
        [[name, s["native"][0], s["opencl"][0], s["opencl"][0] / s["native"][0]] for name, s in seconds.items()],
    )
    cold, warm = builds(CURVED)
    room, full = source_bytes()
    rows = errors(options)
    table("error against run time, curved room", ["backend", "photons", "processor s", "relative RMSE"], rows)

    ratio = {name: s["opencl"][0] / s["native"][0] for name, s in seconds.items()}
    figures = [
        judge("photon pass, OpenCL over native", ratio["photon pass"], 1.2),
        judge("eye pass, OpenCL over native", ratio["eye pass"], 1.2),
        judge("rays without geometry, double, native over OpenCL", 1 / ratio["rays, double"], 0.6, at_most=False),
        judge("rays without geometry, single, native over OpenCL", 1 / ratio["rays, single"], 0.6, at_most=False),
        judge("cold build of the curved room's programs, s", cold, 5.0, note="of the processor"),
        judge("warm start, s", warm, 0.2, note="of the processor"),
        judge("source of the homogeneous diffuse room over that of all kernels", room / full, 0.4),
    ]
    figure, axes = new_figure(1, 1, (6, 4.5))
    axis = axes[0][0]
    for backend in BACKENDS:
        mine = [r for r in rows if r[0] == backend]
        axis.loglog([r[2] for r in mine], [r[3] for r in mine], "o-" if backend == "native" else "s--", label=backend)
    axis.set_xlabel("processor seconds, whole render")
    axis.set_ylabel("relative RMSE")
    axis.set_title("curved room, 120 x 90, 16 bins")
    axis.grid(alpha=0.3, which="both")
    axis.legend()
    write(
        options.results,
        "kernels",
        {
            "photons": options.photons,
            "rays": options.rays,
            "load": load,
            "seconds": seconds,
            "cold": cold,
            "warm": warm,
            "source_bytes": {"room": room, "full": full},
            "errors": rows,
        },
        figures,
        figure,
        packages=("pyopencl",),
    )


if __name__ == "__main__":
    main()
