"""From a scan to objects and what they are for (paper, §IV-C and Fig. 6)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from threadpoolctl import threadpool_limits

from spherefunc_bullet.formats.units import Stopwatch
from spherefunc_bullet.function_model import FunctionModel

from ..pools.vessels import surroundings
from ..scans.cells import cells
from ..scans.filling import filled
from ..scans.levelling import level
from ..scans.neighbors import Near, crowded
from ..scans.scan import Scan
from ..segmentation.box import bounding_box
from ..segmentation.clusters import euclidean_clusters
from ..segmentation.segmentation import LEFT_OVER, WALL, Segmentation, segment
from .choosing import BARS, Candidate, chosen
from .completion import DEFAULT
from .ground_top import ground_top_of, object_of_top
from .inferring import inferred_seats
from .judging import RecognitionContext, is_fragment, judged, surroundings_for
from .proposals import KINDS, Scene, cluster_proposals, propose
from .room import Room, SceneObject
from .smoothing import smoothed

MANY = 2_000_000  # points: what has more is thinned before anything else
FINE = 0.004  # metres, side of the voxels that it is thinned to: the spacing of clouds that are sampled from meshes
FEWEST = 60  # points of an object


def compile_kernels():
    """Have the kernels of clusters and smoothing compiled, or loaded, so that stages are timed without that."""
    few = np.random.default_rng(0).uniform(0, 0.05, (50, 3))
    smoothed(few)
    crowded(few, 0.02)
    Near(few, 0.02).to(few)
    surroundings(few, few)
    euclidean_clusters(few, 0.02)


# Products of a few hundred thousand points with three numbers each: more threads wait longer than they compute.
@threadpool_limits.wrap(limits=1, user_api="blas")
def recognise(
    scan: Scan,
    model: FunctionModel,
    *,
    up: str = "auto",
    settings: Segmentation | None = None,
    completion: Sequence[str] = DEFAULT,
    proposals: Sequence[str] = KINDS,
) -> Room:
    """Find the objects of a scan and tell what each is for.

    Parameters
    ----------
    scan : Scan
    model : FunctionModel
        Trained on whole models, as the paper did, or on scans.
    up : str
        See `levelling.level`.
    settings : Segmentation
    completion : sequence of str
        See `completion.complete`.
    proposals : sequence of {"clusters", "pools"}
        See `proposals.propose`.
    """
    settings, watch = settings or Segmentation(), Stopwatch()
    fine = cells(scan.points, FINE) if len(scan) > MANY else None
    seen = scan.points if fine is None else fine.means
    watch.lap("thinning")
    levelling = level(seen, up, scan.name)
    watch.lap("floor")
    points = levelling.to_level(seen)
    camera = None if levelling.camera is None else levelling.to_level(levelling.camera[None])[0]
    dense = filled(points, settings.leaf_size)
    watch.lap("filling")
    labels = segment(dense, settings, noise=levelling.noise, camera=camera)
    watch.lap("clusters")
    scene = Scene(points=dense, labels=labels, on_table=levelling.source == "table top")
    proposed = propose(scene, model.simulator, proposals, seed=model.seed)
    watch.lap("pools")
    bars = None if model.length.drops is None else BARS  # cubes' votes are no probabilities
    around = surroundings_for(model, dense, labels == WALL)
    context = RecognitionContext(
        model=model, completion=completion, ground_seen=levelling.floor_seen, bars=bars, surroundings=around
    )
    candidates = judged(dense, proposed, context, watch)
    objects = chosen(candidates, FEWEST)
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
        bars=bars,
    )


def recognise_objects(
    points: np.ndarray, labels: np.ndarray, model: FunctionModel, *, completion: Sequence[str] = DEFAULT
) -> list[SceneObject]:
    """Tell what each object of a segmented scan is for.

    Parameters
    ----------
    points : (N, 3) float64, metres, level frame
    labels : (N,) int
        The object of each point, numbered from 0; below, of none.
    model, completion
        See `recognise`.
    """
    context = RecognitionContext(model=model, completion=completion)
    candidates = judged(points, cluster_proposals(points, labels), context, Stopwatch())
    return [scene_object(number, points, one) for number, one in enumerate(candidates)]


def scene_object(number: int, points: np.ndarray, candidate: Candidate) -> SceneObject:
    """Return an object of a scene's points (N, 3)."""
    own, support = points[candidate.proposal.members], candidate.proposal.support
    box = candidate.proposal.box or bounding_box(own)
    return SceneObject(
        id=number,
        points=own,
        support=support,
        box=box.lowered(support),
        fragment=is_fragment(own, box, support),
        functions=candidate.functions,
        proposed_by=candidate.proposal.by,
    )


def labels_of(objects: Sequence[Candidate], labels: np.ndarray) -> np.ndarray:
    """Return the object of each point (N,) int32; what was a cluster and is no object any more is left over."""
    numbered = np.where(labels >= 0, LEFT_OVER, labels).astype(np.int32)
    for number, one in enumerate(objects):
        numbered[one.proposal.members] = number
    return numbered
