"""Spectral global illumination where light bends.

Photons and eye rays follow curved paths through a varying refractive index n(r, λ); the photons are stored and gathered
into spectral pictures. Metres, nanometres, degrees; radiance in W·m⁻²·sr⁻¹·nm⁻¹.

    scene = cpm.load_scene("examples/cross_room_curved.toml")
    image = cpm.render(scene, progress=True)
    image.save("room.exr")

colour-science, matplotlib, trimesh, pydantic and rich are imported when they are first needed, not before.
"""
from . import air, atmosphere, dispersion, kernels, lights, materials, media, spectra, wavelengths
from ._arrays import bin_centers
from ._core import Error
from ._core import version as _version
from .bounds import Box, Sphere
from .camera import Camera
from .devices import Device, devices
from .explain import Explanation, explain
from .explain_rays import RayExplanation
from .feature import Feature
from .image import Image
from .photons import PhotonMap, Photons, trace_photons
from .rays import Rays, trace
from .render import render
from .scene import Scene
from .scene_file import SceneFileError, load_scene
from .settings import RenderSettings
from .shapes import Shape
from .spectra import Spectrum
from .status import RayStatus

__version__ = _version()

__all__ = [
    "Box",
    "Camera",
    "Device",
    "Error",
    "Explanation",
    "Feature",
    "Image",
    "PhotonMap",
    "Photons",
    "RayExplanation",
    "RayStatus",
    "Rays",
    "RenderSettings",
    "Scene",
    "SceneFileError",
    "Shape",
    "Spectrum",
    "Sphere",
    "__version__",
    "air",
    "atmosphere",
    "bin_centers",
    "devices",
    "dispersion",
    "explain",
    "kernels",
    "lights",
    "load_scene",
    "materials",
    "media",
    "render",
    "spectra",
    "trace",
    "trace_photons",
    "wavelengths",
]
