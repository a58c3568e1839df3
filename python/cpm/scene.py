"""The scene: a medium that fills space, bounded media, shapes, lights, a camera."""
from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _core
from ._arrays import Vector, VectorLike, as_number, as_points, as_vector
from ._sky import SkyImage, compass, limb_table, towards
from .bounds import Bounds, Box, Sphere
from .camera import Camera
from .lights import Area, Environment, Light, Point, Spot, Sun
from .materials import Dielectric, Material, as_material
from .media import Grid, Medium, as_medium
from .settings import RenderSettings
from .shapes import Shape
from .status import exclusion_bits, method_code

__all__ = ["Scene"]


class Scene:
    """What is rendered.

    Parameters
    ----------
    medium : Medium, float, str or Dispersion, optional
        Fills everything; default ``Homogeneous(1)``.
    extent : Box, optional
        A ray that crosses it outward has ``LEFT``. Default: the box of shapes, lights and camera grown on each side
        by its diagonal; infinite where everything is homogeneous.
    method : str
        Integrator of curved paths, as in :func:`cpm.trace`.
    exclude : sequence of str
        Methods that "auto" may not choose.
    rtol, atol : float, optional
        Tolerance: position error ≤ atol (m) + rtol × path length. Default rtol 1e-6 (1e-2 for "euler"), atol 0.
    step : float, optional
        Fixed steps, metres of arc.
    max_step : float, optional
        Bound on adaptive steps, metres.

    Attributes
    ----------
    render_defaults : RenderSettings
        What :func:`cpm.render` and :func:`cpm.trace_photons` use for arguments left None; a scene file's [render].

    Notes
    -----
    Bounded media and dielectric shapes form one list in order of addition: where several contain a point the last wins.
    """

    def __init__(self, medium: Any = None, *, extent: Box | None = None, method: str = "auto",
                 exclude: Any = (), rtol: float | None = None, atol: float | None = None, step: float | None = None,
                 max_step: float | None = None) -> None:
        self._additions: list[Callable[[_core.Scene], int]] = []
        self._handle: _core.Scene | None = None
        self._in_use = False
        self._medium = as_medium(1.0 if medium is None else medium)
        self._extent = _as_extent(extent)
        self._camera: Camera | None = None
        self._integrator: dict[str, Any] = {
            "method": method_code(method),
            "exclude": exclusion_bits(exclude),
            "rtol": 0.0 if rtol is None else as_number(rtol, "rtol"),
            "atol": 0.0 if atol is None else as_number(atol, "atol"),
            "step": 0.0 if step is None else as_number(step, "step"),
            "max_step": 0.0 if max_step is None else as_number(max_step, "max_step"),
        }
        self.shapes: list[Shape] = []
        self.lights: list[Light] = []
        self.media: list[Medium] = []
        self._fillings: list[tuple[Bounds, Medium]] = []  # where what is, in order of addition: the last wins
        self.render_defaults = RenderSettings()
        self._open()

    def copy(self, medium: Any = None, **integrator: Any) -> Scene:
        """The same scene, to be changed apart from this one.

        Parameters
        ----------
        medium : Medium, optional
            Another one to fill everything.
        **integrator
            ``method``, ``exclude``, ``rtol``, ``atol``, ``step``, ``max_step``, ``extent``: others than this scene's.
        """
        extent = integrator.pop("extent", self._extent)
        made = Scene(self._medium if medium is None else medium, extent=extent, **integrator)
        made._integrator = {**self._integrator, **{name: made._integrator[name] for name in integrator}}
        made._additions = list(self._additions)
        made._camera = self._camera
        made.shapes = [replace(shape, _owner=made) for shape in self.shapes]
        made.lights, made.media = list(self.lights), list(self.media)
        made._fillings = list(self._fillings)
        made.render_defaults = replace(self.render_defaults)
        made._handle = None
        return made

    # What fills space, how far it goes, who looks.

    @property
    def medium(self) -> Medium:
        """What fills everything that no bounded medium or dielectric does."""
        return self._medium

    @medium.setter
    def medium(self, value: Any) -> None:
        self._medium, self._handle = as_medium(value), None

    @property
    def extent(self) -> Box:
        """The box at which rays leave. Default: the medium's own (an atmosphere's top), else shapes, lights and camera
        grown on each side by their diagonal; infinite where nothing bends. Set it to None to have it chosen again."""
        return self._extent if self._extent is not None else Box.unchecked(*self._use().extent())

    @extent.setter
    def extent(self, value: Box | None) -> None:
        self._extent, self._handle = _as_extent(value), None

    @property
    def up(self) -> Vector:
        """The medium's up (of a sum: of its first term that has one), else +y: whose sky it is."""
        for term in getattr(self._medium, "terms", (self._medium,)):
            if hasattr(term, "up"):
                return as_vector(term.up, "up")
        return (0.0, 1.0, 0.0)

    @property
    def camera(self) -> Camera | None:
        """The camera; None until it is set."""
        return self._camera

    @camera.setter
    def camera(self, camera: Camera) -> None:
        if not isinstance(camera, Camera):
            raise TypeError(f"camera is {camera!r}; cpm.Camera.look_at makes one")
        self._open().set_camera(camera.origin, camera.target, camera.up, camera.fov)
        self._camera = camera

    # Additions. Each is made in the core at once, so that bad input is refused here, and remembered for a rebuild.

    def add_mesh(self, vertices: npt.ArrayLike, faces: npt.ArrayLike, material: Material,
                 normals: npt.ArrayLike | None = None, name: str = "") -> Shape:
        """Add triangles.

        Parameters
        ----------
        vertices : array_like, shape (V, 3)
            Metres.
        faces : array_like of int, shape (F, 3)
            Indices of vertices; the geometric normal is (b − a) × (c − a). Triangles of no area are dropped.
        material : Material
            A ``Dielectric`` needs a closed, consistently oriented mesh.
        normals : array_like, shape (V, 3), optional
            Shading normals.
        name : str
            For messages.

        Returns
        -------
        Shape
        """
        material = as_material(material)
        points, triangles = as_points(vertices, "vertices").copy(), _as_faces(faces, len(np.atleast_2d(vertices)))
        shading = None if normals is None else as_points(normals, "normals").copy()
        if shading is not None and shading.shape != points.shape:
            raise ValueError(f"normals has shape {shading.shape}; that of vertices, {points.shape}, is needed")
        core_material = material._core()
        index = self._add(lambda core: core.add_mesh(points, triangles, core_material, shading, name or None))
        return self._keep(Shape(index, name, material, vertices=points, faces=triangles, _owner=self))

    def add_sphere(self, center: VectorLike, radius: float, material: Material, name: str = "") -> Shape:
        """Add an exact sphere.

        Parameters
        ----------
        center : array_like, shape (3,)
            Metres.
        radius : float
            Metres, > 0.
        material : Material
        name : str
            For messages.

        Returns
        -------
        Shape
        """
        ball = Sphere(center, radius)
        core_material = as_material(material)._core()
        index = self._add(lambda core: core.add_sphere(ball.center, ball.radius, core_material, name or None))
        return self._keep(Shape(index, name, material, center=ball.center, radius=ball.radius, _owner=self))

    def add_medium(self, medium: Medium) -> Medium:
        """Add a bounded medium; it is where ``medium.bounds`` is (without bounds a Grid fills the box of its samples,
        Luneburg's and Eaton's lenses their sphere).

        Returns
        -------
        Medium
            The same one.
        """
        if not isinstance(medium, Medium):
            raise TypeError(f"medium is {medium!r}; one of cpm.media is needed")
        bounds = medium._own_bounds() if medium.bounds is None else medium.bounds
        handle = medium._handle
        if isinstance(bounds, Box):
            low, high = bounds.low, bounds.high
            self._add(lambda core: core.add_medium_in_box(handle, low, high))
        elif isinstance(bounds, Sphere):
            center, radius = bounds.center, bounds.radius
            self._add(lambda core: core.add_medium_in_sphere(handle, center, radius))
        elif isinstance(bounds, Shape):
            index = self._own(bounds).index
            self._add(lambda core: core.add_medium_in_shape(handle, index))
        else:
            raise ValueError(f"{type(medium).__name__} has bounds {bounds!r}; a Box, a Sphere or a shape of the scene "
                             "is needed")
        self.media.append(medium)
        self._fillings.append((bounds, medium))
        return medium

    def add_light(self, light: Light) -> Light:
        """Add one of :mod:`cpm.lights`.

        Returns
        -------
        Light
            The same one.
        """
        if isinstance(light, Spot):
            spectrum = light.intensity._core()
            self._add(lambda core: core.add_spot(light.position, light.target, light.cutoff, spectrum))
        elif isinstance(light, Point):
            spectrum = light.intensity._core()
            self._add(lambda core: core.add_point(light.position, spectrum))
        elif isinstance(light, Area):
            spectrum, index = light.radiance._core(), self._own(light.shape).index
            self._add(lambda core: core.add_area(index, spectrum))
        elif isinstance(light, (Sun, Environment)):
            self._add(lambda core: _add_far(core, light, self.up))
        else:
            raise TypeError(f"light is {light!r}; one of cpm.lights (Point, Spot, Area, Sun, Environment) is needed")
        self.lights.append(light)
        return light

    def __repr__(self) -> str:
        return (f"Scene(medium={self.medium!r}, {len(self.shapes)} shapes, {len(self.media)} bounded media, "
                f"{len(self.lights)} lights)")

    # The core's scene: built by additions, shared once it is in use, rebuilt when it then changes.

    def _own(self, shape: Shape) -> Shape:
        if shape._owner is not self:
            raise ValueError(f"shape {shape.name or shape.index!r} belongs to another scene")
        return shape

    def _keep(self, shape: Shape) -> Shape:
        self.shapes.append(shape)
        if isinstance(shape.material, Dielectric):
            self._fillings.append((shape, shape.material.interior))
        return shape

    def _add(self, addition: Callable[[_core.Scene], int]) -> int:
        index = addition(self._open())
        self._additions.append(addition)
        return index

    def _open(self) -> _core.Scene:
        """A core scene that may still be changed."""
        if self._handle is None or self._in_use:
            extent = self._extent if self._extent is not None else self._medium.extent
            handle = _core.Scene(medium=self._medium._handle,
                                 extent=None if extent is None else (extent.low, extent.high),
                                 **self._integrator)
            for addition in self._additions:
                addition(handle)
            if self._camera is not None:
                camera = self._camera
                handle.set_camera(camera.origin, camera.target, camera.up, camera.fov)
            self._handle, self._in_use = handle, False
        return self._handle

    def _use(self) -> _core.Scene:
        """The core scene for tracing; later changes make a new one, so that a running render is not disturbed."""
        handle = self._handle if self._handle is not None else self._open()
        self._in_use = True
        return handle


