"""From a scan to objects and their functions (paper, §IV-C and Fig. 6)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike
from threadpoolctl import threadpool_limits

from spherefunc_bullet.clouds.cloud import corners_of
from spherefunc_bullet.errors import require_kind
from spherefunc_bullet.formats.units import Stopwatch
from spherefunc_bullet.function_model import FunctionModel

from ..pools.vessels import surroundings
from ..scans.cells import cells
from ..scans.depth_image import filled
from ..scans.levelling import Levelling, level
from ..scans.neighbors import NearPoints, crowded, nearest_others
from ..scans.scan import Scan, require_surfaces
from ..segmentation.clusters import bounding_box, euclidean_clusters, members_of
from ..segmentation.segmentation import FLOOR, LEFT_OVER, WALL, Segmentation, Shell, segment
from ..settings import POOL, RECOGNITION, SCAN, SEGMENTATION
from .completion import DEFAULT, sheet_within, smoothed
from .inferring import inferred_seats
from .judging import (
    RecognitionContext,
    classify_parts,
    classify_proposals,
    surroundings_for,
    unsure_ranges,
)
from .proposals import CLUSTERS, KINDS, Proposal, Scene, cluster_proposals, propose
from .room import THRESHOLDS, ObjectCandidate, Room, SceneObject, choose_objects
from .surroundings import surroundings_alone

TABLE_TOP = "table top"  # `Levelling.source`, and `SceneObject.made_from`


@dataclass(frozen=True, kw_only=True, eq=False)
class RoomFrame:
    """What stays as it is while a room's objects change."""

    levelling: Levelling
    shell: Shell


@dataclass(frozen=True, kw_only=True, eq=False)
class GroundTop:
    """The table top at z = 0 of the level frame."""

    members: np.ndarray  # (K,) int64, ascending, of the scene's points
    height: float | None  # over the floor, metres; None where it is unknown


def ground_top_of(points: np.ndarray, labels: np.ndarray, levelling: Levelling) -> GroundTop | None:
    """Return the table top that carries a scene of points (N, 3) and labels (N,); None where a floor does."""
    on_ground = np.flatnonzero(labels == FLOOR)
    if levelling.source != TABLE_TOP or not len(on_ground):
        return None
    voxels = cells(points[on_ground], SEGMENTATION.leaf_size)
    parts = members_of(euclidean_clusters(voxels.means, POOL.slab))
    largest = np.zeros(len(voxels.means), bool)
    largest[max(parts, key=len)] = True
    return GroundTop(members=on_ground[largest[voxels.cell_of]], height=height_in_scan(points, levelling))


def height_in_scan(points: np.ndarray, levelling: Levelling) -> float | None:
    """Return the height of the level frame's z = 0 over the scan's own z = 0, metres, if the latter is the floor.

    It is the floor if the scan's z axis points up, all points (N, 3) lie above its z = 0, and tables have that height.
    """
    height, lowest = levelling.height, float(points[:, 2].min())
    on_floor = levelling.up[2] > np.cos(SCAN.aligned) and lowest + height > -POOL.slab
    return height if on_floor and RECOGNITION.frame_heights[0] < height < RECOGNITION.frame_heights[1] else None


def object_of_top(top: GroundTop, points: np.ndarray, context: RecognitionContext, number: int) -> SceneObject:
    """Return the top as an object, classified as a whole sheet, since objects on it hide parts of it.

    Spheres fall on the convex outline of the visible part, at its height over the floor, or at the usual height of
    tables if that is unknown. ``number`` is its id.
    """
    from scipy.spatial import ConvexHull

    members = points[top.members]
    height = RECOGNITION.usual_height if top.height is None else top.height
    box = bounding_box(members)
    sheet = sheet_within(ConvexHull(members[:, :2]), *corners_of(members), 0.0)
    proposal = Proposal(by=CLUSTERS, members=top.members, support=-height, box=bounding_box(sheet))
    functions = classify_parts([proposal], [sheet], replace(context, completion=()))[0]
    return SceneObject(
        id=number,
        points=members,
        support=-(top.height or 0.0),
        box=box if top.height is None else box.lowered(-top.height),
        fragment=False,
        functions=functions,
        made_from=TABLE_TOP,
        height=top.height,
    )


def compile_kernels():
    """Compile or load the kernels of clusters and smoothing, so that the times of stages do not include it."""
    few = np.random.default_rng(0).uniform(0, 0.05, (50, 3))
    smoothed(few)
    crowded(few, 0.02)
    nearest_others(few, np.arange(1), 0.02)
    NearPoints(few, 0.02).to(few)
    surroundings(few, few)
    euclidean_clusters(few, 0.02)
    surroundings_alone(few, np.ptp(few, axis=0))


