"""What every task shares: which objects are asked, the share that was classified correctly, and what it took."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

from spherefunc_bullet.console import progress, say
from spherefunc_bullet.datasets.dataset import DatasetObject
from spherefunc_bullet.errors import InputError
from spherefunc_bullet.processes.tasks import run_tasks
from spherefunc_bullet.simulator import Simulator, isolated

Answer = TypeVar("Answer")


@dataclass(frozen=True, kw_only=True)
class Verdict:
    """One object that was asked."""

    name: str
    kind: str
    true: bool
    positive: bool
    value: float  # by which it was classified


@dataclass(frozen=True, kw_only=True)
class Score:
    """How well one backend did a task."""

    backend: str
    asked: int
    f_measure: float
    precision: float
    recall: float
    cpu_seconds: float  # of processor time, of one object in the mean


@dataclass(frozen=True, kw_only=True)
class Outcome:
    """What one backend did of one task, as it can be put beside another's."""

    backend: str
    measure: str  # what the value is
    value: float
    asked: int
    seconds: float  # of one object
    right: dict[str, bool]  # by object


def score_of(backend: str, verdicts: Sequence[Verdict], cpu_seconds: float) -> Score:
    """Return the score of verdicts."""
    hits = sum(one.true and one.positive for one in verdicts)
    positive, true = sum(one.positive for one in verdicts), sum(one.true for one in verdicts)
    precision, recall = hits / positive if positive else 0.0, hits / true if true else 0.0
    both = precision + recall
    return Score(
        backend=backend,
        asked=len(verdicts),
        f_measure=2 * precision * recall / both if both else 0.0,
        precision=precision,
        recall=recall,
        cpu_seconds=cpu_seconds,
    )


def evenly(objects: Sequence[DatasetObject], count: int | None) -> list[DatasetObject]:
    """Return at most so many objects, evenly chosen."""
    most = len(objects) if count is None else min(count, len(objects))
    return [objects[k * len(objects) // most] for k in range(most)]


def asked(
    function: Callable[..., Answer], objects: Sequence[DatasetObject], simulator: Simulator, doing: str, *more: object
) -> Iterator[tuple[DatasetObject, Answer, float]]:
    """Yield each object with a function's answer about its file, and the seconds of processor time that it took."""
    tasks = [(function, item.path, simulator, *more) for item in objects]
    paths = [item.path for item in objects]
    outcomes = run_tasks(timed, tasks, paths, isolate=isolated(simulator))
    for index, outcome in progress(outcomes, len(objects), doing):
        if isinstance(outcome, InputError):
            say(f"left out: {outcome}")
            continue
        answer, seconds = outcome
        yield objects[index], answer, seconds


def timed(function: Callable[..., Answer], path: Path, *more: object) -> tuple[Answer, float]:
    """Return what a function says of a file, and the seconds of processor time that it took."""
    started = time.process_time()
    answer = function(path, *more)
    return answer, time.process_time() - started
