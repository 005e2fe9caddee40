"""The classification of an object, in one place: the steps of the paper, and ours.

The command line, `classify` in Python, estimators, viewer, arrangements and benches all call this module.
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
from .settling.dropping import Check, CloudObject
from .settling.drops import FEW, DropsByRadius, RunLimit, settled_count
from .settling.settling import falls_over, loses_water

CUP, SITTABLE, TABLE = "cup", "sittable", "table"
POSSIBLE = 0.2  # the score of a completed view from which on what was not seen may decide
ON_TOP = "a table with {objects} on it: try `spherefunc scene` to classify each of them"
FALLS = "it would fall over when put down like this; an object that would fall over has no function"
LEAKS = "spheres stay in it as in a cup, but water runs out through a hole or a slit"
NO_PLACE = "spheres stay on it as on a seat, but there is no place on it where a person would fit"
NOTHING = (
    "almost no sphere settled; this looks like a single view of an object, "
    "whose far side and bottom the sensor did not see"
)
UNSEEN = "this looks like a single view of an object; once completed, it may be classified as {functions}"
LIES = 'as it stands it would fall over, and would not with y up: is its up axis right? up="y" says so'
DISAGREE = "the backends disagree about {function}: {scores}"
COMPLETED = "this looks like a single view of an object, so it was completed and classified by the model for scans"


Memberships = dict[str, Membership]  # by the function's name
Asked = tuple[FunctionModel, Callable[[], FunctionModel]]  # a model, and what returns the one for single views


class DropTarget(Protocol):
    """An object on which spheres can be dropped: a cloud in memory, or a file with its cached results."""

    def cloud(self) -> Cloud:
        """Return its points and mesh as spheres meet them: level, and without gaps between sparse points."""
        ...

    def drops(self, length: RunLimit) -> DropsByRadius:
        """Return the drops of a run with this limit, at the radii of the model."""
        ...

    def check(self, name: str, check: Callable[[Cloud], bool]) -> bool:
        """Return the result of ``check`` for the cloud; it may be cached under this name."""
        ...

    def count(self, name: str, count: Callable[[Cloud], int]) -> int:
        """Return the result of ``count`` for the cloud; it may be cached under this name."""
        ...


def has_no_place_to_sit(cloud: Cloud) -> bool:
    """Return whether nobody finds a place to sit on an object, as `places` looks for it; never of points alone.

    A sensor's points are too rough for places, or too few, more often than there is none.
    """
    if cloud.mesh is None:
        return False
    from .places.regions import seat_surface  # of seats alone
    from .places.sitting import sit_places

    return not sit_places(seat_surface(cloud), sittable=1.0)


@dataclass(frozen=True, kw_only=True)
class UseCheck:
    """What is asked about an object that seems to have a function: if it fails, the answer is unsure."""

    name: str  # under which the result is cached: what says something else needs another
    function: str
    fails: Callable[[Cloud], bool]
    doubt: str
    denies: bool  # whether what fails has not the function


USE_CHECKS = (
    UseCheck(name="leaks", function=CUP, fails=loses_water, doubt=LEAKS, denies=True),
    # A seat on which a bag lies may have no place, and is one, so this is a doubt alone.
    UseCheck(name="no_place_to_sit", function=SITTABLE, fails=has_no_place_to_sit, doubt=NO_PLACE, denies=False),
)


def failed_uses(functions: Collection[str], check: Check) -> tuple[UseCheck, ...]:
    """Return the checks that an object fails, of those of functions that it seems to have."""
    return tuple(use for use in USE_CHECKS if use.function in functions and check(use.name, use.fails))


@dataclass(frozen=True, kw_only=True, eq=False)
class Decision:
    """The answer for one object, with the evidence it is based on."""

    model: FunctionModel
    reading: Reading
    fails_stability_check: bool = False
    failed_uses: tuple[UseCheck, ...] = ()  # of functions that it seems to have
    objects_on_top: int = 0  # that stand on a table
    lies: bool = False  # and has no function, as a file does whose up axis is y and is taken for z
    more_doubts: tuple[str, ...] = ()
    by_backend: Mapping[str, Memberships] = field(default_factory=dict)  # where several were asked

    @property
    def scores(self) -> np.ndarray:
        """(F,) float, 0 to 1; all 0 for an object that would fall over, and as a cup for one that leaks."""
        without = denied(self.model.functions_, self.fails_stability_check, self.failed_uses)
        return np.where(without, 0.0, self.reading.scores)

    @property
    def memberships(self) -> Memberships:
        """For each function, by name: whether the object has it, and its score."""
        return self.model.memberships_by(self.scores[None])[0]

    @property
    def functions(self) -> frozenset[str]:
        """The functions that the object has."""
        return frozenset(name for name, one in self.memberships.items() if one.member)

    def reasons(self, explain: bool = True) -> list[str]:
        """Return sentences that explain the answer; none for models that count cubes."""
        said = self.reading.model.sentences(self.reading) if explain else []
        if explain and self.objects_on_top:
            said.append(ON_TOP.format(objects=f"{self.objects_on_top} object{'s' * (self.objects_on_top > 1)}"))
        said = [*said, LIES] if self.lies else said
        return [FALLS, *said] if self.fails_stability_check else said

    def doubts(self) -> list[str]:
        """Return sentences that say why the answer is unsure; none if it is sure."""
        return [*doubts(self), *self.more_doubts]

    def row(self, file: str, seconds: float, explain: bool = True) -> dict[str, Any]:
        """Return what the commands print of the object with ``--json``."""
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
    """Return memberships as the contract prints them."""
    return {name: asdict(one) for name, one in memberships.items()}


def classify_by_all(item: Callable[[FunctionModel], DropTarget], asked: Sequence[Asked]) -> Decision:
    """Classify an object by the model of one backend or of several.

    The first one answers; where another one gives the object other functions, the answer is unsure.

    Parameters
    ----------
    item : callable
        Returns the object as a model's spheres meet it.
    asked : sequence of (FunctionModel, callable)
        Models of different backends, each with what returns its model for single views.
    """
    decisions = [classify(item(model), model, view_model) for model, view_model in asked]
    if len(decisions) == 1:
        return decisions[0]
    names = [model.dropping().simulator.name for model, _ in asked]
    by_backend = {name: one.memberships for name, one in zip(names, decisions, strict=True)}
    return replace(decisions[0], by_backend=by_backend)


def classify(item: DropTarget, model: FunctionModel, view_model: Callable[[], FunctionModel]) -> Decision:
    """Classify an object; a single view of an object without a function is completed and classified again.

    Parameters
    ----------
    item : DroppedOn
    model : FunctionModel
        Fitted.
    view_model : callable
        Returns the model for single views, objects of which a sensor saw only one side.
    """
    decision = decide(item, model)
    if TABLE in decision.functions:
        return with_objects_on_top(decision, item)
    if decision.functions:
        return decision
    if not item.check("one_view", looks_like_one_view):
        return replace(decision, lies=item.check("lies", stands_with_y_up))
    return reclassify_completed(item.cloud(), decision, view_model())


def stands_with_y_up(cloud: Cloud) -> bool:
    """Return whether a cloud's object would fall over with z up, and stand safely with y up; never of points alone."""
    if cloud.mesh is None:
        return False
    geometry = Geometry(cloud.mesh.vertices, cloud.mesh.faces)
    return standing_margin(geometry.vertices, geometry.faces) <= 0 and likely_up(geometry)[0] == "y"


