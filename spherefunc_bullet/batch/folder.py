"""A run's folder: the ledger, and every settled sphere in a file named for all that decides it.

``partial/`` holds what workers wrote and nobody has synced yet: whole, since it was renamed into place, but gone or
garbled if the power fails. ``settled/`` holds what is on the disk for certain; only that gets its row in the ledger.
"""

from __future__ import annotations

import hashlib
import os
import socket
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import FAILURES, InputError
from ..formats.files import write_whole, writing
from ..formats.npz import entry_path, packed, read_entry
from .ledger import DONE, WAITING, Ledger, LedgerRow

KIND = "settled"


class FullDisk(InputError):
    """Nothing more can be kept: the end of the run, and no object's failure."""


@dataclass(frozen=True)
class RunFolder:
    """Where a run keeps what it does; the same layout as the cache's, so that it can be one."""

    path: Path

    @property
    def partial(self) -> Path:
        return self.path / "partial"

    def ledger(self, *, make: bool = False) -> Ledger:
        """Open the ledger."""
        return Ledger(self.path / "ledger.sqlite", make=make)

    def make(self):
        """Make the folder, without the scratch files of processes that are gone."""
        with writing(self.path, "a folder"):
            self.partial.mkdir(parents=True, exist_ok=True)
        self.sweep()

    def sweep(self):
        """Throw away the scratch files of processes that are gone.

        When a call begins, a worker of one that was killed may still be on its way out; so when a call ends as well.
        """
        with writing(self.path, "a folder"):
            for scratch in self.partial.rglob("*.tmp"):
                if not is_alive(int(scratch.suffixes[-2][1:])):
                    scratch.unlink(missing_ok=True)

    def entry(self, run: str) -> Path:
        """Return where the settled centres of a run are kept."""
        return entry_path(KIND, run, self.path)

    def find(self, run: str) -> dict[str, np.ndarray] | None:
        """Return a run's arrays, kept or still partial; None if there are none that are whole."""
        arrays = read_entry(self.entry(run))
        return read_entry(entry_path(KIND, run, self.partial)) if arrays is None else arrays

    def put(self, run: str, arrays: dict[str, np.ndarray]):
        """Write a run's arrays, not synced."""
        self.put_bytes(run, packed(arrays))

    def put_bytes(self, run: str, content: bytes):
        """Write the file of a run's arrays, not synced."""
        path = entry_path(KIND, run, self.partial)
        with writing(path, kind=FullDisk):
            write_whole(path, content)

    def keep(self, run: str) -> dict[str, int]:
        """Sync the file of a run's arrays and move it to where it is kept; return its size and time."""
        partial, entry = entry_path(KIND, run, self.partial), self.entry(run)
        with writing(entry, kind=FullDisk):
            if partial.is_file() and not (entry.is_file() and read_entry(entry)):
                sync(partial)
                entry.parent.mkdir(parents=True, exist_ok=True)
                os.replace(partial, entry)
                sync(entry.parent)
            partial.unlink(missing_ok=True)
            return size_and_time(entry)


def size_and_time(path: Path) -> dict[str, int]:
    """Return what the ledger has of the file of a run's centres."""
    about = path.stat()
    return {"bytes": about.st_size, "kept": about.st_mtime_ns}


def sync(path: Path):
    """Have the disk hold what a file or a folder holds."""
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def digest(centers: np.ndarray) -> str:
    """Return the hash of settled centres (S, 3) float32, by which two runs are compared."""
    return hashlib.sha256(f"{centers.dtype} {centers.shape}".encode() + centers.tobytes()).hexdigest()


def is_alive(process: int) -> bool:
    """Return whether a process of this number runs on this machine."""
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except PermissionError:
        pass
    return not is_zombie(process)


def is_zombie(process: int) -> bool:
    """Return whether a process has ended and waits for its parent to notice, where the system tells: on Linux."""
    try:
        about = Path(f"/proc/{process}/stat").read_text(encoding="ascii", errors="replace")
    except OSError:
        return False
    return about.rpartition(")")[2].split()[:1] == ["Z"]


ROWS_AT_ONCE = 1000  # in a transaction
RANK = {WAITING: 0, DONE: 2}  # of what two ledgers say, the higher counts; between them: failed


def merge_runs(
    sources: Sequence[RunFolder], target: RunFolder, *, failed: Callable[[InputError], None]
) -> dict[str, int]:
    """Copy the rows and settled centres of runs into another run, which may hold some already.

    Cut off, it is called again. A row that is done replaces one that failed, and that one that waits. Centres are
    copied only if they are what their row says; otherwise the row waits, and a batch on the target simulates it.

    Parameters
    ----------
    failed : callable
        Takes what could not be joined: runs that disagree about the same object, centres that are damaged.

    Returns
    -------
    dict
        How many runs were joined, rows taken over, and rows left alone, since the target had them.

    Raises
    ------
    InputError
        If a source is no run, or the target cannot be written.
    """
    counts = {"runs": len(sources), "merged": 0, "kept": 0}
    target.make()
    with target.ledger(make=True) as ledger:
        ledger.check()
        for source in sources:
            with source.ledger() as other:
                for rows in taken_over(source, other, target, ledger, failed, counts):
                    ledger.write(rows)
    return counts


