"""Mechanics: stable poses, standing and carrying of an object that is free to move.

They are optional parts of the interface: `require_ability` raises a clear error for a backend without the method.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any, Protocol, runtime_checkable

import numpy as np

from ..clouds.cloud import Cloud
from ..errors import CheckedSettings, InputError, amount, require_amount
from ..formats.units import format_mass
from . import Simulator, backend_entry_points, make_simulator

AREA_DENSITY = 5.0  # kg/m2 of each face: a wooden board 15 mm thick has 10 on its two sides together
LEVEL = 5e-3  # of the extent: points no higher above the lowest corner are on the ground
CARRIED_ACROSS = 16.0  # radii per largest extent: 6 mm for a mug; smaller spheres would stay behind the rim of a tray
OVERLOAD, OVERLOADED = 1000.0, 100.0  # kg, and in own masses: an object that tips under no smaller load never tips
KINDS = {
    "poses": "find poses",
    "stands": "say whether it stands",
    "carry": "carry an object",
    "prove": "prove places",
}


@dataclass(frozen=True, kw_only=True)
class Material(CheckedSettings):
    """Mass and contact properties of an object."""

    area_density: float = amount(AREA_DENSITY, above=0.0)  # kg/m2, of its surface
    mass: float | None = amount(None, above=0.0)  # kg, of the whole; None: from the surface
    friction: float = amount(0.5)  # on the ground, wood on wood
    restitution: float = amount(0.0, most=0.9)  # 1: bounces back completely


@dataclass(frozen=True, kw_only=True)
class PoseSettings(CheckedSettings):
    """How an object is dropped to find its stable poses."""

    drops: int = amount(100, least=1)
    fall: float = amount(0.1)  # of its largest extent: how far its lowest point falls
    matter: Material = field(default_factory=Material)
    # In sqrt(extent / g), after which a drop is given up: 32 s for an extent of 1 m.
    time_limit: float = amount(100.0, above=0.0)
    least: float = amount(0.002, most=1)  # poses that are less likely, by drops and by statics, are omitted


@dataclass(frozen=True, kw_only=True, eq=False)
class Pose:
    """A stable pose, up to a rotation about the vertical."""

    rotation: np.ndarray  # (3, 3), from the cloud's frame to that of the object as it lies, z up
    probability: float  # by the backend
    statics: float  # probability by statics, for motion without speed

    @property
    def tilt_deg(self) -> float:
        """Angle between the object's own z and the vertical."""
        return math.degrees(math.acos(min(1.0, max(-1.0, float(self.rotation[2, 2])))))


@dataclass(frozen=True, kw_only=True, eq=False)
class Result:
    """The common part of all results: notes, seconds and provenance."""

    notes: tuple[str, ...]  # remarks on the object for the user
    seconds: float
    provenance: dict[str, Any] = field(default_factory=dict)


@dataclass(frozen=True, kw_only=True)
class PoseResult(Result):
    """The stable poses of an object, the most probable first."""

    poses: tuple[Pose, ...]
    drops: int  # 0 where nothing was dropped
    timed_out: int  # drops that never came to rest


class Stance(StrEnum):
    """Whether an object stands, leans, tips or rolls when it is put on level ground."""

    STANDS = "stands"  # keeps its given pose, or returns to it, as a bowl with a round bottom does
    ROCKS = "rocks"  # leans over a little, and stands so
    ROLLS = "rolls"  # has no preferred pose, as a ball
    TIPS = "tips"  # ends in another pose
    MOVES = "moves"  # has not come to rest within the time limit


@dataclass(frozen=True, kw_only=True)
class StandSettings(CheckedSettings):
    """How an object is put on the ground, and the load that is put on it."""

    load: float = amount(0.0)  # kg, at each place in turn
    matter: Material = field(default_factory=Material)
    tilt_deg: float = amount(1.0, above=0.0)  # an object with a larger tilt has left its given pose
    rocking_deg: float = 10.0  # an object with a larger tilt has tipped
    time_limit: float = amount(60.0, above=0.0)  # in sqrt(extent / g)
    most_places: int = amount(100, least=1)  # largest number of places for the load, evenly chosen

    def __post_init__(self):
        super().__post_init__()
        require_amount("rocking_deg", self.rocking_deg, least=self.tilt_deg)


