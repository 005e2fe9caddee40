"""From a scan to objects and what they are for (paper, §IV-C and Fig. 6)."""

from __future__ import annotations

import logging
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from spherefunc_bullet.clouds.cloud import Cloud
from spherefunc_bullet.errors import InputError
from spherefunc_bullet.learning.function_model import FunctionModel, Membership
from spherefunc_bullet.quantities import Stopwatch
from spherefunc_bullet.settling.settling import Settled, settle_all

from ..scans.cells import cells
from ..scans.filling import filled
from ..scans.levelling import Levelling, level
from ..scans.scan import Scan
from ..segmentation.box import Box, bounding_box
from ..segmentation.clusters import euclidean_clusters, members_of
from ..segmentation.segmentation import Segmentation, segment
from ..segmentation.supports import top_below
from .completion import DEFAULT, complete
from .smoothing import smoothed

logger = logging.getLogger("spherefunc")
LARGE = 0.5  # metres: what is larger is no cup, and holds no small thing that a fragment would be one of
# Smallest radii by an object's largest side, both metres. Small spheres on large things take seconds and tell nothing
# that larger ones do not: on whole models 2, 3 and 5 cm alone tell sittables and tables as well (README).
SMALLEST_RADII = ((1.0, 0.02), (LARGE, 0.01))
SPACINGS = ((1.0, 0.008), (LARGE, 0.005))  # metres likewise, side of the voxels that are enough for such spheres
MANY = 2_000_000  # points: what has more is thinned before anything else
FINE = 0.004  # metres, side of the voxels that it is thinned to: the spacing of clouds that are sampled from meshes
FLOATS = 0.10  # metres above its support: what begins higher does not stand


@dataclass(frozen=True, kw_only=True, eq=False)
class SceneObject:
    """One object of a room."""

    id: int  # its label in `Room.labels`
    points: np.ndarray  # (N, 3) float64, metres, level frame; of a scan of many points, thinned
    support: float  # the height it stands on, metres
    box: Box  # in the level frame, down to the support: legs that are not seen are there all the same
    fragment: bool  # small, and carried by nothing: a part of something that is not seen whole
    functions: dict[str, Membership]

    @property
    def members(self) -> frozenset[str]:
        """The functions that it has."""
        return frozenset(name for name, membership in self.functions.items() if membership.member)

    @property
    def main_function(self) -> str | None:
        """The function of the best score that it has, None for none."""
        scores = {name: membership.score for name, membership in self.functions.items() if membership.member}
        return max(scores, key=scores.get) if scores else None


@dataclass(frozen=True, kw_only=True, eq=False)
class Room:
    """What was found in a scan."""

    levelling: Levelling
    labels: np.ndarray  # (N,) int32 of the scan's points: an object's id, -1 floor, -2 wall or ceiling, -3 left over
    objects: list[SceneObject]
    stages: dict[str, float] = field(default_factory=dict)  # seconds that each step took

    @property
    def function_names(self) -> list[str]:
        """The functions that objects were asked for; none without objects."""
        return list(self.objects[0].functions) if self.objects else []

    def box_in_scan(self, box: Box) -> Box:
        """Return a box of the level frame in the scan's, where that is level too; else its corners tell more."""
        center = self.levelling.to_scan(box.center[None])[0]
        x = box.axes[0] @ self.levelling.T_level_scan[:3, :3]
        return Box(center=center, size=box.size, yaw=float(np.arctan2(x[1], x[0])))


def compile_kernels():
    """Have the kernels of clusters and smoothing compiled, or loaded, so that stages are timed without that."""
    few = np.random.default_rng(0).uniform(0, 0.05, (50, 3))
    smoothed(few)
    euclidean_clusters(few, 0.02)


def recognise(
    scan: Scan,
    model: FunctionModel,
    *,
    up: str = "auto",
    settings: Segmentation | None = None,
    completion: Sequence[str] = DEFAULT,
) -> Room:
    """Find the objects of a scan and tell what each is for.

    Parameters
    ----------
    scan : Scan
    model : CubeClassifier
        Trained on whole models, as the paper did, or on scans.
    up : str
        See `levelling.level`.
    settings : Segmentation
    completion : sequence of str
        See `completion.complete`.
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
    objects = recognise_objects(dense, labels, model, completion=completion, watch=watch)
    labels = labels[: len(points)] if fine is None else labels[fine.cell_of]
    return Room(levelling=levelling, labels=labels, objects=objects, stages=watch.seconds)


def recognise_objects(
    points: np.ndarray,
    labels: np.ndarray,
    model: FunctionModel,
    *,
    completion: Sequence[str] = DEFAULT,
    watch: Stopwatch | None = None,
) -> list[SceneObject]:
    """Tell what each object of a segmented scan is for.

    Parameters
    ----------
    points : (N, 3) float64, metres, level frame
    labels : (N,) int
        The object of each point, numbered from 0; below, of none.
    model, completion
        See `recognise`.
    watch : Stopwatch, optional
        Receives the seconds of each step.
    """
    watch = watch or Stopwatch()
    parts = [points[members] for members in members_of(labels)]
    supports = support_heights(parts)
    watch.lap("supports")
    clouds = [object_cloud(part, completion, support) for part, support in zip(parts, supports, strict=True)]
    watch.lap("completion")
    settled = settled_on([cloud for cloud, _ in clouds], model)
    watch.lap("spheres")
    functions = model.memberships_of(settled, any_heading=True)
    watch.lap("classification")
    return [scene_object(k, parts[k], supports[k], clouds[k][1], functions[k]) for k in range(len(parts))]


def scene_object(
    number: int, points: np.ndarray, support: float, box: Box, functions: dict[str, Membership]
) -> SceneObject:
    """Return an object; a fragment is for nothing, whatever the few spheres on it look like."""
    fragment = bool(box.size.max() < LARGE and points[:, 2].min() > support + FLOATS)
    if fragment:
        functions = {name: replace(membership, member=False) for name, membership in functions.items()}
    return SceneObject(
        id=number, points=points, support=support, box=box.lowered(support), fragment=fragment, functions=functions
    )


def support_heights(parts: list[np.ndarray]) -> list[float]:
    """Return the height that each object stands on, metres: the top of what is right below it, else the floor's 0."""
    lows, highs = (np.array([end(part, axis=0) for part in parts]).reshape(-1, 3) for end in (np.min, np.max))
    return [top_below(k, parts, lows, highs) for k in range(len(parts))]


def object_cloud(points: np.ndarray, completion: Sequence[str], support: float) -> tuple[Cloud, Box]:
    """Return an object as spheres see it, completed, standing on its support, its long side along x; and its box."""
    box = bounding_box(points)
    spacing = value_for_size(SPACINGS, box.size.max())
    whole = complete(cells(points, spacing).means if spacing else points, completion, support=support)
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
