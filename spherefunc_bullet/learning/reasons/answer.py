"""What an object is for, with the reason, in one call."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from pathlib import Path
from typing import TYPE_CHECKING, overload

from ...clouds.cloud import Cloud
from ...clouds.conversion import Anything, as_cloud, holds_several
from ...formats.units import BY_FILE
from ...settling.records import settle_kept
from ...settling.settling import Settled, settle
from ...simulator import make_simulator
from ...simulator.statics.falling_over import falls_over
from ..function_model import FALLS, FunctionModel, Membership, of_nobody
from ..model_file import model_to_ask, shipped_model
from ..profiles.profile_model import ProfileModel
from .one_view import COMPLETED, NOTHING, looks_like_one_view, nothing_settled, settled_on_completed
from .words import sentences

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
    asked = model_to_ask(model, backend)
    asked = asked if function is None else asked.only(function)
    of_views = model_of_views(asked, model, function)
    told = partial(answer_of, classifier=asked, explain=explain, cache=cache, of_views=of_views)
    several = holds_several(anything)
    clouds = [
        as_cloud(thing, units=units, up=up, name=f"object {number}" if several else None)
        for number, thing in enumerate(anything if several else [anything])
    ]
    sources = [(thing, units, up) for thing in (anything if several else [anything])]
    answers = [replace(told(cloud), source=source) for cloud, source in zip(clouds, sources, strict=True)]
    return answers if several else answers[0]


def model_of_views(
    asked: FunctionModel, given: str | Path | FunctionModel | None, function: str | None = None
) -> Callable[[], FunctionModel]:
    """Return what gets the model that tells single views: the one that was given, else the one that ships for scans."""

    def model() -> FunctionModel:
        """Return it."""
        if given is not None:
            return asked
        backend = make_simulator(asked.simulator).name
        shipped = model_to_ask(shipped_model(backend, scans=True), backend)
        return shipped if function is None else shipped.only(function)

    return model


def answer_of(
    cloud: Cloud,
    classifier: FunctionModel,
    *,
    explain: bool = True,
    cache: bool = False,
    of_views: Callable[[], FunctionModel] | None = None,
) -> Answer:
    """Return what one cloud is for; one view that is for nothing is completed, and what ``of_views`` gives is asked."""
    drop = settle_kept if cache else settle
    how = (classifier.simulator, classifier.chosen_radii(), classifier.seed)
    settled = classifier.settled_by(partial(drop, cloud, *how))
    answer = answered(cloud.name, settled, classifier, lambda: falls_over(cloud), explain=explain)
    if answer.functions or not looks_like_one_view(cloud):
        return answer
    model = classifier if of_views is None else of_views()
    completed = settled_on_completed(cloud, model)
    if completed is not None:
        whole = answered(cloud.name, completed, model, lambda: False, explain=explain)  # of points: nobody knows
        if whole.functions or nothing_settled(settled):
            return doubted(whole, COMPLETED)
    return doubted(answer, NOTHING) if nothing_settled(settled) else answer


def doubted(answer: Answer, doubt: str) -> Answer:
    """Return an answer that is unsure for a reason more."""
    return replace(answer, unsure=True, reasons=(*answer.reasons, doubt))


def answered(
    name: str, settled: Settled, classifier: FunctionModel, falls_over: Callable[[], bool], *, explain: bool = True
) -> Answer:
    """Return what an object is for, on which spheres have fallen."""
    told, reasons, doubtful = told_in_words(classifier, settled, falls_over, explain)
    return Answer(
        name=name,
        functions=frozenset(function for function, membership in told.items() if membership.member),
        scores={function: membership.score for function, membership in told.items()},
        unsure=bool(doubtful),
        reasons=(*reasons, *doubtful),
    )


def told_in_words(
    classifier: FunctionModel, settled: Settled, falls_over: Callable[[], bool], explain: bool = True
) -> tuple[dict[str, Membership], list[str], list[str]]:
    """Return what an object is for, the same in sentences, and what is doubtful about it.

    The last two are empty where cubes are counted. ``falls_over`` says whether it does when it is put down.
    """
    told = classifier.memberships_of([settled])[0]
    if not isinstance(classifier, ProfileModel):
        return told, [], []
    reader, scores = classifier.reader_of(settled), [membership.score for membership in told.values()]
    said = sentences(reader, settled, scores) if explain else []
    if classifier.serves_nobody(told, falls_over):
        return of_nobody(told), [FALLS, *said], []
    return told, said, reader.doubts(settled, scores)
