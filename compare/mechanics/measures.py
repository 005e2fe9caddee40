"""All tasks by several backends, and in one sentence each what fidelity buys at what price."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from spherefunc_bullet.datasets.dataset import DatasetObject
from spherefunc_bullet.errors import require_known
from spherefunc_bullet.formats.units import format_duration
from spherefunc_bullet.learning.classifier import CloudClassifier
from spherefunc_bullet.learning.model_file import load_model, shipped_model
from spherefunc_bullet.settling.cached_runs import LoadOptions
from spherefunc_bullet.simulator import Simulator

from .poses import KeepScore, PoseScore, score_keeping, score_poses
from .sitting import score_sitting
from .standing import Agreement, ScoredAnswers, StandScore, TaskOutcome, agreement, score_standing

# By task, what a backend needs for it: spheres propose places to sit, and who can prove them does.
ABILITIES = {"poses": "poses", "standing": "stands", "keeping": "carry", "places": "drop"}
TASKS = tuple(ABILITIES)
CHANCE = 0.05  # two backends differ where so much of chance, or less, explains it


@dataclass(frozen=True, kw_only=True)
class TaskReports:
    """What backends did of each task, by backend; of a task that was not asked, nothing."""

    poses: dict[str, PoseScore]
    standing: dict[str, StandScore]
    keeping: dict[str, KeepScore]
    places: dict[str, ScoredAnswers]
    unable: dict[str, tuple[str, ...]]  # by task, the backends that cannot do it

    @property
    def agreement(self) -> Agreement | None:
        """How often the first two backends say the same of what stands."""
        pair = list(self.standing.values())[:2]
        return agreement(*pair) if len(pair) == 2 else None

    def outcomes(self, task: str) -> list[TaskOutcome]:
        """Return what each backend did of a task, comparable over tasks."""
        if task == "poses":
            return [
                TaskOutcome(
                    backend=name,
                    measure="pose of use ranked first",
                    value=row.first,
                    asked=row.asked,
                    seconds=row.seconds,
                    right=row.right,
                )
                for name, row in self.poses.items()
            ]
        measures = {"standing": ("F of sound furniture", self.standing), "keeping": ("F of vessels", self.keeping)}
        measures["places"] = ("F of seats with a place to sit", self.places)
        words, scores = measures[task]
        return [
            TaskOutcome(
                backend=name,
                measure=words,
                value=row.score.f_measure,
                asked=row.score.asked,
                seconds=row.score.cpu_seconds,
                right={f"{each.name} {each.kind}": each.true == each.positive for each in row.verdicts},
            )
            for name, row in scores.items()
        ]


def read_tasks(names: Sequence[str], known: Sequence[str] = TASKS) -> tuple[str, ...]:
    """Return the names of tasks, each once.

    Raises
    ------
    InputError
        If there is no such task.
    """
    given = tuple(dict.fromkeys(name.strip() for name in names))
    require_known("tasks", given, known)
    return given


def measured(
    objects: Sequence[DatasetObject],
    simulators: Mapping[str, Simulator],
    tasks: Sequence[str],
    count: int | None,
    classifier: CloudClassifier | None,
    loading: LoadOptions,
) -> TaskReports:
    """Return what simulators do of tasks, each asked for the tasks that it can do.

    Parameters
    ----------
    count : int, optional
        Objects of each task at most, evenly chosen.
    classifier : CloudClassifier, optional
        Which ranks poses; without one, the model that ships.
    """
    if "poses" in tasks and classifier is None:
        classifier = load_model(shipped_model("fast"))

    def measurable(task: str) -> dict[str, Simulator]:
        named = ABILITIES[task]
        return {name: row for name, row in simulators.items() if task in tasks and callable(getattr(row, named, None))}

    def scored(task: str, score: Callable[..., Any], *more: object) -> dict[str, Any]:
        scored = {name: score(objects, row, *more, count, loading) for name, row in measurable(task).items()}
        return {name: row for name, row in scored.items() if row is not None}

    return TaskReports(
        poses=scored("poses", score_poses, classifier),
        standing=scored("standing", score_standing),
        keeping=scored("keeping", score_keeping),
        places=scored("places", score_sitting),
        unable={task: tuple(name for name in simulators if name not in measurable(task)) for task in tasks},
    )


def benefit_sentence(task: str, outcomes: Sequence[TaskOutcome], unable: Sequence[str]) -> str:
    """Return in one sentence what fidelity buys at a task, at what price: the last backend beside the first."""
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
    verdict = "level with" if chance > CHANCE else "better than" if better else "worse than"
    buys = "gains nothing measurable" if chance > CHANCE else "buys that" if better else "costs that"
    times = f"{slow.seconds / max(quick.seconds, 1e-9):.1f} times the time"
    price = f"{times} ({format_duration(slow.seconds)} against {format_duration(quick.seconds)} each)"
    values = f"{slow.measure} {slow.value:.2f} against {quick.value:.2f} of {slow.asked}"
    return f"{task}: {slow.backend} is {verdict} {quick.backend} ({values}) and {buys}, at {price}."


def compare_outcomes(first: TaskOutcome, second: TaskOutcome) -> tuple[bool, float]:
    """Return whether the second is right more often, and how likely chance alone gives such a difference.

    An exact sign test of the objects of which one alone is right (McNemar).
    """
    from scipy.stats import binomtest

    names = first.right.keys() & second.right.keys()
    gains = sum(second.right[name] and not first.right[name] for name in names)
    losses = sum(first.right[name] and not second.right[name] for name in names)
    chance = binomtest(gains, gains + losses).pvalue if gains + losses else 1.0
    return gains > losses, float(chance)


def sentences(mechanics: TaskReports) -> dict[str, str]:
    """Return for each task that was asked what fidelity buys."""
    return {task: benefit_sentence(task, mechanics.outcomes(task), unable) for task, unable in mechanics.unable.items()}


def task_reports(mechanics: TaskReports) -> dict[str, dict[str, Any]]:
    """Return what was measured of each task, ready for JSON, with its sentence."""
    scores = {task: getattr(mechanics, task) for task in TASKS}
    sentence_of, same = sentences(mechanics), mechanics.agreement
    reports = {}
    for task, unable in mechanics.unable.items():
        rows = [asdict(row) for row in mechanics.outcomes(task)]
        more = {name: asdict(row) for name, row in scores[task].items()}
        for row in more.values():
            row.pop("answers", None)  # the single places of what stands
        reports[task] = {"says": sentence_of[task], "rows": rows, "unable": list(unable), "backends": more}
    if "standing" in reports:
        reports["standing"]["agreement"] = same and asdict(same)
    return reports
