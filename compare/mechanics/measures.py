"""All tasks by several backends, with one sentence for each on the gain and the cost of fidelity."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

from spherefunc_bullet.datasets.dataset import DatasetObject
from spherefunc_bullet.errors import InputError, require_known
from spherefunc_bullet.formats.units import format_duration
from spherefunc_bullet.learning.classifier import CloudClassifier
from spherefunc_bullet.learning.model_file import load_model, shipped_model
from spherefunc_bullet.simulator import Simulator

from .poses import KeepScore, PoseScore, score_keeping, score_poses
from .sitting import score_sitting
from .standing import Agreement, ScoredAnswers, StandScore, TaskOptions, TaskOutcome, agreement, score_standing

# By task, the method that a backend needs; spheres propose places to sit, and some backends can prove them.
ABILITIES = {"poses": "poses", "standing": "stands", "keeping": "carry", "places": "drop"}
TASKS = tuple(ABILITIES)
MEASURES = {
    "poses": "pose of use ranked first",
    "standing": "F of sound furniture",
    "keeping": "F of vessels",
    "places": "F of seats with a place to sit",
}
CHANCE = 0.05  # two backends differ if the p-value is not larger


@dataclass(frozen=True, kw_only=True)
class TaskReports:
    """The results of each task by backend; empty for a task that was not measured."""

    poses: dict[str, PoseScore]
    standing: dict[str, StandScore]
    keeping: dict[str, KeepScore]
    places: dict[str, ScoredAnswers]
    unable: dict[str, tuple[str, ...]]  # by task, the backends that cannot do it

    @property
    def agreement(self) -> Agreement | None:
        """How often the first two backends agree about standing."""
        pair = list(self.standing.values())[:2]
        return agreement(*pair) if len(pair) == 2 else None

    def outcomes(self, task: str) -> list[TaskOutcome]:
        """Return the results of each backend at a task in a form that all tasks share."""
        outcomes = []
        for name, row in getattr(self, task).items():
            if task == "poses":
                figures = {"value": row.first, "asked": row.asked, "seconds": row.seconds, "right": row.right}
            else:
                right = {f"{each.name} {each.kind}": each.true == each.positive for each in row.verdicts}
                figures = {"value": row.score.f_measure, "asked": row.score.asked, "seconds": row.score.cpu_seconds}
                figures["right"] = right
            outcomes.append(TaskOutcome(backend=name, measure=MEASURES[task], **figures))
        return outcomes


def read_tasks(names: Sequence[str], known: Sequence[str] = TASKS) -> tuple[str, ...]:
    """Return the names of tasks, each once.

    Raises
    ------
    InputError
        If a task is unknown.
    """
    given = tuple(dict.fromkeys(name.strip() for name in names))
    require_known("tasks", given, known)
    return given


def measured(
    objects: Sequence[DatasetObject],
    simulators: Mapping[str, Simulator],
    tasks: Sequence[str],
    classifier: CloudClassifier | None,
    options: TaskOptions,
) -> TaskReports:
    """Return the results of simulators at the tasks that each of them can do.

    Parameters
    ----------
    classifier : CloudClassifier, optional
        Ranks poses; by default the model of the package.
    """
    if "poses" in tasks and classifier is None:
        classifier = load_model(shipped_model("fast"))

    said: set[str] = set()

    def say_once(error: InputError):
        if str(error) not in said:
            said.add(str(error))
            options.failed(InputError(f"{error} (left out)"))

    once = replace(options, failed=say_once)

    def measurable(task: str) -> dict[str, Simulator]:
        named = ABILITIES[task]
        return {name: row for name, row in simulators.items() if task in tasks and callable(getattr(row, named, None))}

    def scored(task: str, score: Callable[..., Any], *more: object) -> dict[str, Any]:
        scored = {name: score(objects, row, *more, once) for name, row in measurable(task).items()}
        return {name: row for name, row in scored.items() if row is not None}

    return TaskReports(
        poses=scored("poses", score_poses, classifier),
        standing=scored("standing", score_standing),
        keeping=scored("keeping", score_keeping),
        places=scored("places", score_sitting),
        unable={task: tuple(name for name in simulators if name not in measurable(task)) for task in tasks},
    )


def benefit_sentence(task: str, outcomes: Sequence[TaskOutcome], unable: Sequence[str]) -> str:
    """Return in one sentence the gain and the cost of fidelity at a task: the last backend compared with the first."""
    if not outcomes:
        why = f"{', '.join(unable)} cannot do it" if unable else "the data have nothing to ask about"
        return f"{task}: nothing was measured, {why}."
    quick, slow = outcomes[0], outcomes[-1]
    if len(outcomes) == 1:
        words = f"{slow.measure} {slow.value:.2f} of {slow.asked}, {format_duration(slow.seconds)} each"
        beside_none = f"{slow.backend} was compared with no other backend"
        sentence = f"only {slow.backend} can do it, {', '.join(unable)} cannot" if unable else beside_none
        return f"{task}: {sentence} ({words})."
    better, chance = compare_outcomes(quick, slow)
    verdict = "as good as" if chance > CHANCE else "better than" if better else "worse than"
    buys = "gains nothing measurable" if chance > CHANCE else "buys that" if better else "costs that"
    times = f"{slow.seconds / max(quick.seconds, 1e-9):.1f} times the time"
    price = f"{times} ({format_duration(slow.seconds)} against {format_duration(quick.seconds)} each)"
    values = f"{slow.measure} {slow.value:.2f} against {quick.value:.2f} of {slow.asked}"
    return f"{task}: {slow.backend} is {verdict} {quick.backend} ({values}) and {buys}, at {price}."


def compare_outcomes(first: TaskOutcome, second: TaskOutcome) -> tuple[bool, float]:
    """Return whether the second is right more often, and the p-value of the difference.

    It is that of an exact sign test on the objects on which only one of them is right (McNemar).
    """
    from scipy.stats import binomtest

    names = first.right.keys() & second.right.keys()
    gains = sum(second.right[name] and not first.right[name] for name in names)
    losses = sum(first.right[name] and not second.right[name] for name in names)
    chance = binomtest(gains, gains + losses).pvalue if gains + losses else 1.0
    return gains > losses, float(chance)


def sentences(mechanics: TaskReports) -> dict[str, str]:
    """Return the sentence on each measured task."""
    return {task: benefit_sentence(task, mechanics.outcomes(task), unable) for task, unable in mechanics.unable.items()}


def task_reports(mechanics: TaskReports) -> dict[str, dict[str, Any]]:
    """Return the results of each measured task for JSON, with its sentence."""
    sentence_of, same, reports = sentences(mechanics), mechanics.agreement, {}
    for task, unable in mechanics.unable.items():
        rows = [asdict(row) for row in mechanics.outcomes(task)]
        more = {name: asdict(row) for name, row in getattr(mechanics, task).items()}
        for row in more.values():
            row.pop("answers", None)  # all places of each object that stands
        reports[task] = {"says": sentence_of[task], "rows": rows, "unable": list(unable), "backends": more}
    if "standing" in reports:
        reports["standing"]["agreement"] = same and asdict(same)
    return reports
