"""Screening: which proposals in a scan cannot have a function, learnt from their surroundings alone.

``python -m spherefunc_bullet.compare.rooms.screening household --model MODEL --out MODEL`` adds it to a model for scans
(``make scan-model``). In virtual rooms that the model has not learnt, a forest learns from the surroundings of a
proposal whether the model gives it a function. In scans, proposals that cannot have one are neither completed, nor are
spheres dropped on them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from sklearn.ensemble import ExtraTreesClassifier
from sklearn.model_selection import GroupKFold, cross_val_predict

from spherefunc_bullet.console import Failures, run, say
from spherefunc_bullet.datasets.dataset import open_dataset
from spherefunc_bullet.errors import InputError
from spherefunc_bullet.learning.function_classifier import FunctionClassifier
from spherefunc_bullet.learning.model_file import load_model, save_model
from spherefunc_bullet.learning.profiles.forest import Screening, forest_from_sklearn
from spherefunc_bullet.scenes.recognition.room import LOWEST_THRESHOLD

from .scan_model import LEAST, TREES, examples_of_sets, room_sets
from .training_examples import TrainingExample

FOLDS = 5
LOST = 0.005  # share of the proposals with a function that may be rejected, in data sets that were left out


def main(
    data: Annotated[list[str], typer.Argument(help="Meshes: folders with manifest.csv, or catalogues.")],
    path: Annotated[Path, typer.Option("--model", help="A model for scans.")],
    out: Annotated[Path, typer.Option(help="The model file with screening.")],
    rooms: Annotated[int, typer.Option(min=1, help="Number of virtual rooms that are scanned.")] = 104,
    seed: Annotated[int, typer.Option(min=0, help="Random seed of the rooms, other than the model's.")] = 5000,
    cache: Annotated[Path | None, typer.Option("--keep", help="Folder in which examples are cached.")] = None,
    jobs: Annotated[int, typer.Option(help="Number of parallel processes; -1: one per core.")] = 1,
):
    """Add screening to a model for scans, learnt on the proposals in scans of virtual rooms."""
    failures, model = Failures(), load_model(path)
    if model.scene_forests_ is None:
        raise InputError(f"{path}: expected a model for scans, got one that has learnt no surroundings")
    sets = room_sets([open_dataset(name) for name in data], rooms, seed)
    examples = list(examples_of_sets(sets, model, cache, jobs, failures))
    save_model(with_screening(model, examples, [str(each.dataset.folder) for each in sets]), out)
    failures.exit()


def with_screening(
    model: FunctionClassifier, examples: Sequence[Sequence[TrainingExample]], sources: Sequence[str]
) -> FunctionClassifier:
    """Add screening to a model; its threshold is the highest that rejects at most a share LOST of what has a function.

    Parameters
    ----------
    examples : sequence of sequence of TrainingExample
        The proposals in several sets of rooms, which the model has not learnt.
    sources : sequence of str
        The data set of each set of rooms; each is left out in turn to find the threshold.
    """
    every = [example for some in examples for example in some]
    groups = np.repeat(sources, [len(some) for some in examples])
    around = np.array([example.surroundings for example in every])
    scores = model.scene_forests_.scores(model.profiles([example.settled for example in every]), around)
    has_function = (scores > LOWEST_THRESHOLD).any(axis=1)
    forest = ExtraTreesClassifier(TREES, min_samples_leaf=LEAST, max_features=None, random_state=0)
    folds = GroupKFold(min(FOLDS, len(set(sources))))
    votes = cross_val_predict(forest, around, has_function, groups=groups, cv=folds, method="predict_proba")[:, 1]
    threshold = float(np.quantile(votes[has_function], LOST))
    say(
        f"{len(every):,} proposals, {has_function.sum():,} with a function; in data sets left out "
        f"{np.mean(votes[has_function] < threshold):.3f} of these and "
        f"{np.mean(votes[~has_function] < threshold):.2f} of the others have less than {threshold:.3f} of the votes"
    )
    fitted = forest_from_sklearn(forest.fit(around, has_function)).to_float32()
    model.scene_forests_ = replace(model.scene_forests_, screening=Screening(forest=fitted, threshold=threshold))
    return model


if __name__ == "__main__":
    run(lambda: typer.run(main))
