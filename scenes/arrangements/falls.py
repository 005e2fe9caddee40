"""Spheres that fall on several objects at once, assigned to the object that carries each.

Each object has its own run, over its own box and with all others in their places, so that it gets as many drops as it
would alone. Whatever is more than a few radii away is left out of that run.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np
import trimesh
from scipy.spatial import cKDTree

from spherefunc_bullet.clouds.cloud import MAX_GAP, MIN_POINTS, Cloud, Mesh
from spherefunc_bullet.errors import InputError
from spherefunc_bullet.formats.sources import joined_meshes
from spherefunc_bullet.simulator import DropResult, DropSettings, Outcome, Simulator, drop_on

from .placing import ArrangedObject

NO_OWNER = -1
SLACK = 1.02  # of the farthest that a sample of a touched surface can be: simulators leave that much
TOUCHING = 2.1  # radii between the centres of spheres that touch, as in the resting profile
PATCH = 2.5  # gaps between samples, the radius of the patch that says how a surface slopes
PATCH_POINTS = 12
AROUND = 16  # samples near a sphere that are looked at
THIN = 0.06  # product over squared sum of a patch's two larger variances: less is an edge, which has no slope
BESIDE = 0.15  # radii: an object carries a sphere only if its surface is at most this much farther than the nearest one
LEAST = 0.05  # of the upward parts: a wall that is a little off the vertical carries nothing


def carriers_of(centers: np.ndarray, radius: float, clouds: Sequence[Cloud]) -> tuple[np.ndarray, np.ndarray]:
    """Return which object carries each sphere (S, 3), metres, in the order in which they settled, and at which height.

    A sphere is carried by what it rests on, not by what it leans on: each contact counts by the upward part of its
    normal. A sphere on a table that leans on a mug belongs to the table. A sphere on other spheres, which settled
    before it, belongs to the object that carries most of them.

    Returns
    -------
    (S,) int
        Number of the object, or `NO_OWNER`.
    (S,) float64, metres
        Height of the object's surface under the sphere, or under the spheres that it rests on.
    """
    shares = upward_parts(centers, radius, clouds)
    below = lower_neighbors(centers, radius)
    bases = centers[:, 2] - radius
    for number in np.argsort(centers[:, 2], kind="stable"):  # what carries a sphere is lower
        upon = below[number]
        if not upon:
            continue
        rises = (centers[number, 2] - centers[upon, 2]) / (2 * radius)
        through = (rises[:, None] * shares[upon]).sum(axis=0)
        if through.max() > shares[number].max():
            bases[number] = bases[upon[rises.argmax()]]
        total = shares[number] + through
        shares[number] = total / max(total.sum(), LEAST)
    return np.where(shares.max(axis=1) > 0, shares.argmax(axis=1), NO_OWNER), bases


def lower_neighbors(centers: np.ndarray, radius: float) -> list[list[int]]:
    """Return for each sphere (S, 3) the lower ones that it touches."""
    below: list[list[int]] = [[] for _ in centers]
    for first, other in sorted(cKDTree(centers).query_pairs(TOUCHING * radius) if len(centers) else ()):
        low, high = (first, other) if centers[first, 2] < centers[other, 2] else (other, first)
        below[high].append(low)
    return below


def upward_parts(centers: np.ndarray, radius: float, clouds: Sequence[Cloud]) -> np.ndarray:
    """Return the upward part of the contact of each sphere with each object, (S, K), 0 to 1; 0 where none touches.

    An object that is farther than another by more than a touch carries nothing: a table under the bottom of a mug.
    """
    contacts = [contacts_with(centers, radius, cloud) for cloud in clouds]
    away, parts = (np.stack(values, axis=1) for values in zip(*contacts, strict=True))  # (S, K, 2)
    nearest = away.min(axis=(1, 2), keepdims=True)
    touching = np.isfinite(away) & (away <= np.where(np.isfinite(nearest), nearest, 0) + BESIDE * radius)
    return np.where(touching & (parts > LEAST), parts, 0.0).max(axis=2)


def contacts_with(centers: np.ndarray, radius: float, cloud: Cloud) -> tuple[np.ndarray, np.ndarray]:
    """Return an object's distance from each sphere's centre, metres, and its normal's upward part there, (S, 2).

    Two contacts are measured, at the nearest point and at the point most directly below, since a sphere may touch a
    wall and a floor of the same object. Distances are infinite and upward parts 0 where the surface is out of reach.
    """
    gap = MAX_GAP if cloud.mesh is not None else max(MAX_GAP, cloud.spacing)
    reach, most = SLACK * np.hypot(radius, gap), min(AROUND, len(cloud.points))
    distances, near = cloud.tree.query(centers, k=most, distance_upper_bound=reach)
    touching = np.flatnonzero(np.isfinite(distances[:, 0]))
    away, parts = np.full((len(centers), 2), np.inf), np.zeros((len(centers), 2))
    arms = centers[touching, None] - cloud.points[np.minimum(near[touching], len(cloud.points) - 1)]
    upright = np.where(np.isfinite(distances[touching]), arms[..., 2] / distances[touching], -np.inf)
    rows = np.arange(len(touching))
    for contact, chosen in enumerate((np.zeros(len(rows), int), upright.argmax(axis=1))):
        arm = arms[rows, chosen]
        touched = cloud.points[near[touching, chosen]]
        apart, around = cloud.tree.query(touched, k=min(PATCH_POINTS, len(cloud.points)))
        normals = contact_normals(arm, cloud.points[around], apart <= PATCH * gap, gap)
        parts[touching, contact], away[touching, contact] = normals[:, 2], (normals * arm).sum(axis=1)
    return away, parts


def contact_normals(arms: np.ndarray, around: np.ndarray, near: np.ndarray, gap: float) -> np.ndarray:
    """Return the unit normals (T, 3) of contacts, whose arms (T, 3) lead from surfaces to centres.

    A surface is known by the samples around the contact (T, K, 3) that are near, (T, K) bool. The arm is the normal at
    an edge, and where the centre is farther to the side of the patch than samples are apart (``gap``, metres).
    """
    counts = near.sum(axis=1)[:, None]
    offsets = (around - (around * near[..., None]).sum(axis=1)[:, None] / counts[..., None]) * near[..., None]
    variances, axes = np.linalg.eigh(np.einsum("tki,tkj->tij", offsets, offsets))
    flat = variances[:, 1] * variances[:, 2] > THIN * np.maximum(variances.sum(axis=1), 1e-18) ** 2
    across = axes[:, :, 0] * np.sign(np.einsum("ti,ti->t", axes[:, :, 0], arms))[:, None]
    aside = (arms**2).sum(axis=1) - np.einsum("ti,ti->t", across, arms) ** 2
    flat &= aside < (SLACK * gap) ** 2
    along = arms / np.maximum(np.linalg.norm(arms, axis=1), 1e-12)[:, None]
    return np.where(flat[:, None], across, along)


MARGIN = 4.0  # radii around an object's box within which other objects count
SPARE = 3.0  # standard deviations of the number of drops that fall next to the box


@dataclass(frozen=True, eq=False)
class ArrangedDrops:
    """Drops (D,) and what carries those that settled, in the world's frame, metres."""

    radius: float
    columns: np.ndarray  # (D, 2) where each began
    centers: np.ndarray  # (D, 3) where it rests; NaN where it did not settle
    owners: np.ndarray  # (D,) number of the object that carries it, or `NO_OWNER`
    bases: np.ndarray  # (D,) height of the surface that carries it, metres; NaN where it did not settle
    upon: np.ndarray  # (D,) bool: it rests on spheres alone

    @property
    def arrays(self) -> tuple[np.ndarray, ...]:
        """All arrays, without the radius."""
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
    """Return the part of a cloud over a rectangle from ``low`` to ``high`` (2,); None where there is hardly any."""
    points = cloud.points[((cloud.points[:, :2] >= low) & (cloud.points[:, :2] <= high)).all(axis=1)]
    if len(points) < MIN_POINTS:
        return None
    if cloud.mesh is None:
        return Cloud(points, cloud.name)
    vertices, faces = cloud.mesh.vertices, cloud.mesh.faces
    for axis, sign, edge in ((0, 1, low[0]), (0, -1, high[0]), (1, 1, low[1]), (1, -1, high[1])):
        normal, origin = sign * np.eye(3)[axis], edge * np.eye(3)[axis]
        vertices, faces, _ = trimesh.intersections.slice_faces_plane(vertices, faces, normal, origin)
    return Cloud(points, cloud.name, Mesh(np.asarray(vertices), np.asarray(faces)))


