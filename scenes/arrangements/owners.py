"""Which object carries each sphere: what it rests on, not what it leans on; through other spheres if it must.

A contact carries by how upright it is: its normal's upward part. A sphere on a table that leans on a mug is the
table's. A sphere on spheres belongs to who carries most of those, and they settled before it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from spherefunc_bullet.clouds.cloud import MAX_GAP, Cloud

NO_OWNER = -1
SLACK = 1.02  # of the farthest that a sample of a touched surface can be: simulators leave that much
TOUCHING = 2.1  # radii between the centres of spheres that touch, as in the resting profile
PATCH = 2.5  # gaps between samples, the radius of the patch that says how a surface slopes
PATCH_POINTS = 12
AROUND = 16  # samples near a sphere that are looked at
THIN = 0.06  # product over squared sum of a patch's two larger variances: less is an edge, which has no slope
BESIDE = 0.15  # radii: the surface of an object that carries is no farther than the nearest one by more
LEAST = 0.05  # of the upward parts: a wall that is a little off the vertical carries nothing


@dataclass(frozen=True, eq=False)
class Carried:
    """What carries spheres (S,)."""

    owners: np.ndarray  # (S,) number of the object, or `NOBODY`
    bases: np.ndarray  # (S,) metres, the height of the object's surface under it or under those that it rests on


def carriers_of(centers: np.ndarray, radius: float, clouds: Sequence[Cloud]) -> Carried:
    """Return what carries spheres (S, 3), metres, given in the order in which they settled."""
    shares = upward_parts(centers, radius, clouds)
    below = lower_neighbors(centers, radius)
    bases = centers[:, 2] - radius
    for number in np.argsort(centers[:, 2], kind="stable"):  # whoever carries is lower
        upon = below[number]
        if not upon:
            continue
        rises = (centers[number, 2] - centers[upon, 2]) / (2 * radius)
        through = (rises[:, None] * shares[upon]).sum(axis=0)
        if through.max() > shares[number].max():
            bases[number] = bases[upon[rises.argmax()]]
        total = shares[number] + through
        shares[number] = total / max(total.sum(), LEAST)
    owners = np.where(shares.max(axis=1) > 0, shares.argmax(axis=1), NO_OWNER)
    return Carried(owners, bases)


def lower_neighbors(centers: np.ndarray, radius: float) -> list[list[int]]:
    """Return for each sphere (S, 3) those that it touches and that are lower."""
    below: list[list[int]] = [[] for _ in centers]
    pairs = cKDTree(centers).query_pairs(TOUCHING * radius) if len(centers) else ()
    heights = centers[:, 2]
    for one, other in sorted(pairs):
        low, high = (one, other) if heights[one] < heights[other] else (other, one)
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
    """Return how far an object's surface is from each sphere's centre, metres, and its normal's upward part, (S, 2).

    At the nearest point, and at that which is most directly below: a sphere may touch a wall and a floor of the same
    object. Infinite and 0 where it is out of reach.
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
        around = patches(cloud, cloud.points[near[touching, chosen]], PATCH * gap)
        normals = contact_normals(arm, *around, gap)
        parts[touching, contact], away[touching, contact] = normals[:, 2], (normals * arm).sum(axis=1)
    return away, parts


def patches(cloud: Cloud, points: np.ndarray, reach: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the neighbours (T, K, 3) of points of a cloud (T, 3), and which of them are near enough, (T, K) bool."""
    distances, near = cloud.tree.query(points, k=min(PATCH_POINTS, len(cloud.points)))
    return cloud.points[near], distances <= reach


def contact_normals(arms: np.ndarray, around: np.ndarray, near: np.ndarray, gap: float) -> np.ndarray:
    """Return the unit normals (T, 3) of contacts, whose arms (T, 3) lead from surfaces to centres.

    A surface is known by its neighbours (T, K, 3), those that are near, (T, K). Of an edge, and where the centre is
    farther aside of the surface than samples are apart (``gap``, metres), the arm is the normal.
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
