#!/usr/bin/env python3
"""Stiff and extreme cases: what happens, error against an oracle, evaluations, in double and in single precision.

Asked: rtol 1e-9 in double, 1e-6 in single, default method, unless the case says otherwise. Error: distance of the end
from the oracle's over the length asked for, or what the case names. Estimate: the library's own, error="global", over
the same length. A case holds where status and error are as asked (error ≤ rtol, or the bound that the case names); else
the row says missed, and by which factor. Oracles (tests/oracles) share no code with the library. docs/stability.md is
this table with what it means.
"""
import argparse
import time
import warnings

import numpy as np
from _results import add_arguments, judge, load_average, positive, write
from _stability_cases import RTOL, cases

import cpm


def measure(case, precision):
    """A dict of status, error, bound, evaluations, verdict, seconds, warning."""
    start, bound = time.perf_counter(), case.bounds[precision]
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        try:
            status, error, evaluations, estimate = case.run(precision)
        except (ValueError, cpm.Error) as problem:
            status, error, evaluations = [f"{type(problem).__name__}: {problem}"], np.nan, 0
            estimate = np.nan
            verdict = "refused" if case.refused else "MISSED: refused"
        else:
            if case.refused:
                verdict = "MISSED: accepted"
            elif not set(status) <= {s.name for s in case.status}:
                verdict = f"MISSED: {', '.join(status)}"
            else:
                verdict = "holds" if error <= bound else f"MISSED, {error / bound:.2g} ×"
    return {
        "status": ", ".join(status),
        "error": error,
        "bound": bound,
        "estimate": estimate,
        "evaluations": evaluations,
        "verdict": verdict,
        "warning": "; ".join(str(w.message) for w in said),
        "seconds": time.perf_counter() - start,
    }


def markdown(results):
    """The table of docs/stability.md."""
    lines = [
        "| case | what happens | oracle | status | error | estimate | evaluations | double "
        "| single: status, error | estimate | evaluations | single |",
        "|---" * 12 + "|",
    ]
    for row in results:
        cells = [row["case"], row["what"], row["oracle"]]
        for precision in RTOL:
            got = row[precision]
            status = "ValueError" if got["status"].startswith("ValueError") else got["status"].lower()
            status = "" if row["case"] == "photons asked" else status
            error, estimate = (f"{got[name]:.1e}" if np.isfinite(got[name]) else "" for name in ("error", "estimate"))
            cells += [status, error] if precision == "double" else [f"{status} {error}".strip()]
            cells += [estimate, str(got["evaluations"]), got["verdict"].replace("MISSED", "**missed**")]
        lines.append(f"| {' | '.join(cells)} |")
    return "\n".join(lines)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument(
        "--periods", type=positive, default=1_000_000, metavar="N", help="of the long fibre (default: %(default)s)"
    )
    add_arguments(parser)
    options = parser.parse_args()
    load = load_average()
    results = [
        {
            "case": case.group,
            "what": case.name,
            "oracle": case.oracle,
            **{precision: measure(case, precision) for precision in RTOL},
        }
        for case in cases(options.periods)
    ]
    print(markdown(results))
    figures = [
        judge(
            f"cases that do not hold in {precision} precision, of {len(results)}",
            sum(row[precision]["verdict"].startswith("MISSED") for row in results),
            0,
        )
        for precision in RTOL
    ]
    figures.append(
        judge(
            "most evaluations of a ray, the long fibre apart",
            max(row[p]["evaluations"] for row in results for p in RTOL if row["case"] != "long fibre"),
            1_000_000,
        )
    )
    write(
        options.results,
        "stability",
        {"load_at_start": load, "rtol": RTOL, "periods": options.periods, "results": results},
        figures,
        packages=["scipy"],
    )


if __name__ == "__main__":
    main()
