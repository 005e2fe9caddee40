"""The classification of an object, step by step: the steps of the paper, and ours.

The command line, `classify` in Python, estimators, viewer, arrangements and benchmarks all call this module.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from typing import Any, Protocol

import numpy as np

from .clouds.cloud import Cloud
from .clouds.one_view import completed_clouds, looks_like_one_view
from .clouds.orientation import likely_up, standing_margin
from .formats.sources import Geometry
from .function_model import THRESHOLD, FunctionModel, Membership, Reading
from .places.seats import has_no_place_to_sit, is_full_of_spikes, is_nowhere_level
from .settling.cached_runs import Check, CloudObject
from .settling.drops import FEW, DropsByRadius, RunLimit, settled_count
from .settling.settling import falls_over, mesh_leaks, points_leak

CUP, SITTABLE, TABLE = "cup", "sittable", "table"
LEAKS = "spheres stay in it as in a cup, but water runs out through a hole or a slit"
OPEN = "spheres stay in it as in a cup, but water would run out where no surface was seen"
HOLE_SEEN = "at least half of its bottom was seen, so it probably has a hole"
NO_PLACE = "spheres stay on it as on a seat, but there is no place on it where a person would fit"
SLOPING = "none of it is level over a hand's breadth at the height of a seat"
SPIKES = "spheres stay on it as on a seat, but it is full of spikes"
POSSIBLE = 0.2  # least score of a function of points or of a completed view at which what was not seen may decide
ON_TOP = "a table with {objects} on it: try `spherefunc scene` to classify each of them"
FALLS_OVER = "it would fall over when put down like this; an object that would fall over has no function"
NOTHING_SETTLED = (
    "almost no sphere settled; this looks like a single view of an object, "
    "whose far side and bottom the sensor did not see"
)
SINGLE_VIEW = "this looks like a single view of an object; once completed, it may be classified as {functions}"
PARTLY_SEEN = "a sensor may have missed parts of it; with these it may be classified as {functions}"
WRONG_UP_AXIS = 'as it stands it would fall over, and would not with y up: is its up axis right? up="y" says so'
DISAGREE = "the backends disagree about {function}: {scores}"
COMPLETED = "this looks like a single view of an object, so it was completed and classified by the model for scans"

Memberships = dict[str, Membership]  # by function
ModelPair = tuple[FunctionModel, Callable[[], FunctionModel]]  # a model, and what returns that for single views


class DropTarget(Protocol):
    """An object on which spheres can be dropped: a cloud in memory, or a file with its cached results."""

    def cloud(self) -> Cloud:
        """Return the cloud on which spheres are dropped: level, and without gaps between sparse points."""
        ...

    def drops(self, run_limit: RunLimit) -> DropsByRadius:
        """Return the drops of runs with this limit, at the radii of the model."""
        ...

    def check(self, name: str, check: Callable[[Cloud], bool]) -> bool:
        """Return the result of ``check`` for the cloud; it may be cached under this name."""
        ...

    def count(self, name: str, count: Callable[[Cloud], int]) -> int:
        """Return the result of ``count`` for the cloud; it may be cached under this name."""
        ...


def bottom_was_seen(cloud: Cloud) -> bool:
    """Return whether points lie low within half of an object's outline: its underside, or the floor of a vessel."""
    return not looks_like_one_view(cloud)


@dataclass(frozen=True, kw_only=True)
class UseCheck:
    """A check of an object that seems to have a function; if the object fails it, the answer is unsure."""

    name: str  # under which the result is cached; a check that changes needs another name
    function: str
    fails: Callable[[Cloud], bool]
    doubt: str
    excludes: bool  # whether an object that fails does not have the function
    after: str = ""  # the name of a check before it, which such an object also fails


USE_CHECKS = (
    UseCheck(name="leaks", function=CUP, fails=mesh_leaks, doubt=LEAKS, excludes=True),
    # A scan from above may not show the bottom of a cup, so this is only a doubt.
    UseCheck(name="points_leak", function=CUP, fails=points_leak, doubt=OPEN, excludes=False),
    UseCheck(
        name="hole_seen", function=CUP, fails=bottom_was_seen, doubt=HOLE_SEEN, excludes=True, after="points_leak"
    ),
    # A seat on which a bag lies may have no place to sit and is still a seat, so this is only a doubt.
    UseCheck(name="nowhere_to_sit", function=SITTABLE, fails=has_no_place_to_sit, doubt=NO_PLACE, excludes=False),
    UseCheck(
        name="spikes", function=SITTABLE, fails=is_full_of_spikes, doubt=SPIKES, excludes=True, after="nowhere_to_sit"
    ),
    UseCheck(
        name="level_nowhere",
        function=SITTABLE,
        fails=is_nowhere_level,
        doubt=SLOPING,
        excludes=True,
        after="nowhere_to_sit",
    ),
)


