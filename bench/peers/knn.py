#!/usr/bin/env python3
"""The peers' side of bench/gather.py: the k nearest with SciPy's cKDTree and with pykdtree.

    knn.py PHOTONS QUERIES RADII [--nearest 150] [--threads 2] [--leaf 32]

PHOTONS, QUERIES: raw float32, six a row: position, normal (not looked at). RADII: the distances of the k-th by cKDTree
are written there, raw float64. Prints a JSON list of {"name", "version", "build_seconds", "query_seconds"}; a peer that
is not installed has "missing" instead. Needs NumPy and what is compared, nothing of cpm.
"""
import argparse
import json
import os
import time
from importlib import metadata
from pathlib import Path

import numpy as np


def timed(build, query):
    """Seconds of building, seconds of asking, and what was answered."""
    start = time.perf_counter()
    tree = build()
    built = time.perf_counter()
    answer = query(tree)
    return built - start, time.perf_counter() - built, answer


def scipy_runs(photons, queries, options):
    """cKDTree, unbalanced (sliding midpoint) and balanced (median)."""
    from scipy.spatial import cKDTree

    for balanced in (False, True):
        build, query, (distance, _) = timed(
            lambda balanced=balanced: cKDTree(photons, leafsize=options.leaf, balanced_tree=balanced),
            lambda tree: tree.query(queries, k=options.nearest, workers=options.threads))
        yield f"cKDTree, {'balanced' if balanced else 'unbalanced'}", build, query, distance[:, -1]


def pykdtree_runs(photons, queries, options):
    """pykdtree in single and in double precision; its threads are OpenMP's."""
    from pykdtree.kdtree import KDTree

    for kind in (np.float32, np.float64):
        points, asked = photons.astype(kind), queries.astype(kind)
        build, query, (distance, _) = timed(lambda points=points: KDTree(points, leafsize=options.leaf),
                                            lambda tree, asked=asked: tree.query(asked, k=options.nearest))
        yield f"pykdtree, {np.dtype(kind).name}", build, query, distance[:, -1]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("photons", type=Path)
    parser.add_argument("queries", type=Path)
    parser.add_argument("radii", type=Path)
    parser.add_argument("--nearest", type=int, default=150)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--leaf", type=int, default=32)
    options = parser.parse_args()
    os.environ["OMP_NUM_THREADS"] = str(options.threads)  # before pykdtree is imported

    photons, queries = (np.fromfile(path, np.float32).reshape(-1, 6)[:, :3].copy()
                        for path in (options.photons, options.queries))
    results = []
    for name, package, runs in (("cKDTree", "scipy", scipy_runs), ("pykdtree", "pykdtree", pykdtree_runs)):
        try:
            for label, build, query, radii in runs(photons, queries, options):
                results.append({"name": label, "version": f"{package} {metadata.version(package)}",
                                "build_seconds": build, "query_seconds": query})
                if label == "cKDTree, unbalanced":
                    radii.astype(np.float64).tofile(options.radii)
        except ImportError:
            results.append({"name": name, "missing": True})
    print(json.dumps(results))


if __name__ == "__main__":
    main()
