"""Halves of a data set that furnish rooms, each with a model that has learnt the other half, or a model from a file."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from spherefunc_bullet.batch.simulated import Simulated, simulate_dataset
from spherefunc_bullet.console import say
from spherefunc_bullet.datasets.dataset import Dataset
from spherefunc_bullet.learning.classifier import CloudClassifier
from spherefunc_bullet.learning.model_file import load_model, new_classifier
from spherefunc_bullet.scenes.settings import SEGMENTATION
from spherefunc_bullet.scenes.virtual_rooms.furnishing import ON_FLOOR, ON_TOPS, TABLES, furnish
from spherefunc_bullet.scenes.virtual_rooms.scans import partial_views, scan_room
from spherefunc_bullet.settling.cached_runs import DropConfig
from spherefunc_bullet.settling.drops import DropsByRadius
from spherefunc_bullet.settling.settling import settle

from .trials import Failed, Fold, split_in_halves

VIEWS, NOISE = 3, 1.0  # of the scans that partial views are cut out of
OTHER_ROOMS = 1000  # added to the seed, so that other rooms are learnt than tested


@dataclass(frozen=True, kw_only=True)
class TrainingOptions:
    """How training examples are made, and the method that learns from them."""

    drop_config: DropConfig
    completion: tuple[str, ...] = ()
    method: str = "cubes"


def two_folds(dataset: Dataset, training: TrainingOptions, failed: Failed, jobs: int) -> list[Fold]:
    """Return each half of a data set with a model that has learnt the other half.

    Parameters
    ----------
    failed : callable
        Is called with the error of each file that cannot be used; all others are used.
    """
    simulated = simulate_dataset(dataset, training.drop_config, jobs=jobs, failed=failed)
    one, other = split_in_halves(Dataset(dataset.name, simulated.objects), training.drop_config.seed)
    return [
        Fold(dataset=tested, model=trained_classifier(learnt, simulated, training, failed))
        for tested, learnt in ((one, other), (other, one))
    ]


def whole_fold(dataset: Dataset, model: Path) -> Fold:
    """Return a data set with a model from a file; if the model has learnt some of these objects, print a warning."""
    classifier = load_model(model)
    learnt = set(classifier.names_) & {item.path.name for item in dataset.objects}
    if learnt:
        say(f"{model}: has learnt {len(learnt)} objects of the same names as those tested; figures may be optimistic")
    return Fold(dataset=dataset, model=classifier)


def trained_classifier(
    dataset: Dataset, simulated: Simulated, training: TrainingOptions, failed: Failed
) -> CloudClassifier:
    """Return a classifier that has learnt a data set's objects as whole models, and partial views of large ones.

    Partial views of small objects look like what they are not.
    """
    by_path = {record.path: record.settled for record in simulated.records}
    examples = [(by_path[item.path], item.functions, item.path.name) for item in dataset.objects]
    examples += partial_examples(dataset, training, failed)
    settled, labels, names = ([example[column] for example in examples] for column in range(3))
    return new_classifier(training.drop_config, training.method).fit_settled(settled, labels, names)


def partial_examples(
    dataset: Dataset, training: TrainingOptions, failed: Failed
) -> Iterator[tuple[DropsByRadius, frozenset[str], str]]:
    """Yield the drops, functions and name of each view of a data set's large objects in scans of rooms."""
    rooms, how = -(-len(dataset) // (TABLES + ON_FLOOR + ON_TOPS)), training.drop_config
    for room in furnish(dataset, rooms, seed=how.seed + OTHER_ROOMS, failed=failed):
        scan = scan_room(room, VIEWS, NOISE, how.seed)
        for number, cloud in partial_views(scan, training.completion):
            if cloud.size.max() < SEGMENTATION.large:
                continue
            item = room.objects[number].item
            settled = settle(cloud, how.simulator, how.radii, how.seed, how.run_limit)
            yield settled, item.functions, f"{item.path.stem} in {room.name}"
