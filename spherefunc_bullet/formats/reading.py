"""Geometry from files of any supported format, and one clear error for every kind of bad file."""

from __future__ import annotations

import importlib
import os
import warnings
from pathlib import Path

from ..errors import InputError, one_line
from .limits import refusing
from .sources import Geometry, Source, as_source

# By ending: the module in ``formats`` and its function; imported only when such a file is read.
READERS = {
    ".ply": ("ply", "read_ply"),
    ".pcd": ("points.pcd", "read_pcd"),
    ".obj": ("obj", "read_obj"),
    ".stl": ("stl", "read_stl"),
    ".3ds": ("three_ds", "read_3ds"),
    ".off": ("off", "read_off"),
    ".glb": ("scenes.gltf", "read_gltf"),
    ".gltf": ("scenes.gltf", "read_gltf"),
    ".dae": ("scenes.collada", "read_dae"),
    ".3mf": ("scenes.three_mf", "read_3mf"),
    ".urdf": ("scenes.urdf", "read_urdf"),
    ".xyz": ("points.xyz", "read_xyz"),
    ".csv": ("points.xyz", "read_xyz"),
    ".txt": ("points.xyz", "read_xyz"),
    ".las": ("points.las", "read_las"),
    ".laz": ("points.las", "read_las"),
    ".npz": ("npz", "read_npz"),
    ".npy": ("npz", "read_npy"),
}


def read_geometry(file: str | Path | Source) -> Geometry:
    """Return the vertices and triangles of a file, or its points.

    Parameters
    ----------
    file : str, Path or Source
        PLY, PCD, OBJ, STL, 3DS, OFF, GLB, glTF, DAE, 3MF, URDF, XYZ, CSV, TXT, LAS, LAZ, NPZ or NPY, recognised by the
        ending. Polygons are cut into triangles; the parts of a scene become one object in the scene's frame.

    Returns
    -------
    Geometry
        In the file's own units and axes, but in metres and z up of a DAE and in metres of a 3MF, which say theirs; with
        the colours of its vertices and their labels where a PLY or PCD has them.
        The points of a cloud may be NaN, where a sensor saw nothing; the vertices of a mesh are finite.

    Raises
    ------
    InputError
        If there is no such file, or it is not what its ending says, or damaged, or too large.
    """
    source = as_source(file)
    if source.kind not in READERS and not os.path.isdir(source.path):
        endings, name = ", ".join(READERS), one_line(source.path)
        raise InputError(f"{name}: expected one of {endings}, got '{source.path.suffix}'; convert it")
    source.data  # noqa: B018 - whether there is a file comes first, as whether its reader is installed comes later
    with refusing(source.path), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        module, name = READERS[source.kind]
        reader = getattr(importlib.import_module(f".{module}", __package__), name)
        return reader(source).checked()
