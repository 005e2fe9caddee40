"""What spheres have to beat on the same proposals: boxes, points in the same cubes, and the points' quantities.

Each learns the objects that the model has learnt, and tells what was proposed by what it is made of, without spheres.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

import numpy as np
from sklearn.metrics.pairwise import euclidean_distances

from spherefunc_bullet.batch.simulated import Simulated, simulate_dataset
from spherefunc_bullet.clouds.cloud import Cloud, load_cloud
from spherefunc_bullet.console import say
from spherefunc_bullet.datasets.dataset import Dataset, DatasetObject, open_dataset
from spherefunc_bullet.errors import InputError
from spherefunc_bullet.function_model import FunctionModel
from spherefunc_bullet.learning.classifier import CloudClassifier
from spherefunc_bullet.learning.cube_classifier import CubeClassifier
from spherefunc_bullet.learning.function_classifier import FunctionClassifier
from spherefunc_bullet.learning.labels import memberships
from spherefunc_bullet.learning.method import CUBES, PROFILE_RADII
from spherefunc_bullet.learning.model_file import load_model, new_classifier
from spherefunc_bullet.learning.validation import member_scores
from spherefunc_bullet.scenes.recognition.judging import LARGE, SMALLEST_RADII, value_for_size
from spherefunc_bullet.scenes.virtual_rooms.furnishing import ON_FLOOR, ON_TOPS, TABLES, furnish
from spherefunc_bullet.scenes.virtual_rooms.scans import partial_views, scan_room
from spherefunc_bullet.settling.drops import DropsByRadius, resting_drops
from spherefunc_bullet.settling.records import Dropping, ObjectRecord, shape_of
from spherefunc_bullet.settling.settling import settle

from ..evaluation.features import level_sizes, voxel_centers
from ..evaluation.readings import points_as_drops
from .lessons.files import lesson_paths, read_lessons
from .lessons.lesson import counted, examples_kept, record_of
from .trials import Fold, split_in_halves

CUBE_RADII = (0.01, 0.02, 0.03, 0.05)  # metres, of the cubes, where the model that is compared with has none


@dataclass(frozen=True, kw_only=True)
class Learnt:
    """Objects to learn, as shapes."""

    records: Sequence[ObjectRecord]
    labels: Sequence[frozenset[str]]

    @property
    def names(self) -> list[str]:
        """What the objects are called."""
        return [record.path.name for record in self.records]


class Baseline(Protocol):
    """Tells functions of shapes, after learning some."""

    functions: tuple[str, ...]

    def scores(self, records: Sequence[ObjectRecord]) -> np.ndarray:
        """Return the scores (P, F) of objects."""


def learnt_objects(sources: Sequence[str], failed: Callable[[InputError], None]) -> Learnt:
    """Return the objects of data sets as shapes.

    Parameters
    ----------
    sources : sequence of str
        Folders of objects or of lessons, see `lessons`, or names of catalogues.
    failed : callable
        Is given the error of each file that cannot be used.

    Raises
    ------
    InputError
        If one is no data set, or no object is left.
    """
    known: list[tuple[ObjectRecord, frozenset[str]]] = []
    of_rooms = False
    for source in sources:
        rooms = lesson_paths(Path(source))
        of_rooms |= bool(rooms)
        known += lessons_learnt(rooms) if rooms else objects_learnt(open_dataset(source).objects, failed)
    if not known:
        raise InputError(f"{', '.join(sources)}: expected objects to learn, found none that can be used")
    if of_rooms:  # as a model for scans keeps them: neighbours of all that has no function would not fit into memory
        known = [known[k] for k in examples_kept(np.array([bool(functions) for _, functions in known]))]
    return Learnt(records=[record for record, _ in known], labels=[functions for _, functions in known])


def lessons_learnt(rooms: Sequence[Path]) -> Iterator[tuple[ObjectRecord, frozenset[str]]]:
    """Yield what rooms teach and its functions, as the model for scans learns them; what some are unclear of is not."""
    for one in counted(lesson for path in rooms for lesson in read_lessons(path)):
        if not one.unclear:
            yield one.record, one.functions


def objects_learnt(
    objects: Sequence[DatasetObject], failed: Callable[[InputError], None]
) -> Iterator[tuple[ObjectRecord, frozenset[str]]]:
    """Yield the shapes of a data set's objects, and their functions."""
    for item in objects:
        try:
            yield shape_record(load_cloud(item.path), item.path), item.functions
        except InputError as error:
            failed(error)


def shape_record(cloud: Cloud, path: Path) -> ObjectRecord:
    """Return a cloud's shape, without spheres."""
    return record_of(path, shape_of(cloud), {})


def baselines(learnt: Learnt, model: FunctionModel) -> dict[str, Baseline]:
    """Return every baseline, by its name, after learning."""
    return {
        "bounding box": BoundingBoxes(learnt),
        "points in the same cubes": PointsInCubes(learnt, model),
        "points' quantities": PointsQuantities(learnt, model),
    }


class BoundingBoxes:
    """Nearest neighbours by width, depth and height."""

    def __init__(self, learnt: Learnt):
        self.functions = tuple(sorted(set().union(*learnt.labels)))
        self.sizes = level_sizes(learnt.records)
        self.members = memberships(learnt.labels, self.functions)

    def scores(self, records: Sequence[ObjectRecord]) -> np.ndarray:
        """Return the scores (P, F) of objects."""
        distances = euclidean_distances(level_sizes(records), self.sizes)
        return np.column_stack([member_scores(distances, column, CUBES) for column in self.members.T])


