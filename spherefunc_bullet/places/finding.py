"""All places of one object."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cache
from itertools import pairwise
from pathlib import Path

import numpy as np

from ..clouds.cloud import Cloud, cloud_from_mesh, cloud_of
from ..clouds.conversion import Anything, geometry_of, warn
from ..errors import InputError, require_amount
from ..formats.units import BY_FILE
from ..simulator import Simulator
from ..simulator.mechanics import require_ability
from ..simulator.proofs import PourUse, ProofResult, ProofSettings, PutUse, SitUse, Use
from .place import IDENTITY, Place, Proof, Similarity, similarity_between
from .pouring import pour_places
from .putting import LOWEST, put_places
from .regions import seat_surface, surface_of, without_strays
from .shelves import shelf_places
from .sitting import sit_places

NO_SEAT = 0.2  # score below which an object is surely not a seat: a high box has a level top as well
UNKNOWN = 0.5  # score of a function that is not known


def places_of(
    cloud: Cloud,
    *,
    put: Cloud | None = None,
    scores: Mapping[str, float] | None = None,
    person: float = 1.75,
    only: str | None = None,
) -> list[Place]:
    """Return the places of a cloud's object in the cloud's frame, the best first.

    Parameters
    ----------
    put : Cloud, optional
        An object for which poses are searched, as it stands.
    scores : mapping, optional
        Of each function, 0 to 1, as in `Answer.scores`: places of functions that the object does not have get lower
        scores.
    person : float, metres
        Height of a sitter.
    only : {"sit", "put", "pour"}, optional
        The kind that is searched for; by default all.
    """
    known = {} if scores is None else scores
    if not isinstance(known, Mapping):
        raise InputError(f"scores: expected the score of each function, got {type(known).__name__}")
    for function, score in known.items():
        require_amount(f"score of {function}", score, most=1.0)
    cloud = without_strays(cloud)
    surface = surface_of(cloud)
    sittable = known.get("sittable", UNKNOWN)
    finders = {
        "sit": lambda: sit_places(seat_surface(cloud, surface), person, sittable) if sittable >= NO_SEAT else [],
        "put": lambda: [*put_places(surface, put), *shelf_places(cloud, surface, put, LOWEST)],
        "pour": lambda: pour_places(cloud),
    }
    found = [place for kind, find in finders.items() if only in (None, kind) for place in find()]
    weighted = [
        replace(place, score=float(np.sqrt(place.score * known[place.function]))) if place.function in known else place
        for place in found
    ]
    return sorted(weighted, key=rank)


def rank(place: Place) -> tuple[float, float]:
    """Return the key by which places are sorted: the highest score first, and the largest area of equal scores."""
    return -round(place.score, 2), -place.area


def cloud_and_frame(anything: Anything, *, units: str = "m", up: str = BY_FILE) -> tuple[Cloud, Similarity]:
    """Return the cloud of an object, and the transformation from its frame to that of the input; see `as_cloud`."""
    if isinstance(anything, Cloud):
        return anything, IDENTITY
    name = anything if isinstance(anything, str | Path) else "cloud"
    geometry = geometry_of(anything, str(name))
    cloud = cloud_of(geometry, Path(name), units=units, up=up, report=warn)
    if cloud.mesh is not None:
        return cloud, similarity_between(cloud.mesh.vertices, geometry.vertices[np.unique(geometry.faces)])
    seen = np.isfinite(geometry.vertices).all(axis=1)
    return cloud, similarity_between(cloud.points, geometry.vertices[seen])


# Factor of a score after a failed proof: the share of seats among objects whose best place to sit did not hold, divided
# by that share among all objects with such a place (`python -m spherefunc_bullet.compare.places proofs`; no places to
# put and to pour failed there).
LEFT = 0.36
TRIED_POSES = 3  # of a region
TRIED_HEADINGS = 4  # if all headings are equally good
DISC = 0.04, 0.08  # metres, radius and height of the cylinder that is put down if no object is given


def proven(
    cloud: Cloud,
    places: Sequence[Place],
    simulator: Simulator,
    settings: ProofSettings,
    put: Cloud | None = None,
    seed: int = 0,
) -> list[Place]:
    """Return places, in the cloud's frame, with proofs from using them; the best first.

    If the best place of a kind does not hold, the object probably lacks the function, so all places of that kind get
    lower scores.

    Parameters
    ----------
    places : sequence of Place
        The best first.

    Raises
    ------
    InputError
        If the backend cannot prove.
    """
    able = require_ability(simulator, "prove")
    uses = [uses_of(place, put) for place in places]
    verdicts = iter(able.prove(cloud, [use for of_one in uses for use in of_one], settings, seed))
    proofs = [proof_of(able.name, [next(verdicts) for _ in of_one]) for of_one in uses]
    best = {place.kind: row for row, place in reversed(list(enumerate(places)))}
    results = []
    for row, (place, proof) in enumerate(zip(places, proofs, strict=True)):
        failed = sum(not proofs[number].holds for number in {row, best[place.kind]})
        results.append(replace(place, proven=proof, score=place.score * LEFT**failed))
    return sorted(results, key=rank)


def proof_of(backend: str, verdicts: Sequence[ProofResult]) -> Proof:
    """Return the proof of one place."""
    held = sum(verdict.held for verdict in verdicts)
    why = tuple(reason for reason, _ in Counter(verdict.why for verdict in verdicts if not verdict.held).most_common())
    return Proof(backend=backend, trials=len(verdicts), held=held, why=why)


def uses_of(place: Place, put: Cloud | None) -> list[Use]:
    """Return the uses that are tried at a place, in the cloud's frame."""
    if place.kind == "sit":
        every = 360.0 / TRIED_HEADINGS * np.arange(TRIED_HEADINGS)
        headings = every if place.heading_deg is None else [place.heading_deg]
        return [SitUse(position=place.position, heading=float(np.radians(heading))) for heading in headings]
    if place.kind == "put":
        return [PutUse(cloud=put or disc(), pose=pose) for pose in (place.poses or (standing(place),))[:TRIED_POSES]]
    low, high = place.inside
    return [PourUse(position=place.position, radius=place.radius, volume=place.filled_ml * 1e-6, low=low, high=high)]


def standing(place: Place) -> np.ndarray:
    """Return the pose (4, 4) of an object that stands on the surface of a place."""
    from ..simulator.statics.facets import turned_down

    pose = np.eye(4)
    pose[:3, :3] = turned_down(-place.normal).T
    pose[:3, 3] = place.position
    return pose


@cache
def disc() -> Cloud:
    """Return a cylinder, the object that is put down if none is given."""
    angles = np.arange(24) * 2 * np.pi / 24
    circle = DISC[0] * np.column_stack([np.cos(angles), np.sin(angles)])
    corners = np.vstack([np.column_stack([circle, np.full(24, height)]) for height in (0.0, DISC[1])])
    edges = list(pairwise([*range(24), 0]))
    sides = [(a, b, 24 + b) for a, b in edges] + [(a, 24 + b, 24 + a) for a, b in edges]
    caps = [(0, k + 1, k) for k in range(1, 23)] + [(24, 24 + k, 25 + k) for k in range(1, 23)]
    return cloud_from_mesh(corners, np.array(sides + caps), "disc")
