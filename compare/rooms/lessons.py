"""Models for virtual rooms: learnt from whole models, as the paper did, from partial views, or from both."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from spherefunc_bullet.batch.simulated import Simulated, simulate_dataset
from spherefunc_bullet.console import say
from spherefunc_bullet.datasets.dataset import Dataset
from spherefunc_bullet.errors import InputError
from spherefunc_bullet.learning.function_classifier import FunctionClassifier
from spherefunc_bullet.learning.model_file import load_model
from spherefunc_bullet.scenes.recognition.recognition import LARGE
from spherefunc_bullet.scenes.virtual_rooms.furnishing import Furnishing, furnish
from spherefunc_bullet.scenes.virtual_rooms.partial_views import partial_views
from spherefunc_bullet.scenes.virtual_rooms.scans import scan_room
from spherefunc_bullet.settling.settling import settle
from spherefunc_bullet.simulator import Simulator

from .trials import Condition, Fold, halves

EXAMPLES = ("whole", "views", "both", "both-large")
OTHER_ROOMS = 1000  # added to the seed: the rooms that are learnt from are not those that are tested


@dataclass(frozen=True, kw_only=True)
class Lesson:
    """What is learnt from, and how."""

    simulator: Simulator
    radii: tuple[float, ...]  # metres
    examples: str = "whole"  # one of EXAMPLES
    scanned: Condition = Condition(views=3, noise=1.0)  # how partial views come about
    completion: tuple[str, ...] = ()
    method: str = "default"
    seed: int = 0


def folds(dataset: Dataset, lesson: Lesson, failed: Callable[[InputError], None], jobs: int) -> list[Fold]:
    """Return each half of a data set with a model that has learnt the other half.

    Parameters
    ----------
    failed : callable
        Is given the error of each file that cannot be used; the rest goes on.
    """
    simulated = simulate_dataset(
        dataset, lesson.simulator, lesson.radii, seed=lesson.seed, jobs=jobs, failed=failed
    )
    usable = Dataset(dataset.name, simulated.objects)
    one, other = halves(usable, lesson.seed)
    return [
        Fold(dataset=tested, model=learnt_model(learnt, simulated, lesson, failed), jobs=jobs)
        for tested, learnt in ((one, other), (other, one))
    ]


def told_by(model: Path, dataset: Dataset, jobs: int) -> Fold:
    """Return a data set with a model from a file; if it has learnt the same objects, the figures flatter."""
    classifier = load_model(model)
    learnt = set(classifier.names_) & {item.path.name for item in dataset.objects}
    if learnt:
        say(f"{model}: has learnt {len(learnt)} objects of the names of those it is to tell; the figures may flatter")
    return Fold(dataset=dataset, model=classifier, jobs=jobs)


def learnt_model(
    dataset: Dataset, simulated: Simulated, lesson: Lesson, failed: Callable[[InputError], None]
) -> FunctionClassifier:
    """Return a classifier that has learnt a data set's objects as whole models, partial views, or both.

    Of ``both-large``, partial views of large objects only: those of small ones look like what they are not.
    """
    settled, labels, names = [], [], []
    if lesson.examples != "views":
        by_path = {record.path: record.settled for record in simulated.records}
        settled += [by_path[item.path] for item in dataset.objects]
        labels += [item.functions for item in dataset.objects]
        names += [item.path.name for item in dataset.objects]
    if lesson.examples != "whole":
        for item, name, centers in seen_examples(dataset, lesson, failed):
            settled.append(centers)
            labels.append(item.functions)
            names.append(name)
    model = FunctionClassifier(lesson.simulator, radii=lesson.radii, method=lesson.method, seed=lesson.seed)
    return model.fit_settled(settled, labels, names)


def seen_examples(dataset: Dataset, lesson: Lesson, failed) -> Sequence[tuple]:
    """Yield object, name and settled centres of what scans of rooms show of a data set's objects."""
    settings = Furnishing()
    rooms = -(-len(dataset) // (settings.tables + settings.on_floor + settings.on_tops))
    for room in furnish(dataset, rooms, seed=lesson.seed + OTHER_ROOMS, failed=failed):
        scan = scan_room(room, lesson.scanned.views, lesson.scanned.noise, lesson.seed)
        for number, cloud in partial_views(scan, lesson.completion):
            if lesson.examples == "both-large" and cloud.size.max() < LARGE:
                continue
            name = f"{room.objects[number].item.path.stem} in {room.name}"
            yield room.objects[number].item, name, settle(cloud, lesson.simulator, lesson.radii, lesson.seed)
