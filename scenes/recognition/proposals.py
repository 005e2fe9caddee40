"""Proposals, which may be objects: separate clusters of points, and the parts that carry or hold pools of spheres."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from spherefunc_bullet.clouds.cloud import corners_of
from spherefunc_bullet.errors import require_known
from spherefunc_bullet.simulator import Simulator

from ..pools.surfaces import Pool, level_pools, parted_at_necks, resting_places
from ..pools.tops import Top, cut_out, ground_top, objects_on, top_of_pool
from ..pools.vessels import cut_vessel, vessel_pools
from ..scans.cells import Cells, cells
from ..segmentation.clusters import Box, bounding_box, members_of
from ..segmentation.segmentation import FLOOR, WALL
from ..settings import POOL, RECOGNITION, SCAN, SEGMENTATION

CLUSTERS, POOLS = "clusters", "pools"
KINDS = (CLUSTERS, POOLS)


@dataclass(frozen=True, kw_only=True, eq=False)
class Proposal:
    """Points that may be an object."""

    by: str  # "clusters" or "pools"
    members: np.ndarray  # (K,) int64, ascending, of the scene's points
    support: float  # the height that it stands on, metres
    pool: Pool | None = None  # of large spheres, which it carries
    box: Box | None = None  # around its points, if known
    on_top: bool = False  # whether it stands on a top, apart from everything else there


@dataclass(frozen=True, kw_only=True, eq=False)
class Scene:
    """A levelled scan, segmented into floor, walls and clusters."""

    points: np.ndarray  # (N, 3) float64, metres, level frame
    labels: np.ndarray  # (N,) int, as `segment` gives them
    on_table: bool = False  # whether z = 0 is a table's top


def kinds_of(text: str | None) -> tuple[str, ...]:
    """Return the kinds of proposals of a comma-separated list; all kinds for None.

    Raises
    ------
    InputError
        If there is no such kind.

    Examples
    --------
    >>> kinds_of("pools"), kinds_of(None)
    (('pools',), ('clusters', 'pools'))
    """
    if text is None:
        return KINDS
    kinds = tuple(part.strip() for part in text.split(","))
    require_known("--proposals", kinds, KINDS)
    return kinds


def propose(
    scene: Scene, simulator: str | Simulator, kinds: Sequence[str] = KINDS, *, seed: int = 0, cautious: bool = False
) -> list[Proposal]:
    """Return the proposals of a scene, clusters first, in the order of their labels.

    Parameters
    ----------
    scene : Scene
    simulator : str or Simulator
        Whose spheres find the pools.
    kinds : sequence of {"clusters", "pools"}
    seed : int
        Of the drops.
    cautious : bool
        Whether no surface is divided and backs begin near their seats, as in training, where few guesses are better.
    """
    proposed = cluster_proposals(scene.points, scene.labels) if CLUSTERS in kinds else []
    corners = [corners_of(scene.points[one.members]) for one in proposed]
    for new in pool_proposals(scene, simulator, seed, cautious) if POOLS in kinds else []:
        extent = corners_of(scene.points[new.members])
        same = same_proposal(new, extent, proposed, corners)
        if same is None:
            proposed.append(new)
            corners.append(extent)
        elif new.pool is not None and proposed[same].pool is None:
            proposed[same] = replace(proposed[same], pool=new.pool)
    return proposed


def same_proposal(
    proposal: Proposal, extent: np.ndarray, others: Sequence[Proposal], corners: Sequence[np.ndarray]
) -> int | None:
    """Return which other proposal has nearly the same points and the same corners (2, 3); None if none has.

    Corners matter for a thin back, which has few points: an object with its back differs from its seat alone.
    """
    alike = np.abs(np.reshape(corners, (-1, 2, 3)) - extent).max(axis=(1, 2), initial=0.0) < 2 * POOL.slab
    for k in np.flatnonzero(alike):
        small, large = sorted((len(proposal.members), len(others[k].members)))
        least = RECOGNITION.same_points * large
        if small >= least and shared_points(proposal, others[k]) > least:
            return int(k)
    return None


def shared_points(one: Proposal, other: Proposal) -> int:
    """Return the number of points that two proposals share."""
    small, large = sorted((one.members, other.members), key=len)
    if not len(small) or small[0] > large[-1] or large[0] > small[-1]:
        return 0
    place = np.minimum(np.searchsorted(large, small), len(large) - 1)
    return int(np.count_nonzero(large[place] == small))


def cluster_proposals(points: np.ndarray, labels: np.ndarray) -> list[Proposal]:
    """Return the clusters of points (N, 3) by their labels (N,), each on the support right below it."""
    members = members_of(labels)
    parts = [points[rows] for rows in members]
    lows, highs = np.array([corners_of(part) for part in parts]).reshape(-1, 2, 3).swapaxes(0, 1)
    return [
        Proposal(by=CLUSTERS, members=rows, support=top_below(k, parts, lows, highs)) for k, rows in enumerate(members)
    ]


def top_below(number: int, parts: list[np.ndarray], lows: np.ndarray, highs: np.ndarray) -> float:
    """Return the height of the level top that an object stands on, 0 for the floor, metres.

    A support extends at least as far as the object: a table top stands on the floor even if its pillar is a separate
    cluster.

    Parameters
    ----------
    number : int
        The object.
    parts : list of (N, 3) float64, metres, level frame
        The points of all objects.
    lows, highs : (K, 3) float64, metres
        Their lowest and highest corners.
    """
    low, high, best = lows[number], highs[number], 0.0
    if low[2] < POOL.slab:
        return best
    reaches = (lows[:, :2] <= low[:2] + POOL.slab) & (highs[:, :2] >= high[:2] - POOL.slab)
    begins = (lows[:, 2] < low[2] + SCAN.cell) & (highs[:, 2] > low[2] - POOL.slab)
    for k in np.flatnonzero(reaches.all(axis=1) & begins):
        other = parts[k]
        under = other[(other[:, 2] < low[2] + SCAN.cell) & (other[:, 2] > low[2] - POOL.slab)]
        under = under[((under[:, :2] > low[:2] - POOL.slab) & (under[:, :2] < high[:2] + POOL.slab)).all(axis=1)]
        if k != number and len(under) >= 10 and np.ptp(under[:, :2], axis=0).min() > 0:
            best = max(best, float(np.median(under[:, 2])))
    return best


def pool_proposals(scene: Scene, simulator: str | Simulator, seed: int, cautious: bool) -> list[Proposal]:
    """Return the proposals of pools: surfaces on which large spheres rest, objects on them, and vessels among these."""
    z = scene.points[:, 2]
    solid = np.flatnonzero((scene.labels != FLOOR) & (z > 0) & (z < SEGMENTATION.high))
    thinned = cells(scene.points[solid], SEGMENTATION.leaf_size)
    candidates = np.flatnonzero((scene.labels != FLOOR) & (scene.labels != WALL) & (z > 0))
    points = scene.points[candidates]
    voxels = cells(points, SEGMENTATION.leaf_size)
    pools, centers = layers_of_pools(thinned.means, voxels, simulator, seed)
    if not cautious:
        pools += [part for pool in pools for part in parted_at_necks(pool, centers, RECOGNITION.radius)]
    gap = POOL.cautious_gap if cautious else POOL.back_gap
    proposed = [
        Proposal(by=POOLS, members=candidates[cut_out(voxels, pool, gap)], support=0.0, pool=pool) for pool in pools
    ]
    tops = [top_of_pool(points, pool, voxels) for pool in pools if pool.area >= POOL.part_area]
    tops += [ground_top(points)] if scene.on_table else []
    known: set[bytes] = set()
    for top in tops:
        proposed += on_top(scene.points, candidates, top, known, simulator, seed)
    return [proposal for proposal in proposed if len(proposal.members) >= POOL.min_points]


def layers_of_pools(
    solid: np.ndarray, voxels: Cells, simulator: str | Simulator, seed: int
) -> tuple[list[Pool], np.ndarray]:
    """Return the pools of spheres on a scene and on what its surfaces cover, and the spheres' centres (S, 3), metres.

    From above, no sphere reaches a seat under a table, or a lower board of a shelf. So what carries spheres is taken
    away with everything above it, and spheres fall on what it covered, until they find no other surface.

    Parameters
    ----------
    solid : (N, 3) float64, metres, level frame
        The scene without its floor.
    voxels : Cells
        Of those of its points that are not part of a wall either.
    """
    pools, centers = [], []
    while True:
        centers.append(resting_places(solid, simulator, RECOGNITION.radius, seed=seed))
        layer = [pool for pool in level_pools(voxels, centers[-1], RECOGNITION.radius) if pool.height > POOL.lowest]
        pools += [pool for pool in layer if pool.height < POOL.highest]
        covered = [under(pool, solid) for pool in layer if pool.area >= POOL.part_area]
        if not covered:
            return pools, np.vstack(centers)
        solid = solid[np.any(covered, axis=0)]


def under(pool: Pool, points: np.ndarray) -> np.ndarray:
    """Return which points (N, 3) lie below a pool's surface, (N,) bool."""
    return pool.footprint.holds(points) & (points[:, 2] < pool.height - 2 * POOL.slab)


