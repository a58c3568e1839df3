"""What a scene needs, what was left out for it, and what each costs: measured, not listed."""
from __future__ import annotations

import time
import warnings
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from . import media
from ._arrays import FloatArray
from .camera import Camera
from .explain_rays import RayExplanation, explain_rays
from .feature import Feature, lines_of, middle
from .materials import Black, Mirror
from .render import render
from .scene import Scene
from .settings import resolve
from .shapes import extent_of
from .status import feature_names

__all__ = ["Explanation", "Feature", "explain"]

#: What each feature means where it is in.
_MEANING = {
    "curved": "some medium bends rays",
    "exact": "bent paths in closed form",
    "integrator": "bent paths integrated",
    "dispersion": "bundles split by wavelength",
    "specular": "mirrors or index jumps: a caustic map",
    "boundaries": "bounded media or dielectrics",
    "spheres": "exact spheres",
    "meshes": "triangles",
    "shading_normals": "interpolated normals",
    "area_lights": "emission from shapes",
    "projection": "photons only where something may be hit",
    "delta_lights": "point or spot lights",
    "extinction": "air dims light on its way",
    "sky": "a sun or an environment beyond the extent",
}

#: The trial: small, so that an explanation takes seconds, and several in turn, since machines are noisy.
_TRIAL: dict[str, Any] = {"size": (80, 60), "photons": 50_000, "nearest": 50, "samples": 1, "seed": 0}
_ROUNDS = (3, 9)  # at least, at most
_ENOUGH = 6.0     # s, after which no further round begins
_FAN = 28         # x as many eye rays that are explained alone


@dataclass(frozen=True)
class Explanation:
    """What :func:`explain` found; ``print`` it.

    Attributes
    ----------
    scene : str
        What is in it.
    features : list of Feature
    stats : dict
        Of the trial; empty where nothing was measured.
    rays : RayExplanation or None
        The same of the camera's rays alone, without photons; None where there is no camera or nothing was measured.
    """

    scene: str
    features: list[Feature]
    stats: dict[str, Any] = field(default_factory=dict)
    rays: RayExplanation | None = None

    def __str__(self) -> str:
        measured = bool(self.stats)
        lines = [self.scene, *lines_of(self.features, measured)]
        if measured:
            width, height = _TRIAL["size"]
            lines.append(f"\n× is the time of a whole render with it over one without, as measured on {width} × {height} "
                         f"pixels and {_TRIAL['photons']:,} photons\n(here {self.stats['seconds_total']:.2f} s); "
                         "~ 1: less than the noise; -: not tried.")
        if self.rays is not None:
            lines.append(f"\nEye rays alone\n{self.rays}")
        return "\n".join(lines)