def decide(item: DropTarget, model: FunctionModel) -> Decision:
    """Drop spheres on an object (§III-A), read them (§III-B), score functions (§III-C), and check its stability."""
    return check_stability(model.read(item.drops), item, model)


def check_stability(reading: Reading, item: DropTarget, model: FunctionModel) -> Decision:
    """Return the decision for a reading. Whether the object falls over, or fails in use, is asked if it matters."""
    found = {name for name, score in zip(model.functions_, reading.scores, strict=True) if score > THRESHOLD}
    if not (found and model.checks_stability):
        return Decision(model=model, reading=reading)
    falls = item.check("falls_over", falls_over)
    failed = () if falls else failed_uses(found, item.check)
    return Decision(model=model, reading=reading, fails_stability_check=falls, failed_uses=failed)


def denied(functions: Sequence[str], falls: bool, failed: Collection[UseCheck]) -> np.ndarray:
    """Return which functions (F,) bool an object has not, whatever its scores: all if it falls, a cup's if it leaks."""
    without = {use.function for use in failed if use.denies}
    return np.array([falls or name in without for name in functions])


def with_objects_on_top(decision: Decision, item: DropTarget) -> Decision:
    """Return the decision about a table with how many objects stand on it."""
    name = f"objects_on_table_{decision.model.dropping().simulator.name}"
    count = item.count(name, lambda cloud: decision.model.objects_on_table(cloud, decision.reading))
    return replace(decision, objects_on_top=count)


def reclassify_completed(cloud: Cloud, decision: Decision, model: FunctionModel) -> Decision:
    """Return the decision for the completed object if it has a function or nothing settled before, else the first."""
    nothing, possible = nothing_settled(decision.reading), set()
    for whole in completed_clouds(cloud):
        completed = decide(CloudObject(own=whole, dropping=model.dropping()), model)
        if not nothing_settled(completed.reading) and (nothing or completed.functions):
            return replace(completed, more_doubts=(COMPLETED,))
        possible |= {name for name, one in completed.memberships.items() if one.score > POSSIBLE}
    if nothing:
        return replace(decision, more_doubts=(NOTHING,))
    unseen = UNSEEN.format(functions=" or ".join(sorted(possible)))
    return replace(decision, more_doubts=(unseen,)) if possible else decision


def nothing_settled(reading: Reading) -> bool:
    """Return whether fewer than `FEW` spheres of all radii together settled."""
    return sum(settled_count(reading.drops, radius) for radius in reading.drops) < FEW


def doubts(decision: Decision) -> list[str]:
    """Return why an answer is unsure, each a sentence; the one place for rules of doubt."""
    found = disagreements(decision.by_backend)
    if decision.fails_stability_check:
        return found
    return [*decision.reading.model.doubts(decision.reading), *[use.doubt for use in decision.failed_uses], *found]


def disagreements(by_backend: Mapping[str, Memberships]) -> list[str]:
    """Return a sentence for each function that an object has by one backend and not by another."""
    found = []
    for name in next(iter(by_backend.values()), ()):
        own = {backend: memberships[name] for backend, memberships in by_backend.items()}
        if len({one.member for one in own.values()}) > 1:
            scores = ", ".join(f"{backend} {one.score:.2f}" for backend, one in own.items())
            found.append(DISAGREE.format(function=name, scores=scores))
    return found
