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

from .evaluation import Evaluation, FunctionQuality, evaluate
from .features import sphere_distances
from .protocol import Protocol, labels_of

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
    halves = Protocol(train_sizes=(len(labels) // 2,), trials=trials, seed=seed)
    straight = replace(halves, groups=len(set(labels.groups.tolist())) > 1)
    turned = randomly_turned(simulated, seed)
    every = {name: (method, None) for name, method in ALTERNATIVES.items()}
    every |= {f"default, {limit:,} spheres at most": (METHODS["default"], limit) for limit in LIMITS}
    rows: dict[str, dict[str, dict[str, float]]] = {}
    for name, (method, limit) in every.items():

        def measured(objects: Simulated, protocol: Protocol, method=method, limit=limit) -> Evaluation:
            """Return the evaluation of objects by this alternative."""
            return evaluate(sphere_distances(first_spheres(objects, limit), radii, method), labels, method, protocol)

        given = measured(simulated, straight)
        rows[name] = {"random halves": f_measures(given.quality(len(labels) // 2))}
        if straight.groups:
            rows[name]["across sources"] = f_measures(given.left_out_quality("leave_one_group_out"))
        rows[name]["random halves, turned"] = f_measures(measured(turned, halves).quality(len(labels) // 2))
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
