"""How a trained model classifies labelled objects that it has not learnt: a held-out test set.

    python -m spherefunc_bullet.compare.evaluation.robustness.exam DATA... [--backend bullet] [--model MODEL]

It prints the F-measure of each function, how many answers are unsure, how many of the others are right, and which are
wrong.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Annotated

import numpy as np
import typer

from spherefunc_bullet.answer import classify
from spherefunc_bullet.commands import options
from spherefunc_bullet.console import Failures, print_json, print_table, progress, run
from spherefunc_bullet.datasets.dataset import Dataset, DatasetObject, joined_datasets, open_dataset
from spherefunc_bullet.errors import InputError, require_known
from spherefunc_bullet.learning.model_file import load_model
from spherefunc_bullet.scenes.impairment.folder import function_of
from spherefunc_bullet.scenes.impairment.specimen import NONE

from ..evaluation import Trial
from ..protocol import labels_of
from .across_sources import described, kinds_of, print_report, report_of


@dataclass(frozen=True, kw_only=True)
class SavedAnswer:
    """An answer without the object's points."""

    functions: frozenset[str]
    scores: dict[str, float]
    unsure: bool


def answers_of(dataset: Dataset, failures: Failures, **how: object) -> tuple[Dataset, list[SavedAnswer]]:
    """Return the objects that could be classified, and the answers; all others are added to the failures."""
    objects, answers = [], []
    for item in progress(dataset.objects, len(dataset), "classifying"):
        try:
            answer = classify(item.path, explain=False, **how)
        except InputError as error:
            failures.add(error)
            continue
        objects.append(item)
        answers.append(SavedAnswer(functions=answer.functions, scores=answer.scores, unsure=answer.unsure))
    return replace(dataset, objects=tuple(objects)), answers


def row_of(item: DatasetObject, answer: SavedAnswer) -> dict[str, str]:
    """Return one answer next to the label, as a row of the table."""
    return {
        "file": item.path.name,
        "label": function_of(item) or NONE,
        "answer": ", ".join(sorted(answer.functions)) or NONE,
        "highest score": f"{max(answer.scores.values()):.2f}",
        "unsure": "yes" if answer.unsure else "no",
    }


def main(
    data: Annotated[list[str], typer.Argument(help="Data sets that the model has not learnt.")],
    backend: options.Backend = "fast",
    model: options.Model = None,
    json: options.Json = False,
):
    """Classify objects with a trained model, and compare the answers with the labels."""
    failures, datasets = Failures(), [open_dataset(name) for name in data]
    test_set, trained = joined_datasets(datasets), load_model(model, backend)
    require_known(f"{test_set.name}: label", test_set.functions, trained.functions_)
    dataset, answers = answers_of(test_set, failures, backend=backend, model=trained)
    labels = labels_of(dataset)
    trial = Trial(
        learnt=0,
        rows=np.arange(len(dataset)),
        scores=np.array([[answer.scores[name] for name in labels.functions] for answer in answers]),
        weights=(),
        unsure=np.array([answer.unsure for answer in answers]),
    )
    report = report_of(described(trial, labels, dataset.objects, kinds_of(datasets)))
    wrong = [row_of(dataset.objects[row], answers[row]) for row in np.flatnonzero(trial.wrong(labels))]
    if json:
        print_json(report | {"wrong": wrong})
    else:
        print_report(report)
        print_table("\nwrong answers", list(wrong[0]) if wrong else ["file"], [list(row.values()) for row in wrong])
    failures.exit()


if __name__ == "__main__":
    run(lambda: typer.run(main))
