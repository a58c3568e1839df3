"""The tables of a scene file. An unknown key, a missing one, a value of the wrong kind are refused here."""
from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BaseModel, BeforeValidator, ConfigDict, Discriminator, Field, Tag, model_validator
from pydantic_core import PydanticCustomError

from ..settings import MAX_BUNDLE_TOLERANCE, MAX_NEAREST, MAX_SAMPLES


class Table(BaseModel):
    """A TOML table with known keys."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    @model_validator(mode="before")
    @classmethod
    def _only_known_keys(cls, table: Any) -> Any:
        if not isinstance(table, dict):
            raise PydanticCustomError("not_a_table", "must be a table")
        allowed = [field.alias or name for name, field in cls.model_fields.items()]
        for key in table:
            if key not in allowed:
                raise PydanticCustomError("unknown_key", "unknown key (allowed: {allowed})",
                                          {"key": key, "allowed": ", ".join(allowed)})
        return table


def _integral(value: Any) -> Any:
    """3e6 is an integer here, as it is to anyone who writes it; true is not."""
    return int(value) if isinstance(value, float) and value.is_integer() else value


Number = Annotated[float, Field(strict=True, allow_inf_nan=False)]
Positive = Annotated[float, Field(strict=True, allow_inf_nan=False, gt=0)]
NotNegative = Annotated[float, Field(strict=True, allow_inf_nan=False, ge=0)]
Integer = Annotated[int, Field(strict=True), BeforeValidator(_integral)]
Text = Annotated[str, Field(strict=True, min_length=1)]
Vector = tuple[Number, Number, Number]


def _kind(value: Any) -> str | None:
    """Tag of a value that may be a number, a name or a table."""
    if isinstance(value, str):
        return "<name>"
    if isinstance(value, dict):
        return "<table>"
    return "<number>" if isinstance(value, (int, float)) and not isinstance(value, bool) else None


def _meant(what: str) -> Discriminator:
    """Which of number, name and table was meant, so that errors are those of that branch."""
    return Discriminator(_kind, custom_error_type="kind", custom_error_message=f"must be {what}")


ANumber = Annotated[Number, Tag("<number>")]
AName = Annotated[Text, Tag("<name>")]


def _numbers_kind(value: Any) -> str | None:
    return "<list>" if isinstance(value, list) else "<number>" if _kind(value) == "<number>" else None


#: One for all or one for each.
Numbers = Annotated[
    ANumber | Annotated[list[Number], Tag("<list>")],
    Discriminator(_numbers_kind, custom_error_type="kind", custom_error_message="must be a number or a list of numbers")]


def _exactly_one(table: Table, *names: str) -> None:
    given = [name for name in names if getattr(table, name) is not None]
    if len(given) != 1:
        raise PydanticCustomError("exactly_one", "exactly one of {names} is needed", {"names": ", ".join(names)})


# Spectra.

class SpectrumTable(Table):
    """A name, a table of values, or a file of two columns; times ``scale``."""

    name: Text | None = None
    wavelengths: list[Number] | None = None
    values: list[Number] | None = None
    file: Text | None = None
    scale: Number = 1.0

    @model_validator(mode="after")
    def _one_source(self) -> SpectrumTable:
        _exactly_one(self, "name", "values", "file")
        if (self.values is None) != (self.wavelengths is None):
            raise PydanticCustomError("pair", "wavelengths and values belong together")
        return self


Spectrum = Annotated[ANumber | AName | Annotated[SpectrumTable, Tag("<table>")],
                     _meant("a number, a name or a table of name, wavelengths and values, or file")]


# Dispersion and media.

class SellmeierTable(Table):
    B: list[Number]
    C: list[Number]


class TabulatedTable(Table):
    wavelengths: list[Number]
    n: list[Number]


class AirTable(Table):
    temperature: Number = 288.15
    pressure: Number = 101325.0
    humidity: Number = 0.0
    co2: Number = 450.0
    model: Literal["ciddor", "edlen", "iag1999"] = "ciddor"


class DispersionTable(Table):
    """One of the models of cpm.dispersion."""

    constant: Number | None = None
    cauchy: Annotated[list[Number], Field(min_length=1)] | None = None
    sellmeier: SellmeierTable | None = None
    tabulated: TabulatedTable | None = None
    catalogue: Text | None = None
    air: AirTable | None = None
    range: tuple[Number, Number] | None = None
    extrapolate: Annotated[bool, Field(strict=True)] = False

    @model_validator(mode="after")
    def _one_model(self) -> DispersionTable:
        _exactly_one(self, "constant", "cauchy", "sellmeier", "tabulated", "catalogue", "air")
        return self


Index = Annotated[ANumber | AName | Annotated[DispersionTable, Tag("<table>")],
                  _meant("a number, a catalogue name or a dispersion")]


class BoxTable(Table):
    type: Literal["box"] = "box"
    low: Vector
    high: Vector


class BallTable(Table):
    type: Literal["sphere"]
    center: Vector
    radius: Positive


class ShapeBounds(Table):
    shape: Text


def _bounds_kind(value: Any) -> str | None:
    if not isinstance(value, dict):
        return None
    return "<shape>" if "shape" in value else {"box": "<box>", "sphere": "<sphere>"}.get(value.get("type", "box"))


BoundsTable = Annotated[
    Annotated[BoxTable, Tag("<box>")] | Annotated[BallTable, Tag("<sphere>")] | Annotated[ShapeBounds, Tag("<shape>")],
    Discriminator(_bounds_kind, custom_error_type="kind",
                  custom_error_message="must have type 'box' or 'sphere', or shape = a shape's name")]


class MediumTable(Table):
    dispersion: Index | None = None
    bounds: BoundsTable | None = None


class HomogeneousTable(MediumTable):
    type: Literal["homogeneous"]
    n: Index = 1.0


class LinearSquaredTable(MediumTable):
    type: Literal["linear-squared"]
    n_squared: Number
    gradient: Vector
    origin: Vector = (0.0, 0.0, 0.0)


class LinearTable(MediumTable):
    type: Literal["linear"]
    n: Number
    gradient: Vector
    origin: Vector = (0.0, 0.0, 0.0)


class LayeredTable(MediumTable):
    type: Literal["layered"]
    heights: list[Number]
    n: list[Number]
    up: Vector = (0.0, 1.0, 0.0)
    origin: Vector = (0.0, 0.0, 0.0)
    radius: Positive | None = None
    interpolation: Literal["cubic", "linear-squared", "step"] = "cubic"


class ExpressionTable(MediumTable):
    type: Literal["expression"]
    text: Text
    constants: dict[str, Number] = {}


class SumTable(MediumTable):
    type: Literal["sum"]
    terms: Annotated[list[AnyMedium], Field(min_length=1, max_length=64)]


class GridTable(MediumTable):
    type: Literal["grid"]
    values: Text
    origin: Vector = (0.0, 0.0, 0.0)
    spacing: tuple[Positive, Positive, Positive] = (1.0, 1.0, 1.0)
    interpolation: Literal["linear", "cubic"] = "cubic"
    quantity: Literal["n", "density"] = "n"
    gladstone_dale: Positive | None = None


class ParabolicTable(MediumTable):
    type: Literal["parabolic"]
    n: Number
    alpha: Number
    axis: Vector = (0.0, 0.0, 1.0)
    origin: Vector = (0.0, 0.0, 0.0)


class LuneburgTable(MediumTable):
    type: Literal["luneburg"]
    radius: Positive
    center: Vector = (0.0, 0.0, 0.0)


class FisheyeTable(MediumTable):
    type: Literal["fisheye"]
    n: Number
    radius: Positive
    center: Vector = (0.0, 0.0, 0.0)


class EatonTable(MediumTable):
    type: Literal["eaton"]
    radius: Positive
    center: Vector = (0.0, 0.0, 0.0)


class SourcesTable(MediumTable):
    type: Literal["sources"]
    centers: Annotated[list[Vector], Field(min_length=1)]
    strengths: Numbers
    exponent: Numbers = 2.0
    directions: list[Vector] | None = None


# Profiles and the atmosphere.

class StandardTable(Table):
    type: Literal["us-standard-1976"]


class PolytropicTable(Table):
    type: Literal["polytropic"]
    T0: Number
    p0: Number
    lapse: Number = 0.0065
    tropopause: Number = 11000.0
    reference_height: Number = 0.0
    humidity: Number = 0.0
    latitude: Number = 45.0


class LevelsTable(Table):
    """Levels, or a radiosonde's file of them."""

    type: Literal["table"]
    file: Text | None = None
    h: list[Number] | None = None
    T: list[Number] | None = None
    p: Number | list[Number] | None = None
    rh: Number | list[Number] | None = None
    interpolation: Literal["linear", "monotone"] = "linear"

    @model_validator(mode="after")
    def _one_source(self) -> LevelsTable:
        _exactly_one(self, "file", "h")
        if (self.h is None) != (self.T is None):
            raise PydanticCustomError("pair", "h and T belong together")
        if self.file is not None and (self.p is not None or self.rh is not None):
            raise PydanticCustomError("pair", "p and rh are in the file")
        return self


