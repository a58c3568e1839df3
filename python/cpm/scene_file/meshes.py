"""Triangles for shapes of scene files: quads, and mesh files through trimesh."""
from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from .._arrays import FloatArray
from .models import QuadsTable, Transform

#: What trimesh is asked for here.
SUFFIXES = (".obj", ".ply", ".stl", ".gltf", ".glb")


def quads(table: QuadsTable) -> tuple[FloatArray, np.ndarray]:
    """Vertices and faces of parallelograms; two triangles each, with the normal a × b."""
    corner, a, b = np.moveaxis(np.array(table.quads), 1, 0)
    vertices = np.stack([corner, corner + a, corner + a + b, corner + b], axis=1).reshape(-1, 3)
    first = 4 * np.arange(len(corner))[:, None]
    return vertices, np.concatenate([first + np.array(half) for half in ((0, 1, 2), (0, 2, 3))])


@contextmanager
def uninterrupted() -> Iterator[None]:
    """Ctrl-C comes after: what is imported here swallows a KeyboardInterrupt in its own ``except BaseException``."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    came: list[int] = []
    before = signal.signal(signal.SIGINT, lambda *_: came.append(1))
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)
    if came:
        raise KeyboardInterrupt


def load_mesh(path: Path, smooth: bool) -> tuple[FloatArray, np.ndarray, FloatArray | None]:
    """Vertices and faces of a mesh file and, when ``smooth``, shading normals."""
    if path.suffix.lower() not in SUFFIXES:
        raise ValueError(f"suffix '{path.suffix}' ({', '.join(SUFFIXES)} are allowed)")
    if not path.is_file():
        raise ValueError("no such file")
    with uninterrupted():
        import trimesh

    try:
        mesh: Any = trimesh.load_scene(path, process=False).to_mesh()
    except Exception as error:  # trimesh's loaders raise whatever a broken file makes them trip over
        raise ValueError(f"not a mesh that trimesh can read ({error})") from None
    if not len(mesh.faces):
        raise ValueError("holds no triangles")
    vertices, faces = np.array(mesh.vertices, dtype=float), np.array(mesh.faces)
    return vertices, faces, vertex_normals(vertices, faces) if smooth else None


def vertex_normals(vertices: FloatArray, faces: np.ndarray) -> FloatArray:
    """Unit normals (V, 3): at each place the sum over its corners of face normal × angle (Thürmer and Wüthrich 1998).

    Corners at one place share a normal, whether or not the file has them as one vertex.
    """
    _, place = np.unique(vertices, axis=0, return_inverse=True)
    place = place.reshape(-1)
    corners = vertices[faces]
    edges = _unit(np.roll(corners, -1, axis=1) - corners)
    angles = np.arccos(np.clip(-np.einsum("fkc,fkc->fk", edges, np.roll(edges, 1, axis=1)), -1.0, 1.0))
    face_normals = _unit(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]))
    weighted = angles[..., None] * face_normals[:, None]
    sums = np.zeros((len(vertices), 3))
    np.add.at(sums, place[faces], weighted)
    normals = _unit(sums)[place]
    # A vertex of no face, or between faces that cancel: anything unit will do.
    return np.where(np.any(normals, axis=1, keepdims=True), normals, (0.0, 1.0, 0.0))


def _unit(vectors: FloatArray) -> FloatArray:
    lengths = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return np.divide(vectors, lengths, out=np.zeros_like(vectors), where=lengths > 0)


def transformed(vertices: FloatArray, normals: FloatArray | None,
                transform: Transform) -> tuple[FloatArray, FloatArray | None]:
    """Scale, rotate about x, then y, then z, translate."""
    scale = np.broadcast_to(transform.scale, 3)
    rotation = _rotation(transform.rotate)
    moved = (vertices * scale) @ rotation.T + transform.translate
    if normals is None:
        return moved, None
    turned = (normals / scale) @ rotation.T  # normals go with the inverse transpose
    return moved, turned / np.linalg.norm(turned, axis=1, keepdims=True)


def _rotation(degrees: tuple[float, float, float]) -> FloatArray:
    turn = np.eye(3)
    for axis, angle in enumerate(np.radians(degrees)):
        i, j = (axis + 1) % 3, (axis + 2) % 3
        about = np.eye(3)
        about[i, i] = about[j, j] = np.cos(angle)
        about[i, j], about[j, i] = -np.sin(angle), np.sin(angle)
        turn = about @ turn
    return turn
