"""What an object is for, decided in one place: the paper's steps, and what we added to them.

The command line, `classify` in Python, estimators, viewer, scenes, arrangements and benches all ask here.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from .clouds.cloud import Cloud
from .clouds.one_view import completed_clouds, looks_like_one_view
from .function_model import THRESHOLD, FunctionModel, Membership, Reading
from .learning.reasons.laid import TABLE, objects_on_table, remark
from .settling.drops import FEW, DropsByRadius, RunLimit, settled_count
from .settling.kept_object import CloudObject
from .simulator.statics.falling_over import falls_over

FALLS = "it would fall over when put down like this; an object that would fall over has no function"
NOTHING = (
    "almost no sphere settled; this looks like a single view of an object, "
    "whose far side and bottom the sensor did not see"
)
COMPLETED = "this looks like a single view of an object, so it was completed and classified by the model for scans"


class DroppedOn(Protocol):
    """An object that spheres can be dropped on: a cloud in memory, or a file and what is kept of it."""

    def cloud(self) -> Cloud:
        """Return its points and mesh as spheres meet them: level, and without gaps between sparse points."""
        ...

    def drops(self, length: RunLimit) -> DropsByRadius:
        """Return what becomes of the spheres of a run of some length, at the model's radii."""
        ...

    def check(self, name: str, check: Callable[[Cloud], bool]) -> bool:
        """Return what ``check``, which is kept by a name, says of the cloud."""
        ...

    def count(self, name: str, count: Callable[[Cloud], int]) -> int:
        """Return what ``count``, which is kept by a name, counts in the cloud."""
        ...


@dataclass(frozen=True, kw_only=True, eq=False)
class Decision:
    """What an object is for, and what that was read from."""

    model: FunctionModel
    reading: Reading
    fails_stability_check: bool = False
    objects_on_top: int = 0  # that stand on a table
    more_doubts: tuple[str, ...] = ()

    @property
    def scores(self) -> np.ndarray:
        """(F,) float, 0 to 1: an object that would fall over has no function."""
        return np.zeros_like(self.reading.scores) if self.fails_stability_check else self.reading.scores

    @property
    def memberships(self) -> dict[str, Membership]:
        """Whether it has each function, by name."""
        return self.model.memberships_by(self.scores[None])[0]

    @property
    def functions(self) -> frozenset[str]:
        """Those that it has."""
        return frozenset(name for name, one in self.memberships.items() if one.member)

    def reasons(self, explain: bool = True) -> list[str]:
        """Return sentences that say why; none from models that count cubes."""
        said = self.reading.model.sentences(self.reading) if explain else []
        if explain and self.objects_on_top:
            said.append(remark(self.objects_on_top))
        return [FALLS, *said] if self.fails_stability_check else said

    def doubts(self) -> list[str]:
        """Return sentences that say why the answer is unsure; none where it is sure."""
        return [*doubts(self), *self.more_doubts]


def classify(item: DroppedOn, model: FunctionModel, view_model: Callable[[], FunctionModel]) -> Decision:
    """Return what an object is for.

    Parameters
    ----------
    item : DroppedOn
    model : FunctionModel
        Fitted.
    view_model : callable
        Returns the model that is asked about an object of which a sensor saw one side alone.
    """
    decision = decide(item, model)
    if TABLE in decision.functions:
        return with_objects_on_top(decision, item)
    if decision.functions or not item.check("one_view", looks_like_one_view):
        return decision
    return reclassify_completed(item.cloud(), decision, view_model())


def decide(item: DroppedOn, model: FunctionModel) -> Decision:
    """Return what an object is for as it is: as many spheres fall (§III-A) as their reading (§III-B) needs to score
    each function (§III-C); then an object that would fall over has none."""
    return check_stability(model.read(item.drops), item, model)


def check_stability(reading: Reading, item: DroppedOn, model: FunctionModel) -> Decision:
    """Return what an object is for whose drops are read; whether it falls over is asked where it has a function."""
    asked = model.checks_stability and bool((reading.scores > THRESHOLD).any())
    return Decision(model=model, reading=reading, fails_stability_check=asked and item.check("falls_over", falls_over))


def with_objects_on_top(decision: Decision, item: DroppedOn) -> Decision:
    """Return the decision about a table with how many objects stand on it."""
    name = f"objects_on_table_{decision.model.dropping().simulator.name}"
    count = item.count(name, lambda cloud: objects_on_table(cloud, decision.reading.drops))
    return replace(decision, objects_on_top=count)


def reclassify_completed(cloud: Cloud, decision: Decision, model: FunctionModel) -> Decision:
    """Return what the object is for of which a cloud is one view: completed, if that makes a difference."""
    nothing = nothing_settled(decision.reading)
    for whole in completed_clouds(cloud):
        completed = decide(CloudObject(own=whole, dropping=model.dropping()), model)
        if not nothing_settled(completed.reading) and (nothing or completed.functions):
            return replace(completed, more_doubts=(COMPLETED,))
    return replace(decision, more_doubts=(NOTHING,)) if nothing else decision


def nothing_settled(reading: Reading) -> bool:
    """Return whether hardly a sphere of all radii together stayed."""
    return sum(settled_count(reading.drops, radius) for radius in reading.drops) < FEW


def doubts(decision: Decision) -> list[str]:
    """Return why an answer is unsure, each a sentence."""
    return [] if decision.fails_stability_check else decision.reading.model.doubts(decision.reading)