def drops_over(
    objects: Sequence[ArrangedObject], number: int, simulator: Simulator, settings: DropSettings, seeds: Iterable[int]
) -> ArrangedDrops:
    """Return the drops over one object's box, with what of the others stands within a few radii of it.

    Parameters
    ----------
    settings : DropSettings
        ``max_drops`` is the number that fall over the box in each run; without it the paper's rule ends the run.
    seeds : iterable of int
        Of one run each.
    """
    target, reach = objects[number], MARGIN * settings.radius
    low, high = target.cloud.bounds[:, :2] + [[-reach], [reach]]
    parts = {k: target.cloud if k == number else cut_out(item.cloud, low, high) for k, item in enumerate(objects)}
    present = {k: cloud for k, cloud in parts.items() if cloud is not None}
    clouds, numbers = list(present.values()), np.array([*present, NO_OWNER])  # of the objects; the last for no owner
    union, run = united(clouds, target.name), settings
    if settings.max_drops is not None:
        share = target.own.size[:2].prod() / max(union.size[:2].prod(), 1e-12)
        most = math.ceil((settings.max_drops + SPARE * math.sqrt(settings.max_drops)) / min(max(share, 1e-3), 1.0))
        run = replace(settings, miss_limit=most, max_drops=most)
    runs = []
    for seed in seeds:
        _, falls = falls_on(clouds, union, simulator, run, seed)
        over = np.flatnonzero(target.over(falls.columns))[: settings.max_drops]
        falls = ArrangedDrops(falls.radius, *(part[over] for part in falls.arrays))
        runs.append(within_boxes(replace(falls, owners=numbers[falls.owners]), objects).arrays)
    return ArrangedDrops(settings.radius, *map(np.concatenate, zip(*runs, strict=True)))


