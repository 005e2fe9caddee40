"""What `spherefunc compare --json` prints, and ``report.json`` holds; only the latter has ``per_object``."""

from __future__ import annotations

from typing import Any, NotRequired, TypedDict

from ..evaluation.impaired import Shares
from ..evaluation.tables import Qualities


class Difference(TypedDict):
    """How much better one simulator tells a function than another, over the same trials."""

    difference: float  # of F-measures, mean
    margin: float | None  # half width of its 95 % interval; of one trial there is none
    verdict: str


class Timing(TypedDict):
    """What some runs took; an object's seconds are those of all radii together."""

    seconds_per_object: float  # median
    seconds_per_object_p95: float
    seconds_total: float
    drops: int
    drops_per_second: float | None


class FeatureReport(TypedDict):
    """How well one feature tells functions, over trials and with each object left out."""

    functions: Qualities
    leave_one_out: Qualities


class RadiusReport(Timing):
    """What one radius alone gives and costs."""

    radius: float  # metres
    functions: Qualities
    settled_share: float | None  # of all spheres dropped


class BackendReport(FeatureReport, Timing):
    """Everything of one simulator."""

    settled_share: float | None
    peak_memory: int | None  # bytes of a whole process, interpreter and libraries included
    peak_memory_runs: int  # of how many runs it is known: those of an older cache lack it
    failed: int
    reasons: list[str]
    radii: list[float]  # metres
    by_radius: list[RadiusReport]
    backend: str
    version: str
    options: dict[str, Any]
    sphere_limit: int  # settled spheres at which a run ends


class HistogramAgreement(TypedDict):
    """How far two simulators' histograms lie apart, medians over objects in spheres; None where not finite."""

    radius: float  # metres
    ratio: float | None  # to both seeds
    ratio_to: dict[str, float | None]  # to the seeds of each
    between: float | None
    within: dict[str, float | None]
    norm: float | None
    objects: int  # that have a ratio, of which all these are


class LabelAgreement(TypedDict):
    """Of how many objects two simulators say the same."""

    same: float  # share
    right_alone: dict[str, int]  # objects that one alone has right


class SettledShares(TypedDict):
    """The share of spheres that settled, by simulator."""

    radius: float  # metres
    share: dict[str, float | None]


class PairReport(TypedDict):
    """Whether two simulators agree."""

    backends: list[str]
    objects_again: int
    histograms: list[HistogramAgreement]
    settled: list[SettledShares]
    labels: dict[str, LabelAgreement]  # by function
    labels_of_two_seeds: dict[str, dict[str, float]]  # by simulator and function
    f_measures: dict[str, Difference]  # by function


class ObjectFigures(TypedDict):
    """What one simulator made of an object, with all others learnt."""

    seconds: float
    drops: int
    settled: int
    scores: dict[str, float]


class ObjectReport(TypedDict):
    """What every simulator made of one object."""

    file: str
    functions: list[str]
    also: list[str]
    group: str
    backends: dict[str, ObjectFigures]


class Report(TypedDict):
    """The whole comparison."""

    answer: str
    objects: int
    backends: dict[str, BackendReport]
    agreement: list[PairReport]
    baselines: dict[str, FeatureReport]
    methods: dict[str, dict[str, Qualities]]  # by method and feature
    data: str
    functions: dict[str, int]  # how many objects have each
    train_size: int
    test_size: int
    left_out: list[str]
    objects_again: int
    experiment: dict[str, Any]
    machine: dict[str, str]
    timing: str
    per_object: NotRequired[list[ObjectReport]]
    tasks: NotRequired[dict[str, dict[str, Any]]]  # besides labels, by task, see `mechanics.measures.task_reports`
    impaired: NotRequired[Shares]  # copies still called by their function, where that was asked
