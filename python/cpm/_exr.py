"""Spectral OpenEXR read back; OpenImageIO is imported when a file is read."""
from __future__ import annotations

import os
import re
from pathlib import Path

import numpy as np
import numpy.typing as npt

from ._arrays import FloatArray
from ._core import Error

#: "S0.550,000nm": unpolarised radiance at a wavelength (Fichet et al. 2021, section 4); any SI prefix of metre or hertz
#: is allowed there, nanometres are what is written.
_CHANNEL = re.compile(r"S0\.(\d*,?\d*(?:[eE][+-]?\d+)?)nm")


def read_spectral(path: str | os.PathLike[str]) -> tuple[npt.NDArray[np.float32], FloatArray]:
    """Data (height, width, bins) and wavelengths (bins,) in nm of a spectral OpenEXR file, wavelengths increasing."""
    if not Path(path).is_file():
        raise FileNotFoundError(f"{os.fspath(path)}: no such file")
    try:
        import OpenImageIO
    except ImportError:
        raise Error(f"{os.fspath(path)}: reading OpenEXR needs OpenImageIO: pip install openimageio") from None
    file = OpenImageIO.ImageInput.open(os.fspath(path))
    if file is None:
        raise ValueError(f"{os.fspath(path)}: not an OpenEXR file ({OpenImageIO.geterror().strip()})")
    try:
        names = list(file.spec().channelnames)
        found = {float(match[1].replace(",", ".")): i for i, name in enumerate(names)
                 if (match := _CHANNEL.fullmatch(name))}
        if not found:
            raise ValueError(f"{os.fspath(path)}: no spectral channels such as S0.550,000nm; it has {_listed(names)}")
        pixels = file.read_image(OpenImageIO.FLOAT)
        if pixels is None:
            raise ValueError(f"{os.fspath(path)}: cannot be read ({file.geterror().strip()})")
    finally:
        file.close()
    wavelengths = np.array(sorted(found))
    return np.ascontiguousarray(pixels[..., [found[w] for w in wavelengths]], dtype=np.float32), wavelengths


def _listed(names: list[str]) -> str:
    return ", ".join(names[:6]) + (", ..." if len(names) > 6 else "")
