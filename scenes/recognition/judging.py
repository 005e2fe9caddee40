"""Proposals classified by a model: each is completed, spheres are dropped on it, and its surroundings are read."""

from __future__ import annotations

import logging
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from spherefunc_bullet.clouds.cloud import Cloud
from spherefunc_bullet.errors import InputError
from spherefunc_bullet.formats.units import Stopwatch
from spherefunc_bullet.function_model import FunctionModel, Membership
from spherefunc_bullet.learning.profiles.calibration import ScoreRange
from spherefunc_bullet.learning.profiles.profile_model import ProfileModel
from spherefunc_bullet.processes.tasks import run_tasks
from spherefunc_bullet.settling.drops import DropsByRadius
from spherefunc_bullet.settling.settling import settle
from spherefunc_bullet.simulator import isolated, make_simulator

from ..pools.surfaces import Pool
from ..pools.tops import levelled
from ..scans.cells import cells
from ..segmentation.clusters import Box, bounding_box
from ..settings import RECOGNITION, SEGMENTATION
from .completion import TOP, complete
from .proposals import Proposal
from .room import UNSURE_RANGE, ClaimThreshold, ObjectCandidate, with_claims
from .surroundings import NAMES, ScanSurroundings

logger = logging.getLogger("spherefunc")


@dataclass(frozen=True, kw_only=True, eq=False)
class RecognitionContext:
    """The model, completion, thresholds and surroundings with which proposals are classified."""

    model: FunctionModel
    completion: Sequence[str]  # see `completion.complete`
    thresholds: Mapping[str, ClaimThreshold] | None = None  # by the source of proposals; None: the model's own
    surroundings: ScanSurroundings | None = None  # of the scene, if the model has learnt any

    def read_surroundings(self, proposals: Sequence[Proposal], parts: Sequence[np.ndarray]) -> np.ndarray | None:
        """Return the surroundings (N, S) of proposals with their boxes and points (K, 3); None without a scene."""
        if self.surroundings is None:
            return None
        pairs = zip(proposals, parts, strict=True)
        read = [self.surroundings.of(part, one.box.size, one.support) for one, part in pairs]
        return np.array(read).reshape(-1, len(NAMES))

    def passes(self, surroundings: np.ndarray) -> np.ndarray:
        """Return which proposals with surroundings (N, S) are worth dropping spheres on, (N,) bool."""
        screening = self.model.scene_forests_.screening
        return np.ones(len(surroundings), bool) if screening is None else screening.passes(surroundings)


def surroundings_for(model: FunctionModel, points: np.ndarray, is_wall: np.ndarray) -> ScanSurroundings | None:
    """Return the surroundings in a scene of points (N, 3), some of walls (N,) bool; None if the model learnt none.

    Raises
    ------
    InputError
        If the model has learnt other quantities than these.
    """
    scenes = model.scene_forests_ if isinstance(model, ProfileModel) else None
    if scenes is None:
        return None
    if scenes.names != NAMES:
        raise InputError("the model has learnt other surroundings than this version reads; train it again")
    return ScanSurroundings(points=points, is_wall=is_wall)


def unsure_ranges(model: FunctionModel) -> dict[str, ScoreRange]:
    """Return the range of scores in which each function is unsure in scans; none for models of cubes."""
    if not isinstance(model, ProfileModel):
        return {}
    known = model.scene_forests_ is not None
    return {name: UNSURE_RANGE if known else model.unsure_range(name) for name in model.functions_}


