"""What every benchmark shares: where it ran, tables, figures to reach, and the files that it writes.

A benchmark measures, then calls `table`, `judge` and `write`. Nothing here asserts: a figure that was missed is printed
as missed. No path of the machine goes into a result.
"""
import json
import math
import os
import platform
import subprocess
import sys
from importlib import metadata
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
EXAMPLES = ROOT / "examples"
CURVED, HOMOGENEOUS = EXAMPLES / "cross_room_curved.toml", EXAMPLES / "cross_room_homogeneous.toml"

SIGNIFICANT = 5   # digits: more than the noise leaves


def add_arguments(parser):
    """Options of every benchmark."""
    parser.add_argument("--results", type=Path, default=Path("results"), metavar="FOLDER",
                        help="where NAME.json and NAME.png go (default: ./results; docs/results holds those that are "
                             "published)")


def machine():
    """CPU, its logical cores, those that this process may use, and memory.

    Returns
    -------
    dict
    """
    cpu = platform.processor() or platform.machine()
    try:
        for line in Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                cpu = line.split(":", 1)[1].strip()
                break
    except OSError:
        pass
    usable = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    memory = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / 2**30
    return {"cpu": cpu, "architecture": platform.machine(), "cores": os.cpu_count(), "usable_cores": usable,
            "memory_gib": round(memory, 1), "system": f"{platform.system()} {platform.release()}"}


def versions(*packages):
    """Versions of Python, cpm, what cpm was built with, NumPy, and other packages by their PyPI names.

    Returns
    -------
    dict of str to str
        A package that is not installed is "missing".
    """
    import cpm

    found = {"python": platform.python_version(), "cpm": cpm.__version__, "cpm_build": cpm._core.build_info()}
    for name in ("numpy", *packages):
        try:
            found[name] = metadata.version(name)
        except metadata.PackageNotFoundError:
            found[name] = "missing"
    return found


def commit():
    """The checkout's commit, with "+changes" where files differ from it; None without one."""
    def git(*words):
        return subprocess.run(["git", "-C", ROOT, *words], capture_output=True, text=True, check=True).stdout.strip()

    try:
        return git("rev-parse", "--short=12", "HEAD") + ("+changes" if git("status", "--porcelain") else "")
    except (OSError, subprocess.CalledProcessError):
        return None


COMMIT = commit()   # when the benchmark started, not minutes later


def load_average():
    """Processes that wanted a core in the last minute: a number well above 0 at the start says that others ran too."""
    return os.getloadavg()[0] if hasattr(os, "getloadavg") else None


def judge(name, value, goal, at_most=True, note=""):
    """Compare a measured figure with its goal and print the outcome.

    Parameters
    ----------
    name : str
        What the figure is.
    value : float
        As measured; NaN counts as missed.
    goal : float or None
        None: the figure is only reported.
    at_most : bool
        Whether the goal is an upper bound.
    note : str
        Where it was measured, or what limits it.

    Returns
    -------
    dict
        For the JSON file.
    """
    reached = None if goal is None else bool(value <= goal if at_most else value >= goal)
    word = {None: "reported", True: "reached", False: "MISSED"}[reached]
    bound = "" if goal is None else f" (goal: at {'most' if at_most else 'least'} {goal:g})"
    print(f"{word:>8}: {name}: {value:.4g}{bound}{'; ' + note if note else ''}")
    return {"figure": name, "value": rounded(value), "goal": goal, "at_most": at_most, "reached": reached, "note": note}


def table(title, headers, rows):
    """Print a table; numbers are right-aligned and formatted, None is empty."""
    text = [[_cell(value) for value in row] for row in rows]
    numeric = [all(not isinstance(row[i], str) for row in rows) for i in range(len(headers))]
    try:
        from rich.console import Console
        from rich.table import Table
    except ImportError:
        _plain_table(title, headers, text, numeric)
        return
    drawn = Table(title=title, title_justify="left")
    for header, right in zip(headers, numeric, strict=True):
        drawn.add_column(header, justify="right" if right else "left", no_wrap=True)
    for row in text:
        drawn.add_row(*row)
    # A file or a pipe has no width of its own: nothing is to be cut there.
    Console(width=None if sys.stdout.isatty() else 160).print(drawn)


def _plain_table(title, headers, text, numeric):
    widths = [max(len(line[i]) for line in [headers, *text]) for i in range(len(headers))]
    print(title)
    for line in [headers, *text]:
        print("  ".join(cell.rjust(width) if right else cell.ljust(width)
                        for cell, width, right in zip(line, widths, numeric, strict=True)).rstrip())


def _cell(value):
    if value is None:
        return ""
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def rounded(value):
    """Floats to a few significant digits, through dicts and lists; NaN and infinity, which JSON lacks, become None."""
    if isinstance(value, dict):
        return {str(key): rounded(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [rounded(item) for item in value]
    if hasattr(value, "tolist"):
        return rounded(value.tolist())
    if isinstance(value, float):
        return float(f"{value:.{SIGNIFICANT}g}") if math.isfinite(value) else None
    return value


def write(folder, name, content, figures, figure=None, packages=()):
    """Write NAME.json and NAME.png, each beside its place and then renamed.

    Parameters
    ----------
    folder : Path
    name : str
        The benchmark's.
    content : dict
        What was measured.
    figures : list of dict
        From `judge`.
    figure : matplotlib Figure, optional
    packages : sequence of str
        Packages, beside NumPy, whose versions matter.
    """
    folder.mkdir(parents=True, exist_ok=True)
    result = {"benchmark": name, "machine": machine(), "versions": versions(*packages), "commit": COMMIT,
              "figures": figures, **content}
    text = json.dumps(rounded(result), indent=1, ensure_ascii=False)
    _replace(folder / f"{name}.json", lambda beside: beside.write_text(text + "\n", encoding="utf-8"))
    if figure is not None:
        _replace(folder / f"{name}.png", lambda beside: figure.savefig(beside, format="png", dpi=110))
    print(f"wrote {folder / name}.json{f' and {name}.png' if figure is not None else ''}")


def _replace(path, save):
    beside = path.with_name(f".{path.name}.{os.getpid()}")
    try:
        save(beside)
        beside.replace(path)
    finally:
        beside.unlink(missing_ok=True)


def new_figure(rows, columns, size):
    """A figure that needs no display, and its axes (rows, columns); size in inches."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=size, layout="constrained")
    return figure, figure.subplots(rows, columns, squeeze=False)


def positive(text):
    """An argparse type: an integer of at least 1; 1e6 and 3_000_000 are understood."""
    value = float(text)
    if value < 1 or value != int(value):
        raise ValueError(text)
    return int(value)
