"""The model that ships for scans: learnt from what recognition proposes in virtual rooms, and from whole models.

``python -m spherefunc_bullet.compare.rooms.scan_model household --out MODEL`` makes it (``make scan-model``).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import numpy as np
import typer

from spherefunc_bullet.clouds.cloud import load_cloud
from spherefunc_bullet.console import Failures, progress, run, say
from spherefunc_bullet.datasets.dataset import Dataset, open_dataset
from spherefunc_bullet.errors import InputError
from spherefunc_bullet.learning.function_classifier import FunctionClassifier
from spherefunc_bullet.learning.model_file import save_model
from spherefunc_bullet.learning.profiles.calibration import Kin
from spherefunc_bullet.scenes.virtual_rooms.furnishing import VirtualRoom
from spherefunc_bullet.scenes.virtual_rooms.lived_in import LivedIn, furnish_lived_in, parse_lived_in

from .lesson_files import kept_lessons
from .lessons import SIGHTS, Lesson, Sight, counted, model_lesson

TIDY, LIVED_IN = LivedIn(), parse_lived_in("all=0.5")  # in turn


@dataclass(frozen=True, kw_only=True, eq=False)
class Visit:
    """A room, how it is seen, and the seed of its scans."""

    room: VirtualRoom
    sight: Sight
    seed: int


def visits(
    datasets: Sequence[Dataset], count: int, seed: int, failed: Callable[[InputError], None]
) -> Iterator[Visit]:
    """Yield so many rooms, of each data set tidy and lived-in ones by turns; each kind is seen in every way in turn.

    Fewer rooms are the first ones of more.
    """
    kinds = [(dataset, lived_in) for dataset in datasets for lived_in in (TIDY, LIVED_IN)]
    streets = [
        furnish_lived_in(dataset, count, seed=seed + place, failed=failed, lived_in=lived_in)
        for place, (dataset, lived_in) in enumerate(kinds)
    ]
    for number in range(count):
        turn, place = divmod(number, len(streets))
        yield Visit(room=next(streets[place]), sight=SIGHTS[(turn + place) % len(SIGHTS)], seed=seed + place)


def lessons_of_rooms(
    visited: Iterable[Visit], model: FunctionClassifier, kept: Path | None, jobs: int
) -> Iterator[list[Lesson]]:
    """Yield what each room teaches, in the order of the rooms."""
    from joblib import Parallel, delayed

    tasks = (delayed(kept_lessons)(visit.room, visit.sight, model, visit.seed, kept) for visit in visited)
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
    """Learn what is proposed in scans of virtual rooms, and whole models."""
    failures, datasets = Failures(), [open_dataset(name) for name in data]
    model = FunctionClassifier(backend, early_drops=0)  # what is proposed is asked once, for all that can be known
    lessons = [model_lesson(item, load_cloud(item.path), model) for item in datasets[0].objects]
    found = lessons_of_rooms(visits(datasets, rooms, seed, failures.add), model, kept, jobs)
    for more in progress(found, rooms, "scanning rooms"):
        lessons += counted(more)
    save_model(learn(lessons, model), out)
    say(f"{out}: learnt from {len(lessons)} objects, {sum(bool(one.functions) for one in lessons)} of them of use")
    failures.exit()


def learn(lessons: Sequence[Lesson], model: FunctionClassifier) -> FunctionClassifier:
    """Return the model after the lessons.

    How sure it may be is told by those who have not learnt the same thing in another view or another room.
    """
    things: dict[str, int] = {}
    groups = np.array([things.setdefault(one.thing or one.name, len(things)) for one in lessons])
    return model.fit_settled(
        [one.record.settled for one in lessons],
        [one.functions for one in lessons],
        [one.name for one in lessons],
        kin=Kin(weights=np.ones(len(lessons)), groups=groups),
    )


if __name__ == "__main__":
    run(lambda: typer.run(main))