def _add_far(core: _core.Scene, light: Sun | Environment, scene_up: Vector) -> int:
    up = scene_up if light.up is None else light.up
    aim = None if light.aim is None else (light.aim.low, light.aim.high)
    if isinstance(light, Sun):
        limb = limb_table() if light.limb_darkening else None
        return core.add_sun(towards(light.elevation, light.azimuth, up), light.angular_radius, light.radiance._core(),
                            limb, aim)
    if not isinstance(light.radiance, SkyImage):
        return core.add_environment(light.radiance._core(), aim)
    axis, north, _ = compass(up)
    image = light.radiance
    return core.add_sky_image(image.wavelengths, image.values, as_vector(axis, "up"), as_vector(north, "north"), aim)


def _as_extent(extent: Box | None) -> Box | None:
    if extent is not None and not isinstance(extent, Box):
        raise TypeError(f"extent is {extent!r}; a cpm.Box is needed")
    return extent


def _as_faces(faces: npt.ArrayLike, vertex_count: int) -> npt.NDArray[np.uint32]:
    triangles = np.asarray(faces)
    if triangles.size == 0:
        triangles = np.zeros((0, 3), dtype=np.uint32)
    if triangles.dtype.kind not in "iu":
        raise TypeError(f"faces holds {triangles.dtype.name}; integers are needed")
    if triangles.ndim != 2 or triangles.shape[1] != 3:
        raise ValueError(f"faces has shape {triangles.shape}; (F, 3) is needed")
    # Before the conversion to uint32, where -1 would become a large index.
    bad = np.argwhere((triangles < 0) | (triangles >= vertex_count))
    if bad.size:
        row, column = bad[0]
        raise ValueError(f"faces[{row}][{column}] is {triangles[row, column]}; 0 to {vertex_count - 1} are allowed")
    return np.array(triangles, dtype=np.uint32, order="C")  # ours: the caller's may change
