"""Which places of a room are filled: by cubes of two centimetres, so that objects may touch but not cross."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

SIDE = 0.02  # metres, of a cube; surfaces are sampled every 5 mm, so nothing slips through
_GRAZE = 1e-6  # metres below the floor that rounding may put a point


@dataclass(frozen=True, eq=False)
class Occupancy:
    """How many objects fill each cube of a room, from its corner at the origin."""

    counts: np.ndarray  # (X, Y, Z) int8

    @classmethod
    def of(cls, size: np.ndarray, clouds: Iterable[np.ndarray]) -> Occupancy:
        """Return the occupancy of a room of a size (3,) that holds clouds (N, 3), metres."""
        occupancy = cls(np.zeros(np.ceil(np.asarray(size) / SIDE).astype(int), np.int8))
        for points in clouds:
            occupancy.fill(points)
        return occupancy

    def fill(self, points: np.ndarray):
        """Add an object's points (N, 3), metres."""
        self.add(points, 1)

    def clear(self, points: np.ndarray):
        """Take an object's points (N, 3), metres, away, which were filled before."""
        self.add(points, -1)

    def add(self, points: np.ndarray, count: int):
        """Count an object (N, 3) once in every cube of the room that it has points in."""
        cubes = np.floor((points + _GRAZE) / SIDE).astype(np.int64)
        cubes = cubes[((cubes >= 0) & (cubes < self.counts.shape)).all(axis=1)]
        if not len(cubes):
            return
        low, high = cubes.min(axis=0), cubes.max(axis=0) + 1
        own = np.zeros(high - low, np.int8)
        own[tuple((cubes - low).T)] = count
        self.counts[tuple(slice(a, b) for a, b in zip(low, high, strict=True))] += own

    def is_free(self, points: np.ndarray) -> bool:
        """Return whether points (N, 3), metres, all lie in the room and in no filled cube."""
        cubes = np.floor((points + _GRAZE) / SIDE).astype(np.int64)
        inside = ((cubes >= 0) & (cubes < self.counts.shape)).all()
        return bool(inside and not self.counts[tuple(cubes.T)].any())


def raised(points: np.ndarray) -> np.ndarray:
    """Return points (N, 3) without those of the lowest two cubes: what they stand on may reach into these."""
    return points[points[:, 2] > points[:, 2].min() + 2 * SIDE]