def explain(medium_or_scene: Scene | Any, origins: npt.ArrayLike | None = None, directions: npt.ArrayLike | None = None, *,
            measure: bool = True, **options: Any) -> Explanation | RayExplanation:
    """Say what is needed, what is left out, and what each costs, of a scene's picture or of rays.

    Parameters
    ----------
    medium_or_scene : Medium or Scene
    origins, directions : array_like, shape (N, 3) or (3,), optional
        With them rays are explained, as :func:`cpm.trace` would trace them; a medium needs them. Few rays are repeated, so
        that there is something to time.
    measure : bool
        Render, or trace, trials to fill in counters and costs; takes seconds. A picture needs a camera and a light.
    **options
        Of rays: those of :func:`cpm.trace`; ``wavelength`` is 550 nm by default.

    Returns
    -------
    Explanation or RayExplanation
        The latter where rays are given.

    Raises
    ------
    ValueError
        A medium without rays; what :func:`cpm.trace` refuses.
    """
    if origins is not None and directions is not None:
        return explain_rays(medium_or_scene, origins, directions, measure=measure, **options)
    if origins is not None or directions is not None or not isinstance(medium_or_scene, Scene):
        raise ValueError("explain needs a Scene, or a medium or scene with origins and directions of rays")
    if options:
        raise ValueError(f"{next(iter(options))} is given without rays; give origins and directions")
    scene = medium_or_scene
    wavelengths = resolve(scene.render_defaults).wavelengths
    needed, _ = feature_names(scene._use().features(wavelengths))
    stats: dict[str, Any] = {}
    costs: dict[str, tuple[float, float]] = {}
    rays = None
    if measure and scene.camera is not None and scene.lights:
        stats, costs = _measured(scene)
        rays = explain_rays(scene, scene.camera.origin, _fan(scene.camera), wavelength=float(wavelengths[len(wavelengths) // 2]))
    features = [Feature(name, name in needed, meaning, _counters(name, stats), *costs.get(name, (None, None)))
                for name, meaning in _MEANING.items()]
    return Explanation(_described(scene, wavelengths), features, stats, rays)


def _fan(camera: Camera) -> FloatArray:
    """Directions over the camera's field of view, as high as it is wide."""
    half = np.tan(np.radians(camera.fov) / 2) * np.linspace(-1.0, 1.0, _FAN)
    right, up, forward = camera.axes()
    x, y = (part.ravel()[:, None] for part in np.meshgrid(half, half))
    return x * right + y * up + forward


def _described(scene: Scene, wavelengths: Any) -> str:
    triangles = sum(len(shape.faces) for shape in scene.shapes if shape.faces is not None)
    counts = (_counted(len(scene.shapes), "shape") + (f" ({_counted(triangles, 'triangle')})" if triangles else ""),
              _counted(len(scene.media), "bounded medium", "bounded media"), _counted(len(scene.lights), "light"),
              _counted(len(wavelengths), "bin"))
    return f"{scene.medium!r}\n{', '.join(counts)}"


def _counted(number: int, one: str, more: str | None = None) -> str:
    return f"{number:,} {one if number == 1 else more or one + 's'}"


def _measured(scene: Scene) -> tuple[dict[str, Any], dict[str, tuple[float, float]]]:
    """Stats of the scene's own trial, and what each feature costs: seconds with it over seconds without, and spread.

    A feature's cost comes from the variant of the scene that changes it and the least else. Trials take turns and are
    compared within their round, so that a busy moment of the machine does not fall on one of them alone.
    """
    made = (make(scene) for make in _VARIANTS)
    variants: list[tuple[Scene, dict[str, Any]]] = [(scene, {}), *((one, {}) for one in made if one is not None),
                                                    (scene, {"projection": False})]
    rounds: list[list[dict[str, Any]]] = []
    start = time.perf_counter()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # a black trial is no news
        for variant, options in variants:
            render(variant, **_TRIAL | {"photons": 1000}, **options)  # builds what is kept
        while len(rounds) < _ROUNDS[0] or len(rounds) < _ROUNDS[1] and time.perf_counter() - start < _ENOUGH:
            turn: list[dict[str, Any]] = [{}] * len(variants)
            for i in np.roll(np.arange(len(variants)), len(rounds)):  # nobody always comes first
                turn[i] = render(variants[i][0], **_TRIAL, **variants[i][1]).stats
            rounds.append(turn)

    seconds = np.array([[stats["seconds_total"] for stats in turn] for turn in rounds])
    ratios = seconds[:, 1:] / seconds[:, :1]  # of a variant to the scene itself
    base, *others, _ = rounds[0]
    costs: dict[str, tuple[float, float]] = {}
    if "projection" in base["features"]:
        costs["projection"] = middle(1.0 / ratios[:, -1])
    changes = [set(base["features"]) ^ set(stats["features"]) for stats in others]
    for i in sorted(range(len(others)), key=lambda i: len(changes[i])):
        for name in changes[i] - set(costs):
            costs[name] = middle(1.0 / ratios[:, i] if name in base["features"] else ratios[:, i])
    return {**base, "seconds_total": float(np.median(seconds[:, 0]))}, costs


def _small_thing(scene: Scene) -> tuple[Any, float]:
    """Centre and radius of something too small to matter, in the middle of the scene."""
    low, high = extent_of(scene.shapes)
    return 0.5 * (low + high), 1e-3 * float(np.linalg.norm(high - low))


def _bent(scene: Scene, **integrator: Any) -> Scene | None:
    """The scene in a medium that bends rays by next to nothing."""
    if not isinstance(scene.medium, media.Homogeneous):
        return None
    n, _ = scene.medium.evaluate((0.0, 0.0, 0.0))
    return scene.copy(medium=media.LinearSquared(float(n[0]) ** 2, (0.0, 1e-6, 0.0)), **integrator)


def _with_mirror(scene: Scene) -> Scene:
    changed = scene.copy()
    changed.add_sphere(*_small_thing(scene), Mirror())
    return changed


def _with_sphere(scene: Scene) -> Scene:
    changed = scene.copy()
    changed.add_sphere(*_small_thing(scene), Black())
    return changed


def _without_exact(scene: Scene) -> Scene | None:
    return _bent(scene, exclude=("exact",)) or scene.copy(exclude=("exact",))


#: Scenes that differ from the one explained in a feature or two; None where there is no such scene.
_VARIANTS: tuple[Callable[[Scene], Scene | None], ...] = (_bent, _without_exact, _with_mirror, _with_sphere)


def _counters(name: str, stats: dict[str, Any]) -> str:
    """The counters that show a feature at work, or its absence."""
    if not stats:
        return ""
    if name == "curved":
        return f"{stats['photon_evaluations'] + stats['eye_evaluations']:,} gradient evaluations"
    if name == "specular":
        return (f"{stats['photons_stored_caustic']:,} caustic photons, {stats['bytes_caustic']:,} bytes, "
                f"{stats['projection_caustic_cells']:,} projection cells")
    if name == "projection":
        return (f"{stats['projection_active']} of {stats['projection_cells']} cells active, "
                f"{1e3 * stats['seconds_project']:.1f} ms")
    return ""