def failed_uses(functions: Collection[str], check: Check) -> tuple[UseCheck, ...]:
    """Return the failed checks of an object, among those for functions that it seems to have."""
    failed: dict[str, UseCheck] = {}
    for use in USE_CHECKS:
        if use.function in functions and (not use.after or use.after in failed) and check(use.name, use.fails):
            failed[use.name] = use
    return tuple(failed.values())


@dataclass(frozen=True, kw_only=True, eq=False)
class Decision:
    """The answer for one object, with the evidence it is based on."""

    model: FunctionModel
    reading: Reading
    fails_stability_check: bool = False
    failed_uses: tuple[UseCheck, ...] = ()  # of functions that it seems to have
    objects_on_top: int = 0  # number of objects that stand on a table
    wrong_up_axis: bool = False  # whether it would stand with y up but not with z up, and has no function
    more_doubts: tuple[str, ...] = ()
    by_backend: Mapping[str, Memberships] = field(default_factory=dict)  # of several backends

    @property
    def scores(self) -> np.ndarray:
        """(F,) float, 0 to 1; all are 0 if the object would fall over, one is 0 if a check excludes its function."""
        no_function = excluded(self.model.functions_, self.fails_stability_check, self.failed_uses)
        return np.where(no_function, 0.0, self.reading.scores)

    @property
    def memberships(self) -> Memberships:
        """Whether the object has each function, and its score, by function."""
        return self.model.memberships_by(self.scores[None])[0]

    @property
    def functions(self) -> frozenset[str]:
        """The functions that the object has."""
        return frozenset(name for name, membership in self.memberships.items() if membership.member)

    def reasons(self, explain: bool = True) -> list[str]:
        """Return sentences that explain the answer; none for models that count cubes."""
        sentences = [FALLS_OVER] if self.fails_stability_check else []
        if explain:
            sentences += self.reading.model.sentences(self.reading)
        if explain and self.objects_on_top:
            sentences.append(ON_TOP.format(objects=f"{self.objects_on_top} object{'s' * (self.objects_on_top > 1)}"))
        return sentences + [WRONG_UP_AXIS] * self.wrong_up_axis

    def doubts(self) -> list[str]:
        """Return sentences that say why the answer is unsure; none if it is sure."""
        return [*doubts(self), *self.more_doubts]

    def row(self, file: str, seconds: float, explain: bool = True) -> dict[str, Any]:
        """Return the entry for the object that commands print with ``--json``."""
        doubts = self.doubts()
        by_backend = {backend: membership_rows(memberships) for backend, memberships in self.by_backend.items()}
        return {
            "file": file,
            "functions": membership_rows(self.memberships),
            "unsure": bool(doubts),
            "reasons": [*self.reasons(explain), *doubts],
            "seconds": seconds,
        } | ({"backends": by_backend} if by_backend else {})


def membership_rows(memberships: Memberships) -> dict[str, dict[str, Any]]:
    """Return memberships as they are printed with ``--json``."""
    return {name: asdict(membership) for name, membership in memberships.items()}


def classify_by_all(target: Callable[[FunctionModel], DropTarget], models: Sequence[ModelPair]) -> Decision:
    """Classify an object by the model of one backend or of several.

    The first model answers; where another one gives the object other functions, the answer is unsure.

    Parameters
    ----------
    target : callable
        Returns the object on which the spheres of a model are dropped.
    models : sequence of (FunctionModel, callable)
        Models of different backends, each with a function that returns the model for single views.
    """
    decisions = [classify(target(model), model, view_model) for model, view_model in models]
    if len(decisions) == 1:
        return decisions[0]
    names = [model.drop_config().simulator.name for model, _ in models]
    by_backend = {name: decision.memberships for name, decision in zip(names, decisions, strict=True)}
    return replace(decisions[0], by_backend=by_backend)


