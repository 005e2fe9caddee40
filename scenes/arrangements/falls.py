"""Spheres that fall on several objects at once, assigned to the object that carries each.

An object is asked by the drops over its own box, with all others in their places: so it gets as many as it would alone.
What is farther off than a few radii is left out of such a run.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import trimesh

from spherefunc_bullet.clouds.cloud import MIN_POINTS, Cloud, Mesh
from spherefunc_bullet.errors import InputError
from spherefunc_bullet.formats.sources import joined_meshes
from spherefunc_bullet.simulator import DropResult, DropSettings, Outcome, Simulator

from .owners import NO_OWNER, carriers_of
from .placing import ArrangedObject

MARGIN = 4.0  # radii around an object's box that other objects are kept in
SPARE = 3.0  # standard deviations of the number of drops that fall beside the box


@dataclass(frozen=True, eq=False)
class Falls:
    """Drops (D,) and what carries those that settled, in the world's frame, metres."""

    radius: float
    columns: np.ndarray  # (D, 2) where each began
    centers: np.ndarray  # (D, 3) where it rests; NaN where it did not settle
    owners: np.ndarray  # (D,) number of the object that carries it, or `NOBODY`
    bases: np.ndarray  # (D,) height of the surface that carries it, metres; NaN where it did not settle
    upon: np.ndarray  # (D,) bool: it rests on spheres alone

    def kept(self, which: np.ndarray) -> Falls:
        """Return some of the drops, (D,) bool or their numbers."""
        return Falls(self.radius, *(part[which] for part in self.parts))

    @property
    def parts(self) -> tuple[np.ndarray, ...]:
        """All but the radius."""
        return self.columns, self.centers, self.owners, self.bases, self.upon

    def by(self, number: int) -> np.ndarray:
        """Return which drops an object carries, (D,) bool."""
        return self.owners == number


def united(clouds: Sequence[Cloud], name: str) -> Cloud:
    """Return several clouds as one, with a mesh where all have one."""
    points = np.concatenate([cloud.points for cloud in clouds])
    meshes = [cloud.mesh for cloud in clouds]
    if any(mesh is None for mesh in meshes):
        return Cloud(points, name)
    return Cloud(points, name, Mesh(*joined_meshes([(mesh.vertices, mesh.faces) for mesh in meshes])))


def cut_out(cloud: Cloud, low: np.ndarray, high: np.ndarray) -> Cloud | None:
    """Return what of a cloud stands over a rectangle from ``low`` to ``high`` (2,); None where hardly anything does."""
    points = cloud.points[((cloud.points[:, :2] >= low) & (cloud.points[:, :2] <= high)).all(axis=1)]
    if len(points) < MIN_POINTS:
        return None
    return Cloud(points, cloud.name, None if cloud.mesh is None else cut_mesh(cloud.mesh, low, high))


def cut_mesh(mesh: Mesh, low: np.ndarray, high: np.ndarray) -> Mesh:
    """Return the part of a mesh over a rectangle."""
    vertices, faces = mesh.vertices, mesh.faces
    for axis, sign, edge in ((0, 1, low[0]), (0, -1, high[0]), (1, 1, low[1]), (1, -1, high[1])):
        normal, origin = sign * np.eye(3)[axis], edge * np.eye(3)[axis]
        vertices, faces, _ = trimesh.intersections.slice_faces_plane(vertices, faces, normal, origin)
    return Mesh(np.asarray(vertices), np.asarray(faces))


def drop_on(
    objects: Sequence[ArrangedObject], simulator: Simulator, settings: DropSettings, seed: int, name: str
) -> tuple[DropResult, Falls]:
    """Return what becomes of drops on objects as they stand together, all over them."""
    clouds = [item.cloud for item in objects]
    return falls_on(clouds, united(clouds, name), simulator, settings, seed)


@dataclass(frozen=True, eq=False)
class Surroundings:
    """One of some objects, and what of the others stands within a few radii of its box."""

    objects: Sequence[ArrangedObject]
    number: int  # of the object
    present: dict[int, Cloud]  # by number, the object itself too, in the world's frame
    union: Cloud

    def drop(self, simulator: Simulator, settings: DropSettings, seed: int) -> Falls:
        """Return what becomes of the drops over the object's box.

        Parameters
        ----------
        settings : DropSettings
            ``max_drops`` is how many fall over the box; without it as many as the paper's rule takes.
        """
        asked, run = self.objects[self.number], settings
        if settings.max_drops is not None:
            share = asked.own.size[:2].prod() / max(self.union.size[:2].prod(), 1e-12)
            most = math.ceil((settings.max_drops + SPARE * math.sqrt(settings.max_drops)) / min(max(share, 1e-3), 1.0))
            run = DropSettings(radius=settings.radius, miss_limit=most, max_drops=most)
        _, falls = falls_on(list(self.present.values()), self.union, simulator, run, seed)
        numbers = np.array([*self.present, NO_OWNER])  # of all objects; the last stands for nobody
        falls = replace(falls, owners=numbers[falls.owners])
        over = np.flatnonzero(asked.over(falls.columns))[: settings.max_drops]
        return within_boxes(falls.kept(over), self.objects)


def surroundings(objects: Sequence[ArrangedObject], number: int, radius: float) -> Surroundings:
    """Return one of some objects with what stands around it, for spheres of a radius in metres."""
    asked = objects[number]
    low, high = asked.cloud.bounds[:, :2] + [[-MARGIN * radius], [MARGIN * radius]]
    parts = {k: asked.cloud if k == number else cut_out(item.cloud, low, high) for k, item in enumerate(objects)}
    present = {k: cloud for k, cloud in parts.items() if cloud is not None}
    return Surroundings(objects, number, present, united(list(present.values()), asked.name))


def falls_on(
    clouds: Sequence[Cloud], union: Cloud, simulator: Simulator, settings: DropSettings, seed: int
) -> tuple[DropResult, Falls]:
    """Return a run on several clouds that are one cloud to the simulator, and which of them carries each sphere."""
    result = simulator.drop(union, settings, seed)
    if len(result.columns) != result.drops:
        raise InputError(f"backend {simulator.name!r}: expected one that tells where each drop began")
    settled = result.outcomes == Outcome.SETTLED
    carried = carriers_of(result.centers, settings.radius, clouds)
    centers, bases = np.full((result.drops, 3), np.nan), np.full(result.drops, np.nan)
    owners, upon = np.full(result.drops, NO_OWNER), np.zeros(result.drops, bool)
    centers[settled], bases[settled] = result.centers, carried.bases
    owners[settled], upon[settled] = carried.owners, ~result.on_object
    return result, Falls(settings.radius, result.columns, centers, owners, bases, upon)


def within_boxes(falls: Falls, objects: Sequence[ArrangedObject]) -> Falls:
    """Return falls without those that rest on spheres alone, above the object that carries these (paper, §III-A)."""
    tops = np.array([*(item.cloud.bounds[1, 2] for item in objects), np.inf])[falls.owners]
    outside = falls.upon & (falls.centers[:, 2] > tops)
    centers, bases = falls.centers.copy(), falls.bases.copy()
    centers[outside], bases[outside] = np.nan, np.nan
    return replace(falls, centers=centers, bases=bases, owners=np.where(outside, NO_OWNER, falls.owners))
