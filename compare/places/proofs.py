"""What do proofs buy? Objects of sources that were not learnt, and copies of seats on which nobody can sit."""

from __future__ import annotations

import time
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from spherefunc_bullet.batch.simulated import simulate_dataset
from spherefunc_bullet.clouds.cloud import Cloud, cloud_from_mesh, load_cloud
from spherefunc_bullet.commands.options import dropping
from spherefunc_bullet.console import progress, say
from spherefunc_bullet.datasets.dataset import DatasetObject, open_dataset
from spherefunc_bullet.places.finding import NO_SEAT, places_of, proven
from spherefunc_bullet.places.place import FUNCTION, KINDS
from spherefunc_bullet.scenes.impairment.specimen import Specimen
from spherefunc_bullet.simulator import make_simulator
from spherefunc_bullet.simulator.proofs import ProofSettings

from ..evaluation.protocol import labels_of, leave_one_group_out
from ..evaluation.readings import spheres_profiled
from ..mechanics.sitting import SEAT, SURE, impairs_seat, useless_seats

CLAIMED = 0.5


@dataclass(frozen=True, kw_only=True)
class Tried:
    """What became of the places of one kind of one object."""

    name: str
    group: str
    true: bool  # whether it has the function
    score: float  # of the function, from what has learnt other sources
    places: int
    best: bool  # whether the best place held
    held: int  # places that did
    finding: float  # seconds
    proving: float


def scores_across_sources(folder: Path) -> tuple[tuple[DatasetObject, ...], dict[str, np.ndarray]]:
    """Return a folder's objects, and of each function their scores, from what has learnt the other sources."""
    how = dropping("fast", None, None, 0, "z", "m")
    simulated = simulate_dataset(open_dataset(str(folder)), how, failed=lambda error: say(str(error)))
    labels = labels_of(simulated)
    trial = spheres_profiled(simulated, labels, how.radii).trial(leave_one_group_out(labels.groups))
    scores = trial.scores[np.argsort(trial.rows)]
    return simulated.objects, dict(zip(labels.functions, scores.T, strict=True))


def tried(cloud: Cloud, item: DatasetObject, kind: str, score: float, known: Mapping[str, float]) -> Tried:
    """Return what becomes of an object's places of one kind: all places to sit, the best of the other kinds."""
    started = time.perf_counter()
    places = [place for place in places_of(cloud, scores=known) if place.kind == kind]
    found = time.perf_counter()
    asked = places if kind == "sit" else places[:1]
    after = proven(cloud, asked, make_simulator("bullet"), ProofSettings())
    best = [place.proven.holds for place in after if place.position is places[0].position]
    return Tried(
        name=item.path.name,
        group=item.group,
        true=FUNCTION[kind] in item.functions,
        score=float(score),
        places=len(places),
        best=any(best),
        held=sum(place.proven.holds for place in after),
        finding=found - started,
        proving=time.perf_counter() - found,
    )


def objects_tried(objects: Sequence[DatasetObject], scores: Mapping[str, np.ndarray], kind: str) -> list[Tried]:
    """Return what becomes of each object that has, or may have, a kind's function, but for those that have it also."""
    function = FUNCTION[kind]
    may = [
        row
        for row, item in enumerate(objects)
        if function in item.functions or (scores[function][row] >= NO_SEAT and function not in item.also)
    ]
    return [
        tried(load_cloud(objects[row].path), objects[row], kind, scores[function][row], known_of(scores, row))
        for row in progress(may, len(may), f"{kind}: using objects")
    ]


def known_of(scores: Mapping[str, np.ndarray], row: int) -> dict[str, float]:
    """Return the scores of one object."""
    return {function: float(of_all[row]) for function, of_all in scores.items()}


