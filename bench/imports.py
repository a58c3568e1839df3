#!/usr/bin/env python3
"""Seconds of `import cpm` over `import numpy`, and peak memory of the curved room at the paper's setting.

Each import in a fresh interpreter, in turn with the other; the median of the differences counts. Memory is the kernel's
high-water mark of a process that does nothing but load the scene and render it.
"""
import argparse
import json
import subprocess
import sys
import time

import numpy as np
from _results import CURVED, add_arguments, judge, load_average, new_figure, positive, table, write

# What the package promises to import late.
LATE = ("colour", "matplotlib", "trimesh", "pydantic", "rich", "typer", "pyopencl", "scipy")

LOADED = "import sys, cpm; print(*(name for name in sys.argv[1:] if name in sys.modules))"

# VmHWM belongs to this program's own memory; ru_maxrss starts at what the parent had when it forked.
RENDER = """
import json, resource, sys
def peak():
    for line in open("/proc/self/status"):
        if line.startswith("VmHWM"):
            return int(line.split()[1]) * 1024
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
marks = {}
import cpm
marks["import cpm"] = peak()
scene = cpm.load_scene(sys.argv[1])
marks["load_scene"] = peak()
image = cpm.render(scene)
marks["render"] = peak()
image.to_rgb()
marks["to_rgb"] = peak()
stats = {key: value for key, value in image.stats.items() if isinstance(value, (int, float))}
print(json.dumps({"marks": marks, "stats": stats, "maxrss": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024}))
"""


def run_seconds(statement):
    """Wall seconds of a fresh interpreter that runs one statement."""
    start = time.perf_counter()
    subprocess.run([sys.executable, "-c", statement], check=True)
    return time.perf_counter() - start


def import_seconds(pairs):
    """Seconds (pairs, 2) of interpreters that import numpy, and cpm, in turn; the first, cold, pair is dropped."""
    return np.array([[run_seconds("import numpy"), run_seconds("import cpm")] for _ in range(pairs + 1)][1:])


def heaviest(count):
    """Modules that cost most of `import cpm` by themselves, numpy imported before, by -X importtime.

    Returns
    -------
    list of (str, float)
        Name, milliseconds.
    """
    run = subprocess.run([sys.executable, "-X", "importtime", "-c", "import numpy\nimport cpm"], capture_output=True,
                         text=True, check=True)
    # "import time:  self [us] | cumulative | name"; children come before their parents.
    rows = [line.split(":", 1)[1].split("|") for line in run.stderr.splitlines() if line.startswith("import time:")][1:]
    names = [row[2].strip() for row in rows]
    after = names.index("numpy") + 1
    own = [(name, int(row[0]) / 1000.0) for name, row in zip(names[after:], rows[after:], strict=True)]
    return sorted(own, key=lambda item: -item[1])[:count]


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--pairs", type=positive, default=25, metavar="N", help="default: %(default)s")
    add_arguments(parser)
    return parser.parse_args()


def draw(seconds, marks):
    figure, (axes,) = new_figure(1, 2, (10, 3.6))
    axes[0].hist(1e3 * (seconds[:, 1] - seconds[:, 0]), bins=15)
    axes[0].axvline(150.0, color="tab:red", ls="--", label="goal")
    axes[0].set(xlabel="import cpm over import numpy, ms", ylabel="pairs")
    axes[0].set_xlim(left=0)
    axes[0].legend()
    axes[1].barh(list(marks), [value / 2**20 for value in marks.values()])
    axes[1].axvline(1024.0, color="tab:red", ls="--", label="goal")
    axes[1].invert_yaxis()
    axes[1].set(xlabel="peak memory so far, MiB", title="curved room, 3 M photons, 16 bins")
    axes[1].legend()
    return figure


def main():
    options = parse_arguments()
    load = load_average()
    seconds = import_seconds(options.pairs)
    modules = heaviest(10)
    early = subprocess.run([sys.executable, "-c", LOADED, *LATE], capture_output=True, text=True,
                           check=True).stdout.split()
    memory = json.loads(subprocess.run([sys.executable, "-c", RENDER, CURVED], capture_output=True, text=True,
                                       check=True).stdout)
    marks = memory["marks"]
    table("fresh interpreters, seconds", ["statement", "least", "median", "most"],
          [[name, *(float(take(seconds[:, i])) for take in (np.min, np.median, np.max))]
           for i, name in enumerate(("import numpy", "import cpm"))])
    table("import cpm after numpy: heaviest modules", ["module", "ms of its own"], [list(item) for item in modules])
    table("peak memory of the curved room so far", ["after", "MiB"],
          [[name, value / 2**20] for name, value in marks.items()])
    figures = [judge("import cpm over import numpy, seconds, median of pairs",
                     float(np.median(seconds[:, 1] - seconds[:, 0])), 0.15),
               judge("modules imported early that are promised late", len(early), 0, note=", ".join(early)),
               judge("peak memory of the curved room's render, GiB", marks["render"] / 2**30, 1.0)]
    content = {"load_at_start": load, "seconds": {"numpy": seconds[:, 0], "cpm": seconds[:, 1]},
               "heaviest_modules_ms": dict(modules), "memory_bytes": memory}
    write(options.results, "imports", content, figures, draw(seconds, marks), ["colour-science", "matplotlib"])


if __name__ == "__main__":
    main()
