"""Catalogues of generated objects, found through the entry-point group ``spherefunc.catalogues`` and written once.

A catalogue is a function of a seed that returns objects with ``name``, ``label``, ``also``, ``category`` and
``mesh`` (a `trimesh.Trimesh` in metres, z up).
"""

from __future__ import annotations

import csv
import os
import tempfile
from collections.abc import Callable, Iterable
from importlib.metadata import EntryPoint, entry_points, version
from pathlib import Path

from ..errors import InputError, explaining, one_line
from ..formats.files import cache_home, write_bytes, write_csv, writing

COLUMNS = ("file", "label", "also", "category", "group")
VERSION = 2  # of the catalogues on disk; they are built again when it changes


def catalogue_entry_points() -> dict[str, EntryPoint]:
    """Return the registered catalogues by name, without importing them."""
    return {point.name: point for point in entry_points(group="spherefunc.catalogues")}


def make_catalogue(name: str, seed: int = 0) -> list:
    """Return a catalogue's objects.

    Raises
    ------
    InputError
        If no catalogue has that name.
    """
    points = catalogue_entry_points()
    if name not in points:
        raise InputError(f"catalogue {name!r}: expected one of {', '.join(sorted(points)) or 'none installed'}")
    return points[name].load()(seed)


def built_catalogue(name: str) -> Path:
    """Return the manifest of a catalogue, building it in the cache the first time."""
    folder = cache_home() / "catalogues" / f"{version('spherefunc-bullet')}-{VERSION}" / name
    return built_once(folder, lambda place: write_catalogue(make_catalogue(name), place, name))


def built_once(folder: Path, build: Callable[[Path], object]) -> Path:
    """Return the manifest of a folder, which is built the first time, even by two processes at once.

    Raises
    ------
    InputError
        If the folder cannot be written.
    """
    manifest = folder / "manifest.csv"
    if not manifest.is_file():
        with writing(folder.parent, "a folder, here or in $SPHEREFUNC_CACHE,"):
            folder.parent.mkdir(parents=True, exist_ok=True)
            with tempfile.TemporaryDirectory(dir=folder.parent) as scratch:
                build(Path(scratch) / folder.name)
                try:
                    os.replace(Path(scratch) / folder.name, folder)
                except OSError:  # the first to rename wins, the other's copy is dropped
                    if not manifest.is_file():
                        raise
    return manifest


def write_catalogue(objects: Iterable, directory: str | os.PathLike, group: str) -> Path:
    """Write one binary PLY per object and, last, ``manifest.csv``; return the manifest's path.

    Parameters
    ----------
    objects : iterable
        Each with ``name``, ``label``, ``also``, ``category`` and ``mesh``.
    directory : path
        Created if it is missing.
    group : str
        The source of all objects in the manifest.

    Raises
    ------
    InputError
        If the directory cannot be written.
    """
    directory = Path(directory)
    rows = []
    with writing(directory, "a folder"):
        directory.mkdir(parents=True, exist_ok=True)
    for item in objects:
        file = f"{item.name}.ply"
        write_bytes(directory / file, item.mesh.export(file_type="ply", encoding="binary"))
        rows.append((file, item.label, item.also, item.category, group))
    return write_manifest(directory, COLUMNS, rows)


def require_no_others(directory: Path, files: Iterable[str]):
    """Raise InputError if the manifest of a folder, which would be replaced, has other files than these."""
    manifest = directory / "manifest.csv"
    if not manifest.is_file():
        return
    with explaining(f"{manifest}: expected none, or a CSV file", OSError, UnicodeDecodeError, csv.Error, why="; "):
        lines = manifest.read_text(encoding="utf-8-sig").splitlines()
        others = {row.get("file") or "" for row in csv.DictReader(lines)} - {*files}
    if others:
        lost = f"got the labels of {len(others)} others, such as {one_line(min(others))}, which would be lost"
        raise InputError(f"{manifest}: expected none, or one of the same files, {lost}; choose another folder")


def write_manifest(directory: Path, columns: Iterable[str], rows: Iterable[Iterable]) -> Path:
    """Write ``manifest.csv`` in one step, the file of each row first; return its path.

    Raises
    ------
    InputError
        If there is one with other files already, whose labels would be lost, or it cannot be written.
    """
    rows = list(rows)
    require_no_others(directory, (file for file, *_ in rows))
    return write_csv(directory / "manifest.csv", columns, rows)