class PointsInCubes:
    """The paper's features with an object's points in place of spheres: the same cubes, neighbours and votes."""

    def __init__(self, learnt: Learnt, model: FunctionModel):
        radii = model.radii if isinstance(model, CubeClassifier) else CUBE_RADII
        self.classifier = CubeClassifier(model.simulator, radii=radii, seed=model.seed)
        points = [
            {radius: resting_drops(radius, voxel_centers(record)) for radius in radii} for record in learnt.records
        ]
        self.classifier.fit_settled(points, learnt.labels, learnt.names)
        self.functions = self.classifier.functions_

    def scores(self, records: Sequence[ObjectRecord]) -> np.ndarray:
        """Return the scores (P, F) of objects, each turned by quarters as the spheres' are."""
        return self.classifier.score_settled([self.points_of(record) for record in records], any_heading=True)

    def points_of(self, record: ObjectRecord) -> DropsByRadius:
        """Return an object's points at the radii at which spheres would be dropped on it."""
        least = value_for_size(SMALLEST_RADII, record.size.max())
        radii = [radius for radius in self.classifier.chosen_radii() if radius >= least]
        return {radius: resting_drops(radius, voxel_centers(record)) for radius in radii}


class PointsQuantities:
    """The resting profile's quantities, read of an object's points in place of spheres."""

    def __init__(self, learnt: Learnt, model: FunctionModel):
        self.classifier = FunctionClassifier(model.simulator, radii=PROFILE_RADII, seed=model.seed)
        points = [points_as_drops(record, PROFILE_RADII) for record in learnt.records]
        self.classifier.fit_settled(points, learnt.labels, learnt.names)
        self.functions = self.classifier.functions_

    def scores(self, records: Sequence[ObjectRecord]) -> np.ndarray:
        """Return the scores (P, F) of objects."""
        return self.classifier.score_settled([points_as_drops(record, PROFILE_RADII) for record in records])


EXAMPLES = ("whole", "views", "both", "both-large")
VIEWS, NOISE = 3, 1.0  # of the scans that partial views are cut out of
OTHER_ROOMS = 1000  # added to the seed: the rooms that are learnt from are not those that are tested


@dataclass(frozen=True, kw_only=True)
class Training(Dropping):
    """What is learnt from, and how."""

    examples: str = "whole"  # one of EXAMPLES
    completion: tuple[str, ...] = ()
    method: str = "cubes"

    def __post_init__(self):
        super().__post_init__()
        if self.examples not in EXAMPLES:
            raise InputError(f"--examples {self.examples}: expected one of {', '.join(EXAMPLES)}")


def two_folds(dataset: Dataset, training: Training, failed: Callable[[InputError], None], jobs: int) -> list[Fold]:
    """Return each half of a data set with a model that has learnt the other half.

    Parameters
    ----------
    failed : callable
        Is given the error of each file that cannot be used; the rest goes on.
    """
    simulated = simulate_dataset(dataset, training, jobs=jobs, failed=failed)
    one, other = split_in_halves(Dataset(dataset.name, simulated.objects), training.seed)
    return [
        Fold(dataset=tested, model=trained_classifier(learnt, simulated, training, failed), jobs=jobs)
        for tested, learnt in ((one, other), (other, one))
    ]


def whole_fold(dataset: Dataset, model: Path, jobs: int) -> Fold:
    """Return a data set with a model from a file; if it has learnt the same objects, the figures flatter."""
    classifier = load_model(model)
    learnt = set(classifier.names_) & {item.path.name for item in dataset.objects}
    if learnt:
        say(f"{model}: has learnt {len(learnt)} objects of the names of those it is to tell; the figures may flatter")
    return Fold(dataset=dataset, model=classifier, jobs=jobs)


def trained_classifier(
    dataset: Dataset, simulated: Simulated, training: Training, failed: Callable[[InputError], None]
) -> CloudClassifier:
    """Return a classifier that has learnt a data set's objects as whole models, partial views, or both.

    Of ``both-large``, partial views of large objects only: those of small ones look like what they are not.
    """
    examples: list[tuple[DropsByRadius, frozenset[str], str]] = []
    if training.examples != "views":
        by_path = {record.path: record.settled for record in simulated.records}
        examples += [(by_path[item.path], item.functions, item.path.name) for item in dataset.objects]
    if training.examples != "whole":
        examples += partial_examples(dataset, training, failed)
    settled, labels, names = ([example[column] for example in examples] for column in range(3))
    return new_classifier(training, training.method).fit_settled(settled, labels, names)


def partial_examples(
    dataset: Dataset, training: Training, failed: Callable[[InputError], None]
) -> Iterator[tuple[DropsByRadius, frozenset[str], str]]:
    """Yield settled centres, functions and name of what scans of rooms show of a data set's objects."""
    rooms = -(-len(dataset) // (TABLES + ON_FLOOR + ON_TOPS))
    for room in furnish(dataset, rooms, seed=training.seed + OTHER_ROOMS, failed=failed):
        scan = scan_room(room, VIEWS, NOISE, training.seed)
        for number, cloud in partial_views(scan, training.completion):
            if training.examples == "both-large" and cloud.size.max() < LARGE:
                continue
            item = room.objects[number].item
            settled = settle(cloud, training.simulator, training.radii, training.seed, training.length)
            yield settled, item.functions, f"{item.path.stem} in {room.name}"
