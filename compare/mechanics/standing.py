"""Standing: sound furniture against copies with a leg sawn off, or with legs cut askew.

Furniture is sound if it stands and carries its load at nearly all places where spheres come to rest on its seat or top:
a person on a seat, its own weight on a table. Nothing is learnt.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

import numpy as np

from spherefunc_bullet.clouds.cloud import cloud_from_mesh, load_cloud
from spherefunc_bullet.console import fail, passed
from spherefunc_bullet.datasets.dataset import DatasetObject
from spherefunc_bullet.errors import InputError
from spherefunc_bullet.learning.profiles.columns import outline_of
from spherefunc_bullet.learning.validation import quality
from spherefunc_bullet.processes.tasks import run_tasks
from spherefunc_bullet.scenes.impairment.folder import evenly
from spherefunc_bullet.scenes.impairment.sawn import SAWN, copies_of
from spherefunc_bullet.scenes.impairment.specimen import Specimen
from spherefunc_bullet.settling.cached_runs import LoadOptions
from spherefunc_bullet.settling.resting_places import resting_places
from spherefunc_bullet.simulator import Simulator, isolated
from spherefunc_bullet.simulator.mechanics import Material, Stance, StandSettings
from spherefunc_bullet.simulator.statics.body import body_of

Answer = TypeVar("Answer")


@dataclass(frozen=True, kw_only=True)
class TaskAnswer:
    """The answer about one object."""

    name: str
    kind: str
    true: bool
    positive: bool
    value: float  # that decides the answer


@dataclass(frozen=True, kw_only=True)
class TaskScore:
    """The score of one backend at a task."""

    backend: str
    asked: int
    f_measure: float
    precision: float
    recall: float
    cpu_seconds: float  # mean processor time of one object


@dataclass(frozen=True, kw_only=True)
class ScoredAnswers:
    """The score of one backend at distinguishing objects that work from those that do not, with all its answers."""

    score: TaskScore
    verdicts: tuple[TaskAnswer, ...]


@dataclass(frozen=True, kw_only=True)
class TaskOutcome:
    """The result of one backend at one task, comparable with another backend's."""

    backend: str
    measure: str  # the name of the value
    value: float
    asked: int
    seconds: float  # of one object
    right: dict[str, bool]  # by object: whether its answer is correct


def scored(simulator: Simulator, verdicts: Sequence[TaskAnswer], seconds: Sequence[float]) -> ScoredAnswers:
    """Return verdicts with their score; the seconds are those of each object."""
    found = quality(np.array([answer.true for answer in verdicts]), np.array([answer.positive for answer in verdicts]))
    shares = {"f_measure": found.f_measure, "precision": found.precision, "recall": found.recall}
    about = {"backend": simulator.name, "asked": len(verdicts), "cpu_seconds": float(np.mean(seconds))}
    return ScoredAnswers(score=TaskScore(**about, **shares), verdicts=tuple(verdicts))


def with_function(
    objects: Sequence[DatasetObject], functions: Sequence[str], count: int | None
) -> dict[str, list[DatasetObject]]:
    """Return at most this many of the objects that have some function, evenly chosen, by the first that they have."""
    by: dict[str, list[DatasetObject]] = {function: [] for function in functions}
    for item in evenly([item for item in objects if item.functions & set(functions)], count):
        by[next(name for name in functions if name in item.functions)].append(item)
    return by


@dataclass(frozen=True, kw_only=True)
class TaskOptions:
    """What all tasks have in common."""

    count: int | None = None  # the maximum number of objects of each task, evenly chosen; None: all
    loading: LoadOptions = LoadOptions()
    failed: Callable[[InputError], object] = fail  # receives the errors of files, which are left out


def simulator_answers(
    function: Callable[..., Answer],
    objects: Sequence[DatasetObject],
    simulator: Simulator,
    doing: str,
    options: TaskOptions,
    *more: object,
) -> Iterator[tuple[DatasetObject, Answer, float]]:
    """Yield each object with a function's answer about its file, and the seconds of processor time that it took."""
    tasks = [(function, item.path, simulator, options.loading, *more) for item in objects]
    paths = [item.path for item in objects]
    outcomes = run_tasks(timed, tasks, paths, isolate=isolated(simulator))
    for index, outcome in passed(outcomes, len(objects), doing, options.failed):
        yield objects[index], *outcome


def timed(function: Callable[..., Answer], path: Path, *more: object) -> tuple[Answer, float]:
    """Return a function's answer about a file, and the seconds of processor time that it took."""
    started = time.process_time()
    answer = function(path, *more)
    return answer, time.process_time() - started


