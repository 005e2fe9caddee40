"""What objects take from one another: the level that each needs, and which others carry the drops over it instead."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from spherefunc_bullet.clouds.cloud import Mesh
from spherefunc_bullet.clouds.raycasting import raycasting_scene, rays_from
from spherefunc_bullet.learning.profiles.columns import outline_of
from spherefunc_bullet.settling.resting_places import ACROSS, LIMITS
from spherefunc_bullet.simulator import DropSettings, Simulator

from .falls import ArrangedDrops, drops_over
from .placing import ArrangedObject, along_heading

LAYER = 0.1  # of the box, covered by the spheres of a run, so that few of them meet
FINER = 2.0  # times smaller than the spheres that find places to put objects on
FEWEST = 10  # drops of a run


@dataclass(frozen=True, kw_only=True)
class ArrangedLevel:
    """The level at which an object carries most, and how much of it is left to it. Areas in square metres."""

    height: float  # above the ground, metres
    alone: float  # area of the places from which spheres come to rest on it
    together: float  # the same with the other objects in place
    taken: dict[str, float]  # area over it whose spheres another object carries, by that object's name
    drops: int  # that fell over its box, alone and together

    @property
    def left(self) -> float:
        """The share of its area that is left to it."""
        return self.together / self.alone


def level_of(
    objects: Sequence[ArrangedObject], number: int, simulator: Simulator, radius: float | None, drops: int, seed: int
) -> ArrangedLevel | None:
    """Return the level of one object alone and together with the others; None where nothing rests on it.

    Parameters
    ----------
    radius : float, optional
        Of the spheres, metres; by default as the object is large.
    drops : int
        The least number that fall over its box; the error of areas falls with the square root of it.
    """
    objects, _ = along_heading(objects, number)
    target = objects[number]
    fitting = float(np.clip(target.own.size.max() / (ACROSS * FINER), *LIMITS))
    length = fitting if radius is None else radius
    layer = layer_of(target.own.size, length)
    settings = DropSettings(radius=length, max_drops=layer, even_columns=True)
    run = simulator, settings, range(seed, seed + math.ceil(drops / layer))
    alone, together = drops_over([target], 0, *run), drops_over(objects, number, *run)
    if not alone.by(0).any():
        return None
    ordered = np.sort(alone.bases[alone.by(0)])
    first, last = (
        np.searchsorted(ordered, ordered - length, "left"),
        np.searchsorted(ordered, ordered + length, "right"),
    )
    best = int((last - first).argmax())
    height = float(ordered[first[best] : last[best]].mean())  # where most of these heights lie within a radius
    area, on_alone = float(target.own.size[:2].prod()), on_level(alone, 0, height)
    over = outline_of(alone.centers[on_alone, :2], length).inside(together.columns) >= 0
    others = [k for k in range(len(objects)) if k != number]
    return ArrangedLevel(
        height=height,
        alone=area * float(on_alone.mean()),
        together=area * float(on_level(together, number, height).mean()),
        taken={objects[k].name: area * float((together.by(k) & over).mean()) for k in others},
        drops=len(together.columns),
    )


def layer_of(size: np.ndarray, radius: float, share: float = LAYER) -> int:
    """Return the number of spheres of a radius that cover a share of a box of a size (3,), metres."""
    return max(FEWEST, int(share * size[:2].prod() / (np.pi * radius**2)))


def on_level(falls: ArrangedDrops, number: int, height: float) -> np.ndarray:
    """Return which drops come to rest on one object at a height, or on spheres that do, (D,) bool."""
    return falls.by(number) & (np.abs(falls.bases - height) <= falls.radius)


SUNK = 0.002  # metres: an object that is at most so deep in another touches it
NEAR = 0.012  # metres from the other's surface: an object that crosses it has points there, on either side
STEP = 0.008  # metres between neighbouring samples of one surface, at most


def crossing(one: ArrangedObject, other: ArrangedObject) -> np.ndarray | None:
    """Return a place (3,) where two objects' surfaces cross, metres, the world's frame; None where they do not.

    One of them has to be a mesh; between two clouds no crossing is found. An object that is wholly within a hollow one
    crosses nothing.
    """
    (low, high), (other_low, other_high) = one.cloud.bounds, other.cloud.bounds
    if not (np.minimum(high, other_high) - np.maximum(low, other_low) > SUNK).all():
        return None
    for crossed, passing in ((one, other), (other, one)):
        if crossed.cloud.mesh is not None:
            place = first_crossing(crossed.cloud.mesh, passing.cloud.points)
            if place is not None:
                return place
    return None


def first_crossing(mesh: Mesh, points: np.ndarray) -> np.ndarray | None:
    """Return a place where two neighbouring points (N, 3), neither touching the mesh, lie on its two sides."""
    low, high = mesh.vertices.min(axis=0) - NEAR, mesh.vertices.max(axis=0) + NEAR
    points = points[((points >= low) & (points <= high)).all(axis=1)]
    if not len(points):
        return None
    scene = raycasting_scene((mesh.vertices, mesh.faces), threads=1)
    away = scene.compute_distance(points.astype(np.float32)).numpy()
    points = points[(away > SUNK) & (away < NEAR)]
    pairs = cKDTree(points).query_pairs(STEP, output_type="ndarray") if len(points) else np.empty((0, 2), int)
    if not len(pairs):
        return None
    start, way = points[pairs[:, 0]], points[pairs[:, 1]] - points[pairs[:, 0]]
    met = scene.cast_rays(rays_from(start, way))["t_hit"].numpy()
    crossed = np.flatnonzero(met < 1)
    return None if not len(crossed) else start[crossed[0]] + met[crossed[0]] * way[crossed[0]]
