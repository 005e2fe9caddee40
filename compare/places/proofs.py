"""What do proofs of seats buy? Objects of sources that were not learnt, and impaired copies of seats."""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from spherefunc_bullet.batch.simulated import simulate_dataset
from spherefunc_bullet.clouds.cloud import Cloud, cloud_from_mesh, load_cloud
from spherefunc_bullet.commands.options import dropping
from spherefunc_bullet.console import progress, say
from spherefunc_bullet.datasets.dataset import DatasetObject, open_dataset
from spherefunc_bullet.places.finding import NO_SEAT, places_of
from spherefunc_bullet.places.proving import proven
from spherefunc_bullet.scenes.impairment.impairments import IMPAIRMENTS
from spherefunc_bullet.scenes.impairment.kinds import Impairment
from spherefunc_bullet.scenes.impairment.levels import still_serves
from spherefunc_bullet.scenes.impairment.seats import tilted_seat
from spherefunc_bullet.scenes.impairment.specimen import Specimen
from spherefunc_bullet.scenes.impairment.surfaces import Surface
from spherefunc_bullet.scenes.impairment.tables import spikes_on_top
from spherefunc_bullet.simulator import make_simulator
from spherefunc_bullet.simulator.proofs import ProofSettings

from ..evaluation.profiled import spheres_profiled
from ..evaluation.protocol import labels_of, leave_one_group_out

SEAT = "sittable"
SURE, CLAIMED = {SEAT: 1.0}, 0.5
FOLDED = 0.1  # metres, how thick a folded chair is


@dataclass(frozen=True, kw_only=True)
class Seat:
    """What became of the places to sit of one object."""

    name: str
    group: str
    true: bool  # whether it is a seat
    score: float  # of the function, from what has learnt other sources
    places: int
    best: bool  # whether the best place held a sitter
    held: int  # places that did
    finding: float  # seconds
    proving: float


def spiked(specimen: Specimen, rng: np.random.Generator) -> Surface | None:
    """Cover a seat with spikes of 10 to 20 cm; where most of it stays free of them, there is no copy."""
    copy = spikes_on_top(specimen, rng)
    return None if copy is None or still_serves(copy, specimen.level) else copy


def folded(specimen: Specimen, rng: np.random.Generator) -> Surface | None:
    """Press a seat flat from its back to its front."""
    if specimen.level is None:
        return None
    low, high = specimen.level.box
    axis = int((high - low).argmin()) if specimen.back is None else int(np.abs(specimen.back).argmax())
    pressed = np.ones(3)
    pressed[axis] = FOLDED / max(specimen.surface.size[axis], FOLDED)
    return specimen.surface.mapped(lambda points: points * pressed)


def useless_seats() -> list[Impairment]:
    """Return the kinds of copies on which nobody can sit."""
    more = {"tilted by 25 degrees": partial(tilted_seat, degrees=25.0), "spikes": spiked, "folded": folded}
    named = [Impairment(kind=kind, functions=(SEAT,), works=False, change=change) for kind, change in more.items()]
    return [kind for kind in IMPAIRMENTS if SEAT in kind.functions and not kind.works] + named


def scores_across_sources(folder: Path) -> tuple[tuple[DatasetObject, ...], np.ndarray]:
    """Return a folder's objects, and how surely each is a seat, from what has learnt the other sources."""
    how = dropping("fast", None, None, 0, "z", "m")
    simulated = simulate_dataset(open_dataset(str(folder)), how, failed=lambda error: say(str(error)))
    labels = labels_of(simulated)
    trial = spheres_profiled(simulated, labels, how.radii).trial(leave_one_group_out(labels.groups))
    scores = np.empty(len(labels))
    scores[trial.rows] = trial.scores[:, labels.functions.index(SEAT)]
    return simulated.objects, scores


def seat_tried(cloud: Cloud, item: DatasetObject, score: float, known: Mapping[str, float]) -> Seat:
    """Return what becomes of an object's places to sit."""
    started = time.perf_counter()
    places = [place for place in places_of(cloud, scores=known) if place.kind == "sit"]
    found = time.perf_counter()
    tried = {
        place.position.tobytes(): place.proven.holds
        for place in proven(cloud, places, make_simulator("bullet"), ProofSettings())
    }
    return Seat(
        name=item.path.name,
        group=item.group,
        true=SEAT in item.functions,
        score=float(score),
        places=len(places),
        best=bool(places) and tried[places[0].position.tobytes()],
        held=sum(tried.values()),
        finding=found - started,
        proving=time.perf_counter() - found,
    )


