"""Poses: is the pose of use of a randomly turned object found, and is it ranked first for its function?"""

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

from .standing import ScoredAnswers, TaskAnswer, TaskOptions, scored, simulator_answers, with_function

UPRIGHT_DEG = 10.0  # from the pose in which the file has it


@dataclass(frozen=True, kw_only=True)
class PoseScore:
    """The score of one backend at finding poses."""

    backend: str
    asked: int
    found: float  # share of objects whose upright pose is found
    first: float  # share of objects whose upright pose has the highest score of their function
    likeliest: float  # share of objects whose upright pose is the likeliest one
    poses: float  # mean number of poses of an object
    seconds: float  # the median of the poses alone, wall time
    right: dict[str, bool]  # by file: whether the pose of use is ranked first


def posed(
    path: Path, simulator: Simulator, loading: LoadOptions, function: str, classifier: CloudClassifier
) -> dict[str, float]:
    """Return whether the pose of a file's object is found after a random turn, seeded by its name; see `PoseScore`."""
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
    options: TaskOptions,
) -> PoseScore | None:
    """Return how well a backend finds the poses of objects that have a function; None without such objects."""
    answers: dict[str, dict[str, float]] = {}
    for function, of_function in with_function(objects, classifier.functions_, options.count).items():
        more = (f"posing by {simulator.name}", options, function, classifier)
        for item, answer, _ in simulator_answers(posed, of_function, simulator, *more):
            answers[item.path.name] = answer
    if not answers:
        return None
    columns = {key: [score[key] for score in answers.values()] for key in next(iter(answers.values()))}
    seconds, right = float(np.median(columns.pop("seconds"))), {name: row["first"] for name, row in answers.items()}
    means = {key: float(np.mean(values)) for key, values in columns.items()}
    return PoseScore(backend=simulator.name, asked=len(answers), **means, seconds=seconds, right=right)


OTHERS = ("plate", "tray", "shelf", "shelves", "bookshelf", "bookcase")  # categories, in addition to all tables
SHARE = 0.5  # least share of its filling that a vessel keeps at the largest angle
WHOLE, OTHER = "whole", "other"
Curve = tuple[float, ...]  # share kept at each angle


@dataclass(frozen=True, kw_only=True)
class KeepScore(ScoredAnswers):
    """The score of one backend at recognising vessels, with the mean curves of vessels and other objects."""

    angles_deg: tuple[float, ...]
    vessels: Curve  # mean
    others: Curve
    holed: tuple[HoledScore, ...]


@dataclass(frozen=True, kw_only=True)
class HoledScore:
    """What vessels with a hole in the wall at one height keep."""

    kind: str
    asked: int
    kept: Curve  # mean
    classified: float  # share of vessels that are still classified as such


def carried(path: Path, simulator: Simulator, loading: LoadOptions, holed: bool) -> dict[str, Curve]:
    """Return what a file's object keeps, and what its copies with a hole keep, by kind."""
    cloud = load_cloud(path, up=loading.up, units=loading.units)
    variants = {WHOLE: cloud}
    for kind, surface in copies_of(Specimen(cloud, "cup"), path.name, HOLED) if holed else ():
        variants[kind.kind] = cloud_from_mesh(*surface.mesh(), path.name)
    return {kind: simulator.carry(variant, CarrySettings(), 0).kept for kind, variant in variants.items()}


def score_keeping(objects: Sequence[DatasetObject], simulator: Simulator, options: TaskOptions) -> KeepScore | None:
    """Return how well a backend distinguishes vessels from objects that only carry; None if either are missing."""
    vessels = evenly([item for item in objects if "cup" in item.functions], options.count)
    flat = [item for item in objects if item.category in OTHERS or "table" in item.functions]
    verdicts, seconds = [], []
    curves: dict[str, list[Curve]] = {WHOLE: [], OTHER: []}
    for true, items in ((True, vessels), (False, evenly(flat, options.count))):
        for item, kept, taken in simulator_answers(carried, items, simulator, "carrying", options, true):
            seconds.append(taken / len(kept))
            whole = kept.pop(WHOLE)
            curves[WHOLE if true else OTHER].append(whole)
            for kind, curve in kept.items():
                curves.setdefault(kind, []).append(curve)
            about = {"name": item.path.name, "kind": item.category, "true": true, "value": whole[-1]}
            verdicts.append(TaskAnswer(**about, positive=whole[-1] >= SHARE))
    if not curves[WHOLE] or not curves[OTHER]:
        return None
    return KeepScore(
        **vars(scored(simulator, verdicts, seconds)),
        angles_deg=CarrySettings().angles_deg,
        vessels=mean_curve(curves.pop(WHOLE)),
        others=mean_curve(curves.pop(OTHER)),
        holed=tuple(holed_score(kind, kept) for kind, kept in sorted(curves.items())),
    )


def holed_score(kind: str, curves: Sequence[Curve]) -> HoledScore:
    """Return the score of vessels with one kind of hole."""
    share = float(np.mean([curve[-1] >= SHARE for curve in curves]))
    return HoledScore(kind=kind, asked=len(curves), kept=mean_curve(curves), classified=share)


def mean_curve(curves: Sequence[Curve]) -> Curve:
    """Return the mean share at each angle."""
    return tuple(np.mean(curves, axis=0).round(4).tolist())
