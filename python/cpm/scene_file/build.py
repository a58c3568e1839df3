"""Checked tables to a scene. What the file names by name is looked up here; what the core refuses gets its key."""
from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from .. import _core, atmosphere, dispersion, lights, materials, media, spectra, wavelengths
from .._arrays import bin_centers
from .._sky import is_sky_file, read_sky
from ..bounds import Bounds, Box, Sphere
from ..camera import Camera
from ..scene import Scene
from ..settings import RenderSettings, as_wavelengths
from ..shapes import Shape
from . import models
from .errors import SceneFileError, listed, shown
from .meshes import load_mesh, quads, transformed


def build(table: models.SceneTable, path: str | os.PathLike[str]) -> Scene:
    """The scene that a file describes."""
    return _Builder(table, Path(path)).scene()


class _Builder:
    """Keeps what a file defines by name."""

    def __init__(self, table: models.SceneTable, path: Path) -> None:
        self.table, self.path, self.folder = table, path, path.parent
        self.shapes: dict[str, Shape] = {}
        self.shape_names = [shape.name for shape in table.shapes if shape.name is not None]

    def scene(self) -> Scene:
        table = self.table
        with self.at("medium"):
            medium = None if table.medium is None else self.medium(table.medium, "medium")
        with self.at("integrator"):
            scene = Scene(medium, extent=self.box(table.extent), **table.integrator.model_dump())
        self.materials = {}
        for name, material in table.materials.items():
            self.materials[name] = self.material(material, f"materials.{name}")

        # One list decides where media overlap, and the last wins. Bounded media come before dielectric shapes, so that
        # glass in a heated region stays glass; a shape that bounds a medium has to be there before it.
        bounding = {medium.bounds.shape for medium in table.media if isinstance(medium.bounds, models.ShapeBounds)}
        later = []
        for i, shape in enumerate(table.shapes):
            if shape.name in bounding:
                self.add_shape(scene, shape, f"shapes[{i}]")
            else:
                later.append((shape, f"shapes[{i}]"))
        for i, bounded in enumerate(table.media):
            self.add_medium(scene, bounded, f"media[{i}]")
        for shape, key in later:
            self.add_shape(scene, shape, key)

        for i, light in enumerate(table.lights):
            with self.at(f"lights[{i}]"):
                scene.add_light(self.light(light, f"lights[{i}]"))
        if table.camera is not None:
            with self.at("camera"):
                scene.camera = Camera.look_at(**table.camera.model_dump())
        scene.render_defaults = self.render_settings(scene)
        return scene

    # Errors.

    def refuse(self, key: str, value: Any, problem: str) -> SceneFileError:
        return SceneFileError(self.path, key, f"{shown(value)}: {problem}")

    @contextmanager
    def at(self, key: str) -> Iterator[None]:
        """Whatever is refused inside gets the key."""
        try:
            yield
        except SceneFileError:
            raise
        except (ValueError, TypeError, _core.Error) as error:
            raise SceneFileError(self.path, key, str(error)) from None

    def file(self, name: str, key: str) -> Path:
        path = self.folder / name
        if not path.is_file():
            raise self.refuse(key, name, "no such file")
        return path

    # Spectra, dispersion, media.

    def spectrum(self, value: Any, key: str, seen: tuple[str, ...] = ()) -> spectra.Spectrum:
        with self.at(key):
            if isinstance(value, str):
                return self.named_spectrum(value, key, seen)
            if not isinstance(value, models.SpectrumTable):
                return spectra.as_spectrum(value)
            if value.name is not None:
                made = self.named_spectrum(value.name, f"{key}.name", seen)
            elif value.file is not None:
                made = spectra.Spectrum(*self.columns(value.file, f"{key}.file"))
            else:
                made = spectra.Spectrum(value.wavelengths, value.values or [])
            return made.scaled(value.scale)

    def named_spectrum(self, name: str, key: str, seen: tuple[str, ...]) -> spectra.Spectrum:
        if name in self.table.spectra and name not in seen:
            return self.spectrum(self.table.spectra[name], f"spectra.{name}", (*seen, name))
        try:
            return spectra.named(name)
        except ValueError:
            allowed = listed([*self.table.spectra, *spectra.names()])
            raise self.refuse(key, name, f"no such spectrum (allowed: {allowed}, or an illuminant such as D65, A, E)"
                              ) from None

    def columns(self, name: str, key: str) -> tuple[np.ndarray, np.ndarray]:
        """Wavelengths (nm) and values of a text file of two columns, separated by commas or blanks."""
        path = self.file(name, key)
        try:
            rows = [line.split("#")[0].replace(",", " ").split() for line in path.read_text("utf-8").splitlines()]
            table = np.array([[float(number) for number in row] for row in rows if row])
        except ValueError as error:
            raise self.refuse(key, name, f"two columns of numbers are needed ({error})") from None
        if table.ndim != 2 or table.shape[1] != 2:
            raise self.refuse(key, name, "two columns of numbers are needed")
        return table[:, 0], table[:, 1]

    def index(self, value: Any, key: str) -> Any:
        """A number or a dispersion."""
        if not isinstance(value, models.DispersionTable):
            return dispersion.catalogue(value) if isinstance(value, str) else value
        if value.catalogue is not None:
            if value.range is not None:
                raise self.refuse(f"{key}.range", value.range, "the catalogue has its own range")
            return dispersion.catalogue(value.catalogue, extrapolate=value.extrapolate)
        options: dict[str, Any] = {"extrapolate": value.extrapolate}
        if value.range is not None:
            options["range"] = value.range
        if value.constant is not None:
            return dispersion.Constant(value.constant, **options)
        if value.cauchy is not None:
            return dispersion.Cauchy(*value.cauchy, **options)
        if value.sellmeier is not None:
            return dispersion.Sellmeier(value.sellmeier.B, value.sellmeier.C, **options)
        if value.air is not None:
            if value.range is not None:
                raise self.refuse(f"{key}.range", value.range, "air has its own range")
            return dispersion.Air(**value.air.model_dump(), **options)
        assert value.tabulated is not None
        return dispersion.Tabulated(value.tabulated.wavelengths, value.tabulated.n, **options)

    def medium(self, table: Any, key: str, bounds: Bounds | None = None) -> media.Medium:
        """A medium of any kind; ``bounds`` are those of [[media]], elsewhere the table must have none."""
        if bounds is None and table.bounds is not None:
            raise SceneFileError(self.path, f"{key}.bounds", "bounds are for [[media]]; this one fills its place")
        common: dict[str, Any] = {"bounds": bounds}
        with self.at(key):
            if getattr(table, "dispersion", None) is not None:
                common["dispersion"] = self.index(table.dispersion, f"{key}.dispersion")
            match table:
                case models.HomogeneousTable() | models.PlainTable():
                    return media.Homogeneous(self.index(table.n, f"{key}.n"), **common)
                case models.LinearSquaredTable():
                    return media.LinearSquared(table.n_squared, table.gradient, table.origin, **common)
                case models.LinearTable():
                    return media.Linear(table.n, table.gradient, table.origin, **common)
                case models.LayeredTable():
                    return media.Layered(table.heights, table.n, table.up, table.origin, table.radius,
                                         table.interpolation, **common)
                case models.AtmosphereTable():
                    return media.Atmosphere(self.profile(table.profile, f"{key}.profile"), table.radius, table.up,
                                            table.refractivity, table.origin, extinction=table.extinction, **common)
                case models.ExpressionTable():
                    return media.Expression(table.text, **table.constants, **common)
                case models.SumTable():
                    if table.dispersion is not None:
                        raise SceneFileError(self.path, f"{key}.dispersion", "is each term's own; a sum has none")
                    terms = [self.medium(term, f"{key}.terms[{i}]") for i, term in enumerate(table.terms)]
                    return media.Sum(*terms, bounds=bounds)
                case models.ParabolicTable():
                    return media.Parabolic(table.n, table.alpha, table.axis, table.origin, **common)
                case models.LuneburgTable():
                    return media.Luneburg(table.radius, table.center, **common)
                case models.FisheyeTable():
                    return media.Fisheye(table.n, table.radius, table.center, **common)
                case models.EatonTable():
                    return media.Eaton(table.radius, table.center, **common)
                case models.SourcesTable():
                    return media.Sources(table.centers, table.strengths, table.exponent, table.directions, **common)
                case _:
                    return self.grid(table, key, common)

    def profile(self, table: Any, key: str) -> atmosphere.Profile:
        with self.at(key):
            match table:
                case models.StandardTable():
                    return atmosphere.USStandard1976()
                case models.PolytropicTable():
                    return atmosphere.Polytropic(**table.model_dump(exclude={"type"}))
                case models.LevelsTable(file=str()):
                    return atmosphere.read_sounding(self.file(table.file, f"{key}.file"), table.interpolation)
                case models.LevelsTable():
                    return atmosphere.Table(**table.model_dump(exclude={"type", "file"}))
                case models.HotSurfaceTable():
                    return atmosphere.HotSurface(self.profile(table.base, f"{key}.base"), table.excess, table.thickness)
                case _:
                    return atmosphere.Inversion(self.profile(table.base, f"{key}.base"), table.height, table.strength,
                                                table.thickness)

    def grid(self, table: models.GridTable, key: str, common: dict[str, Any]) -> media.Grid:
        path = self.file(table.values, f"{key}.values")
        try:
            values = np.load(path, allow_pickle=False)  # data, never code
        except (ValueError, OSError, EOFError) as error:
            raise self.refuse(f"{key}.values", table.values, f"a .npy file of numbers is needed ({error})") from None
        if table.gladstone_dale is not None:
            common["gladstone_dale"] = table.gladstone_dale
        return media.Grid(values, table.origin, table.spacing, table.interpolation, table.quantity, **common)

    @staticmethod
    def box(table: models.BoxTable | None) -> Box | None:
        return None if table is None else Box(table.low, table.high)

    def add_medium(self, scene: Scene, table: Any, key: str) -> None:
        bounds: Bounds | None
        with self.at(f"{key}.bounds"):
            match table.bounds:
                case models.BoxTable():
                    bounds = self.box(table.bounds)
                case models.BallTable():
                    bounds = Sphere(table.bounds.center, table.bounds.radius)
                case models.ShapeBounds():
                    bounds = self.shape(table.bounds.shape, f"{key}.bounds.shape")
                case _ if isinstance(table, (models.GridTable, models.LuneburgTable, models.EatonTable)):
                    bounds = None  # the box of its samples, the lens's sphere
                case _:
                    raise SceneFileError(self.path, f"{key}.bounds", "is missing")
        with self.at(key):
            scene.add_medium(self.medium(table, key, bounds))

    # Materials, shapes, lights, settings.

    def material(self, table: Any, key: str) -> materials.Material:
        with self.at(key):
            match table:
                case models.DiffuseTable():
                    return materials.Diffuse(self.spectrum(table.reflectance, f"{key}.reflectance"))
                case models.MirrorTable():
                    return materials.Mirror(self.spectrum(table.reflectance, f"{key}.reflectance"))
                case models.BlackTable():
                    return materials.Black()
                case _:
                    inside = table.interior
                    plain = isinstance(inside, (str, float, models.DispersionTable))
                    return materials.Dielectric((self.index if plain else self.medium)(inside, f"{key}.interior"))

    def material_of(self, value: Any, key: str) -> materials.Material:
        if not isinstance(value, str):
            return self.material(value, key)
        if value not in self.materials:
            raise self.refuse(key, value, f"no such material (allowed: {listed(self.materials)})")
        return self.materials[value]

    def add_shape(self, scene: Scene, table: Any, key: str) -> None:
        if table.name is not None and table.name in self.shapes:
            raise self.refuse(f"{key}.name", table.name, "another shape has this name")
        material, name = self.material_of(table.material, f"{key}.material"), table.name or key
        with self.at(key):
            if isinstance(table, models.SphereTable):
                shape = scene.add_sphere(table.center, table.radius, material, name=name)
            elif isinstance(table, models.GroundTable):
                shape = scene.add_sphere(*self.ground(scene.medium, f"{key}.type"), material, name=name)
            elif isinstance(table, models.QuadsTable):
                shape = scene.add_mesh(*quads(table), material, name=name)
            else:
                shape = self.add_mesh(scene, table, key, material, name)
        if table.name is not None:
            self.shapes[table.name] = shape

    def ground(self, medium: media.Medium, key: str) -> tuple[Any, float]:
        """Centre and radius of the sphere at the atmosphere's lowest height."""
        for term in medium.terms if isinstance(medium, media.Sum) else (medium,):
            if isinstance(term, media.Atmosphere) and term.radius is not None:
                return term.center, term.radius + term.profile.ground
        raise self.refuse(key, "ground", "needs [medium] to be an atmosphere with a radius")

    def add_mesh(self, scene: Scene, table: models.MeshTable, key: str, material: Any, name: str) -> Shape:
        try:
            vertices, faces, normals = load_mesh(self.folder / table.file, table.smooth)
        except ValueError as error:
            raise self.refuse(f"{key}.file", table.file, str(error)) from None
        if not np.all(table.transform.scale):
            raise self.refuse(f"{key}.transform.scale", table.transform.scale, "must not be 0")
        vertices, normals = transformed(vertices, normals, table.transform)
        return scene.add_mesh(vertices, faces, material, normals=normals, name=name)

    def shape(self, name: str, key: str) -> Shape:
        if name not in self.shapes:
            raise self.refuse(key, name, f"no such shape (allowed: {listed(self.shape_names)})")
        return self.shapes[name]

    def light(self, table: Any, key: str) -> lights.Light:
        match table:
            case models.PointTable():
                return lights.Point(table.position, self.spectrum(table.intensity, f"{key}.intensity"))
            case models.SpotTable():
                return lights.Spot(table.position, table.target, table.cutoff,
                                   self.spectrum(table.intensity, f"{key}.intensity"))
            case models.SunTable():
                radiance = None if table.radiance is None else self.spectrum(table.radiance, f"{key}.radiance")
                return lights.Sun(table.elevation, table.azimuth, radiance, table.angular_radius, table.limb_darkening,
                                  table.up, self.box(table.aim))
            case models.EnvironmentTable():
                return lights.Environment(self.sky(table.radiance, f"{key}.radiance"), table.up, self.box(table.aim))
            case _:
                return lights.Area(self.shape(table.shape, f"{key}.shape"),
                                   self.spectrum(table.radiance, f"{key}.radiance"))

    def sky(self, value: Any, key: str) -> Any:
        """A spectrum or an image of all directions."""
        if not isinstance(value, models.SkyTable) or value.file is None or not is_sky_file(value.file):
            if isinstance(value, models.SkyTable) and value.file is not None and value.wavelengths is not None:
                raise SceneFileError(self.path, f"{key}.wavelengths", "are for a .npy; this file has its own")
            return self.spectrum(value, key)
        asked = value.wavelengths
        with self.at(f"{key}.file"):
            bins = asked.model_dump(by_alias=True) if isinstance(asked, models.BinsTable) else asked
            return read_sky(self.file(value.file, f"{key}.file"), bins, value.scale)

    def render_settings(self, scene: Scene) -> RenderSettings:
        table = self.table.render
        settings = RenderSettings(**table.model_dump(exclude={"wavelengths"}))
        if table.wavelengths is not None:
            asked = table.wavelengths
            with self.at("render.wavelengths"):
                if not isinstance(asked, models.BinsTable):
                    settings.wavelengths = as_wavelengths(asked)
                elif asked.sampling == "equal":
                    settings.wavelengths = bin_centers(asked.from_, asked.to, asked.bins)
                else:
                    settings.wavelengths = wavelengths.for_scene(scene, asked.from_, asked.to, asked.bins,
                                                                 asked.sampling)
        return settings
