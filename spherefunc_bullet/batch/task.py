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
from ..formats.sources import Source, as_source
from ..settling.drops import drops_from_rows
from ..settling.records import Dropping
from .folder import FullDisk, RunFolder, digest
from .freshness import source_stamp
from .ledger import DONE, Row


@dataclass(frozen=True, kw_only=True)
class Task:
    """What a worker is to do: one object at the radii that are missing."""

    path: Path
    name: str
    radii: dict[int, float]  # way in the ledger -> metres
    dropping: Dropping
    source: Source | None = None  # with its content, of a task that travels


def settled_rows(task: Task, folder: RunFolder) -> list[Row]:
    """Return the rows of one object, simulating what the folder lacks; called in a worker.

    Raises
    ------
    InputError
        If the file cannot be used, the disk is full, or something is wrong with us or the backend.
    """
    try:
        source = task.source or as_source(task.path)
        content, cloud = task.dropping.content_hash(source), cache(lambda: task.dropping.cloud(source))
        return [settled_row(task, way, radius, content, cloud, folder) for way, radius in task.radii.items()]
    except (InputError, MemoryError):
        raise
    except Exception as error:  # whatever a backend makes of this object, the others are still to be done
        last = traceback.extract_tb(error.__traceback__)[-1]
        where = f"{Path(last.filename).name}, line {last.lineno}"
        raise Unexpected(f"{task.path}: expected a result, got {type(error).__name__}: {error} ({where})") from error


def settled_row(task: Task, way: int, radius: float, content: str, cloud: Callable, folder: RunFolder) -> Row:
    """Return the row of one run, from the folder or simulated now."""
    run = task.dropping.run_hash(content, radius)
    arrays = folder.find(run)
    if arrays is None:
        arrays = task.dropping.run(cloud(), radius)
        folder.put(run, arrays)
    return done_row(task, way, content, run, arrays)


def done_row(task: Task, way: int, content: str, run: str, arrays: dict[str, np.ndarray]) -> Row:
    """Return what the ledger says of settled centres."""
    return Row(
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


def kept_rows(task: Task, outcome: list[Row] | InputError, folder: RunFolder) -> list[Row]:
    """Return a task's rows as they are to be written, once all that they tell of is on the disk for certain."""
    if isinstance(outcome, FullDisk):
        raise outcome
    stamp, now = source_stamp(task.path), time.time()
    rows = outcome if isinstance(outcome, list) else failed_rows(task, outcome, folder)
    return [replace(row, source=stamp, finished=now, **kept(row, folder)) for row in rows]


def kept(row: Row, folder: RunFolder) -> dict[str, int]:
    """Keep the centres of a row, if it has any, and return the size and time of their file."""
    return folder.keep(row.run) if row.outcome == DONE else {}


def failed_rows(task: Task, error: InputError, folder: RunFolder) -> list[Row]:
    """Return the rows of an object that failed: done are the radii that it had finished before."""
    try:
        content = task.dropping.content_hash(task.path)
    except InputError:
        content = None
    rows = []
    for way, radius in task.radii.items():
        run = content and task.dropping.run_hash(content, radius)
        arrays = folder.find(run) if run else None
        if arrays is None:
            line = " ".join(str(error).replace(str(task.path), task.name).split())
            rows.append(Row(object=task.name, way=way, outcome=error.outcome, content=content, error=line))
        else:
            rows.append(done_row(task, way, content, run, arrays))
    return rows
