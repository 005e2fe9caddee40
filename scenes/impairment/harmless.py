"""Harmless changes. Each takes a specimen and a generator, and returns a surface, or None where it cannot be made."""

from __future__ import annotations

import numpy as np

from spherefunc_bullet.clouds.cloud import cloud_from_mesh
from spherefunc_bullet.settling.settling import falls_over

from .levels import Cavity, LevelPart
from .specimen import Specimen, box, needs, turn, turned
from .surfaces import ObjectSurface

NOISE = 0.0015  # metres, standard deviation of a sensor's points along each axis
FRAME = 640 * 480  # points at most, as in a depth camera's image
HOLES = 6  # that a sensor leaves
HOLE = (0.03, 0.015)  # radius: of the largest extent, but at most this many metres
ANGLES, RINGS = 48, 16  # about a cup's axis and along its height, to find a handle
HANDLE = 1.12  # times the body's radius: parts that reach farther are a handle
HANDLE_WIDE = np.radians(110)  # at most
ARM = (0.06, 0.45)  # metres above the seat between which arms are
LEG = 0.05  # metres, the side of a new leg
FEET = 0.4  # of the level's area at most, at a third of its height: more is a body, not legs


def whole(specimen: Specimen, rng: np.random.Generator) -> ObjectSurface:
    """Change nothing."""
    return specimen.surface


def smaller(specimen: Specimen, rng: np.random.Generator) -> ObjectSurface:
    """Make it a tenth smaller."""
    return specimen.surface.mapped(lambda points: 0.9 * points)


def larger(specimen: Specimen, rng: np.random.Generator) -> ObjectSurface:
    """Make it a tenth larger."""
    return specimen.surface.mapped(lambda points: 1.1 * points)


def heading(specimen: Specimen, rng: np.random.Generator) -> ObjectSurface:
    """Turn it about the vertical by any angle."""
    return turned(specimen.surface, turn(np.array([0.0, 0, 1]), rng.uniform(0, 2 * np.pi)))


def sensor(specimen: Specimen, rng: np.random.Generator) -> ObjectSurface:
    """Keep points of its surface as a sensor would measure them, with noise and a few holes."""
    points = specimen.cloud.points
    points = points if len(points) <= FRAME else rng.choice(points, FRAME, replace=False)
    radius = min(HOLE[0] * float(specimen.cloud.size.max()), HOLE[1])
    for place in points[rng.choice(len(points), HOLES)]:
        left = np.linalg.norm(points - place, axis=1) > radius
        points = points[left] if left.sum() > len(points) / 2 else points
    return ObjectSurface(points=points + rng.normal(0, NOISE, points.shape)).standing()


def triangulation(specimen: Specimen, rng: np.random.Generator) -> ObjectSurface | None:
    """Cut every triangle in three at a random place within it, and shuffle them."""
    surface = specimen.surface
    if surface.is_cloud:
        return None
    weights = rng.dirichlet([4, 4, 4], len(surface.triangles))
    middle = (weights[:, :, None] * surface.triangles).sum(axis=1)
    a, b, c = np.moveaxis(surface.triangles, 1, 0)
    parts = np.concatenate([np.stack(corners, axis=1) for corners in ((a, b, middle), (b, c, middle), (c, a, middle))])
    return ObjectSurface(rng.permutation(parts))


@needs("cavity")
def without_handle(specimen: Specimen, cup: Cavity, rng: np.random.Generator) -> ObjectSurface | None:
    """Take off a cup's handle: the part that reaches out on one side only."""
    surface = specimen.surface
    away = surface.centres[:, :2] - cup.axis
    angles, distances = np.arctan2(away[:, 1], away[:, 0]), cup.distances(surface.centres)
    ring = np.clip(surface.centres[:, 2] / surface.size[2] * RINGS, 0, RINGS - 1).astype(int)
    sector = np.clip((angles + np.pi) / (2 * np.pi) * ANGLES, 0, ANGLES - 1).astype(int)
    farthest = np.zeros((RINGS, ANGLES))
    np.maximum.at(farthest, (ring, sector), distances)
    handle = distances > HANDLE * np.median(farthest, axis=1)[ring]
    handle &= distances > np.median(farthest, axis=1)[ring] + 2 * cup.grid.cell
    if handle.sum() < 0.01 * len(handle):
        return None
    toward = np.angle(np.exp(1j * angles[handle]).sum())
    spread = np.abs(np.angle(np.exp(1j * (angles[handle] - toward))))
    return None if spread.max() > HANDLE_WIDE / 2 else surface.without(handle)