PERSON = 75.0  # kg
SHARE = 0.8  # least share of the places of sound furniture that carry the load: with a leg missing, some two thirds do
LEVEL_DEG = 5.0  # a slope that still counts as flat, as for `fast`: spheres stay on it
INSET = 0.05  # metres: least distance from the edge at which a weight acts, half the width of an object there
BAND = 0.1  # metres above and below the middle of all places: the seat or the top, not a back or a shelf
FUNCTIONS = ("sittable", "table")
PLACES = 60


@dataclass(frozen=True, kw_only=True, eq=False)
class StandAnswer:
    """How one object stands, whole or sawn."""

    kind: str
    stance: Stance
    tilt_deg: float  # at which it comes to rest
    carries: np.ndarray  # (P,) bool: the places that carry the load

    @property
    def sound(self) -> bool:
        level = self.stance in (Stance.STANDS, Stance.ROCKS) and self.tilt_deg < LEVEL_DEG
        return level and len(self.carries) > 0 and bool(self.carries.mean() >= SHARE)

    def verdict(self, name: str) -> TaskAnswer:
        """Return the verdict on the object of this name."""
        share = float(self.carries.mean()) if len(self.carries) else 0.0
        return TaskAnswer(name=name, kind=self.kind, true=self.kind == "whole", positive=self.sound, value=share)


def standing_answers(path: Path, simulator: Simulator, loading: LoadOptions, function: str) -> list[StandAnswer]:
    """Return how a file's object and each sawn copy of it stand."""
    cloud = load_cloud(path, up=loading.up, units=loading.units)
    copies = copies_of(Specimen(cloud, function), path.name, SAWN)
    variants = [("whole", cloud), *((kind.kind, cloud_from_mesh(*answer.mesh(), path.name)) for kind, answer in copies)]
    answers = []
    for kind, variant in variants:
        load = PERSON if function == "sittable" else body_of(variant, Material()).mass
        settings, places = StandSettings(load=load, most_places=PLACES), loaded_places(resting_places(variant))
        found = simulator.stands(variant, settings, places, 0)
        answers.append(StandAnswer(kind=kind, stance=found.stance, tilt_deg=found.tilt_deg, carries=found.carries))
    return answers


def loaded_places(places: np.ndarray) -> np.ndarray:
    """Return the places (P, 3) on the seat or the top at which a weight can act, away from the edge.

    An object that is put down has a width, and hardly anybody sits on the very edge.
    """
    if not len(places):
        return places
    level = places[np.abs(places[:, 2] - np.median(places[:, 2])) < BAND]
    within = outline_of(level[:, :2], 0.0).inside(level[:, :2]) >= INSET
    return level[within] if within.any() else level


@dataclass(frozen=True, kw_only=True)
class StandScore(ScoredAnswers):
    """The score of one backend at recognising sound furniture."""

    answers: dict[str, StandAnswer]  # by file and kind


def score_standing(objects: Sequence[DatasetObject], simulator: Simulator, options: TaskOptions) -> StandScore | None:
    """Return how well a backend distinguishes sound furniture from sawn; None without furniture."""
    answers, seconds = {}, []
    for function, of_function in with_function(objects, FUNCTIONS, options.count).items():
        more = (f"standing by {simulator.name}", options, function)
        for item, found, taken in simulator_answers(standing_answers, of_function, simulator, *more):
            answers |= {f"{item.path.name} {answer.kind}": answer for answer in found}
            seconds.append(taken / len(found))
    if not answers:
        return None
    verdicts = [answer.verdict(name) for name, answer in answers.items()]
    return StandScore(**vars(scored(simulator, verdicts, seconds)), answers=answers)


@dataclass(frozen=True, kw_only=True)
class Agreement:
    """The shares in which two backends agree."""

    things: int
    verdicts: float
    stances: float
    places: float


def agreement(one: StandScore, other: StandScore) -> Agreement:
    """Return how often two backends agree about the same objects."""
    names = sorted(one.answers.keys() & other.answers.keys())
    pairs = [(one.answers[name], other.answers[name]) for name in names]
    same = np.concatenate([a.carries == b.carries for a, b in pairs])
    return Agreement(
        things=len(names),
        verdicts=float(np.mean([a.sound == b.sound for a, b in pairs])),
        stances=float(np.mean([a.stance is b.stance for a, b in pairs])),
        places=float(same.mean()),
    )
