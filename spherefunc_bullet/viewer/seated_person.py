"""The drawing of a person who sits on a place: limbs as rods with round ends, which rests on the seat."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..places.place import Place

Rod = tuple[Sequence[float] | np.ndarray, Sequence[float] | np.ndarray, float]  # ends, radius
TALL = 1.75  # metres: the person of the numbers below
SHANK = 0.46  # metres from the knee to the ankle
FOOT = 0.045  # metres: radius of a foot and of a shank
KNEE = np.array([0.42, 0.10, 0.07])
# Ahead, to the left, and up from the seat, metres; of limbs that come in pairs the left one.
SINGLE: tuple[Rod, ...] = (
    ((0.0, 0.0, 0.12), (0.0, 0.0, 0.48), 0.10),  # trunk
    ((0.0, -0.15, 0.55), (0.0, 0.15, 0.55), 0.055),  # shoulders
    ((0.0, 0.0, 0.57), (0.01, 0.0, 0.70), 0.045),  # neck
    ((0.02, 0.0, 0.76), (0.02, 0.0, 0.80), 0.09),  # head
)
PAIRED: tuple[Rod, ...] = (
    ((0.0, 0.06, 0.10), (0.0, 0.08, 0.48), 0.08),  # side of the trunk
    ((0.0, 0.08, 0.07), tuple(KNEE), 0.07),  # thigh
    ((0.0, 0.20, 0.54), (-0.02, 0.23, 0.26), 0.042),  # upper arm
    ((-0.02, 0.23, 0.26), (0.27, 0.13, 0.17), 0.036),  # forearm, with the hand on the thigh
)


@dataclass(frozen=True, eq=False)
class Limb:
    """A rod with round ends, metres."""

    start: np.ndarray  # (3,)
    end: np.ndarray  # (3,)
    radius: float

    def surface(self, step: float) -> np.ndarray:
        """Return a grid of points (rows, columns, 3) on the surface, about so far apart, each row a closed ring."""
        length = np.linalg.norm(self.end - self.start)
        axis = (self.end - self.start) / length
        aside = np.cross(axis, [1.0, 0.0, 0.0] if abs(axis[0]) < 0.9 else [0.0, 1.0, 0.0])
        aside /= np.linalg.norm(aside)
        bow = np.linspace(0, np.pi / 2, 1 + max(2, round(self.radius * np.pi / 2 / step)))
        straight = np.linspace(0, length, 1 + max(1, round(length / step)))[1:-1]
        along = np.concatenate([-self.radius * np.cos(bow), straight, length + self.radius * np.sin(bow)])
        wide = self.radius * np.concatenate([np.sin(bow), np.ones(len(straight)), np.cos(bow)])
        turn = np.linspace(0, 2 * np.pi, 1 + max(8, round(2 * np.pi * self.radius / step)))
        around = np.cos(turn)[:, None] * aside + np.sin(turn)[:, None] * np.cross(axis, aside)
        return self.start + along[:, None, None] * axis + wide[:, None, None] * around

    def holds(self, points: np.ndarray) -> np.ndarray:
        """Return whether points (N, 3) are inside."""
        way = self.end - self.start
        share = np.clip((points - self.start) @ way / (way @ way), 0, 1)
        return np.linalg.norm(points - self.start - share[:, None] * way, axis=1) < 0.98 * self.radius


def seated_person(place: Place, person: float = TALL) -> list[Limb]:
    """Return the limbs of a person, so tall in metres, who sits at a place.

    Both feet are on the ground where the seat is low enough.
    """
    scale = person / TALL
    angle = np.radians(0.0 if place.heading_deg is None else place.heading_deg)
    ahead, left = np.array([np.cos(angle), np.sin(angle), 0.0]), np.array([-np.sin(angle), np.cos(angle), 0.0])
    axes = scale * np.stack([ahead, left, [0.0, 0.0, 1.0]])
    limbs = [*SINGLE]
    for start, end, radius in (*PAIRED, *shank_and_foot(place.height / scale)):
        limbs += [(np.multiply(start, (1, side, 1)), np.multiply(end, (1, side, 1)), radius) for side in (1, -1)]
    return [Limb(place.position + start @ axes, place.position + end @ axes, scale * r) for start, end, r in limbs]


def shank_and_foot(height: float) -> list[Rod]:
    """Return the left shank and foot on a seat of a height above the ground, metres: on a low seat further ahead."""
    down = float(np.clip(height + KNEE[2] - FOOT, 0.1, SHANK))
    ankle = KNEE + [np.sqrt(SHANK**2 - down**2), 0.0, -down]
    return [(KNEE, ankle, FOOT), (ankle, ankle + [0.17, 0.0, 0.0], FOOT)]


def person_faces(limbs: list[Limb]) -> np.ndarray:
    """Return the surface of a person as quadrangles (N, 4, 3)."""
    grids = [limb.surface(0.04) for limb in limbs]
    corners = [np.stack([g[:-1, :-1], g[:-1, 1:], g[1:, 1:], g[1:, :-1]], axis=2).reshape(-1, 4, 3) for g in grids]
    return np.concatenate(corners)


def person_points(limbs: list[Limb], step: float) -> np.ndarray:
    """Return points (N, 3) on the surface of a person, about so far apart."""
    points = []
    for limb in limbs:
        own = limb.surface(step)[:, :-1].reshape(-1, 3)
        inside = np.any([other.holds(own) for other in limbs if other is not limb], axis=0)
        points.append(own[~inside])
    return np.concatenate(points)
