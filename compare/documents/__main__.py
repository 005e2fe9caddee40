"""``make tables``: measure again what is older than its code, and write the tables of README and docs.

    python -m spherefunc_bullet.compare.documents [NAME ...] [--check | --all | --keep WHY]

A NAME is that of a measurement, a table or a document; by default all are chosen. Tables that are kept although they
are older than their code are measured again only if they are named, or with ``--all``.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Annotated

import typer

from spherefunc_bullet.console import fail, run, say
from spherefunc_bullet.errors import InputError

from . import evaluations, measurements
from .tables import DocumentTable, Lines, Measurement, complaints, read_blocks, with_blocks

RESULTS, PAPER_PAGE, IMPAIRED = (f"docs/{name}.md" for name in ("results", "paper", "impaired"))
BOTH = tuple(measurements.ON_MODELS.values())
PAPER = (measurements.PAPER_ON_HOUSEHOLD, measurements.PAPER_ON_MODELS)
ON_MODELS, CUBES = measurements.ON_MODELS["fast"], measurements.CUBES_ON_MODELS
LEARNT = (measurements.ON_MODELS, measurements.FROM_HOUSEHOLD, measurements.FROM_SIX)
OVERVIEW = tuple(learnt[backend] for backend in measurements.BACKENDS for learnt in LEARNT)
HALVES, ONE_LEFT_OUT, SOURCES = (
    evaluations.by_feature(protocol) for protocol in ("random_splits", "leave_one_out", "leave_one_group_out")
)


def table(document: str, name: str, render: Callable[..., Lines], *measured: Measurement) -> DocumentTable:
    """Return a table of a document, made from the results of some measurements."""
    return DocumentTable(name=name, document=document, measurements=measured, render=render)


TABLES = (
    table(RESULTS, "functions", evaluations.overview, *OVERVIEW, CUBES, measurements.CUBES_FROM_HOUSEHOLD),
    table(RESULTS, "unseen-kinds", evaluations.unseen_kinds, ON_MODELS),
    table(IMPAIRED, "copies-means", evaluations.means, *BOTH),
    table(IMPAIRED, "copies-kinds", evaluations.kinds, *BOTH),
    table(PAPER_PAGE, "fig-3", evaluations.fig_3, *PAPER),
    table(PAPER_PAGE, "fig-4", evaluations.fig_4, *PAPER),
    table(PAPER_PAGE, "memberships", evaluations.memberships, *PAPER),
    table(RESULTS, "few-examples", evaluations.by_size, *BOTH, CUBES),
    table(RESULTS, "default-halves", HALVES, ON_MODELS),
    table(RESULTS, "default-sources", SOURCES, ON_MODELS),
    table(RESULTS, "default-six", evaluations.six_catalogues, *measurements.FROM_SIX.values()),
    table(RESULTS, "cubes-and-paper", evaluations.cubes_and_paper, measurements.PAPER_ON_MODELS, CUBES),
    table(RESULTS, "cubes-halves", HALVES, CUBES),
    table(RESULTS, "cubes-one-out", ONE_LEFT_OUT, CUBES),
    *measurements.SHOWN,
)


def main(
    names: Annotated[
        list[str] | None, typer.Argument(metavar="[NAME...]", help="Measurements, tables, documents.")
    ] = None,
    check: Annotated[bool, typer.Option("--check", help="Only print which results are older than their code.")] = False,
    every: Annotated[bool, typer.Option("--all", help="Also measure results again that are up to date.")] = False,
    write: Annotated[bool, typer.Option("--write", help="Only write tables from saved results.")] = False,
    keep: Annotated[str | None, typer.Option(help="Keep tables that are older than their code, and print why.")] = None,
    root: Annotated[Path, typer.Option(help="The repository.")] = Path(),
):
    """Keep the tables of README and docs up to date with the code that they measure."""
    tables, meant = wanted(names or ())
    for table in tables if keep is not None else ():
        table.keep(root, keep)
    if not check and not write and keep is None:
        measure(root, meant if every else due(root, tables if not names else (), meant))
    if not check:
        write_tables(root, tables)
    lines = complaints(root, TABLES)
    for line in lines:
        say(line)
    raise typer.Exit(2 if lines else 0)


def wanted(names: Sequence[str]) -> tuple[list[DocumentTable], list[Measurement]]:
    """Return the tables and the measurements of some names; without a name, all.

    Raises
    ------
    InputError
        If no measurement, table or document has such a name.
    """
    known = {name for table in TABLES for name in names_of(table)}
    if unknown := sorted(set(names) - known):
        raise InputError(f"{unknown[0]}: expected one of {', '.join(sorted(known))}")
    tables = [table for table in TABLES if not names or names_of(table) & set(names)]
    by_name = {measurement.name: measurement for table in tables for measurement in table.measurements}
    only = [measurement for name, measurement in by_name.items() if name in names]
    return tables, only or list(by_name.values())


def due(root: Path, unnamed: Iterable[DocumentTable], meant: Iterable[Measurement]) -> list[Measurement]:
    """Return the measurements that are older than their code, except those of unnamed tables that are all kept."""
    kept: dict[str, bool] = {}
    for table in unnamed:
        for measurement in table.measurements:
            kept[measurement.name] = kept.get(measurement.name, True) and table.kept(root).is_file()
    return [measurement for measurement in meant if not kept.get(measurement.name) and measurement.changed(root)]


def names_of(table: DocumentTable) -> set[str]:
    """Return the names by which a table can be chosen: its own, its document's, those of its measurements."""
    return {table.name, table.document, *(measurement.name for measurement in table.measurements)}


def measure(root: Path, measurements: Sequence[Measurement]):
    """Run the commands of measurements, one after another; errors are printed, and the next one runs."""
    for number, measurement in enumerate(measurements, 1):
        before = ""
        if measurement.path(root).is_file():
            before = f", {measurement.saved(root)['seconds']:.0f} s the last time"
        say(f"{number} of {len(measurements)}{before}: {measurement.command}")
        try:
            measurement.measure(root)
        except InputError as error:
            fail(error)


def write_tables(root: Path, tables: Iterable[DocumentTable]):
    """Write the blocks of the tables with results into their documents."""
    texts: dict[str, dict[str, str]] = {}
    for table in tables:
        if table.is_measured(root):
            table.kept(root).unlink(missing_ok=True)
        try:
            texts.setdefault(table.document, {})[table.name] = table.text(root)
        except InputError as error:
            fail(error)
    for document, blocks in texts.items():
        read_blocks(root, document)
        path = root / document
        path.write_text(with_blocks(path.read_text(encoding="utf-8"), blocks), encoding="utf-8")


if __name__ == "__main__":
    run(lambda: typer.run(main))