def falls_on(
    clouds: Sequence[Cloud], union: Cloud, simulator: Simulator, settings: DropSettings, seed: int
) -> tuple[DropResult, ArrangedDrops]:
    """Return a run on several clouds that are one cloud to the simulator, and which of them carries each sphere."""
    result = drop_on(union, simulator, settings, seed)
    if len(result.columns) != result.drops:
        raise InputError(f"backend {simulator.name!r}: expected one that reports where each drop began")
    settled = result.outcomes == Outcome.SETTLED
    centers, bases = np.full((result.drops, 3), np.nan), np.full(result.drops, np.nan)
    owners, upon = np.full(result.drops, NO_OWNER), np.zeros(result.drops, bool)
    centers[settled], upon[settled] = result.centers, ~result.on_object
    owners[settled], bases[settled] = carriers_of(result.centers, settings.radius, clouds)
    return result, ArrangedDrops(settings.radius, result.columns, centers, owners, bases, upon)


def within_boxes(falls: ArrangedDrops, objects: Sequence[ArrangedObject]) -> ArrangedDrops:
    """Return drops without those that rest on spheres alone and above the object that carries them (paper, §III-A)."""
    tops = np.array([*(item.cloud.bounds[1, 2] for item in objects), np.inf])[falls.owners]
    outside = falls.upon & (falls.centers[:, 2] > tops)
    centers, bases = falls.centers.copy(), falls.bases.copy()
    centers[outside], bases[outside] = np.nan, np.nan
    return replace(falls, centers=centers, bases=bases, owners=np.where(outside, NO_OWNER, falls.owners))