@needs("level")
def without_arms(specimen: Specimen, seat: LevelPart, rng: np.random.Generator) -> ObjectSurface | None:
    """Take off the arms of a chair: the parts that rise from both sides of the seat and are not its back."""
    back, surface = specimen.back, specimen.surface
    if back is None:
        return None
    middle, half = seat.box.mean(axis=0), (seat.box[1] - seat.box[0]) / 2
    places, height = surface.centres[:, :2] - middle, surface.centres[:, 2] - seat.height
    along, across = places @ back, places @ [-back[1], back[0]]
    deep, wide = half @ np.abs(back), half @ np.abs(back[::-1])
    arms = (height > ARM[0]) & (height < ARM[1]) & (along < 0.6 * deep) & (np.abs(across) > 0.75 * wide)
    left, right = (arms & (across < 0)).sum(), (arms & (across > 0)).sum()
    if min(left, right) < max(0.01 * len(arms), 0.5 * max(left, right)):
        return None
    spared = surface.without(arms)
    return spared if seat.is_left_in(spared) else None


@needs("level", triangles=True)
def other_legs(specimen: Specimen, level: LevelPart, rng: np.random.Generator) -> ObjectSurface | None:
    """Replace the legs of a seat or a table by four posts, two panels, or a column on a plate, if it stands on them."""
    surface = specimen.surface
    third = np.abs(surface.centres[:, 2] - level.height / 3) < level.height / 20
    standing = np.isfinite(level.grid.tops(surface.centres[third])).sum() * level.grid.cell**2
    if standing > FEET * level.area:
        return None
    cut = level.height - max(0.05, 0.12 * level.height)
    spared = surface.without(surface.centres[:, 2] < cut)
    low, high = level.box + [[LEG / 2], [-LEG / 2]]
    corners = np.array([low, high, [low[0], high[1]], [high[0], low[1]]])
    square = level.cells[level.grid.cells_of(corners)].all()
    make = (posts, panels, column)[rng.integers(3)] if square else column  # below a round top, nothing at corners
    legs = make(low, high, level.height - 0.02)
    changed = spared.joined(ObjectSurface(np.concatenate(legs)))
    stands = not falls_over(cloud_from_mesh(*changed.standing().mesh(), "on other legs"))
    return changed if stands and level.is_left_in(changed) else None


def posts(low: np.ndarray, high: np.ndarray, height: float) -> list[np.ndarray]:
    """Return a leg at each corner."""
    corners = [np.array([x, y]) for x in (low[0], high[0] - LEG) for y in (low[1], high[1] - LEG)]
    return [box(np.array([*corner, 0.0]), np.array([*(corner + LEG), height])) for corner in corners]


def panels(low: np.ndarray, high: np.ndarray, height: float) -> list[np.ndarray]:
    """Return a board at either end of x."""
    ends = [(low[0], low[0] + LEG / 2), (high[0] - LEG / 2, high[0])]
    return [box(np.array([start, low[1], 0.0]), np.array([end, high[1], height])) for start, end in ends]


def column(low: np.ndarray, high: np.ndarray, height: float) -> list[np.ndarray]:
    """Return a column in the middle, and a plate below it."""
    middle, half = (low + high) / 2, (high - low) / 4
    plate = box(np.array([*(middle - half), 0.0]), np.array([*(middle + half), 0.02]))
    return [plate, box(np.array([*(middle - LEG), 0.02]), np.array([*(middle + LEG), height]))]