class HotSurfaceTable(Table):
    type: Literal["hot-surface"]
    base: AnyProfile
    excess: Number
    thickness: Positive


class InversionTable(Table):
    type: Literal["inversion"]
    base: AnyProfile
    height: Number
    strength: Number
    thickness: Positive


AnyProfile = Annotated[StandardTable | PolytropicTable | LevelsTable | HotSurfaceTable | InversionTable,
                       Field(discriminator="type")]


class AtmosphereTable(Table):
    """No dispersion: the air has its own."""

    type: Literal["atmosphere"]
    profile: AnyProfile
    radius: Annotated[float, Field(strict=True, gt=0)] = 6371e3  # inf: flat
    up: Vector = (0.0, 1.0, 0.0)
    origin: Vector = (0.0, 0.0, 0.0)
    refractivity: Literal["ciddor", "edlen", "iag1999"] = "ciddor"
    extinction: Literal["rayleigh"] | None = None
    bounds: BoundsTable | None = None


AnyMedium = Annotated[
    HomogeneousTable
    | LinearSquaredTable
    | LinearTable
    | LayeredTable
    | GridTable
    | ParabolicTable
    | LuneburgTable
    | FisheyeTable
    | EatonTable
    | SourcesTable


    | AtmosphereTable
    | ExpressionTable
    | SumTable,
    Field(discriminator="type")]
