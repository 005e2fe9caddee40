"""Classification in Python: what an object is for, and why, in one call."""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypedDict, Unpack, overload

from .classification import Decision, classify_by_all
from .clouds.cloud import Cloud
from .clouds.conversion import Anything, as_cloud, held_copy, holds_several, without_table
from .formats.units import BY_FILE
from .learning.model_file import models_for
from .settling.cached_runs import CloudObject

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from .function_model import FunctionModel
    from .learning.classifier import CloudClassifier
    from .places.place import Place

CUBES = 3  # number of cubes that are shown for a function, and against it


@dataclass(frozen=True, kw_only=True)
class Reason:
    """One quantity of an object, and its effect on the score of a function."""

    function: str
    quantity: str
    meaning: str  # of the quantity, in words
    radius: float  # of the spheres, metres
    value: float  # in `unit`
    unit: str  # "m", "m2", "share" (0 to 1), or "" for a number
    median: float  # of the training objects
    effect: float  # change of the score that this value makes, compared with the median

    def __str__(self) -> str:
        from .learning.profiles.words import with_unit

        value, median = (with_unit(number, self.unit) for number in (self.value, self.median))
        return f"{self.function} {self.effect:+.2f}: {self.meaning} {value} (median {median})"


@dataclass(frozen=True, kw_only=True)
class Answer:
    """The functions of one object, and why it has them."""

    name: str  # of the object
    functions: frozenset[str]  # that it has; empty for none
    scores: dict[str, float] = field(hash=False)  # of each function, 0 to 1; above 0.5 the object has it
    unsure: bool  # the last reasons say why
    reasons: tuple[str, ...]  # sentences; none from models that count cubes
    seconds: float = field(default=0.0, compare=False)
    source: tuple[Anything, str, str] | None = field(default=None, repr=False, compare=False)  # with units and up
    decision: Decision | None = field(default=None, repr=False, compare=False)  # with the drops it is based on

    @cached_property
    def cloud(self) -> Cloud | None:
        """The object, metres, z up; made again when first read, since answers for a library would fill the memory."""
        if self.source is None:
            return None
        anything, units, up = self.source
        return as_cloud(anything, units=units, up=up, name=self.name, report=lambda line: None)

    @cached_property
    def places(self) -> list[Place]:
        """Where it can be used, in the coordinates and units of the input; computed when first read."""
        from .places.finding import cloud_and_frame, places_of

        if self.source is None:
            return []
        anything, units, up = self.source
        cloud, to_input = cloud_and_frame(anything, units=units, up=up)
        return [place.moved(to_input) for place in places_of(cloud, scores=self.scores)]

    @cached_property
    def deciding(self) -> dict[str, list[Reason]]:
        """The quantities that decided about each function, the strongest first; none from models that count cubes."""
        decided = {} if self.decision is None else evidence(self.decision).get("quantities", {})
        return {name: [reason_of(name, row) for row in rows] for name, rows in decided.items()}

    def to_dict(self, explain: bool = False) -> dict[str, Any]:
        """Return what ``spherefunc classify --json`` prints of the object, with ``explain`` what decided as well."""
        source = None if self.source is None else self.source[0]
        file = str(source) if isinstance(source, str | Path) else self.name
        row = self.decision.row(file, self.seconds) | {"reasons": list(self.reasons)}
        return row | evidence(self.decision) if explain else row

    def plot(self) -> Figure:
        """Return a Matplotlib figure of the object and the spheres that settled on it, and what its colours mean."""
        from .viewer.still import explained_figure

        drops, radii = self.decision.reading.drops, self.decision.model.radius_
        counting = radii[max(self.scores, key=self.scores.get)]
        radius = counting if counting in drops else max(drops, key=lambda one: len(drops[one].rests))
        title = (", ".join(sorted(self.functions)) or "none") + ", unsure" * self.unsure
        return explained_figure(self.cloud, title, drops[radius].rests, radius)

    def _repr_html_(self) -> str:
        """Return the picture, the scores and the reasons, for notebooks."""
        from .viewer.page import image_html
        from .viewer.still import png_of_figure

        scores = ", ".join(f"{name} {score:.2f}" for name, score in self.scores.items())
        lines = "<br>".join(escape(line) for line in (scores, *self.reasons))
        return f"{image_html(escape(self.name), png_of_figure(self.plot()))}<p>{lines}</p>"


