"""Standing: the centre of mass relative to the support polygon, with and without a load.

Statics is exact for a rigid body that is put down on level ground without speed: it keeps its pose if its weight acts
within the support polygon, and otherwise rolls over an edge. On a round bottom it leans until its weight acts above the
point of contact.
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
from .facets import Facets, facets_of, turned_down
from .round_bottoms import rest_at

DOWN = np.array([[0.0, 0.0, -1.0]])
HEAVIEST, LIGHTEST = 1e4, 1e-3  # in masses of the body: range of loads for a body with a round bottom
FINE = 0.01  # relative accuracy of that load


@dataclass(frozen=True, kw_only=True)
class StandState:
    """The stance of a body that is put on the ground."""

    stance: Stance
    tilt_deg: float
    down: np.ndarray  # (3,) final direction of the body that points down; NaN if unknown
    flat: bool  # on a face of its hull, for which statics is exact

    @property
    def stays(self) -> bool:
        """Whether it keeps its given pose, or leans a little."""
        return self.stance in (Stance.STANDS, Stance.ROCKS)

    @property
    def turn(self) -> np.ndarray:
        """The rotation (3, 3) from its given pose to that in which it stands; identity if it does not stand."""
        return turned_down(self.down) if self.stays else np.eye(3)

    def or_by(self, engine: StandState) -> StandState:
        """Return the result of an engine, unless it is unknown, or the body stands although it tips by statics."""
        overruled = engine.stance is Stance.MOVES or (self.stance is Stance.TIPS and engine.stays)
        return self if overruled else engine


def stand(body: Body, settings: StandSettings) -> StandState:
    """Return the stance of a body that is put on the ground in its given pose."""
    return stance_of_body(facets_of(body), settings)


def stance_of_body(facets: Facets, settings: StandSettings) -> StandState:
    """Return the stance of a body, given its facets."""
    return stance_at(facets, facets.normals[facets.rests_on[facets.pierced(DOWN)][0]], settings)


def stance_at(facets: Facets, down: np.ndarray, settings: StandSettings) -> StandState:
    """Return the stance of a body that has come to rest with a direction (3,) pointing down."""
    rest = rest_at(facets, int(facets.nearest(down[None])[0]))
    tilt = float(np.degrees(np.arccos(np.clip(-rest.down[2], -1, 1))))
    leans = tilt > settings.tilt_deg
    stance = Stance.TIPS if tilt > settings.rocking_deg else Stance.ROCKS if leans else Stance.STANDS
    return StandState(stance=Stance.ROLLS if rest.rolls else stance, tilt_deg=tilt, down=rest.down, flat=rest.flat)


def beyond_support(body: Body, places: np.ndarray) -> np.ndarray | None:
    """Return how far places (P, 2) lie beyond each edge of the support polygon of a body, (P, E) metres.

    The values are negative inside; the result is None if the body stands on a point or a line.
    """
    heights = body.corners[:, 2] - body.corners[:, 2].min()
    feet = body.corners[heights <= LEVEL * body.extent, :2]
    try:
        edges = ConvexHull(feet).equations
    except (QhullError, ValueError):
        return None
    return places @ edges[:, :2].T + edges[:, 2]


def margin(body: Body) -> float:
    """Return the distance of the centre of mass inside the support polygon, metres; minus infinity without one."""
    beyond = beyond_support(body, body.center[None, :2])
    return -np.inf if beyond is None else -float(beyond.max())


def tipping_loads(body: Body, places: np.ndarray) -> np.ndarray:
    """Return the smallest load (P,) kg that tips a body at each of the places (P, 3); infinite if none does.

    At this load, the moments of body and load about an edge of the support polygon are equal.
    """
    beyond, arms = beyond_support(body, body.center[None, :2]), beyond_support(body, places[:, :2])
    if beyond is None:
        return np.zeros(len(places))
    body_moment = -beyond[0]
    with np.errstate(divide="ignore", invalid="ignore"):
        loads = np.where(arms > 1e-9, np.maximum(body_moment, 0) * body.mass / arms, np.inf)
    return loads.min(axis=1) if body_moment.min() > 0 else np.zeros(len(places))


@dataclass(frozen=True, eq=False)
class LoadedBody:
    """A standing body on which loads are put."""

    body: Body
    facets: Facets
    settings: StandSettings

    def stand(self, load: float, place: np.ndarray) -> StandState:
        """Return the stance under a load in kg at a place (3,)."""
        shift = (self.body.loaded(load, place).center - self.body.center) / self.body.extent
        return stance_of_body(self.facets.about(shift), self.settings)

    def bearable(self, place: np.ndarray) -> float:
        """Return the load in kg up to which a body with a round bottom, which leans gradually, keeps its pose."""
        low, high = 0.0, HEAVIEST * self.body.mass
        if self.stand(high, place).stance is Stance.STANDS:
            return np.inf
        while high - low > FINE * high:
            middle = np.sqrt(high * max(low, FINE * high))
            low, high = (middle, high) if self.stand(middle, place).stance is Stance.STANDS else (low, middle)
            if high < LIGHTEST * self.body.mass:
                return 0.0
        return low


def evenly_chosen(places: np.ndarray, most: int) -> np.ndarray:
    """Return at most ``most`` of places (P, 3), evenly chosen."""
    return places if len(places) <= most else places[np.arange(most) * len(places) // most]


# Returns the stances of bodies that are released on the ground, each by itself.
LetGo = Callable[[Sequence[Body]], list[StandState]]


def loaded_stances(
    body: Body, places: np.ndarray, settings: StandSettings, provenance: dict[str, Any], let_go: LetGo | None = None
) -> StandResult:
    """Return how a body stands alone and then, in the pose in which it has come to rest, with a load at each place.

    A chair with uneven legs, for instance, is loaded as it stands on three of them. A body that tips by statics carries
    nothing, whatever an engine computes.

    Parameters
    ----------
    places : (P, 3) float64, metres, in the frame of the body in its given pose
    let_go : callable, optional
        An engine, used where statics is not exact: for bodies that do not stand on a face of their hull.
    """
    started, places = time.perf_counter(), evenly_chosen(places, settings.most_places)
    alone = stand(body, settings)
    if let_go is not None and not (alone.flat and alone.stance is Stance.STANDS):
        alone = alone.or_by(let_go([body])[0])
    resting, at = body.turned(alone.turn), places @ alone.turn.T
    carries, tipping = carried(resting, at, alone, settings, let_go)
    return StandResult(
        stance=alone.stance,
        tilt_deg=alone.tilt_deg,
        mass=body.mass,
        margin=margin(resting) if alone.flat else -np.inf,
        places=places,
        carries=carries,
        tipping_load=tipping,
        notes=body.notes,
        seconds=time.perf_counter() - started,
        provenance=provenance,
    )


def carried(
    resting: Body, places: np.ndarray, alone: StandState, settings: StandSettings, let_go: LetGo | None
) -> tuple[np.ndarray, np.ndarray]:
    """Return whether a body carries the load at each place (P, 3), (P,) bool, and its tipping load there, (P,) kg."""
    if not alone.stays or not len(places):
        return np.zeros(len(places), bool), np.zeros(len(places))
    loaded = LoadedBody(resting, facets_of(resting), settings)
    under = [loaded.stand(settings.load, place) for place in places]
    tipping = tipping_loads(resting, places) if alone.flat else np.array([loaded.bearable(place) for place in places])
    carries = np.array([stance.stance is Stance.STANDS for stance in under]) & (settings.load <= tipping)
    tested = [k for k, stance in enumerate(under) if carries[k] and not stance.flat]
    if let_go is not None and tested:
        engine = let_go([resting.loaded(settings.load, places[k]) for k in tested])
        carries[tested] = [stance.stance is Stance.STANDS for stance in engine]
    return carries, tipping
