"""How a body can lie, and how likely each pose is where nothing has speed (Goldberg et al., IJRR 1999).

A body that is let down meets the ground with the facet that the vertical through its centre of mass goes through, and
rolls from there, always down, until its weight acts within the facet it is on. `trimesh.poses` computes the same, and
tests compare the two; here facets are also grouped into ways to lie, by which an engine's drops are counted.
"""

from __future__ import annotations

import numpy as np

from ..mechanics import Pose, PoseSettings
from .facets import SILL, TURN_DEG, Facets

AWAY_DEG = 3.0  # from every facet it could rest on: a body that is still so far off is balanced, not at rest


def stable_poses(facets: Facets, settings: PoseSettings, counts: np.ndarray | None = None) -> tuple[Pose, ...]:
    """Return the poses that are likely enough, the likeliest first.

    Parameters
    ----------
    counts : (W,) float, optional
        Share of an engine's drops that ended in each way to lie; without it statics is the answer.
    """
    statics = np.bincount(facets.pose_numbers, weights=facets.solid_angles())
    shares = statics if counts is None else counts
    likely = [
        number
        for number in np.unique(facets.pose_numbers[facets.stable])
        if max(shares[number], statics[number]) >= settings.least
    ]
    poses = [
        Pose(
            rotation=turned_down(facets.normals[facets.lowest(number)]),
            probability=float(shares[number]),
            statics=float(statics[number]),
        )
        for number in likely
    ]
    return tuple(sorted(poses, key=lambda pose: (-round(pose.probability, 9), -round(pose.statics, 9))))


def counted(facets: Facets, down: np.ndarray) -> np.ndarray:
    """Return in which share of rests, directions (N, 3) that point down, a body lay in each way, (W,)."""
    pose_numbers = facets.pose_numbers[facets.nearest(down)] if len(down) else np.empty(0, np.int64)
    return np.bincount(pose_numbers, minlength=facets.pose_numbers.max() + 1) / max(1, len(down))


def at_rest(facets: Facets, down: np.ndarray) -> np.ndarray:
    """Return which directions (N, 3) that point down are those of a body that rests and is not balanced, (N,) bool.

    What is round may be held between two of its facets, by friction of rolling, hardly higher than on either.
    """
    nearest = facets.nearest(down)
    turn = np.einsum("ni,ni->n", down, facets.normals[nearest])
    rise = (down @ facets.corners.T).max(axis=1) - facets.heights[nearest]
    between = (turn > np.cos(np.radians(TURN_DEG / 2))) & (rise < SILL * facets.heights[nearest])
    return between | (turn > np.cos(np.radians(AWAY_DEG)))


def turned_down(down: np.ndarray) -> np.ndarray:
    """Return the shortest rotation (3, 3) after which a direction (3,) points down.

    Examples
    --------
    >>> turned_down(np.array([0.0, 0.0, -1.0])).tolist()
    [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
    """
    up = -np.asarray(down, float)
    if up[2] < -1 + 1e-9:
        return np.diag([1.0, -1.0, -1.0])
    x, y, z = up
    lean = 1 / (1 + z)
    rotation = np.array([[1 - x * x * lean, -x * y * lean, -x], [-x * y * lean, 1 - y * y * lean, -y], [x, y, z]])
    return rotation + 0.0