class Options(TypedDict, total=False):
    """How objects are read and classified; see `classify`."""

    units: str
    up: str
    model: str | Path | CloudClassifier | None
    backend: str | None
    function: str | None
    explain: bool
    cache: bool


@overload
def classify(anything: list[Anything], **how: Unpack[Options]) -> list[Answer]: ...


@overload
def classify(anything: Iterator[Anything], **how: Unpack[Options]) -> list[Answer]: ...


@overload
def classify(anything: dict[str, Anything], **how: Unpack[Options]) -> dict[str, Answer]: ...


@overload
def classify(anything: Anything, **how: Unpack[Options]) -> Answer: ...


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
    """Classify an object, or each of several objects.

    The model is read once per process, and kernels are compiled once per machine; after that an object takes about ten
    milliseconds.

    Parameters
    ----------
    anything : path, (N, 3) array_like, Open3D or trimesh object, Cloud
        Or several of these: a list, a generator, a column of a table, or a dict of names to objects; see `as_cloud`.
    units : {"m", "cm", "mm", "in", "auto"}
        Unit of the coordinates; ``auto`` guesses it and warns which it chose.
    up : {"file", "z", "-z", "y", "-y", "x", "-x", "auto"}
        Axis that points up; by default y for glTF files and z for all others.
    model : path or CloudClassifier, optional
        By default the model that comes with the package.
    backend : str, optional
        Simulator of the model; by default ``fast`` where no model is given. Of several, as in ``fast,bullet``, the
        first answers, and the answer is unsure where they disagree.
    function : str, optional
        Classify this function only; a model by cubes then runs its radius only.
    explain : bool
        Whether to give reasons; doubts are given either way.
    cache : bool
        Whether drops on the same object are read from the cache of the user, and written there.

    Returns
    -------
    Answer, or for several objects a list or dict of them

    Raises
    ------
    InputError
        If the object or the model cannot be used, or the size of the object shows that its unit is wrong.

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
    models = models_for(model, backend, function)
    several = holds_several(anything := without_table(anything))
    named = isinstance(anything, Mapping)
    answers, items = [], anything.values() if named else anything if several else [anything]
    for number, item in enumerate(items):
        name = f"object {number}" if several else None
        item = held_copy(item, name or "cloud")
        cloud = as_cloud(item, units=units, up=up, name=name)
        started = time.perf_counter()
        answer = answer_of(cloud.name, classify_by_all(partial(target_of, cloud, cache), models), explain)
        seconds = round(time.perf_counter() - started, 3)
        answers.append(replace(answer, source=(item, units, up), seconds=seconds))
    if named:
        return dict(zip(anything, answers, strict=True))
    return answers if several else answers[0]


def target_of(cloud: Cloud, cache: bool, model: FunctionModel) -> CloudObject:
    """Return a cloud as an object on which the spheres of a model are dropped."""
    return CloudObject(raw_cloud=cloud, drop_config=model.drop_config(), cache=cache)


def answer_of(name: str, decision: Decision, explain: bool = True) -> Answer:
    """Return the answer that reports a decision about an object."""
    doubts = decision.doubts()
    return Answer(
        name=name,
        functions=decision.functions,
        scores={name: membership.score for name, membership in decision.memberships.items()},
        unsure=bool(doubts),
        reasons=(*decision.reasons(explain), *doubts),
        decision=decision,
    )


def evidence(decision: Decision) -> dict[str, Any]:
    """Return the evidence for each function: quantities, or training objects and cubes."""
    reading, model = decision.reading, decision.reading.model
    names = model.functions_
    if reading.profile is None:
        from .learning.reasons.cubes import strongest_cubes

        return {
            "neighbors": {name: model.neighbors(reading.drops, name) for name in names},
            "cubes": {name: strongest_cubes(model, reading.drops, name, CUBES) for name in names},
        }
    from .learning.profiles.words import deciding_quantities, nearest

    falls = decision.fails_stability_check
    quantities = {name: [] if falls else deciding_quantities(reading, name) for name in names}
    return {"quantities": quantities, "nearest": nearest(reading)}


def reason_of(function: str, row: dict[str, Any]) -> Reason:
    """Return the reason in a row of `words.deciding_quantities`."""
    from .learning.profiles.quantities import QUANTITY

    same = {name: row[name] for name in ("quantity", "meaning", "radius", "value", "median")}
    return Reason(function=function, unit=QUANTITY[row["quantity"]].unit, effect=row["share"], **same)