def classify(target: DropTarget, model: FunctionModel, view_model: Callable[[], FunctionModel]) -> Decision:
    """Classify an object; if it has no function and is a single view, complete it and classify it again.

    Parameters
    ----------
    target : DropTarget
    model : FunctionModel
        Fitted.
    view_model : callable
        Returns the model for single views, objects of which a sensor saw only one side.
    """
    decision = decide(target, model)
    if TABLE in decision.functions:
        name = f"objects_on_table_{model.drop_config().simulator.name}"
        count = target.count(name, lambda cloud: model.objects_on_table(cloud, decision.reading))
        return replace(decision, objects_on_top=count)
    if decision.functions:
        return decision
    if target.check("one_view", looks_like_one_view):
        return reclassify_completed(target, decision, view_model())
    more = unseen_doubts(PARTLY_SEEN, decision)
    if more and not target.check("points", lambda cloud: cloud.mesh is None):
        more = ()
    return replace(decision, wrong_up_axis=target.check("lies", stands_with_y_up), more_doubts=more)


def unseen_doubts(sentence: str, *decisions: Decision) -> tuple[str, ...]:
    """Return a sentence on the functions that an object may have by one of its decisions; none without such."""
    memberships = (item for decision in decisions for item in decision.memberships.items())
    possible = sorted({name for name, membership in memberships if membership.score > POSSIBLE})
    return (sentence.format(functions=" or ".join(possible)),) if possible else ()


def stands_with_y_up(cloud: Cloud) -> bool:
    """Return whether an object would fall over with z up and stand safely with y up; False without a mesh."""
    if cloud.mesh is None:
        return False
    geometry = Geometry(cloud.mesh.vertices, cloud.mesh.faces)
    return standing_margin(geometry.vertices, geometry.faces) <= 0 and likely_up(geometry)[0] == "y"


def decide(target: DropTarget, model: FunctionModel) -> Decision:
    """Drop spheres on an object (§III-A), read them (§III-B), score functions (§III-C), and check its stability."""
    return check_stability(model.read(target.drops), target, model)


def check_stability(reading: Reading, target: DropTarget, model: FunctionModel) -> Decision:
    """Return the decision for a reading; stability and use are checked only if a function depends on them."""
    found = {name for name, score in zip(model.functions_, reading.scores, strict=True) if score > THRESHOLD}
    if not (found and model.checks_stability):
        return Decision(model=model, reading=reading)
    falls = target.check("falls_over", falls_over)
    failed = () if falls else failed_uses(found, target.check)
    return Decision(model=model, reading=reading, fails_stability_check=falls, failed_uses=failed)


def excluded(functions: Sequence[str], falls: bool, failed: Collection[UseCheck]) -> np.ndarray:
    """Return the functions (F,) bool that an object cannot have: all if it falls over, or those whose check fails."""
    failed_functions = {use.function for use in failed if use.excludes}
    return np.array([falls or name in failed_functions for name in functions])


def reclassify_completed(target: DropTarget, decision: Decision, model: FunctionModel) -> Decision:
    """Return the decision for the completed object if it has a function or nothing settled before, else the old one."""
    nothing, views = nothing_settled(decision.reading), list[Decision]()
    for whole in completed_clouds(target.cloud()):
        completed = decide(CloudObject(raw_cloud=whole, drop_config=model.drop_config()), model)
        if not nothing_settled(completed.reading) and (nothing or completed.functions):
            seen = failed_uses(completed.functions, target.check)  # what is level may be of the completion alone
            failed = tuple(dict.fromkeys((*completed.failed_uses, *seen)))
            return replace(completed, failed_uses=failed, more_doubts=(COMPLETED,))
        views.append(completed)
    more = (NOTHING_SETTLED,) if nothing else unseen_doubts(SINGLE_VIEW, decision, *views)
    return replace(decision, more_doubts=more)


def nothing_settled(reading: Reading) -> bool:
    """Return whether fewer than `FEW` spheres of all radii together settled."""
    return sum(settled_count(reading.drops, radius) for radius in reading.drops) < FEW


def doubts(decision: Decision) -> list[str]:
    """Return sentences that say why an answer is unsure; all rules for this are here."""
    found = disagreements(decision.by_backend)
    if decision.fails_stability_check:
        return found
    return [*decision.reading.model.doubts(decision.reading), *[use.doubt for use in decision.failed_uses], *found]


def disagreements(by_backend: Mapping[str, Memberships]) -> list[str]:
    """Return a sentence for each function that an object has by one backend and not by another."""
    found = []
    for name in next(iter(by_backend.values()), ()):
        answers = {backend: memberships[name] for backend, memberships in by_backend.items()}
        if len({answer.member for answer in answers.values()}) > 1:
            scores = ", ".join(f"{backend} {answer.score:.2f}" for backend, answer in answers.items())
            found.append(DISAGREE.format(function=name, scores=scores))
    return found
