"""Poses: of an object turned at random, is the pose in which it is used found, and is it the best for its function?"""

from __future__ import annotations

import zlib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from spherefunc_bullet.clouds.cloud import cloud_from_mesh, load_cloud
from spherefunc_bullet.clouds.preparation import rotated_cloud
from spherefunc_bullet.datasets.dataset import DatasetObject
from spherefunc_bullet.learning.any_pose import best_poses, pose_functions
from spherefunc_bullet.learning.classifier import CloudClassifier
from spherefunc_bullet.scenes.impairment.folder import evenly
from spherefunc_bullet.scenes.impairment.sawn import HOLED, copies_of
from spherefunc_bullet.scenes.impairment.specimen import Specimen
from spherefunc_bullet.settling.cached_runs import LoadOptions
from spherefunc_bullet.simulator import Simulator
from spherefunc_bullet.simulator.mechanics import CarrySettings, PoseSettings

from .standing import ScoredAnswers, TaskAnswer, score_of, simulator_answers

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
    path: Path, simulator: Simulator, loading: LoadOptions, function: str, classifier: CloudClassifier
) -> dict[str, float]:
    """Return whether the pose of a file is found after it was turned at random, as its name says; see `PoseScore`."""
    turn = Rotation.random(random_state=zlib.crc32(path.name.encode())).as_matrix()
    cloud = rotated_cloud(load_cloud(path, up=loading.up, units=loading.units), turn)
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
    loading: LoadOptions,
) -> PoseScore | None:
    """Return how well a backend finds the poses of objects that have a function; None where none has one."""
    chosen = evenly([item for item in objects if item.functions & set(classifier.functions_)], count)
    answers: dict[str, dict[str, float]] = {}
    for function in classifier.functions_:
        of_function = [item for item in chosen if main_function(item, classifier.functions_) == function]
        more = (f"posing by {simulator.name}", loading, function, classifier)
        for item, answer, _ in simulator_answers(posed, of_function, simulator, *more):
            answers[item.path.name] = answer
    found = list(answers.values())
    if not found:
        return None
    means = {key: float(np.mean([score[key] for score in found])) for key in ("found", "first", "likeliest", "poses")}
    return PoseScore(
        backend=simulator.name,
        asked=len(found),
        **means,
        seconds=float(np.median([score["seconds"] for score in found])),
        right={name: score["first"] for name, score in answers.items()},
    )


def main_function(item: DatasetObject, functions: Sequence[str]) -> str:
    """Return the one function by which an object's poses are ranked, of several the first by name."""
    return next(name for name in functions if name in item.functions)


OTHERS = ("plate", "tray", "shelf", "shelves", "bookshelf", "bookcase")  # categories, beside all tables
SHARE = 0.5  # of what it would be filled with, at least, is still in a vessel at the farthest angle
WHOLE, OTHER = "whole", "other"
Curve = tuple[float, ...]  # share kept at each angle


@dataclass(frozen=True, kw_only=True)
class KeepScore(ScoredAnswers):
    """How well one backend tells vessels, and the mean curves of either side."""

    angles_deg: tuple[float, ...]
    vessels: Curve  # in the mean
    others: Curve
    holed: tuple[HoledScore, ...]


@dataclass(frozen=True, kw_only=True)
class HoledScore:
    """What vessels keep that have a hole in the wall at one height."""

    kind: str
    asked: int
    kept: Curve  # in the mean
    classified: float  # share that is still classified as a vessel


def carried(path: Path, simulator: Simulator, loading: LoadOptions, holed: bool) -> dict[str, Curve]:
    """Return what a file's object keeps, and what is left of that with a hole in it, each by its kind."""
    cloud = load_cloud(path, up=loading.up, units=loading.units)
    variants = {WHOLE: cloud}
    for kind, surface in copies_of(Specimen(cloud, "cup"), path.name, 0, HOLED) if holed else ():
        variants[kind.kind] = cloud_from_mesh(*surface.mesh(), path.name)
    return {kind: simulator.carry(variant, CarrySettings(), 0).kept for kind, variant in variants.items()}


def score_keeping(
    objects: Sequence[DatasetObject], simulator: Simulator, count: int | None, loading: LoadOptions
) -> KeepScore | None:
    """Return how well a backend tells vessels from what only carries; None where there are none of either."""
    vessels = evenly([item for item in objects if "cup" in item.functions], count)
    flat = [item for item in objects if item.category in OTHERS or "table" in item.functions]
    verdicts, seconds = [], []
    curves: dict[str, list[Curve]] = {WHOLE: [], OTHER: []}
    for true, items in ((True, vessels), (False, evenly(flat, count))):
        for item, kept, taken in simulator_answers(carried, items, simulator, "carrying", loading, true):
            seconds.append(taken / len(kept))
            whole = kept.pop(WHOLE)
            curves[WHOLE if true else OTHER].append(whole)
            for kind, curve in kept.items():
                curves.setdefault(kind, []).append(curve)
            about = {"name": item.path.name, "kind": item.category, "true": true}
            verdicts.append(TaskAnswer(**about, positive=whole[-1] >= SHARE, value=whole[-1]))
    if not curves[WHOLE] or not curves[OTHER]:
        return None
    return KeepScore(
        score=score_of(simulator.name, verdicts, float(np.mean(seconds))),
        verdicts=tuple(verdicts),
        angles_deg=CarrySettings().angles_deg,
        vessels=mean_curve(curves.pop(WHOLE)),
        others=mean_curve(curves.pop(OTHER)),
        holed=tuple(holed_score(kind, kept) for kind, kept in sorted(curves.items())),
    )


def holed_score(kind: str, curves: Sequence[Curve]) -> HoledScore:
    """Return what vessels with one kind of hole keep."""
    share = float(np.mean([curve[-1] >= SHARE for curve in curves]))
    return HoledScore(kind=kind, asked=len(curves), kept=mean_curve(curves), classified=share)


def mean_curve(curves: Sequence[Curve]) -> Curve:
    """Return the mean share at each angle."""
    return tuple(np.mean(curves, axis=0).round(4).tolist())
