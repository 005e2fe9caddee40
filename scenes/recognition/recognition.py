"""From a scan to objects and what they are for (paper, §IV-C and Fig. 6)."""

from __future__ import annotations

import logging
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from spherefunc_bullet.clouds.cloud import Cloud
from spherefunc_bullet.errors import InputError
from spherefunc_bullet.learning.function_model import FunctionModel, Membership
from spherefunc_bullet.quantities import Stopwatch
from spherefunc_bullet.settling.settling import Settled, settle_all

from ..pools.levelling import levelled
from ..pools.surfaces import Pool
from ..scans.cells import cells
from ..scans.filling import crowded, filled
from ..scans.levelling import level
from ..scans.scan import Scan
from ..segmentation.box import Box, bounding_box
from ..segmentation.clusters import euclidean_clusters
from ..segmentation.segmentation import LEFT_OVER, Segmentation, segment
from .assumed_ground import holding_anywhere
from .choosing import BARS, Candidate, chosen, claiming
from .completion import DEFAULT, TOP, complete
from .inferring import inferred_seats
from .proposals import KINDS, Proposal, Scene, cluster_proposals, propose
from .room import Room, SceneObject
from .smoothing import smoothed

logger = logging.getLogger("spherefunc")
LARGE = 0.5  # metres: what is larger is no cup, and holds no small thing that a fragment would be one of
# Smallest radii by an object's largest side, both metres. Small spheres on large things take seconds and tell nothing
# that larger ones do not: on whole models 2, 3 and 5 cm alone tell sittables and tables as well (README).
SMALLEST_RADII = ((1.0, 0.02), (LARGE, 0.01))
SPACINGS = ((1.0, 0.008), (LARGE, 0.005))  # metres likewise, side of the voxels that are enough for such spheres
MANY = 2_000_000  # points: what has more is thinned before anything else
FINE = 0.004  # metres, side of the voxels that it is thinned to: the spacing of clouds that are sampled from meshes
FEWEST = 60  # points of an object
FLOATS = 0.10  # metres above its support: what begins higher does not stand


def compile_kernels():
    """Have the kernels of clusters and smoothing compiled, or loaded, so that stages are timed without that."""
    few = np.random.default_rng(0).uniform(0, 0.05, (50, 3))
    smoothed(few)
    crowded(few, 0.02)
    euclidean_clusters(few, 0.02)


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
    candidates = judged(dense, proposed, model, completion, watch, ground_seen=levelling.floor_seen, bars=bars)
    objects = chosen(candidates, FEWEST)
    labels, items = labels_of(objects, labels), [scene_object(k, dense, one) for k, one in enumerate(objects)]
    watch.lap("choice")
    inferred = inferred_seats(dense, labels, items)
    watch.lap("inferring")
    labels = labels[: len(points)]
    return Room(
        levelling=levelling,
        labels=labels if fine is None else labels[fine.cell_of],
        objects=items,
        proposals=[scene_object(number, dense, one) for number, one in enumerate(candidates)],
        inferred=inferred,
        stages=watch.seconds,
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
    candidates = judged(points, cluster_proposals(points, labels), model, completion, Stopwatch())
    return [scene_object(number, points, one) for number, one in enumerate(candidates)]


def judged(
    points: np.ndarray,
    proposals: Sequence[Proposal],
    model: FunctionModel,
    completion: Sequence[str],
    watch: Stopwatch,
    ground_seen: bool = True,
    bars: Mapping[str, float] | None = None,
) -> list[Candidate]:
    """Return what a model says of each proposal; a fragment is for nothing, whatever the few spheres on it look like.

    Parameters
    ----------
    points : (N, 3) float64, metres, level frame
    watch : Stopwatch
        Receives the seconds of each step.
    ground_seen : bool
        Whether z = 0 is a surface of the scene; else large things are told what they are wherever it may lie.
    bars : dict of str to float, optional
        Scores above which proposals of each kind claim a function; without, those above which the model does.
    """
    clouds = [object_cloud(points[one.members], completion, one.support, one.pool) for one in proposals]
    watch.lap("completion")
    settled = settled_on([cloud for cloud, _ in clouds], model)
    watch.lap("spheres")
    functions = model.memberships_of(settled, any_heading=True)
    if bars is not None:
        functions = [claiming(told, bars[one.by]) for told, one in zip(functions, proposals, strict=True)]
    if not ground_seen:
        functions = holding_anywhere([cloud for cloud, _ in clouds], functions, partial(told_of, model=model), LARGE)
    watch.lap("classification")
    candidates = []
    for place, (proposal, told) in enumerate(zip(proposals, functions, strict=True)):
        if is_fragment(points[proposal.members], clouds[place][1], proposal.support):
            told = {name: replace(membership, member=False) for name, membership in told.items()}
        candidates.append(Candidate(proposal=proposal, functions=told, place=place))
    return candidates


def told_of(clouds: Sequence[Cloud], model: FunctionModel) -> list[dict[str, Membership]]:
    """Return what a model says of clouds."""
    return model.memberships_of(settled_on(clouds, model), any_heading=True)


def is_fragment(points: np.ndarray, box: Box, support: float) -> bool:
    """Return whether points (N, 3) are a part of something that is not seen whole: small, and carried by nothing."""
    return bool(box.size.max() < LARGE and points[:, 2].min() > support + FLOATS)


def scene_object(number: int, points: np.ndarray, candidate: Candidate) -> SceneObject:
    """Return an object of a scene's points (N, 3)."""
    own, support = points[candidate.proposal.members], candidate.proposal.support
    box = bounding_box(own)
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


def object_cloud(
    points: np.ndarray, completion: Sequence[str], support: float, pool: Pool | None = None
) -> tuple[Cloud, Box]:
    """Return an object as spheres see it, completed, standing on its support, its long side along x; and its box."""
    box = bounding_box(points)
    spacing = value_for_size(SPACINGS, box.size.max())
    seen = cells(points, spacing).means if spacing else points
    even = levelled(seen, pool) if pool is not None and TOP in completion else seen
    whole = complete(even, completion, support=support)
    own = (whole - [*box.center[:2], support]) @ box.axes.T
    return Cloud(own, "object"), box


def settled_on(clouds: Sequence[Cloud], model: FunctionModel) -> list[Settled]:
    """Return where spheres settle on each object, for each radius that the model looks at and that tells something.

    An object that the simulator cannot do holds no spheres, and that is logged.
    """
    settled: list[Settled] = [{} for _ in clouds]
    radii = [telling_radii(cloud, model) for cloud in clouds]
    names = [cloud.name for cloud in clouds]
    for number, outcome in settle_all(clouds, model.simulator, radii, model.seed, names, model.length):
        if isinstance(outcome, InputError):
            logger.warning("object %d: %s", number, outcome)
        else:
            settled[number] = outcome
    return settled


def value_for_size(choices: Sequence[tuple[float, float]], side: float) -> float:
    """Return what an object's largest side chooses, 0 for what is small."""
    return next((value for least, value in choices if side >= least), 0.0)


def telling_radii(cloud: Cloud, model: FunctionModel) -> list[float]:
    """Return the radii that tell something of an object, metres; resting profiles need all that were learnt."""
    if model.length.drops is not None:
        return model.chosen_radii()
    smallest = value_for_size(SMALLEST_RADII, cloud.size.max())
    return [radius for radius in model.chosen_radii() if radius >= smallest]
