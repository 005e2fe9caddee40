"""All places of one object."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from ..clouds.cloud import Cloud, cloud_of
from ..clouds.conversion import Anything, geometry_of, warn
from ..formats.units import BY_FILE
from .place import IDENTITY, Place, Similarity, similarity_between
from .pouring import pour_places
from .putting import LOWEST, put_places
from .shelves import shelf_places
from .sitting import sit_places
from .surface import surface_of

SEAT_CELL = 0.025  # metres
NO_SEAT = 0.2  # a score below which an object is surely none: a high box has a level top as well
UNKNOWN = 0.5  # the score of a function that nobody was asked about


def places_of(
    cloud: Cloud, *, put: Cloud | None = None, scores: Mapping[str, float] | None = None, person: float = 1.75
) -> list[Place]:
    """Return the places of a cloud's object in the cloud's frame, the best first.

    Parameters
    ----------
    put : Cloud, optional
        An object for which poses are looked for, standing as it is.
    scores : mapping, optional
        Of each function, 0 to 1, as `Answer.scores` has them: a place of a function that the object has not is
        worth less.
    person : float, metres
        How tall a sitter is.
    """
    surface, coarse = surface_of(cloud), surface_of(cloud, SEAT_CELL)
    known = {} if scores is None else scores
    sittable = known.get("sittable", UNKNOWN)
    found = [
        *(sit_places(coarse, person, sittable) if sittable >= NO_SEAT else []),
        *put_places(surface, put),
        *shelf_places(cloud, surface, put, LOWEST),
        *pour_places(cloud),
    ]
    weighed = [replace(place, score=weighed_score(place, known)) for place in found]
    return sorted(weighed, key=lambda place: -place.score)


def weighed_score(place: Place, scores: Mapping[str, float]) -> float:
    """Return the score of a place on an object of which the score of each function is known."""
    return float(np.sqrt(place.score * scores[place.function])) if place.function in scores else place.score


def places_in_input(
    anything: Anything, *, scores: Mapping[str, float], units: str = "m", up: str = BY_FILE, person: float = 1.75
) -> list[Place]:
    """Return the places of an object whose functions are known, in the coordinates and units of the input."""
    cloud, to_input = cloud_and_frame(anything, units=units, up=up)
    return [place.moved(to_input) for place in places_of(cloud, scores=scores, person=person)]


def cloud_and_frame(anything: Anything, *, units: str = "m", up: str = BY_FILE) -> tuple[Cloud, Similarity]:
    """Return the cloud of an object, and what takes its frame to that of the input; see `as_cloud`."""
    if isinstance(anything, Cloud):
        return anything, IDENTITY
    name = anything if isinstance(anything, str | Path) else "cloud"
    geometry = geometry_of(anything, str(name))
    cloud = cloud_of(geometry, Path(name), units=units, up=up, report=warn)
    if cloud.mesh is not None:
        return cloud, similarity_between(cloud.mesh.vertices, geometry.vertices[np.unique(geometry.faces)])
    seen = np.isfinite(geometry.vertices).all(axis=1)
    return cloud, similarity_between(cloud.points, geometry.vertices[seen])