def classify_proposals(
    points: np.ndarray, proposals: Sequence[Proposal], context: RecognitionContext, watch: Stopwatch
) -> list[ObjectCandidate]:
    """Return each proposal with its memberships.

    A fragment has no function, so no spheres are dropped on it; nor are they where the surroundings rule out all
    functions (see `forest.Screening`).

    Parameters
    ----------
    points : (N, 3) float64, metres, level frame
    watch : Stopwatch
        Receives the seconds of each step.
    """
    parts = [points[proposal.members] for proposal in proposals]
    boxed = [replace(one, box=one.box or bounding_box(part)) for one, part in zip(proposals, parts, strict=True)]
    fragments = [is_fragment(part, one.box, one.support) for one, part in zip(boxed, parts, strict=True)]
    whole = [k for k, fragment in enumerate(fragments) if not fragment]
    around = context.read_surroundings([boxed[k] for k in whole], [parts[k] for k in whole])
    watch.lap("surroundings")
    passed = np.arange(len(whole)) if around is None else np.flatnonzero(context.passes(around))
    tried = [whole[k] for k in passed]
    around = None if around is None else around[passed]
    found = classify_parts([boxed[k] for k in tried], [parts[k] for k in tried], context, around, watch)
    functions, radius = dict(zip(tried, found, strict=True)), context.model.radius_
    nothing = {name: Membership(member=False, score=0.0, radius=radius[name]) for name in context.model.functions_}
    return [
        ObjectCandidate(
            proposal=one,
            functions=functions.get(place, nothing),
            place=place,
            fragment=fragments[place],
            screened=not fragments[place] and place not in functions,
        )
        for place, one in enumerate(boxed)
    ]


def classify_parts(
    proposals: Sequence[Proposal],
    parts: Sequence[np.ndarray],
    context: RecognitionContext,
    surroundings: np.ndarray | None = None,
    watch: Stopwatch | None = None,
) -> list[dict[str, Membership]]:
    """Return the memberships of proposals with their boxes and points (K, 3) that are no fragments.

    With their surroundings (N, S) they are classified by the forests that have learnt these.
    """
    watch, model = watch or Stopwatch(), context.model
    clouds = [
        object_cloud(part, context.completion, one.support, one.pool, one.box)[0]
        for one, part in zip(proposals, parts, strict=True)
    ]
    watch.lap("completion")
    settled = settle_parts(clouds, model)
    watch.lap("spheres")
    if surroundings is None:
        found = model.memberships_of(settled, any_heading=True)
    else:
        found = model.scene_memberships(settled, surroundings)
    if context.thresholds is not None:
        sources = [context.thresholds[one.by] for one in proposals]
        found = [with_claims(one, threshold) for one, threshold in zip(found, sources, strict=True)]
    watch.lap("classification")
    return found


def is_fragment(points: np.ndarray, box: Box, support: float) -> bool:
    """Return whether points (N, 3) are a part of an object that is not seen whole: small, and carried by nothing."""
    return bool(box.size.max() < SEGMENTATION.large and points[:, 2].min() > support + RECOGNITION.floats)


def object_cloud(
    points: np.ndarray, completion: Sequence[str], support: float, pool: Pool | None = None, box: Box | None = None
) -> tuple[Cloud, Box]:
    """Return an object's completed cloud, on its support and with its long side along x, and the object's box."""
    box = box or bounding_box(points)
    spacing = value_for_size(RECOGNITION.spacings, box.size.max())
    seen = cells(points, spacing).means if spacing else points
    even = levelled(seen, pool) if pool is not None and TOP in completion else seen
    whole = complete(even, completion, support=support)
    local = (whole - [*box.center[:2], support]) @ box.axes.T
    return Cloud(local, "object"), box


def settle_parts(clouds: Sequence[Cloud], model: FunctionModel) -> list[DropsByRadius]:
    """Return the drops on each object, by radius.

    Resting profiles need all radii that were learnt; cubes lose nothing without small spheres on large objects. An
    object that the simulator cannot handle holds no spheres, which is logged.
    """
    settled: list[DropsByRadius] = [{} for _ in clouds]
    simulator, profiles, tasks = make_simulator(model.simulator), model.run_limit.drops is not None, []
    for cloud in clouds:
        least = 0.0 if profiles else value_for_size(RECOGNITION.smallest_radii, cloud.size.max())
        radii = [radius for radius in model.chosen_radii() if radius >= least]
        tasks.append((cloud, simulator, radii, model.seed, model.run_limit))
    names = [cloud.name for cloud in clouds]
    for number, outcome in run_tasks(settle, tasks, names, isolate=isolated(simulator)):
        if isinstance(outcome, InputError):
            logger.warning("object %d: %s", number, outcome)
        else:
            settled[number] = outcome
    return settled


def value_for_size(choices: Sequence[tuple[float, float]], side: float) -> float:
    """Return the value of the first choice whose size an object's largest side reaches, 0 for small objects."""
    return next((value for least, value in choices if side >= least), 0.0)
