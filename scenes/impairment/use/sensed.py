"""Corruptions by sensors: noise, few points, one side, holes, stray patches, a tilted floor (after ModelNet40-C).

Each takes an object's points (N, 3), metres, z up on the ground, a severity and a generator, and returns points.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from spherefunc_bullet.clouds.cloud import corners_of, placed

from ..specimen import level_direction, turn

Corrupt = Callable[[np.ndarray, float, np.random.Generator], np.ndarray]
PIXELS = 240  # across an object in a depth image of it
ELEVATION_DEG = (20.0, 50.0)  # of a camera above the level
LEFT = 100  # points that are left at least


def noise(points: np.ndarray, share: float, rng: np.random.Generator) -> np.ndarray:
    """Move points by a normal deviate along each axis, a share of the object's middle extent."""
    return points + rng.normal(0, share * np.ptp(points, axis=0).mean(), points.shape)


def sparse(points: np.ndarray, share: float, rng: np.random.Generator) -> np.ndarray:
    """Keep a share of the points, at random."""
    count = min(max(int(share * len(points)), LEFT), len(points))
    return points[rng.choice(len(points), count, replace=False)]


def tilt(points: np.ndarray, degrees: float, rng: np.random.Generator) -> np.ndarray:
    """Rotate the object about a random level axis, as a wrong gravity direction does."""
    return points @ turn(np.array([*level_direction(rng.uniform(0, 2 * np.pi)), 0.0]), np.radians(degrees)).T


def scale(points: np.ndarray, factor: float, rng: np.random.Generator) -> np.ndarray:
    """Scale the object."""
    return factor * points


def shear(points: np.ndarray, slope: float, rng: np.random.Generator) -> np.ndarray:
    """Shift each height along a level direction, in proportion to the height."""
    return points + np.outer(slope * points[:, 2], [*level_direction(rng.uniform(0, 2 * np.pi)), 0.0])


def outliers(points: np.ndarray, share: float, rng: np.random.Generator) -> np.ndarray:
    """Add stray points anywhere in a box around the object."""
    low, high = corners_of(points)
    margin = 0.05 * (high - low)
    stray = rng.uniform(low - margin * [1, 1, 0], high + margin, (int(share * len(points)), 3))
    return np.concatenate([points, stray])


def holes(points: np.ndarray, count: float, rng: np.random.Generator) -> np.ndarray:
    """Remove round patches whose radius is a twenty-fifth of the largest extent."""
    radius = 0.04 * np.ptp(points, axis=0).max()
    for place in points[rng.choice(len(points), round(count))]:
        left = np.linalg.norm(points - place, axis=1) > radius
        points = points[left] if left.sum() > LEFT else points
    return points


def crumbs(points: np.ndarray, count: float, rng: np.random.Generator) -> np.ndarray:
    """Add patches of the floor around its foot and of neighbours at its side."""
    low, high = corners_of(points)
    size, parts = high - low, [points]
    spacing = np.sqrt((size[0] * size[1] + size[2] * (size[0] + size[1])) / len(points))
    for _ in range(round(count)):
        side = rng.uniform(0.05, 0.15) * size.max()
        steps = np.arange(0, side, max(spacing, side / 60))
        patch = np.stack(np.meshgrid(steps, steps), axis=-1).reshape(-1, 2)
        out = level_direction(rng.uniform(0, 2 * np.pi))
        foot = (low + high)[:2] / 2 + out * 0.5 * size[:2]
        if rng.uniform() < 0.6:
            parts.append(np.column_stack([patch + foot, np.full(len(patch), low[2])]))
        else:
            across = np.outer(patch[:, 0], [-out[1], out[0]]) + foot + 0.02 * size.max() * out
            bottom = rng.uniform(low[2], max(low[2], high[2] - 0.5 * side))
            parts.append(np.column_stack([across, patch[:, 1] + bottom]))
    return np.concatenate(parts)


def views(points: np.ndarray, count: float, rng: np.random.Generator) -> np.ndarray:
    """Keep the points that this many cameras see, which look down on the object from around it."""
    start, seen = rng.uniform(0, 2 * np.pi), np.zeros(len(points), bool)
    for number in range(round(count)):
        azimuth = start + number * 2 * np.pi / round(count) + rng.uniform(-0.3, 0.3)
        elevation = np.radians(rng.uniform(*ELEVATION_DEG))
        seen |= visible(points, np.array([*(np.cos(elevation) * level_direction(azimuth)), np.sin(elevation)]))
    return points[seen]


def visible(points: np.ndarray, toward: np.ndarray) -> np.ndarray:
    """Return which points (N, 3) are seen from far away in a direction (3,), the nearest in each pixel, (N,) bool."""
    right = np.array([-toward[1], toward[0], 0.0]) / np.hypot(*toward[:2])
    image = points @ np.column_stack([right, np.cross(toward, right)])
    pixel = max(np.ptp(image, axis=0).max() / PIXELS, 1.2 * np.sqrt(np.ptp(image, axis=0).prod() / len(points)))
    cells = np.floor((image - image.min(axis=0)) / pixel).astype(np.int64) + 1
    depth, nearest = points @ toward, np.full(cells.max(axis=0) + 2, -np.inf)
    np.maximum.at(nearest, tuple(cells.T), depth)
    around = np.max([np.roll(nearest, shift, axis=(0, 1)) for shift in ((0, 1), (1, 0), (0, -1), (-1, 0))], axis=0)
    front = np.maximum(nearest, around - 3 * pixel)
    return depth > front[tuple(cells.T)] - 2.5 * pixel


CORRUPTIONS: dict[str, tuple[Corrupt, tuple[float, ...]]] = {  # with the parameter of each of five severities
    "noise": (noise, (0.005, 0.01, 0.02, 0.03, 0.04)),
    "sparse": (sparse, (0.5, 0.25, 0.1, 0.05, 0.025)),
    "views": (views, (4, 3, 2, 1, 1)),
    "one_view": (views, (1, 1, 1, 1, 1)),
    "holes": (holes, (5, 10, 20, 40, 80)),
    "outliers": (outliers, (0.005, 0.01, 0.02, 0.05, 0.1)),
    "crumbs": (crumbs, (1, 2, 3, 5, 8)),
    "tilt": (tilt, (1, 2.5, 5, 7.5, 10)),
    "shear": (shear, (0.03, 0.06, 0.1, 0.15, 0.2)),
    "scale": (scale, (1.05, 1.1, 1.15, 1.2, 1.3)),
}


def corrupted(points: np.ndarray, kind: str, severity: int, rng: np.random.Generator) -> np.ndarray:
    """Return points (N, 3) as a sensor gives them, with one corruption of severity 1 to 5."""
    corrupt, levels = CORRUPTIONS[kind]
    return placed(corrupt(points, levels[severity - 1], rng))
