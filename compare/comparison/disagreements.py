"""The objects of which simulators say different things, to be looked at side by side."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import combinations

from spherefunc_bullet.clouds.cloud import load_cloud
from spherefunc_bullet.errors import InputError
from spherefunc_bullet.learning.validation import THRESHOLD
from spherefunc_bullet.quantities import format_length
from spherefunc_bullet.settling.records import Loading
from spherefunc_bullet.viewer.data import Layer, Panel, histogram_cubes, scene

from .entries import Contest, Entry

SHOWN = 6  # objects, so that the page stays small
MAX_SPHERES = 4000  # of one run that are drawn: the first to settle
SPHERES_ACROSS = 24  # radii along the longest side, about, of the spheres shown at first


@dataclass(frozen=True, kw_only=True)
class Disagreement:
    """One object of which at least two simulators say different things, or nearly so."""

    row: int  # of the report's objects
    function: str  # the one with the largest difference of scores
    difference: float  # of the scores
    labels_differ: bool


@dataclass(frozen=True, kw_only=True)
class Shown:
    """A disagreement to look at."""

    disagreement: Disagreement
    scene: dict = field(repr=False)  # for the viewer


def disagreements(per_object: Sequence[dict]) -> list[Disagreement]:
    """Return where simulators differ about an object, those with different labels first, then by scores."""
    found = [each for row, item in enumerate(per_object) for each in differences(row, item)]
    return sorted(found, key=lambda each: (not each.labels_differ, -each.difference, each.row))


def differences(row: int, item: dict) -> list[Disagreement]:
    """Return one object's greatest difference, one with different labels before one without."""
    every = [each["scores"] for each in item["backends"].values()]
    found = [
        Disagreement(
            row=row,
            function=function,
            difference=round(abs(first[function] - second[function]), 4),
            labels_differ=(first[function] > THRESHOLD) != (second[function] > THRESHOLD),
        )
        for first, second in combinations(every, 2)
        for function in first
    ]
    return [max(found, key=lambda each: (each.labels_differ, each.difference))] if found else []


def chosen(found: Sequence[Disagreement], count: int = SHOWN) -> list[Disagreement]:
    """Return the greatest disagreements, in turn about each function, those with different labels before others."""
    about: dict[str, list[Disagreement]] = {}
    for each in found:
        about.setdefault(each.function, []).append(each)
    turns = [(place, each) for own in about.values() for place, each in enumerate(own)]
    order = sorted(turns, key=lambda turn: (not turn[1].labels_differ, turn[0], -turn[1].difference))
    return [each for _, each in order[:count]]


def shown(contest: Contest, found: Sequence[Disagreement], loading: Loading) -> list[Shown]:
    """Return the scenes of some disagreements; a file that has gone since it was simulated is left out."""
    scenes = []
    for each in found:
        try:
            cloud = load_cloud(contest.objects[each.row].path, up=loading.up, units=loading.units)
        except InputError:
            continue
        about = scene(cloud, panels(contest, each.row), first_radius(contest, cloud))
        scenes.append(Shown(disagreement=each, scene=about))
    return scenes


def panels(contest: Contest, row: int) -> list[Panel]:
    """Return a panel for each simulator."""
    return [
        Panel(title=each.contestant.name, layers=[layer(each, row, radius) for radius in each.contestant.radii])
        for each in contest.entries
    ]


def layer(entry: Entry, row: int, radius: float) -> Layer:
    """Return what one simulator's spheres of one radius did on one object."""
    record = entry.simulated.records[row]
    centers = record.settled[radius][:MAX_SPHERES]
    settled = len(record.settled[radius])
    note = f"Spheres of radius {format_length(radius)}: {settled:,} of {record.drops[radius]:,} settled"
    note += f", in {record.seconds[radius]:.3g} s"
    note += f"; the first {len(centers):,} are drawn." if len(centers) < settled else "."
    return Layer(radius=radius, centers=centers, cubes=histogram_cubes(centers, radius), note=note)


def first_radius(contest: Contest, cloud) -> float:
    """Return the radius at which spheres are seen best, of those that most simulators have, metres."""
    radii = [radius for each in contest.entries for radius in each.contestant.radii]
    common = max(map(radii.count, radii))
    wanted = cloud.size.max() / SPHERES_ACROSS
    return min((each for each in radii if radii.count(each) == common), key=lambda each: abs(each - wanted))
