"""Does it stand? The centre of mass against the polygon of its supports, with and without a load.

Exact for a rigid body on level ground that is put down without speed: it keeps its pose while its weight acts within
the support polygon, and rolls over an edge of it otherwise.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from ..mechanics import LEVEL, Stance, StandResult, StandSettings
from .body import Body
from .facets import Facets, facets_of
from .poses import turned_down

DOWN = np.array([[0.0, 0.0, -1.0]])
ROLLING = 0.005  # of the height of the centre of mass: who rises no more than that on the way to another pose rolls


@dataclass(frozen=True, kw_only=True)
class Stand:
    """What becomes of a body that is put on the ground."""

    stance: Stance
    tilt_deg: float
    down: np.ndarray  # (3,) direction of the body that points down in the end; unknown: NaN

    @property
    def turn(self) -> np.ndarray:
        """The rotation (3, 3) from the pose it came in to that in which it stands; none for one that does not."""
        return turned_down(self.down) if self.stance in (Stance.STANDS, Stance.ROCKS) else np.eye(3)


@dataclass(frozen=True, eq=False)
class Support:
    """The polygon on which a body stands, by its edges: a place is within where ``normals @ place + offsets <= 0``."""

    normals: np.ndarray  # (E, 2) outward
    offsets: np.ndarray  # (E,) metres

    def outside(self, places: np.ndarray) -> np.ndarray:
        """Return how far places (P, 2) lie beyond each edge, (P, E) metres; below 0 within."""
        return places @ self.normals.T + self.offsets


def stand(body: Body, settings: StandSettings) -> Stand:
    """Return what becomes of a body that is put on the ground as it came."""
    facets = facets_of(body)
    rest = int(facets.rests_on[facets.pierced(DOWN)][0])
    return stance_at(facets, facets.normals[rest], settings)


def stance_at(facets: Facets, down: np.ndarray, settings: StandSettings) -> Stand:
    """Return how a body stands that has come to rest with a direction (3,) down."""
    tilt = float(np.degrees(np.arccos(np.clip(-down[2], -1, 1))))
    rest = int(facets.nearest(down[None])[0])
    down = facets.normals[rest]
    if wanders(facets, rest, settings.rocking_deg):
        return Stand(stance=Stance.ROLLS, tilt_deg=tilt, down=down)
    leans = tilt > settings.tilt_deg
    stance = Stance.TIPS if tilt > settings.rocking_deg else Stance.ROCKS if leans else Stance.STANDS
    return Stand(stance=stance, tilt_deg=tilt, down=down)


def wanders(facets: Facets, rest: int, far_deg: float) -> bool:
    """Return whether a body rolls from the facet it rests on to one that is farther than an angle, at a touch."""
    left, seen = [rest], {rest}
    limit, level = facets.heights[rest] * (1 + ROLLING), facets.heights[rest] * (1 - ROLLING)
    while left:
        facet = left.pop()
        if facets.normals[facets.rests_on[facet]] @ facets.normals[rest] < np.cos(np.radians(far_deg)):
            return True
        low = facets.neighbors[facet][facets.sills[facet] <= limit]
        low = low[facets.heights[facets.rests_on[low]] >= level]  # what ends lower has tipped
        left += [int(one) for one in low if one not in seen]
        seen.update(int(one) for one in low)
    return False


def support_of(body: Body) -> Support | None:
    """Return the polygon between the corners on which a body stands; None where it is a point or a line."""
    heights = body.corners[:, 2] - body.corners[:, 2].min()
    feet = body.corners[heights <= LEVEL * body.extent, :2]
    try:
        polygon = ConvexHull(feet)
    except (QhullError, ValueError):
        return None
    return Support(polygon.equations[:, :2], polygon.equations[:, 2])


def margin(body: Body) -> float:
    """Return how far within its support polygon a body's weight acts, metres; minus infinity where it has none."""
    support = support_of(body)
    return -np.inf if support is None else -float(support.outside(body.center[None, :2]).max())


def tipping_loads(body: Body, places: np.ndarray) -> np.ndarray:
    """Return from which load on a body tips, (P,) kg, when set on places (P, 3); infinite where none does.

    About an edge of the support polygon the moments of body and load are equal at the load that tips it.
    """
    support = support_of(body)
    if support is None:
        return np.zeros(len(places))
    own, arms = -support.outside(body.center[None, :2])[0], support.outside(places[:, :2])
    with np.errstate(divide="ignore", invalid="ignore"):
        loads = np.where(arms > 0, np.maximum(own, 0) * body.mass / arms, np.inf)
    return loads.min(axis=1) if own.min() > 0 else np.zeros(len(places))


def evenly_chosen(places: np.ndarray, most: int) -> np.ndarray:
    """Return at most so many of places (P, 3), evenly chosen."""
    return places if len(places) <= most else places[np.arange(most) * len(places) // most]


LetGo = Callable[[Sequence[Body]], list[Stand]]  # what becomes of bodies that are put on the ground, each by itself


def stood(
    body: Body, places: np.ndarray, settings: StandSettings, let_go: LetGo, provenance: dict[str, Any]
) -> StandResult:
    """Return how a body stands alone, and then, in the pose in which it has come to rest, with a load at each place.

    Who puts a chair with uneven legs down puts it on three of them; it is loaded as it then stands.

    Parameters
    ----------
    places : (P, 3) float64, metres, the body's frame as it came
    """
    started, places = time.perf_counter(), evenly_chosen(places, settings.most_places)
    [alone] = let_go([body])
    resting, at = body.turned(alone.turn), places @ alone.turn.T
    loaded = let_go([resting.loaded(settings.load, place) for place in at]) if len(at) else []
    stays = alone.stance in (Stance.STANDS, Stance.ROCKS)
    return StandResult(
        stance=alone.stance,
        tilt_deg=alone.tilt_deg,
        mass=body.mass,
        margin=margin(resting),
        places=places,
        carries=np.array([stays and one.stance is Stance.STANDS for one in loaded], bool),
        tipping_load=tipping_loads(resting, at),
        notes=body.notes,
        seconds=time.perf_counter() - started,
        provenance=provenance,
    )
