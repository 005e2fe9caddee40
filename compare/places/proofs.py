"""The benefit of proofs, on objects of sources that were not learnt, and on copies of seats on which nobody can sit."""

from __future__ import annotations

import time
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from spherefunc_bullet.batch.simulated import simulate_dataset
from spherefunc_bullet.clouds.cloud import Cloud, cloud_from_mesh, load_cloud
from spherefunc_bullet.commands.options import drop_config
from spherefunc_bullet.console import progress, say
from spherefunc_bullet.datasets.dataset import DatasetObject, open_dataset
from spherefunc_bullet.learning import validation
from spherefunc_bullet.places.finding import NO_SEAT, places_of, proven, uses_of
from spherefunc_bullet.places.place import FUNCTION, KINDS
from spherefunc_bullet.scenes.impairment.impairments import IMPAIRMENTS
from spherefunc_bullet.scenes.impairment.specimen import Specimen
from spherefunc_bullet.scenes.impairment.use.copies import IN_USE
from spherefunc_bullet.scenes.recognition.objects import scores_of
from spherefunc_bullet.simulator import make_simulator
from spherefunc_bullet.simulator.proofs import ProofSettings

from ..evaluation.protocol import labels_of, leave_one_group_out
from ..evaluation.readings import spheres_profiled
from ..mechanics.sitting import SEAT, SURE, WHOLE, impairs_seat, useless_seats

CLAIMED = 0.5
NAMED = ("missing", "tilted", "tilted by 25 degrees", "folded", "spikes")


@dataclass(frozen=True, kw_only=True)
class TriedPlaces:
    """The places of one kind on one object, and their proofs."""

    name: str
    group: str
    true: bool  # whether it has the function
    score: float  # of the function, by a model of other sources
    places: int
    best: bool  # whether the best place held
    held: int  # number of places that held
    finding: float  # seconds
    proving: float  # seconds


def scores_across_sources(folder: Path) -> tuple[tuple[DatasetObject, ...], dict[str, np.ndarray]]:
    """Return a folder's objects with their scores of each function, by models that have learnt the other sources."""
    how = drop_config("fast", None, None, 0, "z", "m")
    simulated = simulate_dataset(open_dataset(str(folder)), how, failed=lambda error: say(str(error)))
    labels = labels_of(simulated)
    trial = spheres_profiled(simulated, labels, how.radii).trial(leave_one_group_out(labels.groups))
    scores = trial.scores[np.argsort(trial.rows)]
    return simulated.objects, dict(zip(labels.functions, scores.T, strict=True))


