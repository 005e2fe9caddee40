"""What `spherefunc evaluate` reports: every protocol's figures, the baselines' beside the spheres'."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NotRequired, TypedDict

import numpy as np

from spherefunc_bullet.batch.simulated import Simulated
from spherefunc_bullet.console import say
from spherefunc_bullet.learning.method import AnyMethod

from .confusion import Said, confusion_report
from .evaluation import Evaluation, FunctionQuality
from .features import SPHERES
from .protocol import Protocol, Split, Splits, labels_of
from .readings import readings

Qualities = dict[str, FunctionQuality]  # by function


class Result(TypedDict):
    """One protocol's figures at one training size."""

    protocol: str
    train_size: int
    functions: Qualities
    baselines: dict[str, Qualities]
    trials: NotRequired[int]
    said: NotRequired[Said]  # of the tested objects, by the spheres


def evaluate_features(
    simulated: Simulated, radii: tuple[float, ...], method: AnyMethod, protocol: Protocol
) -> dict[str, Evaluation]:
    """Return the evaluation of the spheres and of every baseline; see `readings`."""
    splits = protocol.splits(labels_of(simulated))
    return {name: read.evaluation(splits) for name, read in readings(simulated, radii, method).items()}


def results_of(evaluations: Mapping[str, Evaluation]) -> list[Result]:
    """Return the results of all protocols, random halves first."""
    spheres, results = evaluations[SPHERES], []
    for size, trials in spheres.trials.items():
        figures = {name: evaluation.quality(size) for name, evaluation in evaluations.items()}
        said = confusion_report(spheres.labels, trials)
        results.append(result("random_splits", size, figures) | {"trials": len(trials), "said": said})
    for protocol, pooled in spheres.left_out.items():
        figures = {name: evaluation.left_out_quality(protocol) for name, evaluation in evaluations.items()}
        results.append(result(protocol, pooled.learnt, figures) | {"said": confusion_report(spheres.labels, [pooled])})
    return results


def result(protocol: str, train_size: int, figures: dict[str, Qualities]) -> Result:
    """Return one protocol's figures, the spheres' apart from the baselines'."""
    baselines = {name: qualities for name, qualities in figures.items() if name != SPHERES}
    return {"protocol": protocol, "train_size": train_size, "functions": figures[SPHERES], "baselines": baselines}


def transfer_result(learnt: Simulated, tested: Simulated, radii: tuple[float, ...], method: AnyMethod) -> Result:
    """Return the result of learning on one data set and testing on another.

    Raises
    ------
    InputError
        If all objects to learn from have one label.
    """
    known = labels_of(learnt).functions
    unknown = set().union(*(item.functions for item in tested.objects)) - set(known)
    if unknown:
        say(f"{tested.name}: no training object is labelled {', '.join(sorted(unknown))}; those can't be found")
    both = Simulated(learnt.name, learnt.objects + tested.objects, learnt.records + tested.records)
    labels, count = labels_of(both), len(learnt.objects)
    splits = Splits(halves={count: [Split(np.arange(count), np.arange(count, len(labels)))]})
    evaluations = {name: read.evaluation(splits) for name, read in readings(both, radii, method).items()}
    figures = {name: evaluation.quality(count) for name, evaluation in evaluations.items()}
    return result("test", count, figures) | {"said": confusion_report(labels, evaluations[SPHERES].trials[count])}