SumTable.model_rebuild()


# Materials.

class DiffuseTable(Table):
    type: Literal["diffuse"]
    reflectance: Spectrum


class MirrorTable(Table):
    type: Literal["mirror"]
    reflectance: Spectrum = 1.0


class BlackTable(Table):
    type: Literal["black"]


def _interior_kind(value: Any) -> str | None:
    """A table without a type is a dispersion, or the n of a homogeneous medium."""
    if not isinstance(value, dict):
        return _kind(value)
    return "<table>" if "type" in value else "<n>" if "n" in value else "<dispersion>"


class PlainTable(MediumTable):
    """A homogeneous medium that does not say so."""

    n: Index


class DielectricTable(Table):
    type: Literal["dielectric"]
    interior: Annotated[ANumber | AName | Annotated[AnyMedium, Tag("<table>")] | Annotated[PlainTable, Tag("<n>")]
                        | Annotated[DispersionTable, Tag("<dispersion>")],
                        Discriminator(_interior_kind, custom_error_type="kind", custom_error_message="must be a number, "
                                      "a catalogue name, a dispersion or a medium")]


AnyMaterial = Annotated[DiffuseTable | MirrorTable | BlackTable | DielectricTable, Field(discriminator="type")]


def _material_kind(value: Any) -> str | None:
    return "<name>" if isinstance(value, str) else "<table>" if isinstance(value, dict) else None


MaterialRef = Annotated[
    Annotated[Text, Tag("<name>")] | Annotated[AnyMaterial, Tag("<table>")],
    Discriminator(_material_kind, custom_error_type="kind", custom_error_message="must be a material's name or table")]


# Shapes.

class ShapeTable(Table):
    name: Text | None = None
    material: MaterialRef


class QuadsTable(ShapeTable):
    """Parallelograms: corner, edge a, edge b; the normal is a × b."""

    type: Literal["quads"]
    quads: Annotated[list[tuple[Vector, Vector, Vector]], Field(min_length=1)]


class Transform(Table):
    """In this order: scale, rotate (degrees about x, then y, then z), translate (metres)."""

    scale: Number | Vector = 1.0
    rotate: Vector = (0.0, 0.0, 0.0)
    translate: Vector = (0.0, 0.0, 0.0)


class MeshTable(ShapeTable):
    type: Literal["mesh"]
    file: Text
    transform: Transform = Transform()
    smooth: Annotated[bool, Field(strict=True)] = False


class SphereTable(ShapeTable):
    type: Literal["sphere"]
    center: Vector
    radius: Positive


class GroundTable(ShapeTable):
    """The sphere under the atmosphere that fills the scene."""

    type: Literal["ground"]


AnyShape = Annotated[QuadsTable | MeshTable | SphereTable | GroundTable, Field(discriminator="type")]


class BinsTable(Table):
    from_: Positive = Field(alias="from")
    to: Positive
    bins: Annotated[Integer, Field(ge=1, le=256)]
    sampling: Literal["equal", "refraction", "contribution"] = "equal"


