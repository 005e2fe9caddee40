"""The task of a batch: one object at the radii that are missing, its simulation in a worker, and its ledger rows."""

from __future__ import annotations

import json
import os
import time
from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

import numpy as np

from ..errors import InputError, blaming, one_line
from ..formats.npz import packed, read_entry
from ..formats.sources import NAMING, Source, as_source
from ..settling.cached_runs import DropConfig
from ..settling.drops import drops_from_rows
from .folder import FullDisk, RunFolder, digest, size_and_time
from .ledger import DONE, LedgerRow


def valid_row(
    row: LedgerRow, path: Path, folder: RunFolder, drop_config: DropConfig, retry_failed: bool
) -> LedgerRow | None:
    """Return a row if its object is unchanged and its centres are there; None if not, or if its file was not read.

    Files are compared by size and time; if these differ, as after a copy, by content, and the row gets the new ones.
    """
    if row.content is None or (row.outcome != DONE and retry_failed):
        return None
    stamp = row.source if is_unchanged(path, row.source) else source_stamp(path)
    try:
        if row.source != stamp and drop_config.content_hash(path) != row.content:
            return None
    except InputError:
        return None
    if row.outcome != DONE:
        return replace(row, source=stamp)
    about = valid_file_row(row, folder)
    return about and replace(row, source=stamp, **about)


def source_stamp(path: Path) -> str:
    """Return the stamp of an object's file and of those that it names, as it says; empty if one is missing."""
    try:
        _, *named = as_source(path).parts()
        folder = path.parent.resolve()
        return stamp_of(path, [path.name, *(os.path.relpath(part.path.resolve(), folder) for part in named)])
    except (OSError, ValueError):  # InputError is a ValueError, as is the error for an impossible file name
        return ""


def source_stamps(paths: Iterable[Path]) -> dict[Path, str]:
    """Return the stamps of many objects, side by side for files that name others, since USD takes a process each."""
    paths = list(paths)
    naming = [path for path in paths if path.suffix.lower() in NAMING]
    with ThreadPoolExecutor() as threads:
        known = dict(zip(naming, threads.map(source_stamp, naming), strict=True))
    return {path: known[path] if path in known else source_stamp(path) for path in paths}


def stamp_of(path: Path, names: Iterable[str]) -> str:
    """Return names of files, relative to the folder of an object's file, with their sizes and times, as JSON."""
    files = [(name, (path.parent.resolve() / name).stat()) for name in names]
    return json.dumps([(name, file.st_size, file.st_mtime_ns) for name, file in files])


def is_unchanged(path: Path, stamp: str | None) -> bool:
    """Return whether all files of a stamp are as they were; False where only the object's file can tell which they are.

    That file is not read, for which USD takes a process. Files of other folders may be found elsewhere now.
    """
    try:
        names = [name for name, _, _ in json.loads(stamp or "")]
        return not any(name.startswith("..") for name in names) and stamp == stamp_of(path, names)
    except (OSError, ValueError, TypeError):  # also for stamps of earlier versions
        return False


def valid_file_row(row: LedgerRow, folder: RunFolder) -> dict[str, int] | None:
    """Return the size and time of the file with the centres of a row; another file in its place is deleted."""
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
    """The task of a worker: one object at the radii that are missing."""

    path: Path
    name: str
    stamp: str  # `source_stamp` of the file before it is read, so that a change meanwhile is found by the next call
    radii: dict[int, float]  # number of the run configuration in the ledger -> metres
    drop_config: DropConfig
    source: Source | None = None  # with its content, if the task is sent to another machine


def settled_rows(task: SimulationTask, folder: RunFolder) -> list[LedgerRow]:
    """Return the rows of one object, simulating runs that are missing in the folder; called in a worker.

    Raises
    ------
    InputError
        If the file cannot be used, the disk is full, or this package or the backend has an error.
    """
    rows = []
    with blaming(str(task.path)):  # an error of the backend with this object must not end the run
        source = task.source or as_source(task.path)
        content, cloud = task.drop_config.content_hash(source), cache(lambda: task.drop_config.cloud(source))
        for way, radius in task.radii.items():
            run = task.drop_config.run_hash(content, radius)
            arrays = folder.find(run)
            if arrays is None:
                arrays = task.drop_config.run(cloud(), radius)
                folder.put(run, packed(arrays))
            rows.append(done_row(task, way, content, run, arrays))
    return rows


def done_row(task: SimulationTask, way: int, content: str, run: str, arrays: dict[str, np.ndarray]) -> LedgerRow:
    """Return the ledger row of a run that is done."""
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
    """Return the rows of a task as they are written to the ledger, after their files are synced to the disk."""
    if isinstance(outcome, FullDisk):
        raise outcome
    now = time.time()
    rows = outcome if isinstance(outcome, list) else failed_rows(task, outcome, folder)
    rows = [replace(row, **folder.keep(row.run)) if row.outcome == DONE else row for row in rows]
    return [replace(row, source=task.stamp, finished=now) for row in rows]


def failed_rows(task: SimulationTask, error: InputError, folder: RunFolder) -> list[LedgerRow]:
    """Return the rows of an object that failed; radii that were finished before the failure are done.

    They have no content if the file could not be read, or has changed since the task began: the next call tries again.
    """
    try:
        content = task.drop_config.content_hash(task.path) if source_stamp(task.path) == task.stamp else None
    except InputError:
        content = None
    line = one_line(str(error).replace(str(task.path), task.name))
    rows = []
    for way, radius in task.radii.items():
        run = content and task.drop_config.run_hash(content, radius)
        arrays = folder.find(run) if run else None
        failed = LedgerRow(object=task.name, way=way, outcome=error.outcome, content=content, error=line)
        rows.append(failed if arrays is None else done_row(task, way, content, run, arrays))
    return rows
