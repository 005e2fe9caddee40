"""What the paper leaves open, measured: anchoring, heading, counts, cube side, neighbours, votes.

``spherefunc evaluate DATA --alternatives`` prints the table from which the default was chosen.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from spherefunc_bullet.batch.simulated import Simulated
from spherefunc_bullet.console import print_json, print_table
from spherefunc_bullet.learning.heading import quarter_turns
from spherefunc_bullet.learning.method import METHODS, Method

from .evaluation import labels_of, sphere_distances
from .protocol import leave_one_group_out, pooled_measured, random_splits, trials_measured

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
    labels = labels_of(simulated)
    half = random_splits(len(labels.members), len(labels.members) // 2, trials, seed)
    sources = leave_one_group_out(labels.groups) if len(set(labels.groups.tolist())) > 1 else []
    turned = randomly_turned(simulated, seed)
    every = {name: (method, None) for name, method in ALTERNATIVES.items()}
    every |= {f"default, {limit:,} spheres at most": (METHODS["default"], limit) for limit in LIMITS}
    rows = {}
    for name, (method, limit) in every.items():
        distances = sphere_distances(first_spheres(simulated, limit), radii, method)
        rows[name] = {"random halves": f_measures(trials_measured(distances, labels, half, method))}
        if sources:
            rows[name]["across sources"] = f_measures(pooled_measured(distances, labels, sources, method))
        distances = sphere_distances(first_spheres(turned, limit), radii, method)
        rows[name]["random halves, turned"] = f_measures(trials_measured(distances, labels, half, method))
    if json:
        print_json(rows)
        return
    protocols = list(next(iter(rows.values())))
    table = [[name, *(spaced(row[each]) for each in protocols)] for name, row in rows.items()]
    title = f"{simulated.name}: F-measure of {', '.join(labels.functions)}; turned: each by a random quarter turn"
    print_table(title, ["alternative", *protocols], table)


def spaced(f_measures: dict[str, float]) -> str:
    """Return F-measures side by side."""
    return "  ".join(f"{each:.3f}" for each in f_measures.values())


def f_measures(measured: dict) -> dict[str, float]:
    """Return each function's F-measure alone."""
    return {name: row["f_measure"] for name, row in measured.items()}


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
