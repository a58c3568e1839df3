"""Air around a planet, or over a plane."""

from __future__ import annotations

import numpy as np

from .. import _core, air
from .._arrays import FloatArray, Vector, VectorLike, as_number, as_vector, one_of
from ..atmosphere._knots import breaks, sample
from ..atmosphere._profile import Profile
from ..bounds import Bounds, Box
from ..dispersion import Dispersion, Gas
from ._base import D_LINE, Medium

_BELOW = 100.0  # metres of air under the ground, so that a step of an integrator that ends there is as good as any
_THINNEST = 1e-5  # metres
_MOST = 200_000
_MIXED = 5e-4  # of molar fraction: 0.01″ at the horizon


class Atmosphere(Medium):
    """n of a profile of :mod:`cpm.atmosphere`.

    Parameters
    ----------
    profile : Profile
        Temperature, pressure and humidity of height.
    radius : float or None
        Of the sphere where height is 0, metres, with its centre at ``origin`` − ``radius``·``up``. None or inf: flat.
    up : array_like, shape (3,)
        Need not be unit.
    refractivity : {"ciddor", "edlen", "iag1999"}
        Index of air.
    origin : array_like, shape (3,)
        Where height is 0, metres.
    extinction : None or "rayleigh"
        What molecules scatter out of eye rays, and out of the light of suns and environments on its way in, is lost: optical
        depth σ(λ) ∫ N ds along the curved path (:func:`cpm.air.rayleigh_extinction`). Nothing is scattered into a ray.
    bounds : Box, Sphere or Shape, optional

    Attributes
    ----------
    heights : ndarray, shape (K,)
        Knots of the spline that the core holds: it is within 1e-12 of the profile's n at 587.5618 nm, or within 1e-8 of
        n − 1 where that is more. The profile's kinks (tropopause, levels of a table) are kinks of the spline.
    n : ndarray, shape (K,)
        Index at each.

    Notes
    -----
    Above the profile's top n keeps the top's value, and light goes straight. At other wavelengths n − 1 is multiplied
    by the dispersion of air: density times dispersion. Where the molar fraction of water vapour changes with height by
    more than 5e-4, dry air and vapour are two terms, each with its own dispersion, as in :class:`Sum`, at 2.2 times the
    cost of a ray; where by less, all air has the dispersion of that at the ground, and refraction at the horizon is off
    by 0.01″ at most, from 400 to 700 nm.
    """

    def __init__(
        self,
        profile: Profile,
        radius: float | None = 6371e3,
        up: VectorLike = (0.0, 1.0, 0.0),
        refractivity: str = "ciddor",
        origin: VectorLike = (0.0, 0.0, 0.0),
        bounds: Bounds | None = None,
        extinction: str | None = None,
    ) -> None:
        if not isinstance(profile, Profile):
            raise TypeError(f"profile is {profile!r}; a profile of cpm.atmosphere is needed")
        self.profile, self.refractivity = profile, one_of(refractivity, "refractivity", air.MODELS)
        self.radius = None if radius is None or radius == np.inf else as_number(radius, "radius")
        if self.radius is not None and not self.radius > 0:
            raise ValueError(f"radius is {self.radius:g} m; above 0 is needed, or None for a flat Earth")
        self.up, self.origin = as_vector(up, "up"), as_vector(origin, "origin")
        if not np.any(self.up):
            raise ValueError("up is (0, 0, 0); a direction is needed")
        self.extinction = None if extinction is None else one_of(extinction, "extinction", ("rayleigh",))
        super().__init__(_dispersion(profile, self.refractivity), bounds)
        self.heights, self.n, self._kinks = _spline(profile, self.refractivity)
        if self._mixture_varies():
            self._handle = _core.sum([self._layers(n, model) for n, model in self._components()])
        else:
            self._handle = self._layers(self.n, self.dispersion)
        dim(self._handle, self.extinction)

    def _layers(self, n: FloatArray, dispersion: Dispersion | None) -> _core.Medium:
        """The core's spline through n at the knots."""
        return _core.layered(
            self.heights,
            n,
            self.up,
            self.origin,
            self.radius or 0.0,
            _core.INTERPOLATION["cubic"],
            None if dispersion is None else dispersion._core(),
            self._kinks,
        )

    def _mixture_varies(self) -> bool:
        fraction = self._vapour() / np.maximum(self.profile.pressure(self.heights), 1e-300)
        return bool(np.ptp(fraction) > _MIXED)

    def _vapour(self) -> FloatArray:
        return np.asarray(self.profile.vapour_pressure(self.heights))

    def _components(self) -> list[tuple[FloatArray, Dispersion | None]]:
        """n and dispersion of dry air, and of water vapour."""
        model, range_ = self.refractivity, air.RANGES[self.refractivity]
        state = (self.profile.temperature(self.heights), self.profile.pressure(self.heights), self._vapour())
        vapour = air.vapour_part(D_LINE, *state, model)
        coefficients = air.vapour_coefficients(model)
        dry = Gas(*air.gas_coefficients(model, 288.15, 101325.0, 0.0), range=range_, reference="vacuum")
        wet = None if coefficients is None else Gas(polynomial=coefficients, range=range_, reference="vacuum")
        return [(self.n - vapour, dry), (1.0 + vapour, wet)]

    @property
    def extent(self) -> Box | None:
        """A box around all of the air of a spherical Earth; None over a flat one."""
        center = self.center
        if self.radius is None or center is None:
            return None
        reach = self.radius + self.profile.top
        return Box(np.subtract(center, reach), np.add(center, reach))

    @property
    def center(self) -> Vector | None:
        """Centre of the Earth, metres; None where it is flat."""
        if self.radius is None:
            return None
        axis = np.array(self.up) / np.linalg.norm(self.up)
        return as_vector(self.origin - self.radius * axis, "center")

    def __repr__(self) -> str:
        return f"Atmosphere({self.profile!r}, radius={self.radius!r}, refractivity={self.refractivity!r})"


