"""Impaired copies as a data set on disk: binary PLY files, and a manifest that names the original of each."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from operator import itemgetter
from pathlib import Path

import numpy as np
import trimesh

from spherefunc_bullet.clouds.cloud import Cloud, load_cloud
from spherefunc_bullet.console import passed
from spherefunc_bullet.datasets.catalogue import write_manifest
from spherefunc_bullet.datasets.dataset import Dataset, DatasetObject, csv_table, label_text, open_dataset
from spherefunc_bullet.errors import InputError, one_line
from spherefunc_bullet.formats.files import prepare_folder, write_bytes
from spherefunc_bullet.formats.units import BY_FILE
from spherefunc_bullet.processes.tasks import run_tasks

from .impairments import IMPAIRMENTS
from .specimen import FUNCTIONS, NONE, Impairment, Specimen
from .surfaces import ObjectSurface

COLUMNS = ("file", "label", "of", "kind", "works", "also", "category", "group", "source", "license")
Failed = Callable[[InputError], None]


@dataclass(frozen=True, kw_only=True)
class CopyRow:
    """One copy in a folder."""

    item: DatasetObject  # with the function that the copy has
    of: str  # the original's name in its data set
    kind: str
    works: bool


@dataclass(frozen=True, kw_only=True)
class CopyFolder:
    """The copies that were made of a data set."""

    manifest: Path
    made: dict[str, int]  # by function and kind, such as "cup hole"
    left_out: dict[str, int]  # likewise, of copies that could not be made


def impair_dataset(
    dataset: Dataset,
    directory: Path,
    *,
    seed: int = 0,
    impairments: Sequence[Impairment] = IMPAIRMENTS,
    up: str = BY_FILE,
    units: str = "m",
    points: int | None = None,
    jobs: int = 1,
    failed: Failed,
) -> CopyFolder:
    """Write impaired copies of a data set's functional objects, and ``manifest.csv`` at the end.

    Parameters
    ----------
    seed : int
        The same seed gives the same files, bit for bit.
    up, units : str
        How the files are read (see `load_cloud`); copies are in metres, z up.
    points : int, optional
        Write this many points at random on each copy, as scanners do, instead of its triangles.
    failed : callable
        Called with the error of each file that cannot be used; the others are still copied.

    Raises
    ------
    InputError
        If no object has a function that can be impaired, or the directory cannot be written.
    """
    functions = {function for impairment in impairments for function in impairment.functions}
    numbered = [(number, item) for number, item in enumerate(dataset.objects) if kind_of(item) in functions]
    if not any(function_of(item) for _, item in numbered):
        raise InputError(f"{dataset.name}: expected objects labelled {', '.join(FUNCTIONS)}, got none of them")
    prepare_folder(directory)
    fixed = directory, seed, impairments, points, partial(load_cloud, up=up, units=units)
    tasks = [(number, item, dataset.name_of(item.path), *fixed) for number, item in numbered]
    outcomes = run_tasks(write_copies, tasks, [item.path for _, item in numbered], jobs=jobs)
    done = [copies for _, copies in sorted(passed(outcomes, len(tasks), "making copies", failed), key=itemgetter(0))]
    rows = [row for written, _ in done for row in written]
    left_out = sum((missing for _, missing in done), Counter())
    made = Counter(row[-1] for row in rows)
    manifest = write_manifest(directory, COLUMNS, [row[:-1] for row in rows])
    return CopyFolder(manifest=manifest, made=dict(made), left_out=dict(left_out))


def write_copies(
    number: int,
    item: DatasetObject,
    name: str,
    directory: Path,
    seed: int,
    impairments: Sequence[Impairment],
    points: int | None,
    reading: Callable[[Path], Cloud],
) -> tuple[list[tuple], Counter[str]]:
    """Write the copies of one object; return their rows of the manifest, and how many of each kind were not made.

    Each row ends with the copy's function and kind. A useless copy has no function, nor one that was true of the
    original as well.
    """
    rows, left_out = [], Counter()
    specimen = Specimen(reading(item.path), kind_of(item))
    about = item.category, item.group, item.source, item.license
    for impairment in impairments:
        if specimen.function not in impairment.functions:
            continue
        surface, made = impairment.applied(specimen, name, seed), f"{specimen.function} {impairment.kind}"
        if surface is None:
            left_out[made] += 1
            continue
        file = f"{number:04d}_{one_line(item.path.stem)}_{impairment.kind}.ply"
        write_bytes(directory / file, copy_ply(surface if points is None else surface.sampled(points, seed)))
        works = impairment.works
        label, also = (label_text(item.functions), ";".join(sorted(item.also))) if works else (NONE, "")
        rows.append((file, label, name, impairment.kind, int(works), also, *about, made))
    return rows, left_out


def evenly_chosen(objects: Sequence[DatasetObject], most: int | None) -> tuple[DatasetObject, ...]:
    """Return the objects that have a function: at most this many of each, evenly spread over the data set."""
    return tuple(item for function in FUNCTIONS for item in evenly_spread(objects, function, most))


def evenly_spread(objects: Sequence[DatasetObject], function: str, most: int | None) -> list[DatasetObject]:
    """Return at most this many objects of one function, or of none, evenly spread over the data set."""
    return evenly([item for item in objects if kind_of(item) == function], most)


def evenly(objects: Sequence[DatasetObject], count: int | None) -> list[DatasetObject]:
    """Return at most this many objects, evenly chosen; all without a count."""
    most = len(objects) if count is None else min(count, len(objects))
    return [objects[k * len(objects) // most] for k in range(most)]


def function_of(item: DatasetObject) -> str | None:
    """Return the function of an object that can be impaired, the first by name of several; None if it has none."""
    return next((function for function in FUNCTIONS if function in item.functions), None)


def kind_of(item: DatasetObject) -> str:
    """Return the function by which the copies of an object are chosen; ``none`` for an object without any."""
    return function_of(item) or ("also" if item.also else NONE)


def copy_ply(surface: ObjectSurface) -> bytes:
    """Return a surface as a binary PLY file, a mesh or a cloud."""
    vertices, faces = surface.mesh()
    vertices, how = vertices.astype(np.float32), {"file_type": "ply", "encoding": "binary"}
    if not len(faces):
        return trimesh.PointCloud(vertices).export(**how)
    return trimesh.Trimesh(vertices, faces, process=False).export(**how, vertex_normal=False)


def read_copies(folder: Path) -> list[CopyRow]:
    """Return the copies in a folder, in the order of its manifest.

    Raises
    ------
    InputError
        If `impair_dataset` did not write the folder.
    """
    objects, rows = open_dataset(folder).objects, csv_table(folder / "manifest.csv", "of", "kind", "works")
    return [
        CopyRow(item=item, of=row["of"], kind=row["kind"], works=row["works"] == "1")
        for item, row in zip(objects, rows, strict=True)
    ]
