"""What the paper leaves open, measured by section: limit, grid, heading, counts, cubes, neighbours, splits, votes.

``spherefunc evaluate DATA --alternatives`` prints the table from which the default was chosen. It reads runs that went
to the end (§III-A); where a method has a limit of settled spheres, their first ones, as if each run had ended there.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from spherefunc_bullet.batch.simulated import Simulated
from spherefunc_bullet.console import print_json, print_table, progress
from spherefunc_bullet.errors import InputError
from spherefunc_bullet.learning.histogram import Counts, counted_cubes, quarter_turns
from spherefunc_bullet.learning.method import CUBES, PAPER, Method
from spherefunc_bullet.settling.records import Dropping, ObjectRecord
from spherefunc_bullet.simulator import make_simulator, sphere_limit

from .evaluation import Evaluation, FunctionQuality, evaluate
from .features import Distances, cube_distances
from .protocol import Labels, Protocol, Splits, labels_of

EVERY = sys.maxsize  # neighbours: all training objects


@dataclass(frozen=True, kw_only=True)
class Reading:
    """One way to read settled spheres as a histogram where the paper leaves it open."""

    diameters: float = PAPER.diameters  # side of a cube
    grid: str = "axis"  # its middle cube is centred there; or it begins at the "object" 's corner, or "spheres"
    heading: Callable[[np.ndarray], np.ndarray] | None = None  # turns an object's spheres
    rooted: bool = False  # square roots: a cube with many spheres counts less beside many cubes with few
    limit: int | None = None  # of the spheres that settled first, as if each run had ended there

    def distances(self, simulated: Simulated, radii: Sequence[float]) -> Distances:
        """Return the distances between all objects' histograms at each radius."""
        return {
            radius: cube_distances([self.cubes(record, radius) for record in simulated.records]) for radius in radii
        }

    def cubes(self, record: ObjectRecord, radius: float) -> Counts:
        """Return the cubes that hold an object's spheres of a radius in metres, and how many."""
        centers = np.asarray(record.centers(radius)[: self.limit], dtype=np.float64).reshape(-1, 3)
        if self.heading is not None and len(centers):
            centers = self.heading(centers)
        keys, counts = counted_cubes(centers, self.diameters * 2 * radius, self.corner(record, centers))
        return keys, np.sqrt(counts) if self.rooted else counts

    def corner(self, record: ObjectRecord, centers: np.ndarray) -> np.ndarray | None:
        """Return where the grid begins, x and y (2,) in metres; None: see `cube_keys`."""
        if self.grid == "object":
            return -record.size[:2] / 2
        return centers[:, :2].min(axis=0) if self.grid == "spheres" and len(centers) else None


AS_GIVEN = Reading()


@dataclass(frozen=True, kw_only=True)
class Alternative:
    """One way to read settled spheres and to score what was read."""

    reading: Reading = AS_GIVEN
    method: Method = PAPER

    def read(self, limit: int) -> Reading:
        """Return how spheres are read, of a method with a limit no more than that."""
        if self.method.to_the_end or self.reading.limit is not None:
            return self.reading
        return replace(self.reading, limit=limit)


@dataclass(frozen=True, eq=False)
class Read:
    """A data set that is read in several ways, each once, under one protocol."""

    simulated: Simulated
    labels: Labels
    radii: Sequence[float]  # metres
    splits: Splits
    limit: int  # settled spheres, of methods that do not read runs to the end
    known: dict[Reading, Distances] = field(default_factory=dict)

    def evaluation(self, alternative: Alternative) -> Evaluation:
        """Return what an alternative says of the objects."""
        how = alternative.read(self.limit)
        if how not in self.known:
            self.known[how] = how.distances(self.simulated, self.radii)
        return evaluate(self.known[how], self.labels, alternative.method, self.splits)


def long_side_along_x(centers: np.ndarray) -> np.ndarray:
    """Return settled centres (S, 3) turned so that the longer side of their footprint lies along x."""
    width, depth = np.ptp(centers[:, :2], axis=0)
    return quarter_turns(centers, 1) if depth > width else centers


