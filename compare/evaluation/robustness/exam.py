"""What a model that is ready says of labelled objects that it has not learnt.

    python -m spherefunc_bullet.compare.evaluation.robustness.exam DATA... [--backend bullet] [--model MODEL]

It prints the F-measure of each function, how many answers are unsure, how many of the others are right, and which are
wrong.
"""

from __future__ import annotations

from typing import Annotated

import numpy as np
import typer

from spherefunc_bullet.answer import Answer, classify
from spherefunc_bullet.commands import options
from spherefunc_bullet.console import print_json, print_table, progress, run
from spherefunc_bullet.datasets.dataset import DatasetObject, joined_datasets, open_dataset
from spherefunc_bullet.scenes.impairment.folder import function_of
from spherefunc_bullet.scenes.impairment.specimen import NONE

from ..evaluation import Trial
from ..protocol import labels_of
from .across_sources import WHOLE, Answered, kinds_of, print_report, report_of


def main(
    data: Annotated[list[str], typer.Argument(help="Data sets that the model has not learnt.")],
    backend: options.Backend = "fast",
    model: options.Model = None,
    json: options.Json = False,
):
    """Ask a model that is ready, and compare what it says with the labels."""
    datasets = [open_dataset(name) for name in data]
    dataset, kinds = joined_datasets(datasets), kinds_of(datasets)
    objects, labels = dataset.objects, labels_of(dataset)
    answers = [
        classify(item.path, backend=backend, model=model, explain=False)
        for item in progress(objects, len(objects), "classifying")
    ]
    scores = np.array([[answer.scores[name] for name in labels.functions] for answer in answers])
    unsure = np.array([answer.unsure for answer in answers])
    trial = Trial(learnt=0, rows=np.arange(len(objects)), scores=scores, weights=(), unsure=unsure)
    said = Answered(
        trial=trial,
        labels=labels,
        kinds=np.array([kinds.get(str(item.path), WHOLE) for item in objects]),
        originals=np.array([function_of(item) or NONE for item in objects]),
        folders=np.array([item.path.parent.name for item in objects]),
    )
    wrong = [row_of(objects[row], answers[row]) for row in np.flatnonzero(trial.wrong(labels))]
    report = report_of(said)
    if json:
        print_json(report | {"wrong": wrong})
        return
    print_report(report)
    print_table("\nwrong answers", list(wrong[0]) if wrong else ["file"], [list(row.values()) for row in wrong])


def row_of(item: DatasetObject, answer: Answer) -> dict[str, str]:
    """Return one answer beside the label."""
    return {
        "file": item.path.name,
        "label": function_of(item) or NONE,
        "answer": ", ".join(sorted(answer.functions)) or NONE,
        "highest score": f"{max(answer.scores.values()):.2f}",
        "unsure": "yes" if answer.unsure else "no",
    }


if __name__ == "__main__":
    run(lambda: typer.run(main))
