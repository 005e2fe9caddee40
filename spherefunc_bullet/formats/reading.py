"""Geometry from files of any supported format, and one clear error for every kind of bad file."""

from __future__ import annotations

import importlib
import warnings
from pathlib import Path

from ..errors import InputError, OutOfMemory, one_line
from . import FormatError
from .geometry import Geometry
from .limits import require_file

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
# What only the extra ``formats`` brings.
OPTIONAL = ("collada", "lxml", "yourdfpy", "laspy", "lazrs")
# First bytes that no reader but the one for the named ending takes.
_SIGNATURES = {
    b"\x89PNG": "PNG", b"\xff\xd8\xff": "JPEG", b"GIF8": "GIF", b"%PDF": "PDF", b"\x1f\x8b": "gzip",
    b"PK\x03\x04": "NPZ, 3MF or ZIP", b"ply\n": "PLY", b"ply\r": "PLY", b"glTF": "GLB", b"OFF\n": "OFF",
    b"# .PCD": "PCD", b"LASF": "LAS or LAZ", b"\x93NUMPY": "NPY",
}  # fmt: skip


def _read_bytes(path: Path) -> bytes:
    """Return a file's bytes, or raise InputError if there are none to be had."""
    try:
        require_file(path, one_line(path))
        data = path.read_bytes()
    except (OSError, ValueError) as error:
        if isinstance(error, InputError):
            raise
        reason = getattr(error, "strerror", None) or str(error)
        raise InputError(f"{one_line(path)}: cannot be read: {reason}; check the path and its permissions") from error
    if not data:
        raise InputError(f"{one_line(path)}: expected a mesh or a cloud, got an empty file; was its download cut off?")
    return data


def _require_own_signature(data: bytes, path: Path) -> None:
    """Raise InputError for a file whose first bytes are another format's than its ending's."""
    kind = next((kind for magic, kind in _SIGNATURES.items() if data.startswith(magic)), None)
    expected = path.suffix.lower()[1:].upper()
    is_binary_stl = expected == "STL" and len(data) == 84 + 50 * int.from_bytes(data[80:84], "little")
    if kind and expected not in kind and not is_binary_stl:  # a binary STL may begin with any 80 bytes
        raise InputError(
            f"{one_line(path.name)}: expected {expected}, got a {kind} file; give it the ending of what it is"
        )


def _read_arrays(data: bytes, path: Path) -> Geometry:
    """Return what the reader of the file's ending makes of it, checked."""
    module, name = READERS[path.suffix.lower()]
    reader = getattr(importlib.import_module(f".{module}", __package__), name)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return reader(data, path).checked()


def read_geometry(path: str | Path) -> Geometry:
    """Return the vertices and triangles of a file, or its points.

    Parameters
    ----------
    path : str or Path
        PLY, PCD, OBJ, STL, 3DS, OFF, GLB, glTF, DAE, 3MF, URDF, XYZ, CSV, TXT, LAS, LAZ, NPZ or NPY, told by the
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
    path = Path(path)
    if path.is_dir():
        raise InputError(f"{one_line(path)}: expected a file, got a folder; name a file in it")
    if path.suffix.lower() not in READERS:
        endings = ", ".join(READERS)
        raise InputError(f"{one_line(path)}: expected one of {endings}, got '{path.suffix}'; convert it")
    data = _read_bytes(path)
    _require_own_signature(data, path)
    try:
        return _read_arrays(data, path)
    except ImportError as error:
        if (error.name or "").partition(".")[0] not in OPTIONAL:
            raise  # a broken installation, not a bad file
        needs = f"expected the extra 'formats' to read it, {error.name} is missing"
        raise InputError(f"{one_line(path.name)}: {needs}; pip install 'spherefunc-bullet[formats]'") from error
    except InputError as error:  # of a file that this one names
        raise InputError(f"{one_line(path.name)}: {one_line(error)}") from error
    except FormatError as error:
        raise InputError(f"{one_line(path.name)}: {one_line(error)}") from error
    except MemoryError as error:
        wanted = "expected to need no more memory to read it than there is"
        raise OutOfMemory(f"{one_line(path.name)}: {wanted}; simplify it") from error
    except Exception as error:  # the one place where what readers raise on damaged bytes becomes the user's error
        kind = path.suffix.lower()[1:].upper()
        detail = one_line(f"{type(error).__name__}: {error}")[:160]
        raise InputError(
            f"{one_line(path.name)}: expected a {kind} file, could not read it ({detail}); is it damaged?"
        ) from error
