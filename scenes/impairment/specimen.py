"""An object that is to be impaired or harmlessly changed, and what makes it work."""

from __future__ import annotations

import zlib
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, wraps
from itertools import pairwise
from typing import Any

import numpy as np

from spherefunc_bullet.clouds.cloud import Cloud

from .levels import Cavity, LevelPart, find_cavity, find_level
from .surfaces import ObjectSurface, surface_of

HEIGHTS = {"sittable": (0.15, 0.95), "table": (0.2, 1.3)}  # metres: of seats, of table tops


@dataclass(frozen=True, eq=False)
class Specimen:
    """A whole object with its function and the part that serves it."""

    cloud: Cloud
    function: str

    @cached_property
    def surface(self) -> ObjectSurface:
        """The object's triangles, or its points."""
        return surface_of(self.cloud)

    @cached_property
    def level(self) -> LevelPart | None:
        """The seat or the table top, where one is found."""
        return find_level(self.surface, *HEIGHTS[self.function]) if self.function in HEIGHTS else None

    @cached_property
    def cavity(self) -> Cavity | None:
        """The cavity that holds water, where it is a cup and has one."""
        return find_cavity(self.surface) if self.function == "cup" else None

    @cached_property
    def back(self) -> np.ndarray | None:
        """Level unit vector (2,) from the seat's middle towards the back that rises above it, None without a back.

        It is along x or y, whichever is nearer, since furniture is rectangular.
        """
        seat, centres = self.level, self.surface.centres
        above = centres[:, 2] > seat.upper + 0.15
        if above.sum() < 0.02 * len(centres):
            return None
        toward = centres[above, :2].mean(axis=0) - seat.box.mean(axis=0)
        if np.abs(toward).max() < 0.1 * (seat.box[1] - seat.box[0]).min():
            return None
        axis = int(np.abs(toward).argmax())
        return np.sign(toward[axis]) * np.eye(2)[axis]


FUNCTIONS = ("cup", "sittable", "table")
NONE = "none"  # of objects without any of them
Change = Callable[[Specimen, np.random.Generator], ObjectSurface | None]


@dataclass(frozen=True, kw_only=True)
class Impairment:
    """One kind of change."""

    kind: str
    functions: tuple[str, ...]  # of the objects that it is made of
    works: bool  # whether a changed object still has its function
    change: Change  # returns None where it cannot be made of an object

    def applied(self, specimen: Specimen, name: str, seed: int) -> ObjectSurface | None:
        """Return a changed copy, standing on the ground, or None; the same seed gives the same bits.

        Each object and kind has a random stream of its own, so that adding one changes no others.
        """
        rng = np.random.default_rng([seed, zlib.crc32(name.encode()), zlib.crc32(self.kind.encode())])
        changed = self.change(specimen, rng)
        return None if changed is None else changed.standing()


def kinds(functions: tuple[str, ...], works: bool, **changes: Change) -> list[Impairment]:
    """Return kinds of change of objects with some functions, each under its name; see `Impairment`."""
    return [Impairment(kind=kind, functions=functions, works=works, change=change) for kind, change in changes.items()]


def needs(part: str, *, triangles: bool = False, useless: bool = False) -> Callable[[Callable[..., Any]], Change]:
    """Return a decorator that passes a specimen's part, ``level`` or ``cavity``, to a change.

    The decorated change returns None where the specimen has no such part, where ``triangles`` are needed and it has
    points alone, and where a copy that has to be ``useless`` still has a part that serves.
    """

    def of_part(change: Callable[..., ObjectSurface | None]) -> Change:
        """Return a change of whole specimens."""

        @wraps(change)
        def applied(specimen: Specimen, rng: np.random.Generator, **options: Any) -> ObjectSurface | None:
            """Return the changed surface, or None where the change cannot be made."""
            value = getattr(specimen, part)
            if value is None or (triangles and specimen.surface.is_cloud):
                return None
            changed = change(specimen, value, rng, **options)
            return None if changed is None or (useless and value.is_left_in(changed)) else changed

        return applied

    return of_part


ROUND = 32  # corners of a circle


def circle(centre: np.ndarray, radius: float, height: float) -> np.ndarray:
    """Return the corners (ROUND, 3) of a level circle about a place (2,)."""
    angles = np.linspace(0, 2 * np.pi, ROUND, endpoint=False)
    level = np.asarray(centre)[:2] + radius * np.column_stack([np.cos(angles), np.sin(angles)])
    return np.column_stack([level, np.full(ROUND, height)])


def rectangle(low: np.ndarray, high: np.ndarray, height: float) -> np.ndarray:
    """Return the corners (4, 3) of a level rectangle between two places (2,)."""
    corners = [(low[0], low[1]), (high[0], low[1]), (high[0], high[1]), (low[0], high[1])]
    return np.array([(x, y, height) for x, y in corners])


def box(low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Return a box between two corners (3,)."""
    return loft([rectangle(low, high, low[2]), rectangle(low, high, high[2])])


def loft(rings: list[np.ndarray]) -> np.ndarray:
    """Return the closed body through level rings (K, 3) of convex outline, from the lowest to the highest."""
    parts = []
    for lower, upper in pairwise(rings):
        next_lower, next_upper = np.roll(lower, -1, axis=0), np.roll(upper, -1, axis=0)
        parts += [
            np.stack(corners, axis=1) for corners in ((lower, next_lower, upper), (next_lower, next_upper, upper))
        ]
    return np.concatenate([*parts, fan(rings[0][::-1]), fan(rings[-1])])


def fan(ring: np.ndarray) -> np.ndarray:
    """Return the triangles of a convex outline (K, 3) about its middle."""
    middle = np.broadcast_to(ring.mean(axis=0), ring.shape)
    return np.stack([ring, np.roll(ring, -1, axis=0), middle], axis=1)


def spike(centre: np.ndarray, base: float, foot: float, tip: float) -> np.ndarray:
    """Return a pyramid over a square of side ``base`` about a place (2,), from one height to another."""
    ring = rectangle(centre - base / 2, centre + base / 2, foot)
    top = np.broadcast_to([*centre, tip], ring.shape)
    return np.concatenate([np.stack([ring, np.roll(ring, -1, axis=0), top], axis=1), fan(ring[::-1])])


def turn(axis: np.ndarray, angle: float) -> np.ndarray:
    """Return the rotation matrix (3, 3) by an angle, radians, about a unit vector (3,)."""
    x, y, z = axis
    across = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * across + (1 - np.cos(angle)) * across @ across


def turned(surface: ObjectSurface, rotation: np.ndarray) -> ObjectSurface:
    """Return a surface rotated (3, 3), and standing on the ground again."""
    return surface.mapped(lambda points: points @ rotation.T).standing()


def upside_down(surface: ObjectSurface, rng: np.random.Generator) -> ObjectSurface:
    """Return a surface turned over, about x or about y."""
    return turned(surface, turn(np.eye(3)[rng.integers(2)], np.pi))


def laid(surface: ObjectSurface, toward: np.ndarray) -> ObjectSurface:
    """Return a surface laid on the side that a level unit vector (2,) points to."""
    return turned(surface, turn(np.array([-toward[1], toward[0], 0.0]), np.pi / 2))


def level_direction(angle: float) -> np.ndarray:
    """Return the level unit vector (2,) at an angle from +x, radians."""
    return np.array([np.cos(angle), np.sin(angle)])
