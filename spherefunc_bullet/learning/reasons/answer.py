"""What an object is for, with the reason, in one call."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, overload

from ...classification import Decision
from ...classification import classify as decision_about
from ...clouds.cloud import Cloud
from ...clouds.conversion import Anything, as_cloud, holds_several
from ...formats.units import BY_FILE
from ...settling.kept_object import CloudObject
from ..model_file import inference_model, model_for_views

if TYPE_CHECKING:
    from ..classifier import CloudClassifier


@dataclass(frozen=True, kw_only=True)
class Answer:
    """What one object is for."""

    name: str  # of the object
    functions: frozenset[str]  # that it has; empty for none
    scores: dict[str, float]  # of each function, 0 to 1; above 0.5 the object has it
    unsure: bool  # the last reasons say why
    reasons: tuple[str, ...]  # sentences; none from models that count cubes
    cloud: Cloud | None = field(default=None, repr=False, compare=False)  # that was asked about, metres, z up


@overload
def classify(
    anything: list[Anything],
    *,
    units: str = "m",
    up: str = BY_FILE,
    model: str | Path | CloudClassifier | None = None,
    backend: str | None = None,
    function: str | None = None,
    explain: bool = True,
    cache: bool = False,
) -> list[Answer]: ...


@overload
def classify(
    anything: Anything,
    *,
    units: str = "m",
    up: str = BY_FILE,
    model: str | Path | CloudClassifier | None = None,
    backend: str | None = None,
    function: str | None = None,
    explain: bool = True,
    cache: bool = False,
) -> Answer: ...


def classify(
    anything: Anything,
    *,
    units: str = "m",
    up: str = BY_FILE,
    model: str | Path | CloudClassifier | None = None,
    backend: str | None = None,
    function: str | None = None,
    explain: bool = True,
    cache: bool = False,
) -> Answer | list[Answer]:
    """Say what an object is for, or what each of a list of objects is for.

    The model is read once in a process, and kernels are compiled once on a machine; after that an object takes some ten
    milliseconds.

    Parameters
    ----------
    anything : path, (N, 3) array_like, Open3D or trimesh object, Cloud; or a list of such
    units : {"m", "cm", "mm", "in", "auto"}
        What its numbers mean; ``auto`` guesses, and warns of what it took.
    up : {"file", "z", "-z", "y", "-y", "x", "-x", "auto"}
        Which of its axes points up; by default y for glTF files and z for all else.
    model : path or CloudClassifier, optional
        By default the one that ships with the package.
    backend : str, optional
        The simulator that the model must be for; by default ``fast`` where no model is given.
    function : str, optional
        The only function to ask for: with models that count cubes, its radius alone is run.
    explain : bool
        Whether to give reasons; doubts are given either way.
    cache : bool
        Whether spheres that have fallen on the same object before are looked up in the user's cache.

    Returns
    -------
    Answer, or a list of them

    Raises
    ------
    InputError
        If the object or the model cannot be used, or the object is of a size that the unit must be wrong for.

    Examples
    --------
    >>> import numpy as np
    >>> angle, height = np.meshgrid(np.linspace(0, 6.28, 80), np.arange(0, 100, 4))
    >>> wall = np.column_stack([40 * np.cos(angle.ravel()), height.ravel(), 40 * np.sin(angle.ravel())])
    >>> bottom = np.vstack([wall[:80] * [share, 1, share] for share in np.linspace(0, 1, 11)])
    >>> answer = classify(np.vstack([wall, bottom]), units="mm", up="y")
    >>> sorted(answer.functions), answer.scores["table"] < 0.5, answer.reasons[0][:4]
    (['cup'], True, 'cup ')
    """
    asked = inference_model(model, backend)
    asked = asked if function is None else asked.only(function)
    view_model = partial(model_for_views, asked, given=model is not None)
    several = holds_several(anything)
    clouds = [
        as_cloud(item, units=units, up=up, name=f"object {number}" if several else None)
        for number, item in enumerate(anything if several else [anything])
    ]
    objects = [CloudObject(own=cloud, dropping=asked.dropping(), cache=cache) for cloud in clouds]
    answers = [answer_of(item.own, decision_about(item, asked, view_model), explain) for item in objects]
    return answers if several else answers[0]


def answer_of(cloud: Cloud, decision: Decision, explain: bool = True) -> Answer:
    """Return a decision about a cloud as an answer."""
    doubts = decision.doubts()
    return Answer(
        name=cloud.name,
        functions=decision.functions,
        scores={name: membership.score for name, membership in decision.memberships.items()},
        unsure=bool(doubts),
        reasons=(*decision.reasons(explain), *doubts),
        cloud=cloud,
    )
