"""Pictures of rays.py: work against precision a case, and auto beside the best peer."""
import numpy as np
from _results import new_figure

# Ours in colour and whole, the peers grey and dashed, so that twelve lines stay apart.
STYLE = {"auto": ("black", "-", ""), "nystrom": ("tab:blue", "-", "o"), "adams": ("tab:orange", "-", "s"),
         "dopri5": ("tab:green", "-", "^"), "euler": ("tab:red", "-", "v"), "rk4": ("tab:purple", "-", "x"),
         "leapfrog": ("tab:brown", "-", "+"), "yoshida6": ("tab:pink", "-", "d"),
         "RK45": ("0.65", ":", "^"), "DOP853": ("0.35", "--", "o"), "LSODA": ("0.5", "-.", "s"),
         "CVODE": ("0.2", ":", "D")}


def case_picture(name, points, peers):
    """Error over evaluations and over seconds of one case."""
    figure, ((left, right),) = new_figure(1, 2, (13, 6))
    for axis, key, label in ((left, "evaluations", "gradient evaluations"),
                             (right, "seconds", "seconds a call, one ray")):
        for method in dict.fromkeys(p["method"] for p in points):
            chosen = [p for p in points if p["method"] == method]
            colour, line, marker = STYLE[method]
            axis.plot([p[key] for p in chosen], [max(p["error"], 1e-16) for p in chosen], line, color=colour,
                      marker=marker, ms=4, lw=4 if method == "auto" else 1.2, alpha=0.35 if method == "auto" else 1,
                      label=f"{method} (peer)" if method in peers else method)
        axis.set(xscale="log", yscale="log", xlabel=label, ylim=(1e-16, 1), title=name)
        axis.grid(lw=0.3)
    left.set_ylabel("end-point error / path length")
    right.legend(fontsize=9, loc="center left", bbox_to_anchor=(1.01, 0.5))
    return figure


def ratio_picture(compared):
    """Evaluations of auto, and of our best method, over the best peer's: a pair of bars a case, a panel a level."""
    levels = sorted({row[1] for row in compared}, reverse=True)
    figure, axes = new_figure(1, len(levels), (13, 5))
    for axis, level in zip(axes[0], levels, strict=True):
        rows = [row for row in compared if row[1] == level]
        at = np.arange(len(rows))
        axis.bar(at - 0.2, [row[5] for row in rows], 0.4, color="0.3", label="auto")
        axis.bar(at + 0.2, [row[6] for row in rows], 0.4, color="tab:blue", label="best method in hindsight")
        for x, row in zip(at, rows, strict=True):
            axis.annotate(f"{row[7]}\n/ {row[3]}", (x, 0.02), ha="center", fontsize=6, color="white", rotation=90)
        axis.axhline(0.6, color="tab:green", lw=1, label="goal: geometric mean")
        axis.axhline(0.9, color="tab:red", lw=1, label="goal: worst")
        axis.set(title=f"gradient evaluations over the best peer's, achieved error {level:g}",
                 ylim=(0, 1.4 * max(1.0, *(row[5] for row in rows))))
        axis.set_xticks(at, [row[0] for row in rows], rotation=30, ha="right")
        axis.legend(fontsize=8, loc="upper left", ncols=2)
    return figure
