"""Catalogues: named, labelled objects, the families they are drawn from, and how they are written."""

from __future__ import annotations

import csv
import os
import zlib
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import trimesh

from spherefunc_bullet.errors import InputError

from .solids import stand

COLUMNS = ("file", "label", "also", "category", "group")


@dataclass(frozen=True)
class CatalogueObject:
    """One object of a catalogue: its mesh in metres, z up, its front to -y, and what it is for."""

    name: str
    label: str  # cup, table, sittable or none
    also: str  # functions that are true as well, separated by ';'
    category: str
    mesh: trimesh.Trimesh
    watertight: bool = True  # False: as open as the real thing, or a single-sided shell as many models are


@dataclass(frozen=True)
class Family:
    """Objects of one category, drawn from one parametric builder."""

    category: str
    build: Callable[[np.random.Generator], trimesh.Trimesh]
    count: int = 1
    also: str = ""
    watertight: bool = True


def draw(families: Iterable[Family], label: str, seed: int) -> Iterator[CatalogueObject]:
    """Yield every object of the families, each from a random stream of its own.

    The stream depends on the seed, the category and the number within it, so that a family added later leaves
    the objects of all others as they are.
    """
    numbers: dict[str, int] = {}
    for family in families:
        for _ in range(family.count):
            number = numbers[family.category] = numbers.get(family.category, 0) + 1
            rng = np.random.default_rng([seed, zlib.crc32(family.category.encode()), number])
            mesh = stand(family.build(rng))
            name = f"{family.category}_{number:02d}"
            yield CatalogueObject(name, label, family.also, family.category, mesh, family.watertight)


def write_catalogue(
    objects: Iterable[CatalogueObject],
    directory: str | os.PathLike,
    group: str,
    *,
    advance: Callable = lambda: None,
) -> Path:
    """Write one binary PLY per object and, last, ``manifest.csv``; return the manifest's path.

    Parameters
    ----------
    objects : iterable of CatalogueObject
    directory : path
        Made if it is missing.
    group : str
        The source that the manifest names for every object.
    advance : callable
        Called after each object.

    Raises
    ------
    InputError
        If the directory cannot be written.
    """
    directory = Path(directory)
    rows = []
    try:
        directory.mkdir(parents=True, exist_ok=True)
        for item in objects:
            file = f"{item.name}.ply"
            (directory / file).write_bytes(item.mesh.export(file_type="ply", encoding="binary"))
            rows.append((file, item.label, item.also, item.category, group))
            advance()
        return write_manifest(directory, COLUMNS, rows)
    except OSError as error:
        raise InputError(
            f"{directory}: expected a directory that can be written, got {error.strerror}"
        ) from error


def write_manifest(directory: Path, columns: Iterable[str], rows: Iterable[Iterable]) -> Path:
    """Write ``manifest.csv`` in one step, so that a reader never finds half of it; return its path."""
    part, path = directory / "manifest.csv.part", directory / "manifest.csv"
    with part.open("w", newline="", encoding="utf-8") as stream:
        writer = csv.writer(stream)
        writer.writerow(columns)
        writer.writerows(rows)
    os.replace(part, path)
    return path
