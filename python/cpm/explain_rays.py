"""What a ray needs, what is left out for it, and what each costs: counted and measured on the rays themselves."""
from __future__ import annotations

import time
import warnings
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from . import materials, media
from ._arrays import FloatArray, as_points
from .bounds import Box
from .feature import Feature, lines_of, middle
from .media import Medium, as_medium
from .rays import DEFAULT_PATH_SAMPLES, Rays, trace
from .scene import Scene
from .settings import RenderSettings, resolve

__all__ = ["RayExplanation", "explain_rays"]

#: Rays of a trial: fewer are repeated to so many, or the call itself is all that is timed.
_LEAST_RAYS = 512
_ROUNDS = (3, 9)  # at least, at most
_ENOUGH = 3.0     # s, after which no further round begins

_MEANING = {
    "curved": "the medium bends rays",
    "integrator": "bent paths integrated",
    "surfaces": "looked for along the path",
    "dispersion": "a path for each wavelength",
    "paths": "samples along the way kept",
    "global_error": "a second, finer run",
    "double": "double precision lanes",
}


@dataclass(frozen=True)
class RayExplanation:
    """What :func:`cpm.explain` found about rays; ``print`` it.

    Attributes
    ----------
    subject : str
        The medium or scene, the rays, what ran.
    features : list of Feature
    rays : Rays
        Of the trial as it was asked for.
    seconds : float
        Of one such trial; NaN where nothing was measured.
    """

    subject: str
    features: list[Feature]
    rays: Rays
    seconds: float = float("nan")

    def __str__(self) -> str:
        measured = np.isfinite(self.seconds)
        lines = [self.subject, *lines_of(self.features, measured)]
        if measured:
            lines.append(f"\n× is the time of a trace with it over one without, of {len(self.rays):,} rays (here "
                         f"{1e3 * self.seconds:.2f} ms); ~ 1: less than the noise; -: not tried.")
        return "\n".join(lines)


@dataclass
class _Trial:
    """One way to trace the rays, and what came of it."""

    run: Callable[[], Rays]
    rays: Rays | None = None
    seconds: list[float] = field(default_factory=list)

    def turn(self) -> None:
        start = time.perf_counter()
        self.rays = self.run()
        self.seconds.append(time.perf_counter() - start)


def explain_rays(medium_or_scene: Any, origins: npt.ArrayLike, directions: npt.ArrayLike, *, measure: bool = True,
                 **options: Any) -> RayExplanation:
    """What tracing these rays needs; arguments as of :func:`cpm.trace`."""
    scene = medium_or_scene if isinstance(medium_or_scene, Scene) else None
    medium: Medium = scene.medium if scene is not None else as_medium(medium_or_scene)
    starts, aims, options = _enough(as_points(origins, "origins"), as_points(directions, "directions"), options)
    threads = {"threads": options.pop("threads", 1)}
    asked = trace(medium_or_scene, starts, aims, **options, **threads)
    bundle = _bundle(medium, starts[0], options["wavelength"])
    curved = not isinstance(medium, media.Homogeneous)

    def of(target: Any, **changes: Any) -> _Trial:
        return _Trial(lambda: trace(target, starts, aims, **{**options, **changes}, **threads))

    base = _Trial(lambda: trace(medium_or_scene, starts, aims, **options, **threads), asked)
    pairs: dict[str, tuple[bool, _Trial | None, _Trial | None]] = {}
    straight, bent = _straight(medium_or_scene, medium, starts[0]), _bent(medium_or_scene, medium)
    free = {"method": "auto", "step": None}  # what other media than the one asked about are traced by
    integrated = {"method": "auto", "exclude": tuple({*_names(options.get("exclude", ())), "exact"})}
    runs = str(asked.method[0]) != "exact"
    pairs["curved"] = ((True, base, of(straight, **free)) if curved else (False, of(bent, **free), base))
    pairs["integrator"] = ((True, base, of(straight, **free)) if runs else
                           (False, of(medium_or_scene if curved else bent, **{**free, **integrated}), base))
    pairs["surfaces"] = _surfaces(scene, medium, starts, asked, options, base, of)
    pairs["dispersion"] = (_differs(medium, starts[0], bundle), *_bundles(medium_or_scene, starts, aims, bundle,
                                                                         {**options, **threads}))
    samples = options.get("path", False)
    pairs["paths"] = ((True, base, of(medium_or_scene, path=False)) if samples else
                      (False, of(medium_or_scene, path=DEFAULT_PATH_SAMPLES), base))
    pairs["global_error"] = ((True, base, of(medium_or_scene, error="local"))
                             if options.get("error", "local") == "global" else
                             (False, of(medium_or_scene, error="global"), base))
    if scene is None and runs:
        double = options.get("precision", "double") == "double"
        other = of(medium_or_scene, precision="single" if double else "double")
        pairs["double"] = (double, *((base, other) if double else (other, base)))
    if measure:
        _measure(base, pairs)
    features = [Feature(name, needed, _MEANING[name], _counters(name, needed, having, lacking, asked, len(bundle)),
                        *_cost(having, lacking)) for name, (needed, having, lacking) in pairs.items()]
    return RayExplanation(_described(medium_or_scene, asked), features, asked,
                          float(np.median(base.seconds)) if base.seconds else float("nan"))


