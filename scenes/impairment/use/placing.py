"""Objects put down on a level: where they have room, each beside the others."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np

from ..levels import Level
from ..poses import turn
from ..surfaces import Surface

TRIES = 30  # places and headings that are tried for each
BESIDE = 0.01  # metres between neighbours' circles


@dataclass(eq=False)
class Placed:
    """What lies on a level."""

    surface: Surface
    level: Level
    parts: list[np.ndarray] = field(default_factory=list)  # triangles (T, 3, 3)
    circles: list[tuple[np.ndarray, float]] = field(default_factory=list)  # middle (2,), radius, metres

    def put(self, triangles: np.ndarray, rng: np.random.Generator, near: np.ndarray | None = None) -> bool:
        """Put an object down at a random place (near one, if that is given); return whether there was room."""
        places = self.level.grid.places(self.level.flat)
        for _ in range(TRIES):
            middle = places[rng.integers(len(places))] if near is None else near + rng.normal(0, 0.04, 2)
            turned = triangles @ turn(np.array([0.0, 0, 1]), rng.uniform(0, 2 * np.pi)).T
            corners = turned.reshape(-1, 3)[:, :2] + middle
            if self._has_room(corners, middle):
                self.parts.append(turned + [*middle, self._height(corners)])
                self.circles.append((middle, self._reach(corners, middle)))
                return True
        return False

    def _has_room(self, corners: np.ndarray, middle: np.ndarray) -> bool:
        """Return whether what reaches to these places (N, 2) lies on the level and beside all others."""
        level = self.level
        low, high = level.box - [[0.03], [-0.03]]
        within = ((corners > low) & (corners < high)).all()
        on_level = level.cells[level.grid.cells_of(corners)].mean() > 0.9
        reach = self._reach(corners, middle)
        apart = all(np.linalg.norm(middle - other) > reach + radius + BESIDE for other, radius in self.circles)
        return bool(within and on_level and apart)

    def _height(self, corners: np.ndarray) -> float:
        """Return the height of the level under these places, metres."""
        x, y = self.level.grid.cells_of(corners)
        inside = np.zeros(self.level.flat.shape, bool)
        inside[x.min() : x.max() + 1, y.min() : y.max() + 1] = True
        tops = self.level.grid.tops(self.surface.centres)[inside & self.level.flat]
        return float(tops.max()) if len(tops) else self.level.height

    @staticmethod
    def _reach(corners: np.ndarray, middle: np.ndarray) -> float:
        return 0.9 * float(np.linalg.norm(corners - middle, axis=1).max())

    def joined(self) -> Surface | None:
        """Return the surface with all that was put down; None where nothing was."""
        return self.surface.joined(Surface(np.concatenate(self.parts))) if self.parts else None


def with_objects(
    surface: Surface, level: Level, objects: Iterable[np.ndarray], rng: np.random.Generator
) -> Surface | None:
    """Return a surface with objects, triangles (T, 3, 3) about the origin, put down on a level; None without room."""
    placed = Placed(surface, level)
    for triangles in objects:
        placed.put(triangles, rng)
    return placed.joined()
