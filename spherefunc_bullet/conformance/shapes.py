"""Shapes with known resting places: regular lattices of points, 4 mm apart, as clouds."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ..clouds.cloud import Cloud

SPACING = 0.004  # metres; the paper's half centimetre allows up to 5 mm from any surface location to a point


def steps(length: float) -> np.ndarray:
    """Return offsets along a length, both ends included, at most SPACING apart."""
    return np.linspace(0, length, int(np.ceil(length / SPACING - 1e-9)) + 1)


def sheet(corner: ArrayLike, along: ArrayLike, across: ArrayLike) -> np.ndarray:
    """Return the lattice (N, 3) of the rectangle spanned by two sides, metres, from a corner."""
    along, across = np.asarray(along, float), np.asarray(across, float)
    a, b = (steps(np.linalg.norm(side)) / np.linalg.norm(side) for side in (along, across))
    return np.asarray(corner, float) + (a[:, None, None] * along + b[None, :, None] * across).reshape(-1, 3)


def level(width: float, depth: float, height: float) -> np.ndarray:
    """Return the lattice of a level rectangle centred on the z axis."""
    return sheet([-width / 2, -depth / 2, height], [width, 0, 0], [0, depth, 0])


def post(x: float, y: float, height: float, side: float = 0.04) -> np.ndarray:
    """Return the four faces of a square post standing on the ground, centred on (x, y)."""
    h = side / 2
    corners = [(x - h, y - h, [side, 0, 0]), (x - h, y + h, [side, 0, 0])]
    corners += [(x - h, y - h, [0, side, 0]), (x + h, y - h, [0, side, 0])]
    return np.concatenate([sheet([cx, cy, 0], across, [0, 0, height]) for cx, cy, across in corners])


def posts(width: float, depth: float, height: float) -> list[np.ndarray]:
    """Return four posts under the corners of a level rectangle."""
    return [post(sx * (width / 2 - 0.02), sy * (depth / 2 - 0.02), height) for sx in (-1, 1) for sy in (-1, 1)]


def cloud(*parts: np.ndarray, name: str) -> Cloud:
    """Return the parts as one cloud, without duplicate points."""
    return Cloud(np.unique(np.round(np.concatenate(parts), 9), axis=0), name)


def plate(width: float = 0.3, depth: float = 0.3, height: float = 0.4) -> Cloud:
    """Return one level sheet in the air."""
    return cloud(level(width, depth, height), name="plate")


def table(width: float = 0.6, depth: float = 0.4, height: float = 0.4) -> Cloud:
    """Return a level top on four posts at its corners."""
    return cloud(level(width, depth, height), *posts(width, depth, height), name="table")


def mug(radius: float = 0.04, height: float = 0.1, floor: float = 0.004) -> Cloud:
    """Return a cylindrical wall and a floor, each a single sheet."""
    square = level(2 * radius, 2 * radius, floor)
    disc = square[np.hypot(square[:, 0], square[:, 1]) < radius]
    angles = np.linspace(0, 2 * np.pi, int(np.ceil(2 * np.pi * radius / SPACING)), endpoint=False)
    rings = [
        np.column_stack([radius * np.cos(angles), radius * np.sin(angles), np.full(angles.size, z)])
        for z in steps(height)
    ]
    return cloud(disc, *rings, name="mug")


def chair(seat: float = 0.4, width: float = 0.4, back: float = 0.4) -> Cloud:
    """Return a seat on four posts with a back at +y; its front edge is at -y."""
    rest = sheet([-width / 2, width / 2, seat], [width, 0, 0], [0, 0, back])
    return cloud(level(width, width, seat), rest, *posts(width, width, seat), name="chair")


def groove(length: float = 0.3, width: float = 0.2, height: float = 0.2) -> Cloud:
    """Return two sheets at right angles that meet in a level line along x, open at its ends."""
    h = width / 2
    left = sheet([-length / 2, -h, height + h], [length, 0, 0], [0, h, -h])
    right = sheet([-length / 2, h, height + h], [length, 0, 0], [0, -h, -h])
    return cloud(left, right, name="groove")


def bin_(width: float = 0.16, depth: float = 0.12, height: float = 0.1) -> Cloud:
    """Return a box without a lid that stands on the ground."""
    w, d = width / 2, depth / 2
    walls = [sheet([-w, y, 0], [width, 0, 0], [0, 0, height]) for y in (-d, d)]
    walls += [sheet([x, -d, 0], [0, depth, 0], [0, 0, height]) for x in (-w, w)]
    return cloud(level(width, depth, 0), *walls, name="bin")
