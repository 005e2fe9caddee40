"""Places: seats, and for each a copy on which nobody can sit; is there a place to sit?

Spheres propose places; a backend that can prove them lowers a person there, and only places that hold count. Nothing is
learnt.
"""

from __future__ import annotations

import time
import zlib
from collections.abc import Sequence
from functools import partial
from pathlib import Path

import numpy as np

from spherefunc_bullet.clouds.cloud import Cloud, cloud_from_mesh, load_cloud
from spherefunc_bullet.datasets.dataset import DatasetObject
from spherefunc_bullet.places.finding import places_of, proven
from spherefunc_bullet.scenes.impairment.folder import evenly
from spherefunc_bullet.scenes.impairment.held_out import pressed_flat
from spherefunc_bullet.scenes.impairment.impairments import IMPAIRMENTS
from spherefunc_bullet.scenes.impairment.specimen import Impairment, Specimen, kinds
from spherefunc_bullet.scenes.impairment.useless import spikes_on_top, tilted_seat
from spherefunc_bullet.settling.cached_runs import LoadOptions
from spherefunc_bullet.simulator import Simulator
from spherefunc_bullet.simulator.proofs import ProofSettings

from .standing import ScoredAnswers, TaskAnswer, TaskOptions, scored, simulator_answers

SEAT, WHOLE = "sittable", "whole"
SURE = {SEAT: 1.0}
APART = 0.1  # metres: levels that differ more in height are different levels


def useless_seats() -> list[Impairment]:
    """Return the kinds of copies on which nobody can sit."""
    more = {"tilted by 25 degrees": partial(tilted_seat, degrees=25.0), "spikes": spikes_on_top, "folded": pressed_flat}
    return [kind for kind in IMPAIRMENTS if SEAT in kind.functions and not kind.works] + kinds((SEAT,), False, **more)


def impairs_seat(specimen: Specimen) -> bool:
    """Return whether all places to sit are on the impaired level; an ottoman next to it would remain a seat."""
    places, level = places_of(specimen.cloud, scores=SURE, only="sit"), specimen.level
    if not places or level is None:
        return False
    on_it = level.flat[level.grid.cells_of(np.array([place.position for place in places]))]
    return bool(on_it.all() and all(abs(place.height - level.height) < APART for place in places))


def places_held(path: Path, simulator: Simulator, loading: LoadOptions) -> dict[str, tuple[float, float]]:
    """Return the share of places to sit that hold, on a file's object and on a useless copy of it, by kind.

    Each comes with the seconds of processor time that it took.
    """
    specimen = Specimen(load_cloud(path, up=loading.up, units=loading.units), SEAT)
    variants = {WHOLE: specimen.cloud} | useless_copy(specimen, path.name)
    return {kind: share_held(cloud, simulator) for kind, cloud in variants.items()}


def useless_copy(specimen: Specimen, name: str) -> dict[str, Cloud]:
    """Return one useless copy by its kind, chosen at random with the object's name as seed."""
    if not impairs_seat(specimen):
        return {}
    made = {kind.kind: kind.applied(specimen, name, 0) for kind in useless_seats()}
    copies = {kind: copy for kind, copy in made.items() if copy is not None}
    drawn = sorted(copies)[zlib.crc32(name.encode()) % max(len(copies), 1) :][:1]
    return {kind: cloud_from_mesh(*copies[kind].mesh(), name) for kind in drawn}


def share_held(cloud: Cloud, simulator: Simulator) -> tuple[float, float]:
    """Return the share of places to sit that hold, or 1 if there are places but no proofs, and the seconds it took."""
    started = time.process_time()
    places = places_of(cloud, scores=SURE, only="sit")
    share = float(bool(places))
    if places and callable(getattr(simulator, "prove", None)):
        after = proven(cloud, places, simulator, ProofSettings())
        share = float(np.mean([place.proven.holds for place in after]))
    return share, time.process_time() - started


def score_sitting(objects: Sequence[DatasetObject], simulator: Simulator, options: TaskOptions) -> ScoredAnswers | None:
    """Return how well a backend distinguishes seats from useless copies; None without seats."""
    verdicts, seconds = [], []
    seats = evenly([item for item in objects if SEAT in item.functions], options.count)
    for item, held, _ in simulator_answers(places_held, seats, simulator, f"sitting by {simulator.name}", options):
        seconds += [taken for _, taken in held.values()]
        verdicts += [
            TaskAnswer(name=item.path.name, kind=kind, true=kind == WHOLE, positive=share > 0, value=share)
            for kind, (share, _) in held.items()
        ]
    return scored(simulator, verdicts, seconds) if verdicts else None
