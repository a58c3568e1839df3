"""The fibre of rays.py alone: beside a straight loop over lanes, and over a million periods."""
import json
import platform
import subprocess
import tempfile
import time
from pathlib import Path

import numpy as np
from _program import program
from _ray_cases import WAVELENGTH, cases
from _results import judge, table

import cpm

INDEX, ALPHA = 1.5, 1.0
OMEGA = INDEX * ALPHA   # of the oscillation in sigma
WIDTHS = ("v4", "v3", "baseline") if platform.machine() in ("x86_64", "AMD64") else ("baseline",)
PER_PERIOD = 160        # steps of yoshida6
LOOP_REPEATS = 20


def beside_loop(options):
    """Rays per second of `auto` (exact excluded), one thread, over bench/straight.c's.

    The loop takes as many steps of the same pair as the tracer attempted, in vectors of the widest kind that is fastest
    here, with the same compiler's flags; it has neither estimate nor control. In turn, several times; processor time of both.
    """
    case = next(cases())
    fibre = program("straight")
    count, rng = options.rays, np.random.default_rng(3)
    origins = np.tile(np.array(case.origin, float), (count, 1))
    d = np.array(case.direction) + 0.002 * np.linalg.norm(case.direction) * rng.normal(size=(count, 3))
    n = np.sqrt(case.field(np.array(case.origin))[0])
    length = float(cpm.trace(case.medium, origins[:1], [case.direction], wavelength=WAVELENGTH,
                             until=((0, 0, case.direction[2] * case.sigma), (0, 0, 1)), rtol=1e-12).length[0])

    def ours():
        begun = time.process_time()
        rays = cpm.trace(case.medium, origins, d, wavelength=WAVELENGTH, length=length, exclude=("exact",), rtol=1e-6,
                         threads=1)
        return rays, time.process_time() - begun

    rays, _ = ours()
    attempts = int(round(float((rays.steps + rays.rejected).mean())))
    cost = (float(rays.evaluations.mean()) - 1) / attempts   # evaluations an attempt tell which pair it was
    order = {5: 6, 8: 8}.get(round(cost), 0) if set(rays.method) == {"nystrom"} else 0
    if not order:
        print(f"fibre: {rays.method[0]} with {cost:.1f} evaluations an attempt; the loop knows the pairs 6(4) and 8(6) only")
        return {}, judge("fibre, rays per second over a straight SIMD loop", float("nan"), 0.5, at_most=False)
    rows, ratios = [], []
    with tempfile.TemporaryDirectory() as folder:
        starts, ends = Path(folder) / "starts", Path(folder) / "ends"
        np.column_stack([origins, d / np.linalg.norm(d, axis=1)[:, None] * n]).tofile(starts)
        for _ in range(max(options.repeats, 3)):
            took = min(ours()[1] for _ in range(LOOP_REPEATS))
            loops = {}
            for width in WIDTHS:
                run = subprocess.run([fibre.with_name(f"{fibre.name}_{width}"), starts, ends, str(attempts), str(order),
                                      str(case.sigma), str(LOOP_REPEATS)], capture_output=True, text=True, check=False)
                if run.returncode == 0:   # else an instruction set that this machine has not
                    loops[width] = json.loads(run.stdout)["seconds"]
            best = min(loops, key=loops.get)
            rows.append([count / took, best, count / loops[best], loops[best] / took])
            ratios.append(loops[best] / took)
        # Both go the same way: the loop's arc length at its end is what ours were asked for, rays that lean more aside.
        lengths = np.fromfile(ends).reshape(-1, 8)[:, 6]
    table(f"fibre, {attempts} attempts a ray of nystrom's pair of order {order}, one thread",
          ["ours, rays/s", "loop", "loop, rays/s", "ours / loop"], rows)
    figure = judge("fibre, rays per second over the same arithmetic as a straight SIMD loop, one thread, rtol 1e-6",
                   float(np.median(ratios)), 0.5, at_most=False, note=f"{rows[0][1]}; median of {len(rows)}")
    return {"rows": rows, "attempts": attempts, "order": order, "lengths_apart": float(np.abs(lengths / length - 1).max())}, figure


def long_fibre(options):
    """Transverse energy and phase of yoshida6 after 10, 100, ... periods, one ray each and two for the last.

    E = |p_⊥|²/2 + ω²ρ²/2 is conserved; the phase is that of x = x₀ cos ωσ, with σ = z/p_z from the ray's own end. Ends are
    at arc lengths that are no whole number of periods, where the energy error is far from its zeros.
    """
    origin, direction = np.array([0.3, 0.0, 0.0]), np.array([0.0, 0.15, 1.0])
    n = INDEX * np.sqrt(1 - (ALPHA * origin[0]) ** 2)
    p = n * direction / np.linalg.norm(direction)
    decades = int(np.log10(options.periods))
    periods = np.array([*(10.0**k for k in range(1, decades + 1)), 0.97 * options.periods, options.periods]) + 0.13
    # Mean n over a period: the arc length of one, to a few digits: where a ray ends need not be known beforehand.
    mean = float(np.mean([np.sqrt(INDEX**2 - OMEGA**2 * (origin[0] ** 2 * np.cos(t) ** 2 + (p[1] / OMEGA * np.sin(t)) ** 2))
                          for t in np.linspace(0, 2 * np.pi, 64, endpoint=False)]))
    begun = time.perf_counter()
    rays = cpm.trace(cpm.media.Parabolic(INDEX, alpha=ALPHA), [origin] * len(periods), direction, wavelength=WAVELENGTH,
                     length=2 * np.pi / OMEGA * periods * mean, method="yoshida6",
                     step=2 * np.pi / OMEGA / PER_PERIOD * n, max_evaluations=10**11)
    seconds = time.perf_counter() - begun
    r, q = rays.position, rays.momentum
    energy = 0.5 * (q[:, 0] ** 2 + q[:, 1] ** 2 + OMEGA**2 * (r[:, 0] ** 2 + r[:, 1] ** 2))
    error = np.abs(energy / (0.5 * (p[1] ** 2 + OMEGA**2 * origin[0] ** 2)) - 1)
    angle = np.arctan2(-q[:, 0], OMEGA * r[:, 0]) - OMEGA * r[:, 2] / p[2]
    phase = np.abs((angle + np.pi) % (2 * np.pi) - np.pi)
    rows = [[float(a), float(b), float(c), int(e), str(cpm.RayStatus(s).name)]
            for a, b, c, e, s in zip(periods, error, phase, rays.evaluations, rays.status, strict=True)]
    table(f"fibre by yoshida6, {PER_PERIOD} steps a period ({seconds:.0f} s)",
          ["periods", "energy error", "phase error, rad", "evaluations", "status"], rows)
    arrived = np.all(rays.status == cpm.RayStatus.ARRIVED)
    return rows, [judge(f"fibre over {options.periods:.0e} periods by yoshida6: relative transverse energy error, worst of all",
                        float(error.max()) if arrived else np.nan, 1e-9),
                  judge("the same, phase error in radians", float(phase[-1]), None)]