def dim(handle: _core.Medium, extinction: str | None) -> None:
    """Gives a medium of air its extinction."""
    if extinction is not None:
        low, high = air.RANGES["ciddor"]
        wavelengths = np.arange(low, high + 0.5)
        handle.set_extinction(wavelengths, air.rayleigh_extinction(wavelengths))


def _dispersion(profile: Profile, model: str) -> Gas:
    """Of the air at the ground."""
    t, p, e = (getattr(profile, name)(profile.ground) for name in ("temperature", "pressure", "vapour_pressure"))
    return Gas(*air.gas_coefficients(model, t, p, e), range=air.RANGES[model], reference="vacuum")


def _spline(profile: Profile, model: str) -> tuple[FloatArray, FloatArray, list[int]]:
    """Heights, n, and the indices of the kinks: split until the core's own spline is within tolerance everywhere."""

    def refractivity(h: FloatArray) -> FloatArray:
        return np.asarray(profile.refractivity(h, D_LINE, model))

    def tolerance(value: FloatArray) -> FloatArray:
        return np.maximum(1e-12, 1e-8 * value)

    low, high = profile.ground - _BELOW, profile.top
    kinks = np.array([h for h in profile._kinks() if low < h < high])
    heights = sample(refractivity, breaks(profile, low, high), tolerance)
    shares = np.array([0.15, 0.5, 0.85])
    while True:
        n = 1.0 + refractivity(heights)
        indices = sorted({int(i) for i in np.searchsorted(heights, kinks - 1e-6)} - {0, heights.size - 1})
        flat = _core.layered(
            heights, n, (0.0, 1.0, 0.0), (0.0, 0.0, 0.0), 0.0, _core.INTERPOLATION["cubic"], None, indices
        )
        width = np.diff(heights)
        at = heights[:-1, None] + width[:, None] * shares
        points = np.zeros((at.size, 3))
        points[:, 1] = at.ravel()
        found, _ = flat.evaluate(points, D_LINE)
        wanted = refractivity(at)
        off = np.abs(found.reshape(at.shape) - 1.0 - wanted)
        bad = (off > tolerance(wanted)).any(axis=1) & (width > _THINNEST) & (heights[1:] > profile.ground)
        if not bad.any() or heights.size > _MOST:
            return heights, n, indices
        heights = np.sort(np.concatenate([heights, heights[:-1][bad] + 0.5 * width[bad]]))
