"""What an object is for in each of the poses in which it can lie, and which pose is best for what."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..clouds.cloud import Cloud
from ..clouds.preparation import rotated_cloud
from ..function_model import FunctionModel, Membership
from ..settling.dropping import CloudObject
from ..simulator.mechanics import Pose


@dataclass(frozen=True, kw_only=True)
class PoseFunctions:
    """A pose, and what the object is for in it."""

    pose: Pose
    functions: dict[str, Membership]


def pose_functions(cloud: Cloud, poses: Sequence[Pose], classifier: FunctionModel) -> list[PoseFunctions]:
    """Return what a cloud's object is for in each pose; spheres are dropped on it anew in each."""
    dropping, answers = classifier.dropping(), []
    for pose in poses:
        turned = CloudObject(own=rotated_cloud(cloud, pose.rotation), dropping=dropping)
        scores = classifier.read(turned.drops).scores  # it lies as it can lie, so it does not fall over
        answers.append(PoseFunctions(pose=pose, functions=classifier.memberships_by(scores[None])[0]))
    return answers


def best_poses(answers: Sequence[PoseFunctions]) -> dict[str, int]:
    """Return for each function which pose has the highest score, of equal ones the likelier, which comes first."""
    names = answers[0].functions if answers else ()
    return {name: int(np.argmax([one.functions[name].score for one in answers])) for name in names}