def _wavelengths_kind(value: Any) -> str | None:
    return "<list>" if isinstance(value, list) else "<table>" if isinstance(value, dict) else None


Wavelengths = Annotated[
    Annotated[list[Positive], Field(min_length=1, max_length=256), Tag("<list>")]
    | Annotated[BinsTable, Tag("<table>")],
    Discriminator(_wavelengths_kind, custom_error_type="kind",
                  custom_error_message="must be a list of bin centres or a table of from, to, bins and sampling")]


# Lights, camera, render.

class PointTable(Table):
    type: Literal["point"]
    position: Vector
    intensity: Spectrum


class SpotTable(Table):
    type: Literal["spot"]
    position: Vector
    target: Vector
    cutoff: Annotated[float, Field(strict=True, allow_inf_nan=False, gt=0, le=180)]
    intensity: Spectrum


class AreaTable(Table):
    type: Literal["area"]
    shape: Text
    radiance: Spectrum


class SunTable(Table):
    type: Literal["sun"]
    elevation: Annotated[float, Field(strict=True, allow_inf_nan=False, ge=-90, le=90)]
    azimuth: Number
    radiance: Spectrum | None = None
    angular_radius: Annotated[float, Field(strict=True, allow_inf_nan=False, gt=0, lt=90)] = 0.2666
    limb_darkening: Annotated[bool, Field(strict=True)] = True
    up: Vector | None = None
    aim: BoxTable | None = None


class SkyTable(SpectrumTable):
    """A spectrum, or a file with an image of all directions: a spectral .exr, or a .npy with its wavelengths."""

    wavelengths: Wavelengths | None = None  # type: ignore[assignment]

    @model_validator(mode="after")
    def _one_source(self) -> SkyTable:
        _exactly_one(self, "name", "values", "file")
        if self.values is not None and not isinstance(self.wavelengths, list):
            raise PydanticCustomError("pair", "wavelengths and values belong together")
        if self.name is not None and self.wavelengths is not None:
            raise PydanticCustomError("pair", "wavelengths and values belong together")
        return self


class EnvironmentTable(Table):
    type: Literal["environment"]
    radiance: Annotated[ANumber | AName | Annotated[SkyTable, Tag("<table>")],
                        _meant("a number, a name or a table of name, wavelengths and values, or file")]
    up: Vector | None = None
    aim: BoxTable | None = None


AnyLight = Annotated[PointTable | SpotTable | AreaTable | SunTable | EnvironmentTable, Field(discriminator="type")]


class CameraTable(Table):
    origin: Vector
    target: Vector
    up: Vector = (0.0, 1.0, 0.0)
    fov: Annotated[float, Field(strict=True, allow_inf_nan=False, gt=0, lt=180)] = 60.0


Pixels = Annotated[Integer, Field(ge=1, le=65536)]


class RenderTable(Table):
    """Defaults of cpm.render and cpm.trace_photons for this scene."""

    size: tuple[Pixels, Pixels] | None = None
    photons: Annotated[Integer, Field(ge=0, le=2**32 - 1)] | None = None
    nearest: Annotated[Integer, Field(ge=2, le=MAX_NEAREST)] | None = None
    wavelengths: Wavelengths | None = None
    samples: Annotated[Integer, Field(ge=1, le=MAX_SAMPLES)] | None = None
    seed: Annotated[Integer, Field(ge=0, le=2**63 - 1)] | None = None
    max_radius: Positive | None = None
    bundle_tolerance: Annotated[float, Field(strict=True, allow_inf_nan=False, ge=0,
                                             le=MAX_BUNDLE_TOLERANCE)] | None = None


class IntegratorTable(Table):
    """How curved paths are integrated: the arguments of cpm.Scene."""

    method: Text = "auto"
    exclude: list[Text] = []
    rtol: Annotated[float, Field(strict=True, ge=1e-14, le=1)] | None = None
    atol: NotNegative | None = None
    step: Positive | None = None
    max_step: Positive | None = None


class SceneTable(Table):
    """A whole scene file."""

    format: Literal[1] = 1
    medium: AnyMedium | None = None
    extent: BoxTable | None = None
    integrator: IntegratorTable = IntegratorTable()
    spectra: dict[str, Spectrum] = {}
    materials: dict[str, AnyMaterial] = {}
    media: list[AnyMedium] = []
    shapes: list[AnyShape] = []
    lights: list[AnyLight] = []
    camera: CameraTable | None = None
    render: RenderTable = RenderTable()
