"""What virtual rooms teach: every proposal of their scans, how spheres fell on it, and which object it overlaps.

Rooms take many seconds to scan, and a classifier that learns of them few.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable, Iterator
from dataclasses import asdict, dataclass, replace
from functools import partial
from io import BytesIO
from pathlib import Path

import joblib
import numpy as np

from spherefunc_bullet.clouds.cloud import Cloud
from spherefunc_bullet.datasets.dataset import DatasetObject
from spherefunc_bullet.errors import explaining
from spherefunc_bullet.formats.files import write_whole, writing
from spherefunc_bullet.learning.function_classifier import FunctionClassifier
from spherefunc_bullet.scenes.recognition.examples import Example, proposed_examples
from spherefunc_bullet.scenes.recognition.surroundings import alone
from spherefunc_bullet.scenes.segmentation.clusters import bounding_box
from spherefunc_bullet.scenes.virtual_rooms.furnishing import PlacedObject, VirtualRoom, transformed
from spherefunc_bullet.scenes.virtual_rooms.kinect import Kinect
from spherefunc_bullet.scenes.virtual_rooms.scans import Resolution, VirtualScan, close_ups, scan_room
from spherefunc_bullet.settling.dropping import settle_cached
from spherefunc_bullet.settling.drops import DropsByRadius
from spherefunc_bullet.settling.records import ObjectRecord, shape_of
from spherefunc_bullet.settling.settling import settle
from spherefunc_bullet.simulator import make_simulator

_CARRIED = 0.01  # metres, radius of the spheres that tell what of an object carries or holds
_NEAR = 0.04  # metres from such a sphere's centre to a point of the scan that shows its place
_OBJECT, _PART = 0.4, 0.25  # overlaps from which on a proposal is an object, and is not clearly none
_SHOWN = 0.25  # least share of such places: a chair's back alone, or a table's legs, tell no function


@dataclass(frozen=True, kw_only=True)
class Sight:
    """How one room is seen."""

    views: int  # that are fused
    noise: float  # times a Kinect's
    leaf: float | None = None  # metres: side of the voxels that a fused scan is thinned to
    window: int = 1  # pixels, see `Kinect`
    blur: float = 0.0  # pixels, see `Kinect`
    close: int = 4  # single views of one object each, from near by


# In turn: as a robot that drives around sees a room, as one picture does, as sparse and as dense fusion have it.
SIGHTS = (
    Sight(views=3, noise=1.0),
    Sight(views=1, noise=0.5, window=7),
    Sight(views=2, noise=1.0, leaf=0.03),
    Sight(views=5, noise=1.0, leaf=0.01, window=7),
    Sight(views=1, noise=1.5),
    Sight(views=4, noise=0.5, leaf=0.02, window=7),
)
# As a stereo camera sees objects, whose filters half fill mugs.
STEREO_SIGHTS = (
    Sight(views=1, noise=0.5, window=5, blur=2.0, close=8),
    Sight(views=1, noise=0.5, window=5, blur=3.0, close=8),
    Sight(views=3, noise=0.5, window=5, blur=1.5, close=8),
    Sight(views=1, noise=0.5, window=9, blur=5.0, close=8),
)


@dataclass(frozen=True, kw_only=True, eq=False)
class Lesson:
    """One training object: where spheres settled on it, and the object that it is, or is a part of."""

    name: str
    source: str  # name of the object that it overlaps most, the same wherever that stands; empty for none
    functions: frozenset[str]  # of that object
    unclear: frozenset[str] = frozenset()  # functions that it is an example of neither way
    overlap: float = 1.0  # intersection over union of the two
    shown: float = 1.0  # share of the places where spheres rest on the object that the scan shows
    record: ObjectRecord
    beside: np.ndarray  # (S,) what surrounds it


def scans_of(room: VirtualRoom, sight: Sight, seed: int) -> Iterator[VirtualScan]:
    """Yield the scans of a room: one of the whole, and those of objects from near by."""
    resolution, sensor = Resolution(leaf=sight.leaf, points=None), Kinect(window=sight.window, blur=sight.blur)
    yield scan_room(room, sight.views, sight.noise, seed, resolution, sensor)
    yield from close_ups(room, sight.close, sight.noise, seed, sensor)


def room_lessons(room: VirtualRoom, sight: Sight, model: FunctionClassifier, seed: int) -> list[Lesson]:
    """Return what a room teaches: all that is proposed in its scans."""
    carried = [resting_places(placed, model) for placed in room.objects]
    lessons = []
    for view, scan in enumerate(scans_of(room, sight, seed)):
        shown = [share_shown(scan, number, places) for number, places in enumerate(carried)]
        for place, example in enumerate(proposed_examples(scan.points, scan.labels, model.simulator)):
            name = f"{room.name}_{view}_{example.by}_{place}"
            item = None if example.nearest < 0 else room.objects[example.nearest].item
            settled = settle(example.cloud, model.simulator, model.radii, model.seed, model.length)
            record = record_of(Path(name), shape_of(example.cloud), settled)
            lessons.append(lesson_of(name, example, item, record, shown[example.nearest]))
    return lessons


def lesson_of(name: str, example: Example, item: DatasetObject | None, record: ObjectRecord, shown: float) -> Lesson:
    """Return what a proposal teaches, and the object that it overlaps most, if it overlaps one."""
    own = {"name": name, "record": record, "beside": example.beside}
    if item is None:
        return Lesson(source="", functions=frozenset(), overlap=0.0, shown=0.0, **own)
    return Lesson(source=source_object(item), functions=item.functions, overlap=example.overlap, shown=shown, **own)


def source_object(item: DatasetObject) -> str:
    """Return what an object of one of several data sets is called."""
    return f"{item.path.parent.name}/{item.path.name}"


def record_of(path: Path, shape: dict[str, np.ndarray], settled: DropsByRadius) -> ObjectRecord:
    """Return what is kept of an object of a shape, see `shape_of`, on which spheres have fallen, or none have."""
    return ObjectRecord(path=path, size=shape["size"], occupied=partial(shape.get, "voxels"), settled=settled)


def model_lesson(item: DatasetObject, cloud: Cloud, model: FunctionClassifier) -> Lesson:
    """Return what a whole model teaches."""
    settled = settle_cached(cloud, model.simulator, model.radii, model.seed, model.length)
    name, source = item.path.name, source_object(item)
    beside = alone(cloud.points, bounding_box(cloud.points).size)
    record = record_of(Path(name), shape_of(cloud), settled)
    return Lesson(name=name, source=source, functions=item.functions, record=record, beside=beside)


def resting_places(placed: PlacedObject, model: FunctionClassifier) -> np.ndarray:
    """Return the places (S, 3) where small spheres rest on an object of a room, metres, the room's frame."""
    settled = settle_cached(placed.cloud, model.simulator, model.radii, model.seed, model.length)
    return transformed(settled[_CARRIED].rests.astype(float), placed.T_room_object)


