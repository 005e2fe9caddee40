"""Every measured table of README and docs."""

from __future__ import annotations

from . import choices, copies, labels, measurements, paper_figures, programs
from .tables import Table

RESULTS, METHOD, IMPAIRED = "docs/results.md", "docs/method.md", "docs/impaired.md"
BOTH = tuple(measurements.ON_MODELS.values())
PAPER = (measurements.PAPER_ON_HOUSEHOLD, measurements.PAPER_ON_MODELS)
ON_MODELS, CUBES = measurements.ON_MODELS["fast"], measurements.CUBES_ON_MODELS["fast"]

OVERVIEW = (
    Table(
        name="functions",
        document=RESULTS,
        measurements=(
            *(
                way[backend]
                for backend in measurements.BACKENDS
                for way in (measurements.ON_MODELS, measurements.FROM_HOUSEHOLD, measurements.FROM_SIX)
            ),
            CUBES,
            measurements.CUBES_FROM_HOUSEHOLD,
        ),
        render=labels.overview,
    ),
    Table(name="copies", document=RESULTS, measurements=BOTH, render=copies.means),
    Table(name="unseen-kinds", document=RESULTS, measurements=(ON_MODELS,), render=copies.unseen_kinds),
    Table(name="copies-means", document=IMPAIRED, measurements=BOTH, render=copies.means),
    Table(name="copies-kinds", document=IMPAIRED, measurements=BOTH, render=copies.kinds),
)
AS_PUBLISHED = (
    Table(name="fig-3", document=METHOD, measurements=PAPER, render=paper_figures.fig_3),
    Table(name="fig-4", document=METHOD, measurements=PAPER, render=paper_figures.fig_4),
    Table(name="memberships", document=METHOD, measurements=PAPER, render=paper_figures.memberships),
    Table(
        name="alternatives",
        document=METHOD,
        measurements=(measurements.ALTERNATIVES_ON_HOUSEHOLD, measurements.ALTERNATIVES_ON_MODELS),
        render=choices.alternatives,
    ),
    Table(
        name="limits",
        document=METHOD,
        measurements=(measurements.LIMITS_ON_HOUSEHOLD, measurements.LIMITS_ON_MODELS),
        render=choices.limits,
    ),
    Table(
        name="one-radius",
        document=METHOD,
        measurements=measurements.ONE_RADIUS,
        render=choices.one_radius,
        commands="`spherefunc evaluate DATA --method paper --radii RADIUS --train-sizes half`",
    ),
)
PROFILE = (
    Table(name="drops", document=METHOD, measurements=(measurements.PROFILES,), render=choices.by_drops),
    Table(name="budget", document=METHOD, measurements=(measurements.BUDGET,), render=choices.budget),
    Table(name="stopping", document=METHOD, measurements=(measurements.STOPPING,), render=choices.stopping),
    Table(name="seeds", document=METHOD, measurements=tuple(measurements.SEEDS.values()), render=choices.over_seeds),
    Table(name="together", document=METHOD, measurements=(measurements.PROFILES,), render=choices.across_sources),
    Table(name="reliability", document=METHOD, measurements=(measurements.PROFILES,), render=choices.reliability),
    Table(name="few-examples", document=METHOD, measurements=(*BOTH, CUBES), render=choices.by_size),
)
HALVES, ONE_LEFT_OUT, SOURCES = (
    labels.by_feature(protocol) for protocol in ("random_splits", "leave_one_out", "leave_one_group_out")
)
TRANSFER = labels.by_feature("test", title="learnt on `household`, tested on the real models")
ON_REAL_MODELS = (
    Table(name="default-halves", document=METHOD, measurements=(ON_MODELS,), render=HALVES),
    Table(name="default-sources", document=METHOD, measurements=(ON_MODELS,), render=SOURCES),
    Table(
        name="default-bullet",
        document=METHOD,
        measurements=(measurements.ON_MODELS["bullet"], measurements.FROM_HOUSEHOLD["bullet"]),
        render=choices.of_bullet,
    ),
    Table(
        name="default-household",
        document=METHOD,
        measurements=(measurements.FROM_HOUSEHOLD["fast"],),
        render=TRANSFER,
    ),
    Table(
        name="default-six",
        document=METHOD,
        measurements=tuple(measurements.FROM_SIX.values()),
        render=labels.six_catalogues,
    ),
    Table(
        name="cubes-and-paper",
        document=METHOD,
        measurements=(measurements.PAPER_ON_MODELS, CUBES),
        render=choices.cubes_and_paper,
    ),
    Table(name="cubes-halves", document=METHOD, measurements=(CUBES,), render=HALVES),
    Table(name="cubes-one-out", document=METHOD, measurements=(CUBES,), render=ONE_LEFT_OUT),
    Table(name="cubes-sources", document=METHOD, measurements=(CUBES,), render=SOURCES),
    Table(name="cubes-household", document=METHOD, measurements=(measurements.CUBES_FROM_HOUSEHOLD,), render=TRANSFER),
    Table(name="household-halves", document=METHOD, measurements=(measurements.CUBES_ON_HOUSEHOLD,), render=HALVES),
    Table(
        name="household-one-out",
        document=METHOD,
        measurements=(measurements.CUBES_ON_HOUSEHOLD,),
        render=ONE_LEFT_OUT,
    ),
)

BY_BULLET = (
    Table(
        name="cubes-by-both",
        document=programs.BULLET,
        measurements=tuple(measurements.CUBES_ON_MODELS.values()),
        render=choices.both_by_cubes,
    ),
)

TABLES = (*OVERVIEW, *AS_PUBLISHED, *PROFILE, *ON_REAL_MODELS, *BY_BULLET, *programs.TABLES)
