"""What the paper leaves open, measured: anchoring, heading, counts, cube side, neighbours, votes.

``spherefunc evaluate DATA --alternatives`` prints the table from which the default was chosen.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from spherefunc_bullet.batch.simulated import Simulated
from spherefunc_bullet.console import print_json, print_table
from spherefunc_bullet.learning.histogram import Counts, counted_cubes, quarter_turns
from spherefunc_bullet.learning.method import METHODS, Method

from .evaluation import FunctionQuality, evaluate
from .features import Distances, cube_distances
from .protocol import Protocol, Splits, labels_of

PAPER, DEFAULT = METHODS["paper"], METHODS["default"]


@dataclass(frozen=True, kw_only=True)
class Alternative:
    """One way to read settled spheres where the paper leaves it open."""

    method: Method = PAPER
    from_corner: bool = False  # the grid begins at the lowest sphere; else it is centred on the axis
    heading: Callable[[np.ndarray], np.ndarray] | None = None  # turns an object's spheres
    rooted: bool = False  # square roots: a cube with many spheres counts less beside many cubes with few
    limit: int | None = None  # of the spheres that settled first, as if each run had ended there

    def distances(self, simulated: Simulated, radii: Sequence[float]) -> Distances:
        """Return the distances between all objects' histograms at each radius."""
        return {
            radius: cube_distances([self.cubes(settled[radius], radius) for settled in simulated.settled])
            for radius in radii
        }

    def cubes(self, centers: np.ndarray, radius: float) -> Counts:
        """Return the cubes that hold spheres of an object (S, 3), metres, and how many."""
        centers = np.asarray(centers[: self.limit], dtype=np.float64).reshape(-1, 3)
        if self.heading is not None and len(centers):
            centers = self.heading(centers)
        corner = centers[:, :2].min(axis=0) if self.from_corner and len(centers) else None
        keys, counts = counted_cubes(centers, self.method.histogram(radius).side, corner)
        return keys, np.sqrt(counts) if self.rooted else counts


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
    if max(width, depth) > 1.25 * min(width, depth):
        across = depth > width
    else:
        across = abs(along_x) > abs(along_y)
    # Turned once counterclockwise, what rose along +x rises along +y.
    rise = along_x if across else along_y
    return quarter_turns(centers, (1 if across else 0) + (2 if rise < 0 else 0))


ALTERNATIVES = {
    "paper": Alternative(),
    "anchor: corner": Alternative(from_corner=True),
    "heading: long side along x": Alternative(heading=long_side_along_x),
    "heading: front to -y": Alternative(heading=front_first),
    "counts: square roots": Alternative(rooted=True),
    "cubes of 3 diameters": Alternative(method=replace(PAPER, diameters=3.0)),
    "cubes of 4 diameters": Alternative(method=replace(PAPER, diameters=4.0)),
    "1 neighbour of either side": Alternative(method=replace(PAPER, neighbors=(1,))),
    "3 neighbours of either side": Alternative(method=replace(PAPER, neighbors=(3,))),
    "radii vote (default)": Alternative(method=DEFAULT),
    "default, 1 neighbour": Alternative(method=replace(DEFAULT, neighbors=(1,))),
    "default, square roots": Alternative(method=DEFAULT, rooted=True),
    "default, front to -y": Alternative(method=DEFAULT, heading=front_first),
    "default, 2,000 spheres at most": Alternative(method=DEFAULT, limit=2000),
    "default, 1,000 spheres at most": Alternative(method=DEFAULT, limit=1000),
    "default, 250 spheres at most": Alternative(method=DEFAULT, limit=250),
}


def print_alternatives(simulated: Simulated, radii: Sequence[float], trials: int, seed: int, json: bool):
    """Print every alternative's F-measures on random halves and across sources, as given and turned at random."""
    labels, half = labels_of(simulated), len(simulated.objects) // 2
    groups = len(set(labels.groups.tolist())) > 1
    splits = Protocol(train_sizes=(half,), trials=trials, seed=seed, groups=groups).splits(labels)
    turned, halves = randomly_turned(simulated, seed), Splits(halves=splits.halves)
    rows: dict[str, dict[str, dict[str, float]]] = {}
    for name, alternative in ALTERNATIVES.items():
        as_given, as_turned = (
            evaluate(alternative.distances(objects, radii), labels, alternative.method, tested)
            for objects, tested in ((simulated, splits), (turned, halves))
        )
        rows[name] = {"random halves": f_measures(as_given.quality(half))}
        if groups:
            rows[name]["across sources"] = f_measures(as_given.left_out_quality("leave_one_group_out"))
        rows[name]["random halves, turned"] = f_measures(as_turned.quality(half))
    if json:
        print_json(rows)
        return
    protocols = list(next(iter(rows.values())))
    table = [[name, *(side_by_side(row[protocol]) for protocol in protocols)] for name, row in rows.items()]
    title = f"{simulated.name}: F-measure of {', '.join(labels.functions)}; turned: each by a random quarter turn"
    print_table(title, ["alternative", *protocols], table)


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
        replace(record, settled={r: quarter_turns(centers, turn) for r, centers in record.settled.items()})
        for record, turn in zip(simulated.records, turns, strict=True)
    ]
    return replace(simulated, records=tuple(records))