def share_shown(scan: VirtualScan, number: int, places: np.ndarray) -> float:
    """Return the share of the places (S, 3) where spheres rest on an object that its points in a scan show."""
    from scipy.spatial import cKDTree

    own = scan.points[scan.labels == number]
    if not len(own) or not len(places):
        return 0.0
    return float(np.isfinite(cKDTree(own).query(places, distance_upper_bound=_NEAR)[0]).mean())


def counted(lessons: Iterable[Lesson]) -> Iterator[Lesson]:
    """Yield lessons as examples: of which functions, of which neither way, and of all others' lack.

    What overlaps its object enough has its functions, if the scan shows enough of the surface that they need. Below
    that, or where the surface is hidden, nobody can say whether it has them; small parts and what holds several objects
    have none. Of functions that its object has not, a proposal is never one.
    """
    for one in lessons:
        if one.overlap < _PART:
            yield replace(one, functions=frozenset())
        elif one.overlap >= _OBJECT and one.shown >= _SHOWN:
            yield one
        else:
            yield replace(one, functions=frozenset(), unclear=one.functions)


def examples_kept(useful: np.ndarray) -> np.ndarray:
    """Return the lessons (K,) to keep as examples: the useful ones, and as many others, evenly spread."""
    others = np.flatnonzero(~useful)
    step = max(1.0, len(others) / max(useful.sum(), 1))
    return np.sort(np.append(np.flatnonzero(useful), others[np.arange(0, len(others), step).astype(int)]))


FORMAT = 6  # of the files; another number, scanned anew


def kept_lessons(
    room: VirtualRoom, sight: Sight, model: FunctionClassifier, seed: int, folder: Path | None
) -> list[Lesson]:
    """Return what a room teaches, from a folder where it has it; else that is computed, and kept there.

    Raises
    ------
    InputError
        If the folder cannot be written, or holds a file of that name that cannot be read.
    """
    if folder is None:
        return room_lessons(room, sight, model, seed)
    path = folder / f"{room_hash(room, sight, model, seed)}.joblib"
    if not path.is_file():
        memory = BytesIO()
        joblib.dump(room_lessons(room, sight, model, seed), memory, compress=3)
        with writing(path):
            write_whole(path, memory.getvalue())
    with explaining(f"{path}: expected lessons of a room, as scan_model keeps them; cannot be read", Exception):
        return joblib.load(path)


def room_hash(room: VirtualRoom, sight: Sight, model: FunctionClassifier, seed: int) -> str:
    """Return the name of a room's lessons: the hash of all that decides them but the code that scans."""
    simulator = make_simulator(model.simulator)
    how = [simulator.name, simulator.version, simulator.options(), model.radii, model.drops, model.seed]
    digest = hashlib.sha256(json.dumps([FORMAT, room.name, asdict(sight), seed, how], default=str).encode())
    for placed in room.objects:
        digest.update(placed.item.path.name.encode() + placed.points.tobytes())
    return digest.hexdigest()[:24]
