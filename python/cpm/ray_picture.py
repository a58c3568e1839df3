"""Curved rays drawn in a section of the scene."""
from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING, Any

import numpy as np

from ._arrays import FloatArray
from .lights import Environment, Sun
from .rays import Rays, trace
from .scene import Scene
from .section import Section, light_source
from .settings import resolve
from .status import RayStatus, feature_names

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["ray_picture"]

#: Drawn where wavelengths part, nm and colour; else the middle one alone.
_SPLIT = ((450.0, "tab:blue"), (550.0, "tab:green"), (650.0, "tab:red"))
_SAMPLES = 256          # of a path, where rays are few
_LEAST_SAMPLES = 16
_MOST_POINTS = 1 << 22  # of all paths of one light and wavelength: bounds memory
_DRAWN_AT_ONCE = 500    # paths; matplotlib answers Ctrl-C between such pieces
_FIELD = 240            # points across, of the background
_LEVELS = 14            # of the background, about
_LEAST_CHANGE = 1e-9    # of n, below which there is no background

#: What a legend calls the ways in which a ray ends, and how it is drawn.
_ENDS = {RayStatus.HIT: ("hit", "-"), RayStatus.LEFT: ("left the scene", ":")}
_STOPPED = ("stopped", "--")


def ray_picture(scene: Scene, rays: int = 25, light: int | None = None, title: str = "") -> Figure:
    """Paths from the lights to the first surface, in the plane through a light and what it is aimed at.

    Parameters
    ----------
    scene : Scene
    rays : int
        From each light, in a fan over its cone.
    light : int, optional
        Only this one; default all (in the plane of the first).
    title : str
        Goes before what is drawn.

    Returns
    -------
    matplotlib.figure.Figure
        Walls in the plane in black, paths in colour (dotted: they leave the scene; dashed and crossed: stopped before
        their end), the index behind them where it varies; metres.
    """
    from matplotlib.figure import Figure

    if rays < 1:
        raise ValueError(f"rays is {rays}; at least 1 is needed")
    near = [source for source in scene.lights if not isinstance(source, (Sun, Environment))]  # the others have no place
    lights = near if light is None else scene.lights[light : light + 1] if light >= 0 else []
    if not lights:
        asked = "light is None" if light is None else f"light is {light}"
        allowed = f"0 to {len(scene.lights) - 1} are allowed" if scene.lights else "rays start at lights"
        raise ValueError(f"{asked}; the scene has {len(scene.lights)} lights: {allowed}")
    section = Section.through(scene, lights[0])

    figure = Figure(layout="constrained")
    axes = figure.add_subplot()
    walls = section.edges(scene)
    sources = [section.flat(light_source(source)[0]) for source in lights]
    _frame(axes, np.concatenate([walls.reshape(-1, 2), *(source[None] for source in sources)]))
    shape = np.ptp(axes.get_ylim()) / np.ptp(axes.get_xlim())
    figure.set_size_inches(8.0, float(np.clip(6.6 * shape + 1.3, 3.0, 9.0)))
    wavelengths = _colours(scene)
    _draw_index(figure, axes, section, scene, wavelengths[len(wavelengths) // 2][0])
    samples = min(max(_MOST_POINTS // rays, _LEAST_SAMPLES), _SAMPLES)
    for wavelength, colour in wavelengths:
        traced = [trace(scene, *section.fan(scene, source, rays), wavelength=wavelength, path=samples)
                  for source in lights]
        _draw_rays(axes, section, traced, wavelength, colour)
    _draw_walls(axes, walls)
    axes.plot(*np.transpose(sources), "o", color="gold", markeredgecolor="black", markersize=7, zorder=5,
              label="light" if len(sources) == 1 else "lights")
    axes.set_xlabel(section.label(section.across))
    axes.set_ylabel(section.label(section.up))
    axes.set_title(f"{title + ': ' if title else ''}rays from {'a light' if len(sources) == 1 else 'the lights'}, "
                   f"section {section.place}", fontsize=11)
    figure.legend(loc="outside lower center", ncols=4, fontsize=9, frameon=False)
    return figure


def _draw_index(figure: Any, axes: Any, section: Section, scene: Scene, wavelength: float) -> None:
    """n behind the rays, where it varies: pale steps and a colour bar."""
    from matplotlib.ticker import MaxNLocator

    x, y = np.meshgrid(np.linspace(*axes.get_xlim(), _FIELD), np.linspace(*axes.get_ylim(), _FIELD))
    n = np.ma.masked_invalid(section.index(scene, x, y, wavelength))
    if n.count() == 0 or n.max() - n.min() <= _LEAST_CHANGE:
        return
    levels = MaxNLocator(_LEVELS).tick_values(n.min(), n.max())
    drawn = axes.contourf(x, y, n, levels=levels, cmap="GnBu", alpha=0.4, zorder=0)
    bar = figure.colorbar(drawn, ax=axes, shrink=0.85, pad=0.02)
    bar.set_label(f"refractive index n at {wavelength:.0f} nm")
    bar.formatter.set_useOffset(False)


def _draw_rays(axes: Any, section: Section, traced: list[Rays], wavelength: float, colour: str) -> None:
    """Paths of one wavelength, those that end alike in one style; the legend counts them."""
    from matplotlib.collections import LineCollection

    paths = np.concatenate([section.flat(rays.paths) for rays in traced if rays.paths is not None])
    ends = [_ENDS.get(RayStatus(status), _STOPPED) for rays in traced for status in rays.status]
    for end, count in Counter(ends).items():
        chosen = [path for path, way in zip(paths, ends, strict=True) if way == end]
        for first in range(0, count, _DRAWN_AT_ONCE):
            label = f"{wavelength:.0f} nm: {count} {end[0]}" if first == 0 else "_more"
            axes.add_collection(LineCollection(chosen[first : first + _DRAWN_AT_ONCE], colors=colour, linewidths=0.8,
                                               alpha=0.85, linestyles=end[1], zorder=2, label=label), autolim=False)
        if end == _STOPPED:
            axes.plot(*np.transpose([path[-1] for path in chosen]), "x", color="black", zorder=4)


def _draw_walls(axes: Any, walls: FloatArray) -> None:
    from matplotlib.collections import LineCollection

    if len(walls):
        axes.add_collection(LineCollection(list(walls), colors="black", linewidths=1.8, zorder=3,
                                           capstyle="projecting", label="surfaces"))


def _colours(scene: Scene) -> Any:
    wavelengths = resolve(scene.render_defaults).wavelengths
    needed, _ = feature_names(scene._use().features(wavelengths))
    return _SPLIT if "dispersion" in needed else ((float(np.median(wavelengths)), "tab:orange"),)


def _frame(axes: Any, points: FloatArray) -> None:
    """Show the scene and its lights; rays that miss everything run out of the picture."""
    low, high = points.min(axis=0), points.max(axis=0)
    margin = 0.05 * max(float((high - low).max()), 1e-9)
    axes.set_xlim(low[0] - margin, high[0] + margin)
    axes.set_ylim(low[1] - margin, high[1] + margin)
    axes.set_aspect("equal")