def taken_over(
    source: RunFolder, other: Ledger, target: RunFolder, ledger: Ledger, failed: Callable, counts: dict[str, int]
) -> Iterator[list[LedgerRow]]:
    """Yield the rows that the target's ledger is to get, some at a time, once their centres are copied."""
    for number, way in other.ways().items():
        ours = ledger.number(way)
        known = {row.object: row for row in ledger.rows([ours])}
        rows = []
        for row in other.rows([number]):
            moved = joined(replace(row, way=ours), known.get(row.object), source, target, failed)
            counts["kept" if moved is None else "merged"] += 1
            rows += [moved] if moved is not None else []
            if len(rows) == ROWS_AT_ONCE:
                yield rows
                rows = []
        yield rows


def joined(
    row: LedgerRow, known: LedgerRow | None, source: RunFolder, target: RunFolder, failed: Callable
) -> LedgerRow | None:
    """Return the row that the target gets, None if it has as good a one."""
    if known is not None and rank(known) >= rank(row):
        if known.outcome == row.outcome == DONE and known.digest != row.digest:
            other = f"expected the same spheres in every run, {source.path} has others"
            failed(InputError(f"{row.object}: {other}; left out"))
        return None
    if row.outcome != DONE:
        return row
    arrays = read_entry(source.entry(row.run))
    if arrays is None or "centers" not in arrays or digest(arrays["centers"]) != row.digest:
        failed(InputError(f"{row.object}: expected its spheres in {source.path}, they are damaged; simulate it again"))
        return LedgerRow(object=row.object, way=row.way)
    target.put_bytes(row.run, source.entry(row.run).read_bytes())
    return replace(row, **target.keep(row.run))


def rank(row: LedgerRow) -> int:
    """Return how much a row is worth: one that is done the most, one that waits the least."""
    return RANK.get(row.outcome, 1)


# Of an object, from the outcomes of its rows.
STATE = f"CASE WHEN max(outcome = '{WAITING}') THEN 'waiting' WHEN min(outcome = '{DONE}') THEN 'done'"
STATE += " ELSE 'failed' END"
REASONS = 20  # failures that are listed


def status(ledger: Ledger) -> dict[str, Any]:
    """Return a run's progress, rate, failures and time left.

    Returns
    -------
    dict
        ``objects``, ``done``, ``failed`` and ``waiting`` count objects, ``runs`` their rows by outcome;
        ``seconds`` of simulation and ``bytes`` of centres so far; ``rate`` in runs per second since the last call
        began; ``seconds_left`` at that rate, None while it is unknown or nothing runs; ``running`` whether a call is at
        work, None where only another machine could tell.
    """
    by_object = f"SELECT {STATE} AS state FROM runs GROUP BY object"
    states = dict(ledger.query(f"SELECT state, count(*) FROM ({by_object}) GROUP BY state"))
    totals = ledger.query("SELECT outcome, count(*), sum(seconds), sum(bytes) FROM runs GROUP BY outcome")
    runs = {outcome: count for outcome, count, *_ in totals}
    running = is_running(ledger)
    rate = rate_of(ledger, running)
    waiting = runs.get(WAITING, 0)
    left = round(waiting / rate) if rate and running is not False else None
    return {
        "objects": sum(states.values()),
        **{state: states.get(state, 0) for state in (DONE, "failed", WAITING)},
        "runs": runs,
        "seconds": round(sum(seconds or 0.0 for _, _, seconds, _ in totals), 3),
        "bytes": sum(size or 0 for *_, size in totals),
        "rate": rate and round(rate, 4),
        "seconds_left": left if waiting else 0,
        "running": running,
        "failures": failures(ledger),
    }


def is_running(ledger: Ledger) -> bool | None:
    """Return whether some call is at work: one that has not ended and whose process lives; None: on another machine."""
    answers = {
        is_alive(process) if host == socket.gethostname() else None
        for host, process in ledger.query("SELECT host, process FROM calls WHERE ended IS NULL")
    }
    return True if True in answers else None if None in answers else False


def rate_of(ledger: Ledger, running: bool | None) -> float | None:
    """Return the runs per second of the last call, until now or until it ended; None if there are none yet."""
    last = ledger.query("SELECT started, ended FROM calls ORDER BY rowid DESC LIMIT 1")
    if not last:
        return None
    started, ended = last[0]
    outcomes = ", ".join(f"'{outcome}'" for outcome in (DONE, *FAILURES))
    sql = f"SELECT count(*), max(finished) FROM runs WHERE outcome IN ({outcomes}) AND finished >= ?"
    ((count, newest),) = ledger.query(sql, (started,))
    if not count:
        return None
    until = ended or (newest if running is False else max(time.time(), newest))
    return count / max(until - started, 1e-3)


def failures(ledger: Ledger) -> list[dict[str, str]]:
    """Return the first objects that failed, and why."""
    sql = f"SELECT object, outcome, min(error) FROM runs WHERE outcome IN ({', '.join('?' * len(FAILURES))})"
    rows = ledger.query(f"{sql} GROUP BY object, outcome ORDER BY object LIMIT {REASONS}", FAILURES)
    return [dict(zip(("object", "outcome", "error"), row, strict=True)) for row in rows]
