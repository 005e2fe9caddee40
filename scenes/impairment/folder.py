"""Impaired copies as a data set on disk: binary PLY files and a manifest that says what each is a copy of."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from operator import itemgetter
from pathlib import Path

import numpy as np
import trimesh

from spherefunc_bullet.clouds.cloud import Cloud, load_cloud
from spherefunc_bullet.console import passed
from spherefunc_bullet.datasets.catalogue import write_manifest
from spherefunc_bullet.datasets.dataset import NONE, Dataset, DatasetObject, csv_table, label_text, open_dataset
from spherefunc_bullet.errors import InputError
from spherefunc_bullet.formats.files import prepare_folder, write_bytes
from spherefunc_bullet.formats.units import BY_FILE
from spherefunc_bullet.processes.tasks import run_tasks

from .impairments import IMPAIRMENTS
from .specimen import FUNCTIONS, Impairment, Specimen
from .specimen import NONE as NOTHING
from .surfaces import ObjectSurface

COLUMNS = ("file", "label", "of", "kind", "works", "also", "category", "group", "source", "license")
Failed = Callable[[InputError], None]


@dataclass(frozen=True, kw_only=True)
class CopyRow:
    """One copy in a folder."""

    item: DatasetObject  # with the function that it has now
    of: str  # the original, as its data set calls it
    kind: str
    works: bool


@dataclass(frozen=True, kw_only=True)
class CopyFolder:
    """What was made of a data set."""

    manifest: Path
    made: dict[str, int]  # by function and kind, such as "cup hole"
    left_out: dict[str, int]  # of what cannot be made of an object


def impair_dataset(
    dataset: Dataset,
    directory: Path,
    *,
    seed: int = 0,
    impairments: Sequence[Impairment] = IMPAIRMENTS,
    up: str = BY_FILE,
    units: str = "m",
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
    failed : callable
        Is given the error of each file that cannot be used; the others go on.

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
    reading = partial(load_cloud, up=up, units=units)
    fixed = directory, seed, impairments, reading
    tasks = [(number, item, dataset.name_of(item.path), *fixed) for number, item in numbered]
    outcomes = run_tasks(write_copies, tasks, [item.path for _, item in numbered], jobs=jobs)
    done = [copies for _, copies in sorted(passed(outcomes, len(tasks), "making copies", failed), key=itemgetter(0))]
    rows = [row for written, _ in done for row in written]
    left_out = sum((missing for _, missing in done), Counter())
    made = Counter(f"{function} {kind}" for function, kind in (row[-1] for row in rows))
    manifest = write_manifest(directory, COLUMNS, [row[:-1] for row in rows])
    return CopyFolder(manifest=manifest, made=dict(made), left_out=dict(left_out))


def write_copies(
    number: int,
    item: DatasetObject,
    name: str,
    directory: Path,
    seed: int,
    impairments: Sequence[Impairment],
    reading: Callable[[Path], Cloud],
) -> tuple[list[tuple], Counter[str]]:
    """Write the copies of one object; return their rows of the manifest, and how often which kind cannot be made."""
    rows, left_out = [], Counter()
    specimen = Specimen(reading(item.path), kind_of(item))
    for impairment, surface in changed_copies(specimen, name, seed, impairments):
        if surface is None:
            left_out[f"{specimen.function} {impairment.kind}"] += 1
            continue
        file = f"{number:04d}_{item.path.stem}_{impairment.kind}.ply"
        write_bytes(directory / file, copy_ply(surface))
        rows.append(manifest_row(file, name, item, impairment))
    return rows, left_out


def evenly_chosen(objects: Sequence[DatasetObject], most: int | None) -> tuple[DatasetObject, ...]:
    """Return the objects that have a function, at most this many of each, evenly spread over the data set."""
    return tuple(item for function in FUNCTIONS for item in evenly_spread(objects, function, most))


def evenly_spread(objects: Sequence[DatasetObject], function: str, most: int | None) -> list[DatasetObject]:
    """Return at most this many objects of one function, or of none, evenly spread over the data set."""
    return evenly([item for item in objects if kind_of(item) == function], most)


def evenly(objects: Sequence[DatasetObject], count: int | None) -> list[DatasetObject]:
    """Return at most this many objects, evenly chosen; all without a count."""
    most = len(objects) if count is None else min(count, len(objects))
    return [objects[k * len(objects) // most] for k in range(most)]


def function_of(item: DatasetObject) -> str | None:
    """Return the one function of an object that can be impaired; of several, the first by name."""
    return next((function for function in FUNCTIONS if function in item.functions), None)


def kind_of(item: DatasetObject) -> str:
    """Return the one function that decides which copies are made of an object; ``none`` of what has none at all."""
    return function_of(item) or ("also" if item.also else NOTHING)


def changed_copies(
    specimen: Specimen, name: str, seed: int, impairments: Iterable[Impairment]
) -> Iterator[tuple[Impairment, ObjectSurface | None]]:
    """Yield each kind for an object's function, with the copy or None where it cannot be made."""
    for impairment in impairments:
        if specimen.function in impairment.functions:
            yield impairment, impairment.applied(specimen, name, seed)


def manifest_row(file: str, of: str, item: DatasetObject, impairment: Impairment) -> tuple:
    """Return a copy's row of the manifest, and last its function and kind.

    A useless copy has no function, nor one that was true of the original as well.
    """
    label, also = (label_text(item.functions), ";".join(sorted(item.also))) if impairment.works else (NONE, "")
    kind, works = impairment.kind, int(impairment.works)
    about = (item.category, item.group, item.source, item.license)
    return file, label, of, kind, works, also, *about, (kind_of(item), kind)


def copy_ply(surface: ObjectSurface) -> bytes:
    """Return a surface as a binary PLY file, a mesh or a cloud."""
    vertices, faces = surface.mesh()
    vertices = vertices.astype(np.float32)
    item = trimesh.Trimesh(vertices, faces, process=False) if len(faces) else trimesh.PointCloud(vertices)
    if len(faces):
        return item.export(file_type="ply", encoding="binary", vertex_normal=False)
    return item.export(file_type="ply", encoding="binary")


def read_copies(folder: Path) -> list[CopyRow]:
    """Return the copies in a folder, in the order of its manifest.

    Raises
    ------
    InputError
        If the folder is none that `impair_dataset` wrote.
    """
    objects, rows = open_dataset(folder).objects, csv_table(folder / "manifest.csv", "of", "kind", "works")
    return [
        CopyRow(item=item, of=row["of"], kind=row["kind"], works=row["works"] == "1")
        for item, row in zip(objects, rows, strict=True)
    ]