def objects_tried(objects: Sequence[DatasetObject], scores: np.ndarray) -> Iterator[Seat]:
    """Yield what becomes of each object that may be a seat, but for those that are one besides."""
    rows = [row for row, item in enumerate(objects) if SEAT not in item.also - item.functions]
    for row in progress(rows, len(rows), "sitting on objects"):
        if scores[row] >= NO_SEAT or SEAT in objects[row].functions:
            yield seat_tried(load_cloud(objects[row].path), objects[row], scores[row], {SEAT: scores[row]})


def copies_tried(objects: Sequence[DatasetObject], every: int) -> dict[str, dict[str, float]]:
    """Return for each kind of copies of seats the share with a place to sit, and on which a sitter held."""
    rows: dict[str, list[Seat]] = {}
    seats = [item for item in objects if SEAT in item.functions][::every]
    for item in progress(seats, len(seats), "sitting on copies"):
        specimen = Specimen(load_cloud(item.path), SEAT)
        rows.setdefault("whole", []).append(seat_tried(specimen.cloud, item, 1.0, SURE))
        for kind in useless_seats():
            copy = kind.applied(specimen, item.path.name, 0)
            if copy is not None:
                tried = seat_tried(cloud_from_mesh(*copy.mesh(), kind.kind), item, 1.0, SURE)
                rows.setdefault(kind.kind, []).append(tried)
    return {
        kind: {
            "copies": len(tried),
            "proposed": share([one.places > 0 for one in tried]),
            "held": share([one.held > 0 for one in tried]),
            "best held": share([one.best for one in tried]),
        }
        for kind, tried in rows.items()
    }


def share(which: Sequence[bool]) -> float | None:
    """Return the share that is true, to three places; None of nothing."""
    return round(float(np.mean(which)), 3) if len(which) else None


def quality(seats: Sequence[Seat], said: Sequence[bool]) -> dict[str, float]:
    """Return precision, recall and F-measure of what is said to be a seat."""
    right = sum(one.true and yes for one, yes in zip(seats, said, strict=True))
    precision, recall = right / max(1, sum(said)), right / max(1, sum(one.true for one in seats))
    both = 2 * precision * recall / max(precision + recall, 1e-9)
    return {"precision": round(precision, 3), "recall": round(recall, 3), "f_measure": round(both, 3)}


def proofs_examined(folder: Path, every: int) -> dict[str, object]:
    """Return what spheres, places and proofs say of objects and of copies, and what share of each verdict is a seat."""
    objects, scores = scores_across_sources(folder)
    seats = list(objects_tried(objects, scores))
    called = [one.score > CLAIMED for one in seats]
    placed = [yes and one.places > 0 for one, yes in zip(seats, called, strict=True)]
    held = [yes and one.best for one, yes in zip(seats, placed, strict=True)]
    asked = [one for one in seats if one.score >= NO_SEAT and one.places]
    return {
        "spheres": quality(seats, called),
        "and a place": quality(seats, placed) | {"seconds": mean(one.finding for one in seats)},
        "and its proof": quality(seats, held) | {"seconds": mean(one.proving for one in seats if one.places)},
        "false claims": {one.name: one.best for one, yes in zip(seats, placed, strict=True) if yes and not one.true},
        "true claims lost": [one.name for one, yes in zip(seats, placed, strict=True) if yes and one.true > one.best],
        "less sure": {one.name: one.best for one in asked if one.score <= CLAIMED and not one.true},
        "shares that are seats": shares(asked),
        "without a source": {
            group: shares([one for one in asked if one.group != group]) for group in sorted({s.group for s in asked})
        },
        "copies": copies_tried(objects, every),
    }


def shares(seats: Sequence[Seat]) -> dict[str, float | None]:
    """Return what share are seats of all, of those whose best place held a sitter, and of those whose did not."""
    return {
        "all": share([one.true for one in seats]),
        "held": share([one.true for one in seats if one.best]),
        "failed": share([one.true for one in seats if not one.best]),
    }


def mean(seconds: Iterator[float]) -> float:
    """Return a mean to a millisecond."""
    return round(float(np.mean(list(seconds))), 3)
