#!/usr/bin/env python3
"""The k nearest photons: libcpm's map against SciPy's cKDTree and pykdtree, build and query, in one run.

Photons and queries are spread evenly over the faces of a cube; queries come in Morton order, for everyone. The photons'
normals are all equal, so that libcpm finds what its peers find, and its radii are checked against cKDTree's. Its build
moves records and spectra into the tree's order; its queries sum the spectra of the photons found: the peers, which know
of neither, return sorted distances and indices. A second run of libcpm has the faces' own normals, as a render has.

    cpm bench gather -- --peer-python venv/bin/python      # peers from another environment: NumPy, SciPy, pykdtree
"""
import argparse
import json
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from _program import program
from _results import ROOT, add_arguments, judge, load_average, new_figure, positive, table, write

OURS, OURS_NORMALS = "libcpm, irradiance", "libcpm, irradiance, faces' normals"
OURS_RADIUS = "libcpm, radius alone"
RADIUS_ERROR = 3e-7     # single-precision distances against double


def on_a_cube(generator, count):
    """Points on the faces of the unit cube and the faces' inner normals, (count, 3) float32 each."""
    points = generator.random((count, 3), dtype=np.float32)
    face = generator.integers(0, 6, count)
    rows, axis, side = np.arange(count), face % 3, face // 3
    points[rows, axis] = side
    normals = np.zeros((count, 3), np.float32)
    normals[rows, axis] = 1 - 2 * side
    return points, normals


def morton_order(points, bits=10):
    """Indices that sort points of the unit cube along a Morton curve."""
    cell = np.minimum((points * (1 << bits)).astype(np.uint64), (1 << bits) - 1)
    code = np.zeros(len(points), np.uint64)
    for bit in range(bits):
        for axis in range(3):
            code |= (cell[:, axis] >> np.uint64(bit) & np.uint64(1)) << np.uint64(3 * bit + axis)
    return np.argsort(code, kind="stable")


def write_data(folder, options):
    """Raw files of photons and queries, with one normal and with the faces' own."""
    generator = np.random.default_rng(options.seed)
    photons = on_a_cube(generator, options.photons)
    queries = on_a_cube(generator, options.queries)
    if options.order == "morton":
        order = morton_order(queries[0])
        queries = tuple(array[order] for array in queries)
    up = np.array([0, 0, 1], np.float32)
    for name, (points, normals) in (("photons", photons), ("queries", queries)):
        np.hstack([points, np.broadcast_to(up, points.shape)]).astype(np.float32).tofile(folder / f"{name}-one")
        np.hstack([points, normals]).astype(np.float32).tofile(folder / f"{name}-faces")


def run_ours(folder, normals, options):
    """What bench/gather.c prints."""
    command = [program("gather"), folder / f"photons-{normals}", folder / f"queries-{normals}",
               folder / f"radii-{normals}", str(options.nearest), str(options.threads), str(options.bins), "1"]
    return json.loads(subprocess.run(command, capture_output=True, text=True, check=True).stdout)


def run_peers(folder, options):
    """What bench/peers/knn.py prints."""
    command = [options.peer_python, ROOT / "bench" / "peers" / "knn.py", folder / "photons-one", folder / "queries-one",
               folder / "radii-peer", "--nearest", str(options.nearest), "--threads", str(options.threads)]
    return json.loads(subprocess.run(command, capture_output=True, text=True, check=True).stdout)


def keep_fastest(best, name, build, query):
    """Keep the run with the least build + query of each competitor."""
    if name not in best or build + query < sum(best[name]):
        best[name] = (build, query)


