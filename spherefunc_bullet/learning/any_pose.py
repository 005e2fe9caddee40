"""The functions of an object in each of its stable poses, and the best pose for each function."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..clouds.cloud import Cloud
from ..clouds.preparation import rotated_cloud
from ..function_model import FunctionModel, Membership
from ..settling.cached_runs import CloudObject
from ..simulator.mechanics import Pose


@dataclass(frozen=True, kw_only=True)
class PoseFunctions:
    """A stable pose, and the memberships of the object in it."""

    pose: Pose
    functions: dict[str, Membership]


def pose_functions(cloud: Cloud, poses: Sequence[Pose], classifier: FunctionModel) -> list[PoseFunctions]:
    """Return the memberships of an object in each pose; spheres are dropped on it in each of them."""
    drop_config, answers = classifier.drop_config(), []
    for pose in poses:
        turned = CloudObject(raw_cloud=rotated_cloud(cloud, pose.rotation), drop_config=drop_config)
        scores = classifier.read(turned.drops).scores  # a stable pose needs no stability check
        answers.append(PoseFunctions(pose=pose, functions=classifier.memberships_by(scores[None])[0]))
    return answers


def best_poses(answers: Sequence[PoseFunctions]) -> dict[str, int]:
    """Return the index of the pose with the highest score for each function; of equal ones the more probable."""
    names = answers[0].functions if answers else ()
    return {name: int(np.argmax([answer.functions[name].score for answer in answers])) for name in names}
