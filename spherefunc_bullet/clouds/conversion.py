"""Clouds from the representations of an object in Python: a path, an array, an Open3D or a trimesh object.

Objects of those libraries are recognised by their attributes; the libraries are never imported here.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import InputError, explaining
from ..formats.sources import Geometry, read_geometry
from ..formats.units import BY_FILE
from .cloud import Cloud, cloud_of
from .orientation import Report

# The representations of an object: a path, points, vertices and faces, an Open3D or a trimesh object, or a `Cloud`.
Anything = Any
EXPECTED = "a path, an array (N, 3), (vertices, faces), an Open3D or trimesh object, or a Cloud"
BESIDE = (3, 4, 6, 7)  # number of columns: points only, with intensity, with normals or colours, with colours and alpha


def as_cloud(
    anything: Anything, *, units: str = "m", up: str = BY_FILE, name: str | None = None, report: Report | None = None
) -> Cloud:
    """Return the cloud of an object, in metres, z up, on the ground.

    A `Cloud` is returned unchanged, since it is in metres with z up.

    Parameters
    ----------
    anything : path, array_like, tuple, open3d PointCloud or TriangleMesh, trimesh Trimesh, Scene or PointCloud, Cloud
        Points (N, 3), or (H, W, 3) as a depth camera orders them; further columns with intensity, normals or colours
        are ignored; a structured array, as in ROS, or a DataFrame with x, y and z; a masked array; or a tuple of
        vertices (N, 3) and faces (M, 3). Meshes are sampled. Points that are masked or not finite, since the sensor
        measured nothing, are dropped and reported.
    units, up
        See `load_cloud`.
    name : str, optional
        Name in errors and results; by default the name of the file, or ``cloud``.
    report : callable, optional
        Receives one line of text for whatever looks wrong; by default `warnings.warn`.

    Raises
    ------
    InputError
        If it is none of these, cannot be used, or is of a size that only a wrong unit explains.
    """
    if isinstance(anything, Cloud):
        if units not in ("m", "auto") or up not in ("z", "auto", BY_FILE):
            raise InputError(f"{anything.name}: a Cloud is in metres with z up; got units {units!r} and up {up!r}")
        return anything
    path = Path(anything).expanduser() if isinstance(anything, str | Path) else Path(name or "cloud")
    return cloud_of(geometry_of(anything, path.name), path, up=up, units=units, report=report or warn)


def as_clouds(objects: Iterable[Anything]) -> Iterator[Cloud]:
    """Return an iterator of the clouds of several objects in metres with z up, see `as_cloud`, each made when needed.

    Errors name them by number.
    """
    return (as_cloud(item, name=f"object {number}") for number, item in enumerate(listed(objects)))


def listed(objects: Iterable[Anything]) -> Iterable[Anything]:
    """Return several objects as they are, or a column of a table as a list; InputError for what holds only one."""
    if isinstance(objects, str | Path | Cloud | Mapping) or not isinstance(objects, Iterable):
        raise InputError(f"expected several objects in a list, each {EXPECTED}; got {type(objects).__name__}")
    objects = without_table(objects)
    if len(shape := np.shape(objects) if hasattr(objects, "shape") else ()) == 2:
        raise InputError(f"expected several objects in a list, each {EXPECTED}; got a table of {shape[1]} columns")
    return objects


def without_table(anything: Anything) -> Anything:
    """Return a column of paths or other objects, as of a DataFrame, as a list; anything else unchanged."""
    shape = np.shape(anything) if hasattr(anything, "shape") else ()
    if len(shape) == 1 or shape[1:] == (1,):
        column = np.asarray(anything)
        return anything if column.dtype.names or column.dtype.kind in "biufc" else column.ravel().tolist()
    return anything


def geometry_of(anything: Anything, name: str) -> Geometry:
    """Return the vertices and triangles, or the points, of an object that is not a `Cloud`, in its own frame and unit.

    Raises
    ------
    InputError
        If it has none.
    """
    if isinstance(anything, str | Path):
        return read_geometry(Path(anything).expanduser())
    if is_mesh_pair(anything):
        return Geometry(as_numbers(anything[0], name), as_triangles(anything[1], name))
    held = anything
    for flatten in ("to_legacy", "to_mesh"):  # Open3D's tensor geometries, trimesh's scenes
        held = getattr(held, flatten)() if hasattr(held, flatten) and not hasattr(held, "faces") else held
    if hasattr(anything, "graph") and not len(held.faces):  # trimesh's scene of clouds
        from ..formats.scenes.parts import joined, parts_of

        return joined(parts_of(anything, "vertices"))
    vertices = getattr(held, "vertices", getattr(held, "points", held))
    faces = getattr(held, "faces", getattr(held, "triangles", ()))
    return Geometry(as_numbers(vertices, name), as_triangles(faces, name))


def held_copy(anything: Anything, name: str) -> Anything:
    """Return a path or a `Cloud` as it is, and of other objects a copy, since callers use an array for many objects."""
    if isinstance(anything, str | Path | Cloud):
        return anything
    geometry = geometry_of(anything, name)
    return (geometry.vertices.copy(), geometry.faces.copy()) if len(geometry.faces) else geometry.vertices.copy()


def as_triangles(faces: Anything, name: str) -> np.ndarray:
    """Return faces (M, 3) int64, none for a cloud, or raise InputError."""
    with explaining(f"{name}: expected triangles (M, 3), got faces of different lengths", TypeError, ValueError):
        array = np.asarray(faces)
    if array.size and (array.shape[1:] != (3,) or array.dtype.kind not in "iu"):
        raise InputError(f"{name}: expected triangles (M, 3) of integers, got faces {array.shape} of {array.dtype}")
    return array.astype(np.int64).reshape(-1, 3)


def as_numbers(points: Anything, name: str) -> np.ndarray:
    """Return points (N, 3) float64, with NaN for masked ones, or raise InputError."""
    if {"x", "y", "z"} <= set(getattr(points, "columns", ())):  # of a DataFrame
        points = points[["x", "y", "z"]]
    fields = getattr(getattr(points, "dtype", None), "names", None)
    if fields is not None:
        if not {"x", "y", "z"} <= set(fields):
            raise InputError(f"{name}: expected a structured array with fields x, y and z, got {', '.join(fields)}")
        points = np.ma.stack([points[axis].ravel() for axis in "xyz"], axis=1)
    with explaining(f"{name}: expected {EXPECTED}, got {type(points).__name__}", TypeError, ValueError):
        masked = np.ma.asarray(points, dtype=np.float64) if np.ma.isMaskedArray(points) else None
        array = np.asarray(points, dtype=np.float64) if masked is None else masked.filled(np.nan)
    if array.ndim not in (2, 3) or array.shape[-1] not in BESIDE:
        came = f"an array of shape {array.shape}" if array.ndim else repr(points)
        raise InputError(f"{name}: expected {EXPECTED}, got {came}")
    return array.reshape(-1, array.shape[-1])[:, :3]


def is_mesh_pair(anything: Anything) -> bool:
    """Return whether something is a tuple of vertices (N, 3) and faces (M, 3) of integers, as arrays or lists.

    In lists, coordinates must be floats and faces name vertices: two lists of integers are the points of two objects.
    """
    if not isinstance(anything, tuple) or len(anything) != 2:
        return False
    if any(isinstance(part, list | tuple) for part in anything):
        with suppress(ValueError):  # rows of different lengths, no rows
            vertices, faces = map(np.asarray, anything)
            rows_of_three = vertices.shape[1:] == faces.shape[1:] == (3,)
            kinds = vertices.dtype.kind + faces.dtype.kind
            return rows_of_three and kinds == "fi" and 0 <= faces.min() <= faces.max() < len(vertices)
        return False
    vertices, faces = (getattr(part, "dtype", None) for part in anything)
    whole = faces is not None and np.issubdtype(faces, np.integer) and anything[1].shape[1:] == (3,)
    return vertices is not None and bool(whole)


def holds_several(anything: Anything) -> bool:
    """Return whether something is a list, a dict or another iterable of objects rather than one.

    Rows of numbers are the points of one object, and a tuple of vertices and faces is the mesh of one object.
    """
    one = isinstance(anything, str | bytes | Path | Cloud) or is_mesh_pair(anything)
    if one or any(hasattr(anything, name) for name in ("shape", "vertices", "points")):
        return False
    first = anything[0] if isinstance(anything, list | tuple) and anything else None
    return isinstance(anything, Iterable) and not (isinstance(first, list | tuple | np.ndarray) and np.ndim(first) == 1)


def warn(line: str):
    """Issue a warning."""
    warnings.warn(line, UserWarning, stacklevel=4)