def front_first(centers: np.ndarray) -> np.ndarray:
    """Return settled centres (S, 3) turned so that the higher ones, against a back, lie to +y: seats face one way.

    Where one side is a quarter longer, it lies along x.
    """
    width, depth = np.ptp(centers[:, :2], axis=0)
    # How height goes along with x and y: towards the back it rises.
    along_x, along_y = (centers[:, 2] - centers[:, 2].mean()) @ centers[:, :2]
    oblong = max(width, depth) > 1.25 * min(width, depth)
    across = depth > width if oblong else abs(along_x) > abs(along_y)
    # Turned once counterclockwise, what rose along +x rises along +y.
    rise = along_x if across else along_y
    return quarter_turns(centers, (1 if across else 0) + (2 if rise < 0 else 0))


def reading(**changes: Any) -> Alternative:
    """Return the paper's method on spheres that are read in another way."""
    return Alternative(reading=Reading(**changes))


def paper(**changes: Any) -> Alternative:
    """Return the paper's method with other choices between histograms and scores."""
    return Alternative(method=replace(PAPER, **changes))


def cubes(how: Reading = AS_GIVEN, **changes: Any) -> Alternative:
    """Return the default method with other choices, on spheres that are read in another way."""
    return Alternative(reading=how, method=replace(CUBES, **changes))


# What the paper leaves open of the drops themselves, as options of the backend ``fast``.
DROPPED = {
    "§III-A: columns over points": {"columns": "points"},
    "§III-A: the whole sphere inside the box": {"inside": "sphere"},
    "§III-A: no stall rule": {"stalled_steps": 0},
}
ALTERNATIVES = {
    "paper": Alternative(),
    "§III-A: 20,000 spheres at most": reading(limit=20_000),
    "§III-A: 1,000 spheres at most": reading(limit=1000),
    "§III-B: grid from the object's corner": reading(grid="object"),
    "§III-B: grid from the lowest spheres": reading(grid="spheres"),
    "§III-B: long side along x": reading(heading=long_side_along_x),
    "§III-B: front to -y": reading(heading=front_first),
    "§III-B: square roots of counts": reading(rooted=True),
    **{f"§III-B: side of cubes / diameter = {d}": reading(diameters=float(d)) for d in (1, 2, 3, 4, 5, 7, 14)},
    "§III-C: all examples": paper(neighbors=(EVERY,)),
    "§III-C: the nearest of all": paper(neighbors=(1,)),
    "§III-C: nearest 5 of all": paper(neighbors=(5,)),
    "§III-C: 1 and 3 of either side": paper(neighbors=(1, 3), of_all=False),
    "§III-C: 1 of either side": paper(neighbors=(1,), of_all=False),
    "§III-C: 3 of either side": paper(neighbors=(3,), of_all=False),
    "§III-C: 20 splits choose the radius": paper(splits=20),
    "§III-C: of equal radii the smallest": paper(tied="smallest"),
    "§III-C: radii vote": paper(splits=20, vote=True),
    "cubes": cubes(),
    "cubes, best radius alone": cubes(vote=False),
    "cubes, to the end": cubes(to_the_end=True),
    "cubes, 1 neighbour": cubes(neighbors=(1,)),
    "cubes, square roots": cubes(Reading(rooted=True)),
    "cubes, front to -y": cubes(Reading(heading=front_first)),
    "cubes, 2,000 spheres at most": cubes(Reading(limit=2000)),
    "cubes, 1,000 spheres at most": cubes(Reading(limit=1000)),
    "cubes, 250 spheres at most": cubes(Reading(limit=250)),
}


def wanted_alternatives(only: str) -> list[str]:
    """Return the names of the alternatives that hold one of some words, all of them where there are no words.

    Raises
    ------
    InputError
        If there is none.
    """
    names = [*DROPPED, *ALTERNATIVES]
    found = [name for name in names if any(part.strip() in name for part in only.split(","))]
    if not found:
        raise InputError(f"--only {only}: expected words of the table's rows, such as {names[3]!r} or 'III-B'")
    return found


