"""Poses: of an object turned at random, is the pose in which it is used found, and is it the best for its function?"""

from __future__ import annotations

import zlib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from spherefunc_bullet.clouds.cloud import load_cloud
from spherefunc_bullet.datasets.dataset import DatasetObject
from spherefunc_bullet.learning.any_pose import best_poses, pose_functions, turned_cloud
from spherefunc_bullet.learning.classifier import CloudClassifier
from spherefunc_bullet.settling.records import Loading
from spherefunc_bullet.simulator import Simulator
from spherefunc_bullet.simulator.mechanics import PoseSettings

from .tasks import asked, evenly

UPRIGHT_DEG = 10.0  # from the pose in which the file has it


@dataclass(frozen=True, kw_only=True)
class PoseScore:
    """How well one backend finds poses."""

    backend: str
    asked: int
    found: float  # share of objects whose upright pose is among them
    first: float  # the upright pose has the highest score of the object's function
    likeliest: float  # it is the likeliest pose
    poses: float  # of an object, in the mean
    seconds: float  # the median of the poses alone, by the clock
    right: dict[str, bool]  # by file: the pose of use is ranked first


def posed(
    path: Path, simulator: Simulator, loading: Loading, function: str, classifier: CloudClassifier
) -> dict[str, float]:
    """Return whether the pose of a file is found after it was turned at random, as its name says; see `PoseScore`."""
    turn = Rotation.random(random_state=zlib.crc32(path.name.encode())).as_matrix()
    cloud = turned_cloud(load_cloud(path, up=loading.up, units=loading.units), turn)
    result = simulator.poses(cloud, PoseSettings(), 0)
    upright = [(pose.rotation @ turn)[2, 2] > np.cos(np.radians(UPRIGHT_DEG)) for pose in result.poses]
    best = best_poses(pose_functions(cloud, result.poses, classifier))[function]
    shares = {"found": any(upright), "first": bool(upright[best]), "likeliest": bool(upright[0])}
    return shares | {"poses": len(upright), "seconds": result.seconds}


def score_poses(
    objects: Sequence[DatasetObject],
    simulator: Simulator,
    classifier: CloudClassifier,
    count: int | None,
    loading: Loading,
) -> PoseScore | None:
    """Return how well a backend finds the poses of objects that have a function; None where none has one."""
    chosen = evenly([item for item in objects if item.functions & set(classifier.functions_)], count)
    answers: dict[str, dict[str, float]] = {}
    for function in classifier.functions_:
        own = [item for item in chosen if main_function(item, classifier.functions_) == function]
        more = (f"posing by {simulator.name}", loading, function, classifier)
        for item, answer, _ in asked(posed, own, simulator, *more):
            answers[item.path.name] = answer
    found = list(answers.values())
    if not found:
        return None
    means = {key: float(np.mean([one[key] for one in found])) for key in ("found", "first", "likeliest", "poses")}
    return PoseScore(
        backend=simulator.name,
        asked=len(found),
        **means,
        seconds=float(np.median([one["seconds"] for one in found])),
        right={name: one["first"] for name, one in answers.items()},
    )


def main_function(item: DatasetObject, functions: Sequence[str]) -> str:
    """Return the one function by which an object's poses are ranked, of several the first by name."""
    return next(name for name in functions if name in item.functions)