@dataclass(frozen=True, kw_only=True, eq=False)
class StandResult(Result):
    """Whether an object stands, alone and with a load."""

    stance: Stance
    tilt_deg: float  # between the given pose and the final one
    mass: float  # kg
    margin: float  # metres from where the weight acts to the nearest edge over which it would tip; negative beyond it
    places: np.ndarray  # (P, 3) of the load, metres, in the frame of the cloud
    carries: np.ndarray  # (P,) bool: whether it keeps, under the load, the pose in which it stands alone
    tipping_load: np.ndarray  # (P,) kg, smallest load at which it leaves its pose by statics; infinite if none does

    @property
    def share(self) -> float | None:
        """Share of the places that can carry the load; None if there are no places."""
        return float(self.carries.mean()) if len(self.carries) else None

    @property
    def tips_from(self) -> float:
        """The smallest load that tips the object at any of the places, kg; infinite if none does."""
        return float(self.tipping_load.min(initial=math.inf))

    @property
    def tipping_words(self) -> str:
        """The smallest tipping load in words; empty if the object does not stand, or no load was put on it."""
        if self.stance not in (Stance.STANDS, Stance.ROCKS) or not len(self.places):
            return ""
        if self.tips_from >= min(OVERLOAD, OVERLOADED * self.mass):
            return "no load tips it"
        return f"tips from {format_mass(self.tips_from)}" if self.tips_from > 0 else "any load tips it"


@dataclass(frozen=True, kw_only=True)
class CarrySettings(CheckedSettings):
    """How a filled object is carried: tilted to all sides, farther each time, and shaken."""

    radius: float | None = amount(None, above=0.0)  # of the spheres, metres; None: by the size of the object
    spheres: int = amount(300, least=1)  # largest number for filling
    fill: float = amount(0.9, above=0.0, most=1.0)  # of the spheres that it holds; a vessel full to the brim spills
    angles_deg: tuple[float, ...] = (15.0, 30.0, 45.0)
    # Speed of tilting and turning: with 1 a turn takes 26 to 120 sqrt(radius / g), with 0.1 ten times as long.
    haste: float = amount(1.0, above=0.0, most=2.0)
    shake: float = amount(0.01)  # metres, amplitude along x, y and z
    frequency: float = amount(3.0, above=0.0)  # Hz
    friction: float = amount(0.5)
    restitution: float = amount(0.0, most=0.9)
    density: float = amount(1000.0, above=0.0)  # kg/m3 of the spheres; it does not influence their motion

    def __post_init__(self):
        super().__post_init__()
        if not self.angles_deg or list(self.angles_deg) != sorted(set(self.angles_deg)):
            raise InputError(f"angles {self.angles_deg}: expected ascending angles, such as 15,30,45")
        for angle in self.angles_deg:
            require_amount("angle", angle, above=0.0, most=180.0)


@dataclass(frozen=True, kw_only=True, eq=False)
class CarryResult(Result):
    """The share of its filling that an object kept."""

    filled: int  # number of spheres in it, without those on its rim, its handle or its saucer
    radius: float  # of the spheres, metres
    holds: float  # volume that spheres cannot leave without rising, relative to that without holes in the walls; 0 to 1
    angles_deg: tuple[float, ...]
    kept: tuple[float, ...]  # share still in it after each angle, relative to its filling without holes
    kept_shaken: float  # share after it was shaken and set down
    centers: np.ndarray  # (S, 3) of the spheres that stayed, metres, in the frame of the object
    weight: float  # kg, of the spheres that stayed


def carry_radius(cloud: Cloud) -> float:
    """Return the default radius of the spheres with which an object is filled, metres."""
    return float(cloud.size.max()) / CARRIED_ACROSS


@runtime_checkable
class SupportsPoses(Protocol):
    """A backend that finds stable poses."""

    def poses(self, cloud: Cloud, settings: PoseSettings, seed: int = 0) -> PoseResult:
        """Return the stable poses of an object; reproducible bit for bit."""
        ...


@runtime_checkable
class SupportsStance(Protocol):
    """A backend that finds whether an object stands."""

    def stands(self, cloud: Cloud, settings: StandSettings, places: np.ndarray, seed: int = 0) -> StandResult:
        """Return whether an object stands in its given pose, and with a load at each of the places (P, 3), metres."""
        ...


@runtime_checkable
class SupportsCarrying(Protocol):
    """A backend that carries a filled object."""

    def carry(self, cloud: Cloud, settings: CarrySettings, seed: int = 0) -> CarryResult:
        """Return the share of its filling that an object keeps."""
        ...


def require_ability(simulator: str | Simulator, ability: str) -> Simulator:
    """Return a simulator that has one of the optional abilities, a key of `KINDS`.

    Raises
    ------
    InputError
        If it lacks the ability.
    """
    simulator = make_simulator(simulator)
    if not callable(getattr(simulator, ability, None)):
        able = ", ".join(able_backends(ability)) or "none that is installed"
        raise InputError(f"backend {simulator.name!r} cannot {KINDS[ability]}: expected one that can: {able}")
    return simulator


def able_backends(ability: str) -> Sequence[str]:
    """Return the names of the registered backends that can be imported and have an ability."""
    able = []
    for name, point in sorted(backend_entry_points().items()):
        with suppress(Exception):  # other packages' code may raise anything
            if callable(getattr(point.load(), ability, None)):
                able.append(name)
    return able
