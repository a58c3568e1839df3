"""The pinhole camera."""
from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ._arrays import FloatArray, Vector, VectorLike, as_number, as_vector

__all__ = ["Camera"]


@dataclass(frozen=True)
class Camera:
    """A pinhole in any index. Pixel row 0 is on top, column 0 on the left, right = forward × up.

    Attributes
    ----------
    origin, target, up : tuple of 3 floats
        Metres; ``up`` is a direction.
    fov : float
        Horizontal field of view, degrees.
    """

    origin: Vector
    target: Vector
    up: Vector
    fov: float

    @classmethod
    def look_at(cls, origin: VectorLike, target: VectorLike, up: VectorLike = (0.0, 1.0, 0.0),
                fov: float = 60.0) -> Camera:
        """A camera at ``origin`` that looks at ``target``.

        Parameters
        ----------
        origin, target : array_like, shape (3,)
            Metres.
        up : array_like, shape (3,)
            What is up in the picture; not parallel to the view.
        fov : float
            Horizontal field of view, degrees, in (0, 180).
        """
        camera = cls(as_vector(origin, "origin"), as_vector(target, "target"), as_vector(up, "up"),
                     as_number(fov, "fov"))
        if not 0 < camera.fov < 180:
            raise ValueError(f"fov is {camera.fov:g} degrees; more than 0, less than 180 is allowed")
        forward = np.subtract(camera.target, camera.origin)
        if not np.any(forward):
            raise ValueError(f"origin and target are both {camera.origin}; the camera has no direction")
        with np.errstate(over="ignore"):
            parallel = (np.linalg.norm(np.cross(forward, camera.up))
                        <= 1e-12 * np.linalg.norm(forward) * np.linalg.norm(camera.up))
        if parallel:
            raise ValueError(f"up is {camera.up}; it must not be zero or parallel to the view")
        return camera

    def axes(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Unit vectors right, up and forward."""
        forward = np.subtract(self.target, self.origin)
        forward /= np.linalg.norm(forward)
        right = np.cross(forward, self.up)
        right /= np.linalg.norm(right)
        return right, np.cross(right, forward), forward
