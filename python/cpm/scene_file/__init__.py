"""Scenes from TOML files: ``type`` is the Python class in lower case with hyphens, other keys are its arguments.

``errors`` and this module are light; ``models`` (pydantic) and ``build`` are imported when a file is loaded.
"""
from __future__ import annotations

import os
from typing import TYPE_CHECKING

from .errors import SceneFileError

if TYPE_CHECKING:
    from ..scene import Scene

__all__ = ["SceneFileError", "load_scene"]


def load_scene(path: str | os.PathLike[str]) -> Scene:
    """Read a scene file.

    Parameters
    ----------
    path : path
        A TOML file; paths in it are relative to it. Values are data, never code.

    Returns
    -------
    Scene
        Its [render] table is ``scene.render_defaults``.

    Raises
    ------
    SceneFileError
        A ValueError of one line that names file, key, value and what is allowed.
    FileNotFoundError
        The file itself is not there.
    """
    from .build import build
    from .read import read

    return build(read(path), path)
