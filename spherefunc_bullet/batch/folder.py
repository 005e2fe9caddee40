"""The folder of a run: the ledger, and the settled spheres in files named by a hash of all that determines them.

``partial/`` holds files of workers that are not synced yet: complete, since they were renamed into place, but lost or
damaged if the power fails. ``settled/`` holds files that are synced to the disk; only these get a row in the ledger.
"""

from __future__ import annotations

import hashlib
import os
import socket
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import FAILURES, InputError
from ..formats.files import write_whole, writing
from ..formats.npz import entry_path, read_entry
from .ledger import DONE, WAITING, Ledger, LedgerRow

KIND = "settled"


class FullDisk(InputError):
    """Nothing more can be written, which ends the run and is not the failure of an object."""


@dataclass(frozen=True)
class RunFolder:
    """The folder of a run, with the same layout as the cache, so that it can be used as one."""

    path: Path

    @property
    def partial(self) -> Path:
        return self.path / "partial"

    def ledger(self, *, make: bool = False) -> Ledger:
        """Open the ledger."""
        return Ledger(self.path / "ledger.sqlite", make=make)

    def make(self):
        """Make the folder, and delete the scratch files of processes that have ended."""
        with writing(self.path, "a folder"):
            self.partial.mkdir(parents=True, exist_ok=True)
        self.sweep()

    def sweep(self):
        """Delete the scratch files of processes that have ended.

        This is done at the end of a call as well, since workers of a killed call may still be ending at its beginning.
        """
        with writing(self.path, "a folder"):
            for scratch in self.partial.rglob("*.tmp"):
                if not is_alive(int(scratch.suffixes[-2][1:])):
                    scratch.unlink(missing_ok=True)

    def entry(self, run: str) -> Path:
        """Return where the settled centres of a run are kept."""
        return entry_path(KIND, run, self.path)

    def find(self, run: str) -> dict[str, np.ndarray] | None:
        """Return the arrays of a run, kept or still partial; None if there is no complete file."""
        arrays = read_entry(self.entry(run))
        return read_entry(entry_path(KIND, run, self.partial)) if arrays is None else arrays

    def put(self, run: str, content: bytes):
        """Write the content of the file of a run's arrays, without syncing."""
        path = entry_path(KIND, run, self.partial)
        with writing(path, kind=FullDisk):
            write_whole(path, content)

    def keep(self, run: str) -> dict[str, int]:
        """Sync the file of a run's arrays, move it to its final place, and return its size and time."""
        partial, entry = entry_path(KIND, run, self.partial), self.entry(run)
        with writing(entry, kind=FullDisk):
            if partial.is_file() and not (entry.is_file() and read_entry(entry)):
                entry.parent.mkdir(parents=True, exist_ok=True)
                with suppress(FileNotFoundError):  # another batch on the same run has moved it meanwhile
                    sync(partial)
                    os.replace(partial, entry)
                sync(entry.parent)
            partial.unlink(missing_ok=True)
            return size_and_time(entry)


def size_and_time(path: Path) -> dict[str, int]:
    """Return the size and the time of the file of a run's centres, as columns of the ledger."""
    about = path.stat()
    return {"bytes": about.st_size, "kept": about.st_mtime_ns}


def sync(path: Path):
    """Sync a file or a folder to the disk."""
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def digest(centers: np.ndarray) -> str:
    """Return the hash of settled centres (S, 3) float32, by which two runs are compared."""
    return hashlib.sha256(f"{centers.dtype} {centers.shape}".encode() + centers.tobytes()).hexdigest()


def is_alive(process: int) -> bool:
    """Return whether a process with this number runs on this machine."""
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except PermissionError:
        pass
    return not is_zombie(process)


def is_zombie(process: int) -> bool:
    """Return whether a process has ended and its parent has not noticed yet, which is known on Linux only."""
    try:
        about = Path(f"/proc/{process}/stat").read_text(encoding="ascii", errors="replace")
    except OSError:
        return False
    return about.rpartition(")")[2].split()[:1] == ["Z"]


ROWS_AT_ONCE = 1000  # in a transaction
RANK = {WAITING: 0, DONE: 2}  # the row of two ledgers with the higher rank counts; failed rows are between these


def merge_runs(
    sources: Sequence[RunFolder], target: RunFolder, *, failed: Callable[[InputError], None]
) -> dict[str, int]:
    """Copy the rows and settled centres of runs into another run, which may hold some already.

    If it is interrupted, it can be called again. A row that is done replaces one that failed, and that replaces one
    that waits. Centres are copied only if they agree with their row; otherwise the row waits, and a batch on the target
    simulates it.

    Parameters
    ----------
    failed : callable
        Gets an error for each object on which runs disagree, or whose centres are damaged.

    Returns
    -------
    dict
        The number of runs that were joined, of rows that were copied (``merged``), and of rows that the target had
        already (``kept``).

    Raises
    ------
    InputError
        If a source is not a run, or the target cannot be written.
    """
    counts = {"runs": len(sources), "merged": 0, "kept": 0}
    target.make()
    with target.ledger(make=True) as ledger:
        ledger.check()
        for source in sources:
            with source.ledger() as other:
                for rows in copied_rows(source, other, target, ledger, failed, counts):
                    ledger.write(rows)
    return counts


def copied_rows(
    source: RunFolder, other: Ledger, target: RunFolder, ledger: Ledger, failed: Callable, counts: dict[str, int]
) -> Iterator[list[LedgerRow]]:
    """Yield the rows for the ledger of the target, in portions, after their centres are copied."""
    for number, config in other.run_configs().items():
        ours = ledger.number(config)
        known = {row.object: row for row in ledger.rows([ours])}
        rows = []
        for row in other.rows([number]):
            copied = copied_row(replace(row, way=ours), known.get(row.object), source, target, failed)
            counts["kept" if copied is None else "merged"] += 1
            rows += [copied] if copied is not None else []
            if len(rows) == ROWS_AT_ONCE:
                yield rows
                rows = []
        yield rows


def copied_row(
    row: LedgerRow, known: LedgerRow | None, source: RunFolder, target: RunFolder, failed: Callable
) -> LedgerRow | None:
    """Return a row for the target, after its centres are copied; None if the target's own row ranks as high."""
    if known is not None and RANK.get(known.outcome, 1) >= RANK.get(row.outcome, 1):
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
    target.put(row.run, source.entry(row.run).read_bytes())
    return replace(row, **target.keep(row.run))


# The state of an object, from the outcomes of its rows.
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
        began; ``seconds_left`` at that rate, None while it is unknown or nothing runs; ``running`` whether a call is
        running, None if that is known on another machine only.
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
    """Return whether a call is running: it has not ended and its process lives; None if it is on another machine."""
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