def measure(options):
    """Rounds of everybody in turn, so that a busy machine slows all alike.

    Returns
    -------
    best : dict of str to (build, query) seconds
    ours : dict
        The last of bench/gather.c's results.
    versions : dict of str to str
        Of each peer.
    missing : list of str
        Peers that are not installed.
    radius_error : float
        Largest relative difference of the k-th distances from cKDTree's; NaN without SciPy.
    """
    best, versions, missing, radius_error = {}, {}, [], float("nan")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        write_data(folder, options)
        for _ in range(options.rounds):
            ours = run_ours(folder, "one", options)
            keep_fastest(best, OURS, ours["build_seconds"], ours["irradiance_seconds"])
            keep_fastest(best, OURS_RADIUS, ours["build_seconds"], ours["radius_seconds"])
            faces = run_ours(folder, "faces", options)
            keep_fastest(best, OURS_NORMALS, faces["build_seconds"], faces["irradiance_seconds"])
            for peer in run_peers(folder, options):
                if peer.get("missing"):
                    missing.append(peer["name"])
                else:
                    versions[peer["name"]] = peer["version"]
                    keep_fastest(best, peer["name"], peer["build_seconds"], peer["query_seconds"])
        if (folder / "radii-peer").exists():
            theirs = np.fromfile(folder / "radii-peer")
            radius_error = float(np.max(np.abs(np.fromfile(folder / "radii-one") / theirs - 1)))
    return best, ours, versions, sorted(set(missing)), radius_error


def draw(best, options):
    """Bars of build and query."""
    figure, ((axis,),) = new_figure(1, 1, (8, 3.6))
    names = sorted(best, key=lambda name: -sum(best[name]))
    builds, queries = ([best[name][part] for name in names] for part in (0, 1))
    axis.barh(names, builds, label="build")
    axis.barh(names, queries, left=builds, label="query")
    axis.set(xlabel=f"seconds, {options.threads} threads",
             title=f"{options.queries:,} queries in {options.order} order × {options.nearest} nearest "
                   f"of {options.photons:,} photons")
    axis.legend()
    return figure


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--photons", type=positive, default=3_000_000, metavar="N", help="default: 3e6")
    parser.add_argument("--queries", type=positive, default=120_000, metavar="N", help="default: %(default)s")
    parser.add_argument("--nearest", type=positive, default=150, metavar="K", help="default: %(default)s")
    parser.add_argument("--threads", type=positive, default=2, metavar="N", help="of everybody (default: %(default)s)")
    parser.add_argument("--bins", type=positive, default=16, metavar="N", help="of libcpm (default: %(default)s)")
    parser.add_argument("--order", choices=["morton", "random"], default="morton", help="of the queries, for everybody")
    parser.add_argument("--rounds", type=positive, default=5, metavar="N",
                        help="of everybody in turn; the fastest counts (default: %(default)s)")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--peer-python", default=sys.executable, metavar="PATH",
                        help="interpreter that has the peers (default: this one)")
    add_arguments(parser)
    return parser.parse_args()


def main():
    options = parse_arguments()
    program("gather")
    load = load_average()
    best, ours, versions, missing, radius_error = measure(options)
    peers = {name: sum(seconds) for name, seconds in best.items() if not name.startswith("libcpm")}
    best_peer = min(peers, key=peers.get) if peers else None
    least = peers[best_peer] if peers else float("nan")

    table("seconds, fastest of the rounds", ["", "build", "query", "build + query", "× best peer"],
          [[name, *seconds, sum(seconds), sum(seconds) / least]
           for name, seconds in sorted(best.items(), key=lambda item: sum(item[1]))])
    for name in missing:
        print(f"{name} is not installed: left out")
    bytes_each = ours["bytes"] / options.photons
    print(f"instruction set {ours['isa']}; {bytes_each:.1f} bytes a photon, {2 * options.bins} of them its spectrum")
    figures = [
        judge("build + query over the best peer's", sum(best[OURS]) / least, 1 / 3, note=f"best peer: {best_peer}"),
        judge("the same with the faces' normals", sum(best[OURS_NORMALS]) / least, 1 / 3),
        judge("the same for the radius alone", sum(best[OURS_RADIUS]) / least, None),
        judge("largest relative difference of r_k from cKDTree's", radius_error, RADIUS_ERROR),
        judge("bytes a photon", bytes_each, None),
    ]
    settings = ("photons", "queries", "nearest", "threads", "bins", "order", "rounds", "seed")
    content = {"load_at_start": load, "peers": versions, "missing": missing, "isa": ours["isa"],
               "checksum": ours["checksum"],
               "settings": {name: getattr(options, name) for name in settings},
               "seconds": {name: {"build": build, "query": query} for name, (build, query) in best.items()}}
    write(options.results, "gather", content, figures, draw(best, options))


if __name__ == "__main__":
    main()
