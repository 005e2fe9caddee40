"""The model that ships for scans: learnt from what recognition proposes in virtual rooms, and from whole models.

``python -m spherefunc_bullet.compare.rooms.scan_model household --out MODEL`` makes it (``make scan-model``).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import typer

from spherefunc_bullet.clouds.cloud import load_cloud
from spherefunc_bullet.console import Failures, progress, run, say
from spherefunc_bullet.datasets.dataset import Dataset, open_dataset
from spherefunc_bullet.errors import InputError
from spherefunc_bullet.learning.function_classifier import FunctionClassifier
from spherefunc_bullet.learning.model_file import save_model
from spherefunc_bullet.scenes.recognition.examples import proposed_examples
from spherefunc_bullet.scenes.virtual_rooms.close_ups import close_ups
from spherefunc_bullet.scenes.virtual_rooms.furnishing import VirtualRoom
from spherefunc_bullet.scenes.virtual_rooms.lived_in import furnish_lived_in, parse_lived_in
from spherefunc_bullet.scenes.virtual_rooms.scans import Resolution, VirtualScan, scan_room
from spherefunc_bullet.settling.records import settle_kept
from spherefunc_bullet.settling.settling import Settled, settle

LIVED_IN = "all=0.5"  # of the rooms, for each kind of disorder


@dataclass(frozen=True, kw_only=True)
class Sight:
    """How one room is seen."""

    views: int  # that are fused
    noise: float  # times a Kinect's
    leaf: float | None = None  # metres: side of the voxels that a fused scan is thinned to
    close: int = 4  # single views of one thing each, from near by


# In turn: as a robot that drives around sees a room, as one picture does, as sparse and as dense fusion have it.
SIGHTS = (
    Sight(views=3, noise=1.0),
    Sight(views=1, noise=0.5),
    Sight(views=2, noise=1.0, leaf=0.03),
    Sight(views=5, noise=1.0, leaf=0.01),
    Sight(views=1, noise=1.5),
    Sight(views=4, noise=0.5, leaf=0.02),
)


@dataclass(frozen=True, kw_only=True, eq=False)
class Lesson:
    """One training object: where spheres settled on it, and what it is for."""

    name: str
    functions: frozenset[str]
    settled: Settled


def scans_of(room: VirtualRoom, number: int, seed: int) -> Iterator[VirtualScan]:
    """Yield the scans of a room of a number: one of the whole, and those of things from near by."""
    sight = SIGHTS[number % len(SIGHTS)]
    yield scan_room(room, sight.views, sight.noise, seed, Resolution(leaf=sight.leaf, points=None))
    yield from close_ups(room, sight.close, sight.noise, seed)


def lessons_of_rooms(
    dataset: Dataset, count: int, model: FunctionClassifier, seed: int, failed: Callable[[InputError], None]
) -> Iterator[list[Lesson]]:
    """Yield what each room teaches: what is proposed in its scans, and what that is for."""
    rooms = furnish_lived_in(dataset, count, seed=seed, failed=failed, lived_in=parse_lived_in(LIVED_IN))
    for number, room in enumerate(rooms):
        functions = [placed.item.functions for placed in room.objects]
        lessons = []
        for view, scan in enumerate(scans_of(room, number, seed)):
            for place, example in enumerate(proposed_examples(scan.points, scan.labels, model.simulator)):
                settled = settle(example.cloud, model.simulator, model.radii, model.seed, model.length)
                told = frozenset() if example.number is None else functions[example.number]
                name = f"{room.name}_{view}_{example.by}_{place}"
                lessons.append(Lesson(name=name, functions=told, settled=settled))
        yield lessons


def lessons_of_models(dataset: Dataset, model: FunctionClassifier) -> Iterator[Lesson]:
    """Yield what whole models teach."""
    for item in dataset.objects:
        settled = settle_kept(load_cloud(item.path), model.simulator, model.radii, model.seed, model.length)
        yield Lesson(name=item.path.name, functions=item.functions, settled=settled)


def learn(lessons: list[Lesson], model: FunctionClassifier) -> FunctionClassifier:
    """Return the model after the lessons."""
    return model.fit_settled(
        [one.settled for one in lessons], [one.functions for one in lessons], [one.name for one in lessons]
    )


def main(
    data: Annotated[str, typer.Argument(help="Meshes: a folder with manifest.csv, or a catalogue.")],
    out: Annotated[Path, typer.Option(help="The model file.")],
    backend: Annotated[str, typer.Option(help="The simulator.")] = "fast",
    rooms: Annotated[int, typer.Option(min=1, help="Virtual rooms that are scanned.")] = 32,
    seed: Annotated[int, typer.Option(min=0, help="Another seed, other rooms.")] = 1000,
):
    """Learn what is proposed in scans of virtual rooms, and whole models."""
    failures, dataset = Failures(), open_dataset(data)
    model = FunctionClassifier(backend, early_drops=0)  # what is proposed is asked once, for all that can be known
    lessons = list(lessons_of_models(dataset, model))
    for more in progress(lessons_of_rooms(dataset, rooms, model, seed, failures.add), rooms, "scanning rooms"):
        lessons += more
    save_model(learn(lessons, model), out)
    say(f"{out}: learnt from {len(lessons)} objects, {sum(bool(one.functions) for one in lessons)} of them of use")
    failures.exit()


if __name__ == "__main__":
    run(lambda: typer.run(main))
