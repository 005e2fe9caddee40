"""The model of the package for scans: fitted to the proposals in scans of virtual rooms, and to whole models.

``python -m spherefunc_bullet.compare.rooms.scan_model household --out MODEL`` makes it (``make scan-model``). With
``--join EARLIER`` the trees of an earlier model, which has learnt other rooms, vote together with those of the new one:
scanning rooms takes hours, so the earlier model is worth keeping.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import chain
from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from joblib import Parallel, delayed
from sklearn.ensemble import ExtraTreesClassifier

from spherefunc_bullet.clouds.cloud import load_cloud
from spherefunc_bullet.console import Failures, progress, run, say
from spherefunc_bullet.datasets.dataset import Dataset, open_dataset
from spherefunc_bullet.errors import InputError
from spherefunc_bullet.learning.function_classifier import FunctionClassifier
from spherefunc_bullet.learning.labels import memberships
from spherefunc_bullet.learning.model_file import load_model, save_model
from spherefunc_bullet.learning.profiles.calibration import Calibration, CopyGroups
from spherefunc_bullet.learning.profiles.forest import LEAF, Forest, SceneForests
from spherefunc_bullet.scenes.recognition.surroundings import NAMES
from spherefunc_bullet.scenes.virtual_rooms.lived_in import LivedIn, furnish_lived_in, parse_lived_in

from .training_examples import (
    SCAN_SETUPS,
    STEREO_SETUPS,
    ScanSetup,
    TrainingExample,
    balanced_rows,
    cached_examples,
    label_by_overlap,
    whole_model_example,
)
from .trials import shares

TIDY, LIVED_IN = LivedIn(), parse_lived_in("all=0.5")  # rooms of both kinds
TREES, LEAST = 100, 2  # trees of a forest, objects in a leaf: as accurate as one object, with a third of the nodes


@dataclass(frozen=True, kw_only=True)
class RoomSet:
    """Rooms of one data set and kind, scanned with several setups in turn."""

    dataset: Dataset
    lived_in: LivedIn
    setups: tuple[ScanSetup, ...]
    rooms: int
    seed: int


def room_sets(datasets: Sequence[Dataset], rooms: int, seed: int) -> list[RoomSet]:
    """Return sets of rooms, tidy and lived-in for each data set; the last four are scanned by stereo cameras."""
    kinds = [(dataset, lived_in, SCAN_SETUPS) for dataset in datasets for lived_in in (TIDY, LIVED_IN)]
    for place, lived_in in ((0, LIVED_IN), (-1, TIDY), (2, LIVED_IN), (3, TIDY)):
        kinds.append((datasets[place % len(datasets)], lived_in, STEREO_SETUPS))
    counts = shares(rooms, len(kinds))
    return [
        RoomSet(dataset=dataset, lived_in=lived_in, setups=setups, rooms=count, seed=seed + place)
        for place, ((dataset, lived_in, setups), count) in enumerate(zip(kinds, counts, strict=True))
    ]


def examples_of_set(
    room_set: RoomSet, place: int, model: FunctionClassifier, cache: Path | None
) -> tuple[list[TrainingExample], list[InputError]]:
    """Return the training examples of a set of rooms, whose index decides the first setup, and errors of its files."""
    examples, errors = [], []
    how = {"seed": room_set.seed, "failed": errors.append, "lived_in": room_set.lived_in}
    rooms = furnish_lived_in(room_set.dataset, room_set.rooms, **how)
    for turn, room in enumerate(rooms):
        setup = room_set.setups[(turn + place) % len(room_set.setups)]
        examples += label_by_overlap(cached_examples(room, setup, model, room_set.seed, cache))
    return examples, errors


def examples_of_sets(
    sets: Sequence[RoomSet], model: FunctionClassifier, cache: Path | None, jobs: int, failures: Failures
) -> Iterator[list[TrainingExample]]:
    """Yield the training examples of each set of rooms, in order."""
    tasks = (delayed(examples_of_set)(room_set, place, model, cache) for place, room_set in enumerate(sets))
    done = Parallel(n_jobs=jobs, return_as="generator")(tasks)
    for examples, errors in progress(done, len(sets), "scanning rooms"):
        for error in errors:
            failures.add(error)
        yield examples


def main(
    data: Annotated[list[str], typer.Argument(help="Meshes: folders with manifest.csv, or catalogues.")],
    out: Annotated[Path, typer.Option(help="The model file.")],
    backend: Annotated[str, typer.Option(help="The simulator.")] = "fast",
    rooms: Annotated[int, typer.Option(min=1, help="Number of virtual rooms that are scanned.")] = 32,
    seed: Annotated[int, typer.Option(min=0, help="Random seed of the rooms.")] = 1000,
    cache: Annotated[Path | None, typer.Option("--keep", help="Folder in which examples are cached.")] = None,
    earlier: Annotated[Path | None, typer.Option("--join", help="An earlier model, whose trees vote as well.")] = None,
    jobs: Annotated[int, typer.Option(help="Number of parallel processes; -1: one per core.")] = 1,
):
    """Train a model on the proposals in scans of virtual rooms, and on whole models of the first data set."""
    failures, datasets = Failures(), [open_dataset(name) for name in data]
    forest = ExtraTreesClassifier(TREES, min_samples_leaf=LEAST, random_state=0)
    model = FunctionClassifier(backend, early_drops=0, estimator=forest)  # all drops of a proposal are always read
    partner = None if earlier is None else load_model(earlier, backend)
    examples = [whole_model_example(item, load_cloud(item.path), model) for item in datasets[0].objects]
    sets = room_sets(datasets, rooms, seed)
    examples += chain.from_iterable(examples_of_sets(sets, model, cache, jobs, failures))
    fitted = learn(examples, model)
    save_model(fitted if partner is None else join(fitted, partner), out)
    say(f"{out}: trained on {len(examples)} examples, {sum(bool(each.functions) for each in examples)} with a function")
    failures.exit()


def learn(examples: Sequence[TrainingExample], model: FunctionClassifier) -> FunctionClassifier:
    """Return the model fitted to the examples; it keeps those with a function, and as many others, for comparison.

    For calibration all views of an object in all rooms are held out together.
    """
    functions = tuple(sorted(set().union(*(example.functions for example in examples))))
    members = memberships([example.functions for example in examples], functions)
    labelled = ~memberships([example.unlabelled for example in examples], functions)
    sources: dict[str, int] = {}
    groups = np.array([sources.setdefault(example.source or example.name, len(sources)) for example in examples])
    copy_groups = CopyGroups(weights=np.ones(len(examples)), groups=groups)
    profiles = model.profiles([example.settled for example in examples])
    model.fit_profiles(profiles, members, functions, [example.name for example in examples], copy_groups, labelled)
    model.fit_scene_forests(np.array([example.surroundings for example in examples]), NAMES, members, labelled)
    complete = np.flatnonzero(labelled.all(axis=1))
    return model.keep(complete[balanced_rows(members[complete].any(axis=1))])


def join(model: FunctionClassifier, earlier: FunctionClassifier) -> FunctionClassifier:
    """Add the trees of an earlier model to those of a model, which keeps its training objects and unsure ranges.

    Both have to be fitted to scans. Each tree has one vote, and the calibration is the mean of both, in log odds.

    Raises
    ------
    InputError
        If the two do not know the same functions, radii and surroundings, or the earlier one reads quantities that the
        model does not have.
    """
    check_compatible(model, earlier)
    names, scenes, others = model.quantity_names(), model.scene_forests_, earlier.scene_forests_
    columns = column_indices(earlier.quantity_names(), names)
    model.forests_ = joined_forests(model.forests_, earlier.forests_, columns)
    model.calibrations_ = mean_calibrations(model.calibrations_, earlier.calibrations_)
    columns = column_indices([*earlier.quantity_names(), *scenes.names], [*names, *scenes.names])
    model.scene_forests_ = SceneForests(
        names=scenes.names,
        forests=joined_forests(scenes.forests, others.forests, columns),
        calibrations=mean_calibrations(scenes.calibrations, others.calibrations),
    )
    return model


def check_compatible(model: FunctionClassifier, earlier: FunctionClassifier):
    """Raise InputError if the trees of two models cannot vote together."""
    for what in ("functions_", "radii", "drops"):
        own, other = getattr(model, what), getattr(earlier, what)
        if own != other:
            raise InputError(f"the earlier model: expected {what.rstrip('_')} {own}, as the new one has, got {other}")
    scenes = earlier.scene_forests_
    if scenes is None or scenes.names != model.scene_forests_.names:
        raise InputError("the earlier model: expected one that has learnt the same surroundings of objects in scans")
    unknown = sorted(set(earlier.quantities) - set(model.quantities))
    if unknown:
        raise InputError(f"the earlier model reads quantities that the new one lacks: {', '.join(unknown)}")


def column_indices(names: Sequence[str], columns: Sequence[str]) -> np.ndarray:
    """Return the index (N,) int16 of each name among the columns."""
    return np.array([columns.index(name) for name in names], np.int16)


def joined_forests(own: Sequence[Forest], earlier: Sequence[Forest], columns: np.ndarray) -> list[Forest]:
    """Return for each function one forest of the trees of both; ``columns`` (Q,) are of the earlier quantities."""
    return [joined(one, other, columns) for one, other in zip(own, earlier, strict=True)]


def joined(one: Forest, other: Forest, columns: np.ndarray) -> Forest:
    """Return one forest of the trees of two, the other one's reading their quantities from other columns (Q,)."""
    start, feature = np.int32(len(one.feature)), np.where(other.feature == LEAF, LEAF, columns[other.feature])
    moved = replace(other, feature=feature.astype(np.int16), roots=other.roots + start, below=other.below + start)
    return Forest(**{name: np.concatenate([values, getattr(moved, name)]) for name, values in one.arrays().items()})


def mean_calibrations(own: Sequence[Calibration], earlier: Sequence[Calibration]) -> list[Calibration]:
    """Return the mean calibration of each function."""
    return [tuple(pair) for pair in np.mean([own, earlier], axis=0).tolist()]


if __name__ == "__main__":
    run(lambda: typer.run(main))
