"""Outlines and paths that solids are made from: circles, rounded rectangles, arcs and bent bars, in metres."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike


def circle(radius: float, sections: int = 24) -> np.ndarray:
    """Return the points of a circle about the origin, (sections, 2), metres."""
    angles = np.linspace(0, 2 * np.pi, sections, endpoint=False)
    return radius * np.stack([np.cos(angles), np.sin(angles)], axis=1)


def arc(radius: float, start_deg: float, end_deg: float, steps: int = 12) -> np.ndarray:
    """Return points of an arc about the origin, (steps + 1, 2), metres."""
    angles = np.radians(np.linspace(start_deg, end_deg, steps + 1))
    return radius * np.stack([np.cos(angles), np.sin(angles)], axis=1)


def superellipse(width: float, depth: float, exponent: float = 2.0, sections: int = 32) -> np.ndarray:
    """Return a rounded outline, (sections, 2), metres: 2 is an ellipse, larger exponents near a rectangle."""
    unit = circle(1.0, sections)
    return np.sign(unit) * np.abs(unit) ** (2 / exponent) * [width / 2, depth / 2]


def rectangle(width: float, depth: float) -> np.ndarray:
    """Return the corners of a rectangle about the origin, (4, 2), metres."""
    return np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * [width / 2, depth / 2]


def rounded_rectangle(width: float, depth: float, corner: float, steps: int = 4) -> np.ndarray:
    """Return a rectangle with round corners of the given radius, (4 (steps + 1), 2), metres."""
    corner = min(corner, 0.499 * width, 0.499 * depth)
    quarter = np.linspace(0, np.pi / 2, steps + 1)
    turns = [quarter + k * np.pi / 2 for k in range(4)]
    middles = rectangle(width - 2 * corner, depth - 2 * corner)[[2, 3, 0, 1]]
    arcs = [m + corner * np.stack([np.cos(t), np.sin(t)], axis=1) for m, t in zip(middles, turns, strict=True)]
    return np.concatenate(arcs)


def outline(shape: str, width: float, depth: float) -> np.ndarray:
    """Return a table top's outline; round ones depend on the width only."""
    return {
        "rectangle": lambda: rounded_rectangle(width, depth, 0.004, steps=1),
        "rounded": lambda: rounded_rectangle(width, depth, 0.25 * min(width, depth), steps=6),
        "round": lambda: circle(width / 2, 40),
        "oval": lambda: superellipse(width, depth, 2.0, 40),
        "boat": lambda: superellipse(width, depth, 3.2, 40),
    }[shape]()


def rounded(path: ArrayLike, rounds: int = 2) -> np.ndarray:
    """Return a path (K, 3) with its inner corners cut off ``rounds`` times (Chaikin's curve)."""
    path = np.asarray(path, dtype=float)
    for _ in range(rounds):
        near, far = 0.75 * path[:-1] + 0.25 * path[1:], 0.25 * path[:-1] + 0.75 * path[1:]
        path = np.concatenate([path[:1], np.stack([near, far], axis=1).reshape(-1, path.shape[1])[1:-1], path[-1:]])
    return path


def arch(half: Sequence[Sequence[float]], rounds: int = 2) -> np.ndarray:
    """Return a rounded path (K, 3) through points on one side of the plane x = 0 and their mirror images."""
    return rounded([*half, *[[-x, y, z] for x, y, z in half[::-1]]], rounds)


def at_height(outline: np.ndarray, z: ArrayLike) -> np.ndarray:
    """Return an outline (N, 2) at one height, or at one height for each point, (N, 3), metres."""
    return np.column_stack([outline, np.full(len(outline), z)])