def copies_tried(objects: Sequence[DatasetObject], every: int) -> dict[str, dict[str, float]]:
    """Return for each kind of copies of seats the share with a place to sit, and on which a sitter held.

    Where what would be impaired is not what one sits on, such as an ottoman beside its armchair, there are no copies.
    """
    rows: dict[str, list[Tried]] = {}
    seats = [item for item in objects if SEAT in item.functions][::every]
    for item in progress(seats, len(seats), "sitting on copies"):
        specimen = Specimen(load_cloud(item.path), SEAT)
        rows.setdefault("whole", []).append(tried(specimen.cloud, item, "sit", 1.0, SURE))
        for kind in useless_seats() if impairs_seat(specimen) else ():
            copy = kind.applied(specimen, item.path.name, 0)
            if copy is not None:
                cloud = cloud_from_mesh(*copy.mesh(), kind.kind)
                rows.setdefault(kind.kind, []).append(tried(cloud, item, "sit", 1.0, SURE))
    return {
        kind: {
            "copies": len(of_kind),
            "proposed": share([one.places > 0 for one in of_kind]),
            "held": share([one.held > 0 for one in of_kind]),
            "best held": share([one.best for one in of_kind]),
        }
        for kind, of_kind in rows.items()
    }


def share(which: Sequence[bool]) -> float | None:
    """Return the share that is true, to three places; None of nothing."""
    return round(float(np.mean(which)), 3) if len(which) else None


def quality(rows: Sequence[Tried], said: Sequence[bool]) -> dict[str, float]:
    """Return precision, recall and F-measure of what is said to have the function."""
    right = sum(one.true and yes for one, yes in zip(rows, said, strict=True))
    precision, recall = right / max(1, sum(said)), right / max(1, sum(one.true for one in rows))
    both = 2 * precision * recall / max(precision + recall, 1e-9)
    return {"precision": round(precision, 3), "recall": round(recall, 3), "f_measure": round(both, 3)}


def proofs_examined(folder: Path, every: int) -> dict[str, object]:
    """Return what spheres, places and proofs say of objects and of copies, and what the verdicts are worth."""
    objects, scores = scores_across_sources(folder)
    rows = {kind: bought(objects_tried(objects, scores, kind)) for kind in KINDS}
    return rows | {"copies of seats": copies_tried(objects, every)}


def bought(rows: Sequence[Tried]) -> dict[str, object]:
    """Return what places and proofs of one kind add to the spheres' scores, and the shares that have the function."""
    called = [one.score > CLAIMED for one in rows]
    placed = [yes and one.places > 0 for one, yes in zip(rows, called, strict=True)]
    held = [yes and one.best for one, yes in zip(rows, placed, strict=True)]
    claims = [one for one, yes in zip(rows, placed, strict=True) if yes]
    asked = [one for one in rows if one.score >= NO_SEAT and one.places]
    return {
        "spheres": quality(rows, called),
        "and a place": quality(rows, placed) | {"seconds": mean(one.finding for one in rows)},
        "and its proof": quality(rows, held) | {"seconds": mean(one.proving for one in rows if one.places)},
        "false claims, whether they held": {one.name: one.best for one in claims if not one.true},
        "true claims": sum(one.true for one in claims),
        "true claims lost": [one.name for one in claims if one.true and not one.best],
        "less sure, false": {one.name: one.best for one in asked if one.score <= CLAIMED and not one.true},
        "shares": shares(asked),
        "shares without a source": {
            group: shares([one for one in asked if one.group != group])
            for group in sorted({row.group for row in asked})
        },
    }


def shares(rows: Sequence[Tried]) -> dict[str, float | None]:
    """Return what share has the function: of all, of those whose best place held, and of those whose did not."""
    return {
        "all": share([one.true for one in rows]),
        "held": share([one.true for one in rows if one.best]),
        "failed": share([one.true for one in rows if not one.best]),
    }


def mean(seconds: Iterable[float]) -> float:
    """Return a mean to a millisecond."""
    return round(float(np.mean(list(seconds))), 3)
