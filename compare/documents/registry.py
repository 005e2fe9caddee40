"""Every measured table of README and docs."""

from __future__ import annotations

from collections.abc import Callable

from . import choices, measurements, paper_figures, programs
from .saved import Measurement
from .tables import Lines, Table

RESULTS, PAPER_PAGE, IMPAIRED = (f"docs/{name}.md" for name in ("results", "paper", "impaired"))
BOTH = tuple(measurements.ON_MODELS.values())
PAPER = (measurements.PAPER_ON_HOUSEHOLD, measurements.PAPER_ON_MODELS)
ON_MODELS, CUBES = measurements.ON_MODELS["fast"], measurements.CUBES_ON_MODELS
LEARNT = (measurements.ON_MODELS, measurements.FROM_HOUSEHOLD, measurements.FROM_SIX)
OVERVIEW = tuple(learnt[backend] for backend in measurements.BACKENDS for learnt in LEARNT)
HALVES, ONE_LEFT_OUT, SOURCES = (
    paper_figures.by_feature(protocol) for protocol in ("random_splits", "leave_one_out", "leave_one_group_out")
)
TRANSFER = paper_figures.by_feature("test", title="learnt on `household`, tested on the real models")


def table(document: str, name: str, render: Callable[..., Lines], *measured: Measurement) -> Table:
    """Return a table of a document, made from the results of some measurements."""
    return Table(name=name, document=document, measurements=measured, render=render)


TABLES = (
    table(RESULTS, "functions", paper_figures.overview, *OVERVIEW, CUBES, measurements.CUBES_FROM_HOUSEHOLD),
    table(RESULTS, "unseen-kinds", choices.unseen_kinds, ON_MODELS),
    table(IMPAIRED, "copies-means", choices.means, *BOTH),
    table(IMPAIRED, "copies-kinds", choices.kinds, *BOTH),
    table(PAPER_PAGE, "fig-3", paper_figures.fig_3, *PAPER),
    table(PAPER_PAGE, "fig-4", paper_figures.fig_4, *PAPER),
    table(PAPER_PAGE, "memberships", paper_figures.memberships, *PAPER),
    table(RESULTS, "few-examples", choices.by_size, *BOTH, CUBES),
    table(RESULTS, "default-halves", HALVES, ON_MODELS),
    table(RESULTS, "default-sources", SOURCES, ON_MODELS),
    table(RESULTS, "default-household", TRANSFER, measurements.FROM_HOUSEHOLD["fast"]),
    table(RESULTS, "default-six", paper_figures.six_catalogues, *measurements.FROM_SIX.values()),
    table(RESULTS, "cubes-and-paper", choices.cubes_and_paper, measurements.PAPER_ON_MODELS, CUBES),
    table(RESULTS, "cubes-halves", HALVES, CUBES),
    table(RESULTS, "cubes-one-out", ONE_LEFT_OUT, CUBES),
    table(RESULTS, "cubes-sources", SOURCES, CUBES),
    table(RESULTS, "cubes-household", TRANSFER, measurements.CUBES_FROM_HOUSEHOLD),
    table(RESULTS, "household-halves", HALVES, measurements.CUBES_ON_HOUSEHOLD),
    table(RESULTS, "household-one-out", ONE_LEFT_OUT, measurements.CUBES_ON_HOUSEHOLD),
    *programs.TABLES,
)
