"""Where the meshes of a URDF are looked for: in its own folder, in its package, and where the user points.

The user points with ``--package-path`` or ``ROS_PACKAGE_PATH``. Nothing outside of these folders is ever read.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from pathlib import Path
from urllib.parse import unquote

from ..sources import inside

PACKAGE_PATH = "ROS_PACKAGE_PATH"  # of the environment: folders of packages, or packages
_MARK = "package.xml"  # that ROS has in every package
_LAYOUT = ("urdf", "robots", "xacro")  # where a package keeps such files, if it has no mark


def find_mesh(name: str, folder: Path) -> Path | None:
    """Return the mesh that a URDF in a folder calls by a name; None if there is none where it may be."""
    folder = folder.resolve()
    trusted = [*(parent for parent in folder.parents if (parent / _MARK).is_file()), *_pointed()]
    places = _places(unquote(name), folder, trusted)
    return next((target for root, inner in places if (target := inside(root / inner, [root, *trusted]))), None)


def _pointed() -> list[Path]:
    """Return the folders that the user points to."""
    return [Path(part).resolve() for part in os.environ.get(PACKAGE_PATH, "").split(os.pathsep) if part.strip()]


def _places(name: str, folder: Path, trusted: Sequence[Path]) -> Iterator[tuple[Path, str]]:
    """Yield the folders in which a name may be, and what it is called there: in ``package://name/file``, file."""
    scheme, _, rest = name.rpartition("://")
    if scheme in ("", "file"):
        yield folder, rest
    elif scheme == "package":
        package, _, inner = rest.partition("/")
        if package.strip(".") and inner:
            roots = [folder, *_unmarked(folder), *trusted]
            yield from ((root, inner) for root in roots if root.name == package)
            yield from ((root / package, inner) for root in trusted)
            yield from ((folder, inner), (folder, rest))  # the second is where PyBullet finds it


def _unmarked(folder: Path) -> list[Path]:
    """Return the package that a folder is a part of by its name alone; homes and top folders hold more than that."""
    package = folder.parent
    shared = len(package.parents) < 2 or Path.home().resolve().is_relative_to(package)
    return [package] if folder.name in _LAYOUT and not shared else []
