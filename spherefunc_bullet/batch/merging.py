"""Several runs joined in one: those of a job array's shards, or of several machines."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

from ..errors import InputError
from ..settling.cache import read_entry
from .folder import RunFolder, digest
from .ledger import DONE, WAITING, Ledger, Row

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
) -> Iterator[list[Row]]:
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


def joined(row: Row, known: Row | None, source: RunFolder, target: RunFolder, failed: Callable) -> Row | None:
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
        return Row(object=row.object, way=row.way)
    target.put_bytes(row.run, source.entry(row.run).read_bytes())
    return replace(row, **target.keep(row.run))


def rank(row: Row) -> int:
    """Return how much a row is worth: one that is done the most, one that waits the least."""
    return RANK.get(row.outcome, 1)
