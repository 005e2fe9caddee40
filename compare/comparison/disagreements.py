"""The objects on which simulators disagree, to be looked at side by side."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Any

from spherefunc_bullet.clouds.cloud import Cloud, load_cloud
from spherefunc_bullet.errors import InputError
from spherefunc_bullet.formats.units import format_length
from spherefunc_bullet.learning.validation import THRESHOLD
from spherefunc_bullet.settling.cached_runs import LoadOptions
from spherefunc_bullet.viewer.data import Layer, Panel, display, histogram_cubes
from spherefunc_bullet.viewer.pictures import fitting_radius

from .entries import ComparedRun, Comparison
from .significance import Report

MOST = 6  # objects, so that the page stays small
MAX_SPHERES = 4000  # of one run that are drawn: the first to settle
Display = dict[str, Any]  # for the viewer, see `viewer.data.display`
SPHERES_ACROSS = 24  # radii along the longest side, about, of the spheres shown at first


@dataclass(frozen=True, kw_only=True)
class Disagreement:
    """One object on which at least two simulators disagree, or nearly so."""

    row: int  # of the report's objects
    function: str  # the one with the largest difference of scores
    difference: float  # of the scores
    labels_differ: bool


def disagreements(per_object: Sequence[Report]) -> list[Disagreement]:
    """Return where simulators differ about an object, those with different labels first, then by scores."""
    greatest = [greatest_difference(row, item) for row, item in enumerate(per_object) if len(item["backends"]) > 1]
    return sorted(greatest, key=lambda case: (not case.labels_differ, -case.difference, case.row))


def greatest_difference(row: int, item: Report) -> Disagreement:
    """Return one object's greatest difference, one with different labels before one without."""
    cases = [
        Disagreement(
            row=row,
            function=function,
            difference=round(abs(first[function] - second[function]), 4),
            labels_differ=(first[function] > THRESHOLD) != (second[function] > THRESHOLD),
        )
        for first, second in combinations([figures["scores"] for figures in item["backends"].values()], 2)
        for function in first
    ]
    return max(cases, key=lambda case: (case.labels_differ, case.difference))


def clearest(cases: Sequence[Disagreement], count: int = MOST) -> list[Disagreement]:
    """Return the greatest disagreements, in turn about each function, those with different labels before others."""
    about: dict[str, list[Disagreement]] = {}
    for case in cases:
        about.setdefault(case.function, []).append(case)
    turns = [(place, case) for own in about.values() for place, case in enumerate(own)]
    order = sorted(turns, key=lambda turn: (not turn[1].labels_differ, turn[0], -turn[1].difference))
    return [case for _, case in order[:count]]


def displays_of(
    comparison: Comparison, cases: Sequence[Disagreement], loading: LoadOptions
) -> list[tuple[Disagreement, Display]]:
    """Return some disagreements with what the viewer draws; a file that has gone since it fell is left out."""
    displays = []
    for case in cases:
        try:
            cloud = load_cloud(comparison.simulated.objects[case.row].path, up=loading.up, units=loading.units)
        except InputError:
            continue
        panels = [
            Panel(title=entry.name, layers=[layer(entry, case.row, radius) for radius in entry.radii])
            for entry in comparison.entries
        ]
        displays.append((case, display(cloud, panels, first_radius(comparison, cloud))))
    return displays


def layer(entry: ComparedRun, row: int, radius: float) -> Layer:
    """Return what one simulator's spheres of one radius did on one object."""
    record = entry.records[row]
    everything = record.centers(radius)
    centers, settled = everything[:MAX_SPHERES], len(everything)
    note = f"Spheres of radius {format_length(radius)}: {settled:,} of {record.drops[radius]:,} settled"
    note += f", in {record.seconds[radius]:.3g} s"
    note += f"; the first {len(centers):,} are drawn." if len(centers) < settled else "."
    return Layer(radius=radius, centers=centers, cubes=histogram_cubes(centers, radius), note=note)


def first_radius(comparison: Comparison, cloud: Cloud) -> float:
    """Return the radius at which spheres are seen best, of those that most simulators have, metres."""
    radii = [radius for entry in comparison.entries for radius in entry.radii]
    most = max(map(radii.count, radii))
    return fitting_radius([radius for radius in radii if radii.count(radius) == most], cloud.size, SPHERES_ACROSS)
