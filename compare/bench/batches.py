"""What a batch's run cost, and what larger collections would.

    python -m spherefunc_bullet.compare.bench cost_model --run DIR

Read from a finished run's ledger.
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Annotated, NamedTuple

import typer

from spherefunc_bullet.batch.folder import RunFolder
from spherefunc_bullet.batch.ledger import Ledger
from spherefunc_bullet.console import print_table
from spherefunc_bullet.formats.units import format_duration, format_length, format_memory

COLLECTIONS = {"ShapeNet": 51_300, "Objaverse": 800_000, "ten million": 10_000_000}
CORES = (1, 64, 4096)


class Cost(NamedTuple):
    """What one radius of one backend cost in a run, an object on average."""

    backend: str
    radius: float  # metres
    objects: int
    seconds: float  # of simulation
    bytes: float  # of the file of the centres
    drops: float


def costs(ledger: Ledger) -> list[Cost]:
    """Return the mean costs by backend and radius, of the runs that were done."""
    sql = """SELECT backend, radius, count(*), avg(seconds), avg(bytes), avg(drops)
        FROM runs JOIN ways USING (way) WHERE outcome = 'done' GROUP BY backend, radius ORDER BY backend, radius"""
    return [Cost(*row) for row in ledger.query(sql)]


def bytes_per_row(ledger: Ledger) -> float:
    """Return what a row takes in the ledger, its index included."""
    ((rows,),) = ledger.query("SELECT count(*) FROM runs")
    ((pages, size),) = ledger.query("SELECT page_count, page_size FROM pragma_page_count, pragma_page_size")
    return pages * size / max(rows, 1)


def cost_rows(measured: Iterable[Cost]) -> list[list[str]]:
    """Return the table of measured costs."""
    return [
        [cost.backend, format_length(cost.radius), str(cost.objects), f"{cost.seconds:.3f}", f"{cost.drops:,.0f}"]
        + [format_memory(cost.bytes)]
        for cost in measured
    ]


def extrapolated(measured: list[Cost], overhead: float, row_bytes: float) -> list[list[str]]:
    """Return the table of larger collections, by backend, all radii of the run together.

    Parameters
    ----------
    overhead : float
        Seconds an object takes beside its simulations: reading, sampling, hashing.
    """
    rows = []
    for backend in dict.fromkeys(cost.backend for cost in measured):
        own = [cost for cost in measured if cost.backend == backend]
        seconds, size = sum(cost.seconds for cost in own) + overhead, sum(cost.bytes for cost in own)
        for name, count in COLLECTIONS.items():
            times = [format_duration(count * seconds / cores) for cores in CORES]
            files, ledger = format_memory(count * size), format_memory(count * len(own) * row_bytes)
            rows.append([f"{backend}, {name}", f"{count:,}", *times, files, f"{count * len(own):,}", ledger])
    return rows


def print_cost_model(
    run: Annotated[list[Path], typer.Option(metavar="DIR", help="A finished run; may be repeated.")],
    overhead: Annotated[float, typer.Option(help="Seconds an object takes beside its simulations.")] = 0.0,
):
    """Print the cost model of one run or several."""
    measured, sizes = [], []
    for folder in run:
        with RunFolder(folder).ledger() as ledger:
            measured += costs(ledger)
            sizes.append(bytes_per_row(ledger))
    columns = ["backend", "radius", "objects", "s/object", "drops", "file"]
    print_table("Measured, the mean of an object", columns, cost_rows(measured))
    cores = [f"{count:,} core{'s' * (count > 1)}" for count in CORES]
    columns = ["collection", "objects", *cores, "centres", "files", "ledger"]
    larger = extrapolated(measured, overhead, max(sizes))
    print_table(f"\nExtrapolated, {max(sizes):.0f} bytes a ledger row", columns, larger)
