"""Places to sit, to put and to pour, of an object or of a scan, in one call."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from spherefunc_bullet.clouds.cloud import Cloud
from spherefunc_bullet.clouds.conversion import Anything
from spherefunc_bullet.formats.units import BY_FILE
from spherefunc_bullet.places.finding import cloud_and_frame, places_of, proven
from spherefunc_bullet.places.place import Place, Similarity
from spherefunc_bullet.simulator import make_simulator
from spherefunc_bullet.simulator.mechanics import require_ability
from spherefunc_bullet.simulator.proofs import ProofSettings

from ..scans.scan import Scan
from .partial_places import room_places
from .room import Room

PROVER = "bullet"


def find_places(
    anything: Anything,
    put: Anything | None = None,
    prove: bool = False,
    person: float = 1.75,
    *,
    backend: str | None = None,
    scores: Mapping[str, float] | None = None,
    units: str = "m",
    up: str = BY_FILE,
    seed: int = 0,
) -> list[Place]:
    """Return where and how an object can be used: places to sit, to put and to pour, the best first.

    Proposals need no engine and take some ten milliseconds; a proof takes some tenths of a second.

    Parameters
    ----------
    anything : path, (N, 3) array_like, Open3D or trimesh object, Cloud
    put : the same, optional
        An object for which poses are looked for; it stands as it comes, z up, in metres.
    prove : bool
        Whether places are used by rigid bodies; scores know what became of that.
    person : float, metres
        How tall a sitter is.
    backend : str, optional
        Who proves; by default ``bullet``.
    scores : mapping, optional
        Of each function, as `classify` gives them; by default the model that ships is asked.
    units, up
        See `classify`.
    seed : int
        Of the stream that is poured.

    Returns
    -------
    list of Place
        In the coordinates and units of the input.

    Raises
    ------
    InputError
        If an object cannot be used, or the backend cannot prove.
    """
    settings = ProofSettings(person=person)
    prover = require_ability(make_simulator(backend or PROVER), "prove") if prove else None
    cloud, to_input = cloud_and_frame(anything, units=units, up=up)
    own, own_frame = (None, None) if put is None else cloud_and_frame(put)
    known = scores_of(cloud) if scores is None else scores
    found = places_of(cloud, put=own, scores=known, person=person)
    if prover is not None:
        found = proven(cloud, found, prover, settings, own, seed)
    moved = [place.moved(to_input) for place in found]
    return moved if own_frame is None else [with_poses_of(place, own_frame) for place in moved]


def places_in_room(
    scan: Scan, room: Room, put: Anything | None = None, person: float = 1.75
) -> dict[int | None, list[Place]]:
    """Return the places of each object of a room by its id, and under None those that are on none.

    Poses are from the frame in which the object that is put came, in metres.
    """
    own, frame = (None, None) if put is None else cloud_and_frame(put)
    found = room_places(scan, room, own, person)
    if frame is None:
        return found
    return {owner: [with_poses_of(place, frame) for place in places] for owner, places in found.items()}


def scores_of(cloud: Cloud) -> dict[str, float]:
    """Return what the model that ships says of an object."""
    from spherefunc_bullet.answer import classify

    return classify(cloud, explain=False).scores


def with_poses_of(place: Place, frame: Similarity) -> Place:
    """Return a place whose poses are from the frame in which the object that is put came, in metres."""
    undo = np.eye(4)
    undo[:3, :3] = frame.rotation.T
    undo[:3, 3] = -frame.rotation.T @ frame.shift / frame.scale
    return replace(place, poses=tuple(pose @ undo for pose in place.poses))