# More threads would spend more time waiting than computing, in products of a few hundred thousand points.
@threadpool_limits.wrap(limits=1, user_api="blas")
def recognise(
    scan: Scan,
    model: FunctionModel,
    *,
    up: str | ArrayLike = "auto",
    settings: Segmentation | None = None,
    completion: Sequence[str] = DEFAULT,
    proposals: Sequence[str] = KINDS,
    frame: RoomFrame | None = None,
) -> Room:
    """Find the objects of a scan and classify each.

    Parameters
    ----------
    scan : Scan
    model : FunctionModel
        Trained on whole models, as in the paper, or on scans.
    up : str or (3,) array_like
        See `levelling.level`.
    settings : Segmentation
    completion : sequence of str
        See `completion.complete`.
    proposals : sequence of {"clusters", "pools"}
        See `proposals.propose`.
    frame : RoomFrame, optional
        Of the room that the scan is a part of, if it is known; otherwise it is found in the scan.
    """
    require_kind("settings", settings, Segmentation)
    settings, watch = settings or Segmentation(), Stopwatch()
    fine = cells(scan.points, POOL.spacing) if len(scan) > RECOGNITION.many else None
    seen = scan.points if fine is None else fine.means
    if frame is None:
        require_surfaces(seen, scan.name)
    watch.lap("thinning")
    levelling = level(seen, up, scan.name) if frame is None else frame.levelling
    watch.lap("floor")
    points = levelling.to_level(seen)
    dense = filled(points, settings.leaf_size)
    watch.lap("filling")
    labels = segment(dense, settings, noise=levelling.noise, shell=None if frame is None else frame.shell)
    watch.lap("clusters")
    scene = Scene(points=dense, labels=labels, on_table=levelling.source == "table top")
    proposed = propose(scene, model.simulator, proposals, seed=model.seed)
    watch.lap("pools")
    thresholds = None if model.run_limit.drops is None else THRESHOLDS  # votes of cubes are no probabilities
    around = surroundings_for(model, dense, labels == WALL)
    context = RecognitionContext(model=model, completion=completion, thresholds=thresholds, surroundings=around)
    candidates = classify_proposals(dense, proposed, context, watch)
    objects = [one for one in choose_objects(candidates, SEGMENTATION.min_cluster_size) if not one.fragment]
    top = ground_top_of(dense, labels, levelling)
    labels, items = labels_of(objects, labels), [scene_object(k, dense, one) for k, one in enumerate(objects)]
    watch.lap("choice")
    inferred = inferred_seats(dense, labels, items)
    if top is not None:
        labels[top.members] = len(items)
        items.append(object_of_top(top, dense, context, len(items)))
    watch.lap("inferring")
    labels = labels[: len(points)]
    return Room(
        levelling=levelling,
        labels=labels if fine is None else labels[fine.cell_of],
        objects=items,
        proposals=[scene_object(number, dense, one) for number, one in enumerate(candidates)],
        inferred=inferred,
        stages=watch.seconds,
        thresholds=thresholds,
        unsure_ranges=unsure_ranges(model),
    )


def recognise_objects(
    points: np.ndarray, labels: np.ndarray, model: FunctionModel, *, completion: Sequence[str] = DEFAULT
) -> list[SceneObject]:
    """Classify each object of a segmented scan.

    Parameters
    ----------
    points : (N, 3) float64, metres, level frame
    labels : (N,) int
        The object of each point, numbered from 0; negative for points of no object.
    model, completion
        See `recognise`.
    """
    context = RecognitionContext(model=model, completion=completion)
    candidates = classify_proposals(points, cluster_proposals(points, labels), context, Stopwatch())
    return [scene_object(number, points, candidate) for number, candidate in enumerate(candidates)]


def scene_object(number: int, points: np.ndarray, candidate: ObjectCandidate) -> SceneObject:
    """Return an object of a scene's points (N, 3)."""
    members, support = points[candidate.proposal.members], candidate.proposal.support
    box = candidate.proposal.box or bounding_box(members)
    return SceneObject(
        id=number,
        points=members,
        support=support,
        box=box.lowered(support),
        fragment=candidate.fragment,
        functions=candidate.functions,
        screened=candidate.screened,
        proposed_by=candidate.proposal.by,
    )


def labels_of(objects: Sequence[ObjectCandidate], labels: np.ndarray) -> np.ndarray:
    """Return the object of each point (N,) int32; points of clusters that are no objects are left over."""
    numbered = np.where(labels >= 0, LEFT_OVER, labels).astype(np.int32)
    for number, one in enumerate(objects):
        numbered[one.proposal.members] = number
    return numbered
