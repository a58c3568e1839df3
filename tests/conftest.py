"""What every Python test shares: backends, thread counts, tiers, failure pictures.

Tests import `oracles` (this folder is on the path, by pytest's "prepend" mode) and `cpm`.
"""

from __future__ import annotations

import os
import pathlib

import numpy as np
import pytest

#: Extended as backends land: every physics test runs on each.
BACKENDS = ["native"]
THREADS = [1, 2]


def pytest_addoption(parser):
    parser.addoption("--long", action="store_true", help="also run the tests marked long (minutes)")
    parser.addoption(
        "--pictures", default=os.environ.get("CPM_TEST_PICTURES"), help="folder for pictures of failed image tests"
    )


def pytest_configure(config):
    config.addinivalue_line("markers", "long: minutes, not seconds; runs with --long or -m long")


def pytest_collection_modifyitems(config, items):
    if config.getoption("--long") or "long" in (config.getoption("-m") or ""):
        return
    skip = pytest.mark.skip(reason="long: use --long")
    for item in items:
        if "long" in item.keywords:
            item.add_marker(skip)


@pytest.fixture(params=BACKENDS)
def backend(request):
    """Name of the backend under test."""
    return request.param


@pytest.fixture(params=THREADS, ids=lambda t: f"{t}thread")
def threads(request):
    """Thread count under test."""
    return request.param


@pytest.hookimpl(hookwrapper=True)
def pytest_runtest_makereport(item, call):
    report = (yield).get_result()
    if report.when == "call":
        item.failed_call = report.failed


@pytest.fixture
def picture(request):
    """A function ``picture(name, array)``: (H, W) or (H, W, 3) written as PNG if the test fails."""
    kept = {}
    yield lambda name, array: kept.update({name: np.asarray(array)})
    folder = request.config.getoption("--pictures")
    if folder and getattr(request.node, "failed_call", False):
        import matplotlib.image

        folder = pathlib.Path(folder)
        folder.mkdir(parents=True, exist_ok=True)
        for name, array in kept.items():
            matplotlib.image.imsave(
                folder / f"{request.node.name}-{name}.png", np.clip(array / max(array.max(), 1e-300), 0, 1)
            )
