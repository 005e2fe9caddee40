"""Where an object is put: its place and heading, and its height, or what carries it there."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np

from spherefunc_bullet.clouds.cloud import Cloud, Mesh
from spherefunc_bullet.clouds.preparation import headed, turned
from spherefunc_bullet.errors import CheckedSettings, InputError, amount, explaining

from .surfaces import WorldSurface, surface_of

WANTED = "FILE@x,y or FILE@x,y,z or FILE@x,y,z,heading, in metres and degrees, z empty to set it down"


@dataclass(frozen=True, kw_only=True)
class Placement(CheckedSettings):
    """Where the middle of an object's footprint goes, and at which height its foot."""

    x: float = amount(0.0, least=-1e6, most=1e6)  # metres
    y: float = amount(0.0, least=-1e6, most=1e6)
    # Metres above the ground; None: lowered from above until something carries it.
    z: float | None = amount(None, most=1e6)
    heading_deg: float = amount(0.0, least=-math.inf)  # counterclockwise about the vertical


def parse_placed(text: str) -> tuple[Path, Placement]:
    """Return the file and the placement of ``FILE[@x,y[,z[,heading]]]``; without a place, in the middle.

    Raises
    ------
    InputError
        If what follows the last @ is no place.

    Examples
    --------
    >>> parse_placed("mug.ply@0.1,0.2,,90")
    (PosixPath('mug.ply'), Placement(x=0.1, y=0.2, z=None, heading_deg=90.0))
    >>> parse_placed("mug.ply")[1].z is None
    True
    """
    file, mark, place = text.rpartition("@")
    if not mark or Path(text).exists():
        return Path(text), Placement()
    parts = [part.strip() for part in place.split(",")]
    if not 2 <= len(parts) <= 4:
        raise InputError(f"{text}: expected {WANTED}; got {len(parts)} numbers")
    x, y = number(text, parts[0]), number(text, parts[1])
    z = number(text, parts[2]) if len(parts) > 2 and parts[2] else None
    heading = number(text, parts[3]) if len(parts) > 3 else 0.0
    with explaining(text, InputError, why=": "):
        return Path(file), Placement(x=x, y=y, z=z, heading_deg=heading)


def number(text: str, part: str) -> float:
    """Return a part of a placement as a number."""
    with explaining(f"{text}: expected {WANTED}; got {part!r} for a number", ValueError):
        return float(part)


@dataclass(frozen=True, eq=False)
class ArrangedObject:
    """An object in its place; its own frame is that of its cloud, the world's that of all of them."""

    name: str  # no other object of the arrangement has it
    own: Cloud
    placement: Placement
    height: float  # metres, of its foot above the ground

    @property
    def shift(self) -> np.ndarray:
        """Where its frame's origin is in the world, (3,) metres."""
        return np.array([self.placement.x, self.placement.y, self.height])

    @cached_property
    def turn(self) -> np.ndarray:
        """The rotation (3, 3) from its own frame to the world's."""
        angle = math.radians(self.placement.heading_deg)
        return np.array([[math.cos(angle), -math.sin(angle), 0], [math.sin(angle), math.cos(angle), 0], [0, 0, 1.0]])

    @cached_property
    def cloud(self) -> Cloud:
        """The object in the world's frame."""
        mesh = self.own.mesh
        placed = None if mesh is None else Mesh(self.to_world(mesh.vertices), mesh.faces)
        return Cloud(self.to_world(self.own.points), self.name, placed)

    @cached_property
    def surface(self) -> WorldSurface:
        """Its surface in the world's frame, for objects above or below it."""
        return surface_of(self.cloud)

    def to_world(self, points: np.ndarray) -> np.ndarray:
        """Return points (N, 3) of its own frame in the world's."""
        return points @ self.turn.T + self.shift

    def to_own(self, points: np.ndarray) -> np.ndarray:
        """Return points (N, 3) of the world's frame in its own."""
        return (points - self.shift) @ self.turn

    def over(self, columns: np.ndarray) -> np.ndarray:
        """Return which columns (D, 2) of the world's frame meet its own box, (D,) bool."""
        low, high = self.own.bounds[:, :2]
        places = (columns - self.shift[:2]) @ self.turn[:2, :2]
        return ((places >= low) & (places <= high)).all(axis=1)

    def at(self, height: float) -> ArrangedObject:
        """Return the object with its foot at another height, metres."""
        return replace(self, height=height)

    def turned(self, angle: float) -> ArrangedObject:
        """Return the object rotated about the world's vertical axis by an angle, radians, counterclockwise."""
        x, y = turned(self.shift[None, :2], angle)[0]
        heading_deg = self.placement.heading_deg + math.degrees(angle)
        return replace(self, placement=replace(self.placement, x=float(x), y=float(y), heading_deg=heading_deg))


def along_heading(objects: Sequence[ArrangedObject], number: int) -> tuple[list[ArrangedObject], float]:
    """Return objects rotated together so that one of them lies along its heading, and the angle of its own frame.

    Spheres then fall on the narrowest rectangle around that object, as they do on it alone (`preparation.headed`). Its
    own frame is rotated by the angle, radians.
    """
    target = objects[number]
    own, angle = headed(target.own)
    whole = angle - math.radians(target.placement.heading_deg)
    around = [item.turned(whole) if whole else item for item in objects]
    around[number] = replace(around[number], own=own, placement=replace(around[number].placement, heading_deg=0.0))
    return around, angle