def try_places(cloud: Cloud, item: DatasetObject, kind: str, score: float, known: Mapping[str, float]) -> TriedPlaces:
    """Return an object's places of one kind with proofs: of all places to sit, or of the best of the other kinds."""
    started = time.perf_counter()
    places = places_of(cloud, scores=known, only=kind)
    found = time.perf_counter()
    tested = places if kind == "sit" else places[:1]
    after = proven(cloud, tested, make_simulator("bullet"), ProofSettings())
    best = [place.proven.holds for place in after if place.position is places[0].position]
    return TriedPlaces(
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


def objects_tried(objects: Sequence[DatasetObject], scores: Mapping[str, np.ndarray], kind: str) -> list[TriedPlaces]:
    """Return the proofs of each object that has, or may have, a kind's function, except those that have it also."""
    function, likely = FUNCTION[kind], []
    for row, item in enumerate(objects):
        if function in item.functions or (scores[function][row] >= NO_SEAT and function not in item.also):
            likely.append((item, {name: float(of_all[row]) for name, of_all in scores.items()}))
    tried = progress(likely, len(likely), f"{kind}: using objects")
    return [try_places(load_cloud(item.path), item, kind, known[function], known) for item, known in tried]


@dataclass(frozen=True, kw_only=True)
class CopySeats:
    """The places to sit on one copy of a seat."""

    kind: str
    works: bool  # whether one can sit on such copies
    assumed: TriedPlaces  # if it is taken for a seat
    answered: TriedPlaces | None  # as spheres classify it; None if they classify it as no seat


def copies_tried(objects: Sequence[DatasetObject], every: int) -> dict[str, object]:
    """Return for kinds of copies of seats the shares with a place to sit, and those on which a proof holds.

    If only some of the places to sit would be impaired, as next to an ottoman, there are no useless copies.
    """
    seats = [item for item in objects if SEAT in item.functions][::every]
    rows = [row for item in progress(seats, len(seats), "sitting on copies") for row in sat_on(item)]
    works = {row.kind: row.works for row in rows}
    return {
        "whole": sitters(row for row in rows if row.kind == WHOLE),
        "harmless and in use": sitters(row for row in rows if row.works and row.kind != WHOLE),
        "useless": sitters(row for row in rows if not row.works),
        "seatless, tilted, folded, spikes": sitters(row for row in rows if not row.works and row.kind in NAMED),
        "kinds": {kind: sitters(row for row in rows if row.kind == kind) for kind in works},
        "useless and held": [f"{row.assumed.name} {row.kind}" for row in rows if not row.works and row.assumed.held],
        "whole and not held": [row.assumed.name for row in rows if row.kind == WHOLE and not row.assumed.held],
    }


def sat_on(item: DatasetObject) -> Iterator[CopySeats]:
    """Yield the places to sit on a seat and on each copy of it."""
    specimen = Specimen(load_cloud(item.path), SEAT)
    working = [kind for kind in (*IMPAIRMENTS, *IN_USE) if kind.works and SEAT in kind.functions]
    worn = [kind for kind in IN_USE if SEAT in kind.functions and not kind.works]
    for kind in [*working, *([*useless_seats(), *worn] if impairs_seat(specimen) else [])]:
        copy = kind.applied(specimen, item.path.name, 0)
        if copy is None:
            continue
        cloud = Cloud(copy.points, kind.kind) if copy.is_cloud else cloud_from_mesh(*copy.mesh(), kind.kind)
        assumed = try_places(cloud, item, "sit", 1.0, SURE)
        known = scores_of(cloud)
        answered = assumed
        if known[SEAT] <= CLAIMED:  # otherwise the places are those of a seat
            answered = try_places(cloud, item, "sit", known[SEAT], known) if known[SEAT] >= NO_SEAT else None
        yield CopySeats(kind=kind.kind, works=kind.works, assumed=assumed, answered=answered)


def sitters(rows: Iterable[CopySeats]) -> dict[str, float | None]:
    """Return the number of copies, and the shares with a place to sit, and with one that holds."""
    every = list(rows)
    classified = [row.answered for row in every]
    return {
        "copies": len(every),
        "proposed": share([row.assumed.places > 0 for row in every]),
        "held": share([row.assumed.held > 0 for row in every]),
        "proposed as classified": share([tried is not None and tried.places > 0 for tried in classified]),
        "held as classified": share([tried is not None and tried.held > 0 for tried in classified]),
    }


def seconds_taken(folder: Path, every: int) -> dict[str, object]:
    """Return the milliseconds of processor time that places of labelled objects and one proof of each kind take."""
    objects, prover = open_dataset(str(folder)).objects[::every], make_simulator("bullet")
    warm, finding, proving = load_cloud(objects[0].path), [], {kind: [] for kind in KINDS}
    proven(warm, places_of(warm)[:1], prover, ProofSettings())  # compiles
    for item in progress(objects, len(objects), "timing"):
        cloud, started = load_cloud(item.path), time.process_time()
        known = {function: float(function in item.functions) for function in FUNCTION.values()}
        places = places_of(cloud, scores=known)
        finding.append(1000 * (time.process_time() - started))
        for place in {place.kind: place for place in reversed(places) if known[place.function]}.values():
            started, trials = time.process_time(), len(uses_of(place, None))
            proven(cloud, [place], prover, ProofSettings())
            proving[place.kind].append(1000 * (time.process_time() - started) / trials)
    return {"places": milliseconds(finding)} | {f"proof to {kind}": milliseconds(proving[kind]) for kind in KINDS}


def milliseconds(taken: Sequence[float]) -> dict[str, float]:
    """Return the number of times, their median and the longest."""
    return {"count": len(taken), "median": round(float(np.median(taken)), 1), "most": round(max(taken), 1)}


def share(which: Sequence[bool]) -> float | None:
    """Return the share that is true, to three places; None if there is nothing."""
    return round(float(np.mean(which)), 3) if len(which) else None


def quality(rows: Sequence[TriedPlaces], predicted: Sequence[bool]) -> dict[str, float]:
    """Return precision, recall and F-measure of predictions of the function."""
    found = validation.quality(np.array([row.true for row in rows], bool), np.array(predicted, bool))
    return {name: round(getattr(found, name), 3) for name in ("precision", "recall", "f_measure")}


def proofs_benchmark(folder: Path) -> dict[str, object]:
    """Return the quality of spheres, places and proofs on the objects of a folder, by kind of place."""
    objects, scores = scores_across_sources(folder)
    return {kind: benefit_of_proofs(objects_tried(objects, scores, kind)) for kind in KINDS}


def benefit_of_proofs(rows: Sequence[TriedPlaces]) -> dict[str, object]:
    """Return what places and proofs of one kind add to the spheres' scores, and the shares with the function."""
    called = [one.score > CLAIMED for one in rows]
    placed = [one.score > CLAIMED and one.places > 0 for one in rows]
    held = [claimed and one.best for one, claimed in zip(rows, placed, strict=True)]
    claims = [one for one, claimed in zip(rows, placed, strict=True) if claimed]
    tested = [one for one in rows if one.score >= NO_SEAT and one.places]
    return {
        "spheres": quality(rows, called),
        "and a place": quality(rows, placed) | {"seconds": mean(one.finding for one in rows)},
        "and its proof": quality(rows, held) | {"seconds": mean(one.proving for one in rows if one.places)},
        "false claims, whether they held": {one.name: one.best for one in claims if not one.true},
        "true claims": sum(one.true for one in claims),
        "true claims lost": [one.name for one in claims if one.true and not one.best],
        "less sure, false": {one.name: one.best for one in tested if one.score <= CLAIMED and not one.true},
        "shares": shares(tested),
        "shares without a source": {
            name: shares([one for one in tested if one.group != name]) for name in sorted({one.group for one in tested})
        },
    }


def shares(rows: Sequence[TriedPlaces]) -> dict[str, float | None]:
    """Return the share with the function: of all, of those whose best place held, and of those whose did not."""
    return {
        "all": share([row.true for row in rows]),
        "held": share([row.true for row in rows if row.best]),
        "failed": share([row.true for row in rows if not row.best]),
    }


def mean(seconds: Iterable[float]) -> float:
    """Return a mean to a millisecond."""
    return round(float(np.mean(list(seconds))), 3)