def dropped_otherwise(
    dropping: Dropping, simulated: Callable[[Dropping], Simulated], names: Sequence[str]
) -> dict[str, Simulated]:
    """Return a data set with spheres dropped in every other way that the backend has, of those wanted."""
    simulator = dropping.simulator
    if simulator.name != "fast":
        return {}
    options = simulator.options()
    asked = {name: changes for name, changes in DROPPED.items() if name in names}
    hows = {name: make_simulator(simulator.name, **options | changes) for name, changes in asked.items()}
    return {name: simulated(replace(dropping, simulator=how)) for name, how in hows.items()}


def print_alternatives(
    simulated: Simulated,
    dropping: Dropping,
    drop: Callable[[Dropping], Simulated],
    trials: int,
    json: bool,
    names: Sequence[str],
):
    """Print every alternative's F-measures on random halves and across sources, as given and turned at random.

    Parameters
    ----------
    dropping : Dropping
        How spheres fell; its seed is that of the splits and turns too.
    drop : callable
        Returns the same objects with spheres dropped in another way, which the paper's method reads.
    names : sequence of str
        Of the alternatives that are asked for.
    """
    labels, dropped = labels_of(simulated), dropped_otherwise(dropping, drop, names)
    half, groups = len(labels) // 2, len(set(labels.groups.tolist())) > 1
    splits = Protocol(train_sizes=(half,), trials=trials, seed=dropping.seed, groups=groups).splits(labels)
    radii, limit = dropping.radii, sphere_limit(dropping.simulator)
    rows: dict[str, dict[str, dict[str, float]]] = {}

    def reads(dropped: Simulated) -> tuple[Read, Read]:
        """Return objects as given, and turned at random."""
        turned = Read(randomly_turned(dropped, dropping.seed), labels, radii, Splits(halves=splits.halves), limit)
        return Read(dropped, labels, radii, splits, limit), turned

    as_dropped = reads(simulated)
    work = [(name, as_dropped, alternative) for name, alternative in ALTERNATIVES.items() if name in names]
    work[1:1] = [(name, reads(other), Alternative()) for name, other in dropped.items()]
    for name, both, alternative in progress(work, len(work), "learning and testing"):
        as_given, as_turned = (read.evaluation(alternative) for read in both)
        rows[name] = {"random halves": f_measures(as_given.quality(half))}
        if groups:
            rows[name]["across sources"] = f_measures(as_given.left_out_quality("leave_one_group_out"))
        rows[name]["random halves, turned"] = f_measures(as_turned.quality(half))
    title = f"{simulated.name}: F-measure of {', '.join(labels.functions)}; turned: each by a random quarter turn"
    print_beside("alternative", rows, title, json)


def print_beside(what: str, rows: Mapping[str, Mapping[str, dict[str, float] | float]], title: str, json: bool):
    """Print a row for each way, its F-measures of all functions or another figure in each column; or all as JSON."""
    if json:
        print_json(rows)
        return
    columns = list(next(iter(rows.values())))
    table = [[name, *map(cell, row.values())] for name, row in rows.items()]
    print_table(title, [what, *columns], table)


def cell(value: dict[str, float] | float) -> str:
    """Return one cell of a table."""
    return side_by_side(value) if isinstance(value, dict) else f"{value:.4f}"


def side_by_side(f_measures: Mapping[str, float]) -> str:
    """Return F-measures side by side."""
    return "  ".join(f"{f_measure:.3f}" for f_measure in f_measures.values())


def f_measures(qualities: Mapping[str, FunctionQuality]) -> dict[str, float]:
    """Return each function's F-measure alone."""
    return {name: row["f_measure"] for name, row in qualities.items()}


def randomly_turned(simulated: Simulated, seed: int) -> Simulated:
    """Return the data set with each object's settled spheres turned by a random multiple of 90 degrees."""
    turns = np.random.default_rng(seed).integers(4, size=len(simulated.records))
    records = [
        replace(
            record,
            settled={
                radius: replace(drops, rests=quarter_turns(drops.rests, turn))
                for radius, drops in record.settled.items()
            },
            size=record.size[[1, 0, 2]] if turn % 2 else record.size,
        )
        for record, turn in zip(simulated.records, turns, strict=True)
    ]
    return replace(simulated, records=tuple(records))
