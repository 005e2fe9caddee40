"""What the paper leaves open, measured: anchoring, heading, counts, cube side, neighbours, votes.

``spherefunc evaluate DATA --alternatives`` prints the table from which the default was chosen.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from spherefunc_bullet.batch.simulated import Simulated
from spherefunc_bullet.console import print_json, print_table
from spherefunc_bullet.learning.heading import quarter_turns
from spherefunc_bullet.learning.method import METHODS, Method

from .evaluation import FunctionQuality, evaluate
from .features import sphere_distances
from .protocol import Protocol, Splits, labels_of

PAPER = METHODS["paper"]
LIMITS = (2000, 1000, 250)  # settled spheres at which a run might end
ALTERNATIVES: dict[str, Method] = {
    "paper": PAPER,
    "anchor: corner": replace(PAPER, anchor="corner"),
    "heading: long side along x": replace(PAPER, heading="long_side"),
    "heading: front to -y": replace(PAPER, heading="front"),
    "counts: square roots": replace(PAPER, counts="sqrt"),
    "cubes of 3 diameters": replace(PAPER, diameters=3.0),
    "cubes of 4 diameters": replace(PAPER, diameters=4.0),
    "1 neighbour of either side": replace(PAPER, neighbors=(1,)),
    "3 neighbours of either side": replace(PAPER, neighbors=(3,)),
    "radii vote (default)": METHODS["default"],
    "default, 1 neighbour": replace(METHODS["default"], neighbors=(1,)),
    "default, square roots": replace(METHODS["default"], counts="sqrt"),
    "default, front to -y": replace(METHODS["default"], heading="front"),
}


def print_alternatives(simulated: Simulated, radii: Sequence[float], trials: int, seed: int, json: bool):
    """Print every alternative's F-measures on random halves and across sources, as given and turned at random."""
    labels, half = labels_of(simulated), len(simulated.objects) // 2
    groups = len(set(labels.groups.tolist())) > 1
    splits = Protocol(train_sizes=(half,), trials=trials, seed=seed, groups=groups).splits(labels)
    turned, halves = randomly_turned(simulated, seed), Splits(halves=splits.halves)
    every = {name: (method, None) for name, method in ALTERNATIVES.items()}
    every |= {f"default, {limit:,} spheres at most": (METHODS["default"], limit) for limit in LIMITS}
    rows: dict[str, dict[str, dict[str, float]]] = {}
    for name, (method, limit) in every.items():
        as_given, as_turned = (
            evaluate(sphere_distances(first_spheres(objects, limit), radii, method), labels, method, tested)
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


def first_spheres(simulated: Simulated, limit: int | None) -> Simulated:
    """Return the data set with the spheres that settled first alone, as if each run had ended there."""
    records = [
        replace(record, settled={r: centers[:limit] for r, centers in record.settled.items()})
        for record in simulated.records
    ]
    return replace(simulated, records=tuple(records))


def randomly_turned(simulated: Simulated, seed: int) -> Simulated:
    """Return the data set with each object's settled spheres turned by a random multiple of 90 degrees."""
    turns = np.random.default_rng(seed).integers(4, size=len(simulated.records))
    records = [
        replace(record, settled={r: quarter_turns(centers, turn) for r, centers in record.settled.items()})
        for record, turn in zip(simulated.records, turns, strict=True)
    ]
    return replace(simulated, records=tuple(records))
