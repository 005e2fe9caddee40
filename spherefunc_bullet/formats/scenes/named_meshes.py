"""Meshes, and other files, that a URDF, SDF or MJCF names.

The readers of their own formats read them, with the same limits. They are looked for in the folder of the file, in its
ROS package or what is laid out like one, and in the folders that the user gives with ``--package-path`` or
``ROS_PACKAGE_PATH``; nothing outside these folders is ever read.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from urllib.parse import unquote

from .. import FormatError
from ..sources import Source, inside, read_geometry
from .parts import Part

PACKAGE_PATH = "ROS_PACKAGE_PATH"  # environment variable: folders of packages, or packages
_MARK = "package.xml"  # every ROS package has this file
_LAYOUT = frozenset({"urdf", "robots", "xacro"})  # subfolders of a package without that file that hold URDF files,
_MESHES = ("meshes", "mesh")  # and their meshes
_ASSETS = "assets"  # folder of models, of what they include, and of their meshes
_NAMING_MESHES = (".urdf", ".sdf")  # files that are no mesh, but name some


def find_mesh(name: str, folder: Path) -> Path | None:
    """Return the path of the mesh that a file in ``folder`` names; None if it is in none of the allowed folders.

    Gazebo's ``model://name/file`` is found as ``package://name/file`` is.
    """
    folder = folder.resolve()
    given = [Path(part).resolve() for part in os.environ.get(PACKAGE_PATH, "").split(os.pathsep) if part.strip()]
    trusted = [*(parent for parent in folder.parents if (parent / _MARK).is_file()), *_unmarked(folder), *given]
    places = (place for spelling in (name, unquote(name)) for place in _places(spelling, folder, trusted))
    return next((target for root, inner in places if (target := inside(root / inner, [root, *trusted]))), None)


def _places(name: str, folder: Path, trusted: Sequence[Path]) -> Iterator[tuple[Path, str]]:
    """Yield each folder in which a mesh may be, and its path there: of ``package://name/file`` it is ``file``.

    A path without a scheme is looked for in the folder of the file, then in those given, as PyBullet does.
    """
    scheme, _, rest = name.rpartition("://")
    if scheme in ("", "file"):
        yield from ((root, rest) for root in (folder, *trusted))
    elif scheme in ("package", "model"):
        package, _, inner = rest.partition("/")
        if package.strip(".") and inner:
            yield from ((root, inner) for root in (folder, *trusted) if root.name == package)
            yield from ((root / package, inner) for root in trusted)
            yield from ((folder, inner), (folder, rest))  # the second is where PyBullet finds it


def _unmarked(folder: Path) -> list[Path]:
    """Return packages up to two folders above, recognised by names of folders; never a home or a top-level folder."""
    home = Path.home().resolve()
    return [
        package
        for package, inner in zip(folder.parents[:2], (folder, *folder.parents), strict=False)
        if len(package.parents) > 1
        and not home.is_relative_to(package)
        and (package.name == _ASSETS or inner.name in _LAYOUT or any((package / name).is_dir() for name in _MESHES))
    ]


def mesh_source(name: str, folder: Path) -> Source:
    """Return the source of a mesh, or of another file, that a file in ``folder`` names; see `find_mesh`."""
    if not name.strip("./ "):
        raise FormatError(f"expected the name of a file, got {name[:80]!r}")
    target = find_mesh(name, folder)
    if target is None or target.suffix.lower() in _NAMING_MESHES:
        places = f"put them beside it, or name their package's folder in {PACKAGE_PATH}"
        raise FormatError(f"expected what it names in its own folder or its package, got {name[:80]!r}; {places}")
    return Source(target, target.suffix.lower())


def mesh_part(name: str, named: Mapping[str, Source]) -> Part:
    """Return the vertices and faces of a mesh among the sources that a file names."""
    geometry = read_geometry(named[name])
    if not len(geometry.faces):
        raise FormatError(f"expected meshes, got the points of {name[:80]!r}")
    return geometry.vertices, geometry.faces
