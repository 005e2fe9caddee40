"""Closed bodies that are added to objects: boxes, discs, fillings, spikes; triangles (T, 3, 3) in metres."""

from __future__ import annotations

import numpy as np

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
    walls = [wall for lower, upper in zip(rings, rings[1:], strict=False) for wall in between(lower, upper)]
    return np.concatenate([*walls, fan(rings[0][::-1]), fan(rings[-1])])


def between(lower: np.ndarray, upper: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the triangles between two rings."""
    next_lower, next_upper = np.roll(lower, -1, axis=0), np.roll(upper, -1, axis=0)
    return np.stack([lower, next_lower, upper], axis=1), np.stack([next_lower, next_upper, upper], axis=1)


def fan(ring: np.ndarray) -> np.ndarray:
    """Return the triangles of a convex outline (K, 3) about its middle."""
    middle = np.broadcast_to(ring.mean(axis=0), ring.shape)
    return np.stack([ring, np.roll(ring, -1, axis=0), middle], axis=1)


def spike(centre: np.ndarray, base: float, foot: float, tip: float) -> np.ndarray:
    """Return a pyramid over a square of side ``base`` about a place (2,), from one height to another."""
    ring = rectangle(centre - base / 2, centre + base / 2, foot)
    top = np.broadcast_to([*centre, tip], ring.shape)
    return np.concatenate([np.stack([ring, np.roll(ring, -1, axis=0), top], axis=1), fan(ring[::-1])])