def on_top(
    points: np.ndarray, own: np.ndarray, top: Top, known: set[bytes], simulator: str | Simulator, seed: int
) -> list[Proposal]:
    """Return the objects that stand on a top, and the vessels in those that are wider than a vessel.

    Parameters
    ----------
    points : (N, 3) float64, metres, level frame
    own : (M,) int64
        The points that the top's indices refer to.
    known : set of bytes
        The members of objects on other tops, which are left out; those of this top are added.
    """
    proposed = []
    for members in objects_on(top):
        if members.tobytes() in known:
            continue
        known.add(members.tobytes())
        item = points[own[members]]
        box = bounding_box(item)
        if box.size[1] < POOL.narrowest:
            continue
        support = float(np.median(top.height_at(item)))
        proposed.append(Proposal(by=POOLS, members=own[members], support=support, box=box, on_top=top.is_table))
        if np.ptp(corners_of(item)[:, :2], axis=0).max() > RECOGNITION.widest_vessel:
            alone = Top(plane=top.plane, points=item, indices=members)
            for pool in vessel_pools(alone, simulator, seed=seed):
                inside = own[members[cut_vessel(item, pool)]]
                box = bounding_box(points[inside]) if len(inside) >= POOL.min_points else None
                if box is not None and box.size[1] >= POOL.narrowest:
                    proposed.append(Proposal(by=POOLS, members=inside, support=pool.support, box=box))
    return proposed
