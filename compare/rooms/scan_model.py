"""The model that ships for scans: learnt from what recognition proposes in virtual rooms, and from whole models.

``python -m spherefunc_bullet.compare.rooms.scan_model household --out MODEL`` makes it (``make scan-model``).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
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
from spherefunc_bullet.learning.model_file import save_model
from spherefunc_bullet.learning.profiles.calibration import CopyGroups
from spherefunc_bullet.scenes.recognition.surroundings import NAMES
from spherefunc_bullet.scenes.virtual_rooms.lived_in import LivedIn, furnish_lived_in, parse_lived_in

from .lessons import SIGHTS, STEREO_SIGHTS, Lesson, Sight, counted, examples_kept, kept_lessons, model_lesson
from .trials import shares

TIDY, LIVED_IN = LivedIn(), parse_lived_in("all=0.5")  # in turn
TREES, LEAST = 100, 2  # of a forest, and objects in a leaf: a third of the nodes that single ones take, as right


@dataclass(frozen=True, kw_only=True)
class Street:
    """Rooms of one kind, each seen in another way, in turn."""

    dataset: Dataset
    lived_in: LivedIn
    sights: tuple[Sight, ...]
    rooms: int
    seed: int


@dataclass(frozen=True, kw_only=True, eq=False)
class Taught:
    """What the rooms of a street teach, and the errors of files that could not be used."""

    lessons: list[Lesson]
    errors: list[InputError]


def streets_of(datasets: Sequence[Dataset], rooms: int, seed: int) -> list[Street]:
    """Return so many rooms by kind: of each data set tidy and lived-in ones; last, four that stereo cameras see."""
    ways = [(dataset, lived_in, SIGHTS) for dataset in datasets for lived_in in (TIDY, LIVED_IN)]
    for place, lived_in in ((0, LIVED_IN), (-1, TIDY), (2, LIVED_IN), (3, TIDY)):
        ways.append((datasets[place % len(datasets)], lived_in, STEREO_SIGHTS))
    counts = shares(rooms, len(ways))
    return [
        Street(dataset=dataset, lived_in=lived_in, sights=sights, rooms=count, seed=seed + place)
        for place, ((dataset, lived_in, sights), count) in enumerate(zip(ways, counts, strict=True))
    ]


def taught_in(street: Street, place: int, model: FunctionClassifier, kept: Path | None) -> Taught:
    """Return what the rooms of a street teach; each street begins with another way of seeing, by its place."""
    lessons, errors = [], []
    rooms = furnish_lived_in(
        street.dataset, street.rooms, seed=street.seed, failed=errors.append, lived_in=street.lived_in
    )
    for turn, room in enumerate(rooms):
        sight = street.sights[(turn + place) % len(street.sights)]
        lessons += counted(kept_lessons(room, sight, model, street.seed, kept))
    return Taught(lessons=lessons, errors=errors)


def taught_in_all(
    streets: Sequence[Street], model: FunctionClassifier, kept: Path | None, jobs: int
) -> Iterator[Taught]:
    """Yield what each street teaches, in their order, whoever is done first."""
    tasks = (delayed(taught_in)(street, place, model, kept) for place, street in enumerate(streets))
    yield from Parallel(n_jobs=jobs, return_as="generator")(tasks)


def main(
    data: Annotated[list[str], typer.Argument(help="Meshes: folders with manifest.csv, or catalogues.")],
    out: Annotated[Path, typer.Option(help="The model file.")],
    backend: Annotated[str, typer.Option(help="The simulator.")] = "fast",
    rooms: Annotated[int, typer.Option(min=1, help="Virtual rooms that are scanned.")] = 32,
    seed: Annotated[int, typer.Option(min=0, help="Another seed, other rooms.")] = 1000,
    kept: Annotated[Path | None, typer.Option("--keep", help="Folder for what rooms teach: scanned once.")] = None,
    jobs: Annotated[int, typer.Option(help="Rooms that are scanned at once; -1: one per core.")] = 1,
):
    """Learn what is proposed in scans of virtual rooms, and whole models of the first data set."""
    failures, datasets = Failures(), [open_dataset(name) for name in data]
    model = FunctionClassifier(backend, early_drops=0, estimator=forest())  # proposals are asked once, with all drops
    lessons = [model_lesson(item, load_cloud(item.path), model) for item in datasets[0].objects]
    streets = streets_of(datasets, rooms, seed)
    for taught in progress(taught_in_all(streets, model, kept, jobs), len(streets), "scanning rooms"):
        lessons += taught.lessons
        for error in taught.errors:
            failures.add(error)
    save_model(learn(lessons, model), out)
    say(f"{out}: learnt from {len(lessons)} objects, {sum(bool(one.functions) for one in lessons)} of them of use")
    failures.exit()


def forest() -> ExtraTreesClassifier:
    """Return the classifier of one function."""
    return ExtraTreesClassifier(TREES, min_samples_leaf=LEAST, random_state=0)


def learn(lessons: Sequence[Lesson], model: FunctionClassifier) -> FunctionClassifier:
    """Return the model after the lessons; it keeps those of use, and as many of what has no function.

    How sure it may be is measured by those who have not learnt the same object in another view or another room.
    """
    functions = tuple(sorted(set().union(*(one.functions for one in lessons))))
    members = memberships([one.functions for one in lessons], functions)
    taught = ~memberships([one.unclear for one in lessons], functions)
    sources: dict[str, int] = {}
    groups = np.array([sources.setdefault(one.source or one.name, len(sources)) for one in lessons])
    copy_groups = CopyGroups(weights=np.ones(len(lessons)), groups=groups)
    profiles = model.profiles([one.record.settled for one in lessons])
    model.fit_profiles(profiles, members, functions, [one.name for one in lessons], copy_groups, taught)
    model.fit_scene_forests(np.array([one.beside for one in lessons]), NAMES, members, taught)
    clear = np.flatnonzero(taught.all(axis=1))
    return model.keep(clear[examples_kept(members[clear].any(axis=1))])


if __name__ == "__main__":
    run(lambda: typer.run(main))
