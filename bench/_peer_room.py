"""Mitsuba's side of the room: runs peers/mitsuba_room.py in another process and reads its curve."""
import json
import subprocess
from collections import defaultdict

import numpy as np
from _results import ROOT
from regions import NAMES

PROGRAM = ROOT / "bench" / "peers" / "mitsuba_room.py"


def run_peer(python, reference, spps, seeds, threads=None):
    """Render the peer's sweep.

    Parameters
    ----------
    python : path
        The interpreter that has Mitsuba.
    reference : Path
    spps : list of int
        Samples per pixel.
    seeds : int
        Pictures for each.
    threads : int, optional

    Returns
    -------
    list of dict or str
        The program's lines about pictures; where it cannot run, the one line that says why.
    """
    command = [python, PROGRAM, "--reference", reference, "--spp", *map(str, spps), "--seeds", str(seeds)]
    if threads:
        command += ["--threads", str(threads)]
    try:
        run = subprocess.run(command, capture_output=True, text=True, check=False)
    except OSError as error:
        return f"the peer's interpreter does not run: {error.strerror}"
    if run.returncode:
        return (run.stderr.strip() or f"it ended with status {run.returncode}").splitlines()[-1]
    lines = [json.loads(line) for line in run.stdout.splitlines()]
    return [line for line in lines if "peer" in line]


def curve(lines):
    """One point for each sample count, by seconds.

    Parameters
    ----------
    lines : list of dict
        Of `run_peer`, several runs or one.

    Returns
    -------
    list of dict
        ``spp``, ``seconds`` (median), ``pictures`` and, by region, ``error`` (root mean square over the pictures).
    """
    by_spp = defaultdict(list)
    for line in lines:
        by_spp[line["spp"]].append(line)
    points = [{"spp": spp, "pictures": len(group), "seconds": float(np.median([line["seconds"] for line in group])),
               "error": {name: float(np.sqrt(np.mean([line["relative_rmse"][name] ** 2 for line in group])))
                         for name in NAMES},
               "mean": float(np.mean([line["mean"] for line in group]))}
              for spp, group in by_spp.items()]
    return sorted(points, key=lambda point: point["seconds"])


def error_at(points, region, seconds):
    """The peer's error in a region after so many seconds.

    Log-log between its points; beyond them error falls as 1/√seconds, as Monte Carlo does.
    """
    times = np.log([point["seconds"] for point in points])
    errors = np.log([point["error"][region] for point in points])
    at = np.log(seconds)
    inside = np.clip(at, times[0], times[-1])
    return float(np.exp(np.interp(inside, times, errors) - 0.5 * (at - inside)))
