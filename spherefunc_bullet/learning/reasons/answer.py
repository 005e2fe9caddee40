"""What an object is for, with the reason, in one call."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
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
    from ...places.place import Place
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
    source: tuple[Anything, str, str] | None = field(default=None, repr=False, compare=False)  # with units and up

    @cached_property
    def places(self) -> list[Place]:
        """Where it can be used, in the coordinates and units of the input; looked for when it is first asked."""
        from ...places.finding import places_in_input

        if self.source is None:
            return []
        anything, units, up = self.source
        return places_in_input(anything, scores=self.scores, units=units, up=up)


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
    anything: dict[str, Anything],
    *,
    units: str = "m",
    up: str = BY_FILE,
    model: str | Path | CloudClassifier | None = None,
    backend: str | None = None,
    function: str | None = None,
    explain: bool = True,
    cache: bool = False,
) -> dict[str, Answer]: ...


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
) -> Answer | list[Answer] | dict[str, Answer]:
    """Say what an object is for, or what each of a list of objects is for.

    The model is read once in a process, and kernels are compiled once on a machine; after that an object takes some ten
    milliseconds.

    Parameters
    ----------
    anything : path, (N, 3) array_like, Open3D or trimesh object, Cloud
        Or several of such: a list, a generator, or a dict of names to objects; see `as_cloud`.
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
    Answer; a list of them, or a dict of names to them, of several objects

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
    items = each_of(anything) if several else [anything]
    clouds = [
        as_cloud(item, units=units, up=up, name=f"object {number}" if several else None)
        for number, item in enumerate(items)
    ]
    objects = [CloudObject(own=cloud, dropping=asked.dropping(), cache=cache) for cloud in clouds]
    answers = [
        replace(answer_of(each.own, decision_about(each, asked, view_model), explain), source=(item, units, up))
        for each, item in zip(objects, items, strict=True)
    ]
    if isinstance(anything, Mapping):
        return dict(zip(anything, answers, strict=True))
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


def each_of(anything: Iterable[Anything] | Mapping[str, Anything]) -> list[Anything]:
    """Return the objects of a list, a generator, or a dict of names to objects."""
    return list(anything.values() if isinstance(anything, Mapping) else anything)