def _names(exclude: Any) -> tuple[str, ...]:
    return (exclude,) if isinstance(exclude, str) else tuple(exclude)


def _enough(starts: FloatArray, aims: FloatArray, options: dict[str, Any]) -> tuple[FloatArray, FloatArray, dict[str, Any]]:
    """The rays as often as makes a trial worth timing, and what is given for each of them."""
    count = max(len(starts), len(aims))
    times = -(-_LEAST_RAYS // count)
    starts, aims = (np.tile(np.broadcast_to(rows, (count, 3)), (times, 1)) for rows in (starts, aims))
    options = dict(options)
    for name in ("wavelength", "length"):
        if np.ndim(options.get(name)) == 1:
            options[name] = np.tile(options[name], times)
    options.setdefault("wavelength", 550.0)
    return starts, aims, options


def _bundle(medium: Medium, start: FloatArray, wavelength: Any) -> FloatArray:
    """The wavelengths that a bundle would carry: a picture's bins, or the one asked for where its glass ends before."""
    bins = resolve(RenderSettings()).wavelengths
    try:
        medium.evaluate(start, float(bins[0]))
        medium.evaluate(start, float(bins[-1]))
    except ValueError:
        return np.atleast_1d(np.asarray(wavelength, float))[:1]
    return bins


def _differs(medium: Medium, start: FloatArray, bundle: FloatArray) -> bool:
    n = [float(medium.evaluate(start, float(w))[0][0]) for w in bundle]
    return max(n) > min(n)


def _bundles(target: Any, starts: FloatArray, aims: FloatArray, bundle: FloatArray,
             options: dict[str, Any]) -> tuple[_Trial, _Trial]:
    """A ray for each wavelength, and one for them all."""
    some = slice(0, max(1, len(starts) // len(bundle)))  # as many rays in all as in the other trials
    options = {name: value[some] if np.ndim(value) == 1 and name in ("length", "wavelength") else value
               for name, value in options.items()}
    one = {**options, "wavelength": float(bundle[len(bundle) // 2])}
    count = len(starts[some])
    each = {**options, "wavelength": np.repeat(bundle, count)}
    if np.ndim(options.get("length")) == 1:
        each["length"] = np.tile(options["length"], len(bundle))
    return (_Trial(lambda: trace(target, np.tile(starts[some], (len(bundle), 1)), np.tile(aims[some], (len(bundle), 1)),
                                 **each)),
            _Trial(lambda: trace(target, starts[some], aims[some], **one)))


def _straight(target: Any, medium: Medium, start: FloatArray) -> Any:
    """The same with a medium that bends nothing."""
    plain = media.Homogeneous(float(medium.evaluate(start)[0][0]))
    return target.copy(medium=plain) if isinstance(target, Scene) else plain


def _bent(target: Any, medium: Medium) -> Any:
    """The same with a medium that bends rays by next to nothing."""
    bent = media.LinearSquared(float(medium.evaluate((0.0, 0.0, 0.0))[0][0]) ** 2, (0.0, 1e-6, 0.0))
    return target.copy(medium=bent) if isinstance(target, Scene) else bent


def _surfaces(scene: Scene | None, medium: Medium, starts: FloatArray, asked: Rays, options: dict[str, Any], base: _Trial,
              of: Callable[..., _Trial]) -> tuple[bool, _Trial | None, _Trial | None]:
    """In a scene, and as far in its medium alone; in a medium, and in a scene with a ball out of everyone's way."""
    if scene is not None:
        crosses = bool(scene.media) or any(isinstance(shape.material, materials.Dielectric) for shape in scene.shapes)
        alone = None if crosses else of(medium, length=asked.length, until=None)
        return True, base, alone
    reach = 4.0 * (float(np.max(np.abs(np.concatenate([starts, asked.position])))) + float(asked.length.max()) + 1e-12)
    other = Scene(medium, extent=Box((-4.0 * reach,) * 3, (4.0 * reach,) * 3))
    other.add_sphere((reach, reach, reach), 1e-3 * reach, materials.Black())
    return False, of(other, precision="double"), base


def _measure(base: _Trial, pairs: dict[str, tuple[bool, _Trial | None, _Trial | None]]) -> None:
    """All trials in turn, several times; what cannot be traced so (discrete layers integrated) is left out."""
    trials = {id(trial): trial for _, *both in pairs.values() for trial in both if trial is not None}
    trials[id(base)] = base
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        for key, trial in list(trials.items()):
            try:
                trial.turn()
            except (ValueError, RuntimeError):
                del trials[key]
            trial.seconds.clear()  # the first finds caches cold
        start = time.perf_counter()
        for number in range(_ROUNDS[1]):
            if number >= _ROUNDS[0] and time.perf_counter() - start > _ENOUGH:
                break
            order = list(trials.values())
            for i in np.roll(np.arange(len(order)), number):  # nobody always comes first
                order[i].turn()


def _cost(having: _Trial | None, lacking: _Trial | None) -> tuple[float | None, float | None]:
    """Seconds with it over seconds without, of each turn: median, and median distance from it."""
    if having is None or lacking is None or not having.seconds or not lacking.seconds:
        return None, None
    return middle(np.array(having.seconds) / np.array(lacking.seconds))


def _counters(name: str, needed: bool, having: _Trial | None, lacking: _Trial | None, base: Rays,
              wavelengths: int) -> str:
    """What it did, or the zeros that prove its absence and what it would have done."""
    def of(trial: _Trial | None) -> str:
        if trial is None or trial.rays is None:
            return ""
        rays = trial.rays
        if name in ("curved", "surfaces"):
            return f"{rays.steps.mean():.1f} steps a ray" + (f", {np.mean(rays.status == 1):.0%} hit" if name == "surfaces"
                                                              else "")
        if name == "integrator":
            return (f"{rays.evaluations.mean():.1f} evaluations, {rays.rejected.mean():.1f} steps refused a ray"
                    if rays.evaluations.any() else "0 evaluations")
        if name == "dispersion":
            return f"{len(rays) // max(1, len(base) // wavelengths)} trace(s) for {wavelengths} wavelengths"
        if name == "paths":
            return f"{0 if rays.paths is None else rays.paths.nbytes:,} bytes"
        if name == "global_error":
            return f"{rays.error_evaluations.mean():.1f} further evaluations a ray"
        return f"{rays.evaluations.mean():.1f} evaluations a ray"

    shown, other = of(having if needed else lacking), of(lacking if needed else having)
    return shown + (f" ({'without' if needed else 'with'}: {other})" if other and shown else "")


def _described(target: Any, rays: Rays) -> str:
    where = target.medium if isinstance(target, Scene) else target
    ended = ", ".join(f"{count:,} {name}" for name, count in _ends(rays))
    return f"{where!r}\n{len(rays):,} rays by {rays.method[0]}: {ended}"


def _ends(rays: Rays) -> list[tuple[str, int]]:
    from .status import RayStatus

    codes, counts = np.unique(rays.status, return_counts=True)
    return [(RayStatus(code).name.lower(), int(count)) for code, count in zip(codes, counts, strict=True)]
