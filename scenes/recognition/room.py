"""What is found in a scan: objects with their functions, and what may be there without being seen."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from spherefunc_bullet.function_model import THRESHOLD, Membership

from ..scans.levelling import Levelling
from ..segmentation.clusters import Box
from .choosing import Bar
from .proposals import CLUSTERS

FRAGMENT = "it is small and carried by nothing: a part of an object that is not seen whole"
ASSUMED = "neither floor nor table top is seen: heights are over the lowest point"


@dataclass(frozen=True, kw_only=True, eq=False)
class SceneObject:
    """One object of a room."""

    id: int  # its label in `Room.labels`
    points: np.ndarray  # (N, 3) float64, metres, level frame; of a scan of many points, thinned
    support: float  # the height it stands on, metres
    box: Box  # in the level frame, down to the support: legs that are not seen are there all the same
    fragment: bool  # small, and carried by nothing: a part of something that is not seen whole
    functions: dict[str, Membership]
    proposed_by: str = CLUSTERS  # or "pools"
    made_from: str | None = None  # "table top": the support that serves as ground
    height: float | None = None  # of such a top over the floor, metres; None: nothing tells it

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
class Inferred:
    """An object that was not seen, but has its place; see `inferring`."""

    function: str
    box: Box  # level frame: as deep as a chair, from the floor to the back's top
    table: int  # the object whose edge it stands at
    reason: str


@dataclass(frozen=True, kw_only=True, eq=False)
class Room:
    """What was found in a scan."""

    levelling: Levelling
    labels: np.ndarray  # (N,) int32 of the scan's points: an object's id, -1 floor, -2 wall or ceiling, -3 left over
    objects: list[SceneObject]
    proposals: list[SceneObject] = field(default_factory=list)  # all that was asked about, overlapping ones too
    inferred: list[Inferred] = field(default_factory=list)  # not seen, and not counted among the objects
    stages: dict[str, float] = field(default_factory=dict)  # seconds that each step took
    bars: Mapping[str, Bar] | None = None  # by what proposed an object; None: the model's own

    @property
    def function_names(self) -> list[str]:
        """The functions that objects were asked for; none without objects."""
        return list(self.objects[0].functions) if self.objects else []

    def bar(self, item: SceneObject, function: str) -> float:
        """Return the score that an object had to pass to have a function."""
        return THRESHOLD if self.bars is None else self.bars[item.proposed_by].of(function)

    def reasons(self, item: SceneObject) -> list[str]:
        """Return a sentence for each function that an object has."""
        return [
            f"{name} {one.score:.2f}: above the {self.bar(item, name):.2f} asked of what {item.proposed_by} propose"
            for name, one in item.functions.items()
            if one.member
        ]

    def doubts(self, item: SceneObject) -> list[str]:
        """Return why the answer about an object is unsure, each a sentence; none if it is sure."""
        doubts = [FRAGMENT] if item.fragment else []
        below = [name for name in item.members if item.functions[name].score <= THRESHOLD]
        if below:
            doubts.append(f"as likely as not no {' or '.join(sorted(below))}: claimed with a score of at most 0.5")
        return [*doubts, ASSUMED] if self.levelling.source == "assumed" else doubts

    def box_in_scan(self, box: Box) -> Box:
        """Return a box of the level frame in the scan's, where that is level too; else its corners tell more."""
        center = self.levelling.to_scan(box.center[None])[0]
        x = box.axes[0] @ self.levelling.T_level_scan[:3, :3]
        return Box(center=center, size=box.size, yaw=float(np.arctan2(x[1], x[0])))
