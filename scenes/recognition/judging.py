"""What a model says of proposals, each completed, and of what surrounds them."""

from __future__ import annotations

import logging
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from spherefunc_bullet.clouds.cloud import Cloud
from spherefunc_bullet.errors import InputError
from spherefunc_bullet.formats.units import Stopwatch
from spherefunc_bullet.function_model import FunctionModel, Membership
from spherefunc_bullet.learning.profiles.profile_model import ProfileModel
from spherefunc_bullet.settling.drops import DropsByRadius
from spherefunc_bullet.settling.settling import settle_all

from ..pools.surfaces import Pool
from ..pools.tops import levelled
from ..scans.cells import cells
from ..segmentation.clusters import Box, bounding_box
from ..settings import RECOGNITION, SEGMENTATION
from .completion import TOP, complete
from .proposals import Proposal
from .room import ClaimThreshold, ObjectCandidate, candidate_with_claims
from .surroundings import NAMES, ScanSurroundings

Memberships = dict[str, Membership]  # by the function's name


logger = logging.getLogger("spherefunc")


@dataclass(frozen=True, kw_only=True, eq=False)
class RecognitionContext:
    """How proposals are asked about."""

    model: FunctionModel
    completion: Sequence[str]  # see `completion.complete`
    bars: Mapping[str, ClaimThreshold] | None = (
        None  # scores above which each kind claims a function; else the model's own
    )
    surroundings: ScanSurroundings | None = None  # of the scene, if the model has learnt such


class ScanPart(NamedTuple):
    """A proposal with its points (K, 3) and their box."""

    proposal: Proposal
    points: np.ndarray
    box: Box


def surroundings_for(model: FunctionModel, points: np.ndarray, is_wall: np.ndarray) -> ScanSurroundings | None:
    """Return the surroundings in a scene of points (N, 3), some of walls (N,) bool, for a model that has learnt such.

    Raises
    ------
    InputError
        If it has learnt other ones than these.
    """
    scenes = model.scene_forests_ if isinstance(model, ProfileModel) else None
    if scenes is None:
        return None
    if scenes.names != NAMES:
        raise InputError("the model has learnt other surroundings than this version reads; train it again")
    return ScanSurroundings(points=points, is_wall=is_wall)


def classify_proposals(
    points: np.ndarray, proposals: Sequence[Proposal], context: RecognitionContext, watch: Stopwatch
) -> list[ObjectCandidate]:
    """Return what a model says of each proposal.

    A fragment has no function, whatever the few spheres on it would look like, so none are dropped there.

    Parameters
    ----------
    points : (N, 3) float64, metres, level frame
    watch : Stopwatch
        Receives the seconds of each step.
    """
    parts = [scan_part(points, proposal) for proposal in proposals]
    whole = [not is_fragment(part.points, part.box, part.proposal.support) for part in parts]
    predictions = iter(
        classify_parts([part for part, proposal in zip(parts, whole, strict=True) if proposal], context, watch)
    )
    radius = context.model.radius_
    nothing = {name: Membership(member=False, score=0.0, radius=radius[name]) for name in context.model.functions_}
    return [
        ObjectCandidate(
            proposal=part.proposal,
            functions=next(predictions) if proposal else nothing,
            place=place,
            fragment=not proposal,
        )
        for place, (part, proposal) in enumerate(zip(parts, whole, strict=True))
    ]


def scan_part(points: np.ndarray, proposal: Proposal) -> ScanPart:
    """Return a proposal with its own of a scene's points (N, 3), and their box."""
    members = points[proposal.members]
    box = proposal.box or bounding_box(members)
    return ScanPart(replace(proposal, box=box), members, box)


def classify_parts(
    parts: Sequence[ScanPart], context: RecognitionContext, watch: Stopwatch | None = None
) -> list[Memberships]:
    """Return what a model says of parts that are no fragments, completed, on which spheres fall."""
    watch = watch or Stopwatch()
    clouds = [
        object_cloud(part.points, context.completion, part.proposal.support, part.proposal.pool, part.box)[0]
        for part in parts
    ]
    watch.lap("completion")
    settled = settle_parts(clouds, context.model)
    watch.lap("spheres")
    functions = classify_dropped(parts, settled, context)
    watch.lap("classification")
    return functions


def classify_dropped(
    parts: Sequence[ScanPart], settled: Sequence[DropsByRadius], context: RecognitionContext
) -> list[Memberships]:
    """Return what a model says of parts of a scene on which spheres have fallen."""
    if context.surroundings is None or not parts:
        predictions = context.model.memberships_of(settled, any_heading=True)
    else:
        around = context.surroundings.of
        surroundings = [around(part.points, part.box.size, part.proposal.support) for part in parts]
        predictions = context.model.scene_memberships(settled, np.array(surroundings))
    if context.bars is None:
        return predictions
    return [
        candidate_with_claims(prediction, context.bars[part.proposal.by])
        for prediction, part in zip(predictions, parts, strict=True)
    ]


def is_fragment(points: np.ndarray, box: Box, support: float) -> bool:
    """Return whether points (N, 3) are a part of something that is not seen whole: small, and carried by nothing."""
    return bool(box.size.max() < SEGMENTATION.large and points[:, 2].min() > support + RECOGNITION.floats)


def object_cloud(
    points: np.ndarray, completion: Sequence[str], support: float, pool: Pool | None = None, box: Box | None = None
) -> tuple[Cloud, Box]:
    """Return an object as spheres see it, completed, standing on its support, its long side along x; and its box."""
    box = box or bounding_box(points)
    spacing = value_for_size(RECOGNITION.spacings, box.size.max())
    seen = cells(points, spacing).means if spacing else points
    even = levelled(seen, pool) if pool is not None and TOP in completion else seen
    whole = complete(even, completion, support=support)
    local = (whole - [*box.center[:2], support]) @ box.axes.T
    return Cloud(local, "object"), box


def settle_parts(clouds: Sequence[Cloud], model: FunctionModel) -> list[DropsByRadius]:
    """Return where spheres settle on each object, for each radius that the model looks at and that tells something.

    An object that the simulator cannot do holds no spheres, and that is logged.
    """
    settled: list[DropsByRadius] = [{} for _ in clouds]
    radii = [informative_radii(cloud, model) for cloud in clouds]
    names = [cloud.name for cloud in clouds]
    for number, outcome in settle_all(clouds, model.simulator, radii, model.seed, names, model.run_limit):
        if isinstance(outcome, InputError):
            logger.warning("object %d: %s", number, outcome)
        else:
            settled[number] = outcome
    return settled


def value_for_size(choices: Sequence[tuple[float, float]], side: float) -> float:
    """Return what an object's largest side chooses, 0 for what is small."""
    return next((value for least, value in choices if side >= least), 0.0)


def informative_radii(cloud: Cloud, model: FunctionModel) -> list[float]:
    """Return the radii that tell something of an object, metres; resting profiles need all that were learnt."""
    if model.run_limit.drops is not None:
        return model.chosen_radii()
    smallest = value_for_size(RECOGNITION.smallest_radii, cloud.size.max())
    return [radius for radius in model.chosen_radii() if radius >= smallest]
