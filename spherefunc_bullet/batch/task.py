"""A batch's task: one object at the radii that are missing, what a worker makes of it, and what is kept of that."""

from __future__ import annotations

import time
import traceback
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

import numpy as np

from ..errors import InputError, Unexpected
from ..formats.npz import read_entry
from ..formats.sources import Source, as_source
from ..settling.cached_runs import DropConfig
from ..settling.drops import drops_from_rows
from .folder import FullDisk, RunFolder, digest, size_and_time
from .ledger import DONE, WAITING, LedgerRow


def valid_row(
    row: LedgerRow, path: Path, folder: RunFolder, drop_config: DropConfig, retry_failed: bool
) -> LedgerRow | None:
    """Return a row that is as true as when it was written: same object, and the centres are there. Else None.

    Sizes and times tell; where they differ, as after a copy, the contents do, and the row notes the new ones.
    """
    if row.outcome == WAITING or (row.outcome != DONE and retry_failed):
        return None
    stamp = source_stamp(path)
    if row.source != stamp and not same_content(row, path, drop_config):
        return None
    if row.outcome != DONE:
        return replace(row, source=stamp)
    about = valid_file_row(row, folder)
    return about and replace(row, source=stamp, **about)


def same_content(row: LedgerRow, path: Path, drop_config: DropConfig) -> bool:
    """Return whether a file holds what it held when a row was written."""
    try:
        return drop_config.content_hash(path) == row.content
    except InputError:
        return False


def source_stamp(path: Path) -> str:
    """Return the size and time of an object's file, and of each that it names; empty if one is not there."""
    try:
        about = [part.path.stat() for part in as_source(path).parts()]
    except (OSError, ValueError):  # InputError is a ValueError, and so is a name that no file can have
        return ""
    return " ".join(f"{file.st_size} {file.st_mtime_ns}" for file in about)


def valid_file_row(row: LedgerRow, folder: RunFolder) -> dict[str, int] | None:
    """Return size and time of the file of a row's centres; what is not that file is thrown away."""
    path = folder.entry(row.run)
    try:
        now = size_and_time(path)
    except OSError:
        return None
    if now == {"bytes": row.bytes, "kept": row.kept}:
        return now
    arrays = read_entry(path)
    if arrays is not None and "centers" in arrays and digest(arrays["centers"]) == row.digest:
        return now
    path.unlink(missing_ok=True)
    return None


@dataclass(frozen=True, kw_only=True)
class SimulationTask:
    """What a worker is to do: one object at the radii that are missing."""

    path: Path
    name: str
    radii: dict[int, float]  # way in the ledger -> metres
    drop_config: DropConfig
    source: Source | None = None  # with its content, of a task that travels


def settled_rows(task: SimulationTask, folder: RunFolder) -> list[LedgerRow]:
    """Return the rows of one object, simulating what the folder lacks; called in a worker.

    Raises
    ------
    InputError
        If the file cannot be used, the disk is full, or something is wrong with us or the backend.
    """
    try:
        source = task.source or as_source(task.path)
        content, cloud = task.drop_config.content_hash(source), cache(lambda: task.drop_config.cloud(source))
        return [settled_row(task, way, radius, content, cloud, folder) for way, radius in task.radii.items()]
    except (InputError, MemoryError):
        raise
    except Exception as error:  # whatever a backend makes of this object, the others are still to be done
        last = traceback.extract_tb(error.__traceback__)[-1]
        where = f"{Path(last.filename).name}, line {last.lineno}"
        raise Unexpected(f"{task.path}: expected a result, got {type(error).__name__}: {error} ({where})") from error


def settled_row(
    task: SimulationTask, way: int, radius: float, content: str, cloud: Callable, folder: RunFolder
) -> LedgerRow:
    """Return the row of one run, from the folder or simulated now."""
    run = task.drop_config.run_hash(content, radius)
    arrays = folder.find(run)
    if arrays is None:
        arrays = task.drop_config.run(cloud(), radius)
        folder.put(run, arrays)
    return done_row(task, way, content, run, arrays)


def done_row(task: SimulationTask, way: int, content: str, run: str, arrays: dict[str, np.ndarray]) -> LedgerRow:
    """Return what the ledger says of settled centres."""
    return LedgerRow(
        object=task.name,
        way=way,
        outcome=DONE,
        content=content,
        run=run,
        digest=digest(arrays["centers"]),
        settled=len(drops_from_rows(task.radii[way], arrays["centers"]).rests),
        drops=int(arrays["drops"]),
        seconds=float(arrays["seconds"]),
        memory=int(arrays["memory"]) if "memory" in arrays else None,
    )


def rows_to_record(task: SimulationTask, outcome: list[LedgerRow] | InputError, folder: RunFolder) -> list[LedgerRow]:
    """Return a task's rows as they are to be written, once all that they tell of is on the disk for certain."""
    if isinstance(outcome, FullDisk):
        raise outcome
    stamp, now = source_stamp(task.path), time.time()
    rows = outcome if isinstance(outcome, list) else failed_rows(task, outcome, folder)
    return [replace(row, source=stamp, finished=now, **kept(row, folder)) for row in rows]


def kept(row: LedgerRow, folder: RunFolder) -> dict[str, int]:
    """Keep the centres of a row, if it has any, and return the size and time of their file."""
    return folder.keep(row.run) if row.outcome == DONE else {}


def failed_rows(task: SimulationTask, error: InputError, folder: RunFolder) -> list[LedgerRow]:
    """Return the rows of an object that failed: done are the radii that it had finished before."""
    try:
        content = task.drop_config.content_hash(task.path)
    except InputError:
        content = None
    rows = []
    for way, radius in task.radii.items():
        run = content and task.drop_config.run_hash(content, radius)
        arrays = folder.find(run) if run else None
        if arrays is None:
            line = " ".join(str(error).replace(str(task.path), task.name).split())
            rows.append(LedgerRow(object=task.name, way=way, outcome=error.outcome, content=content, error=line))
        else:
            rows.append(done_row(task, way, content, run, arrays))
    return rows
