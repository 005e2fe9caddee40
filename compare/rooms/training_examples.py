"""Training examples from virtual rooms: each proposal of their scans, its drops, and the object that it overlaps.

Scanning a room takes many seconds, so examples are cached in files; fitting a classifier to them takes few.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable, Iterator
from dataclasses import asdict, dataclass, replace
from io import BytesIO
from itertools import chain
from pathlib import Path

import joblib
import numpy as np

from spherefunc_bullet.clouds.cloud import Cloud
from spherefunc_bullet.datasets.dataset import DatasetObject
from spherefunc_bullet.errors import explaining
from spherefunc_bullet.formats.files import write_bytes
from spherefunc_bullet.learning.function_classifier import FunctionClassifier
from spherefunc_bullet.scenes.recognition.examples import Example, proposed_examples
from spherefunc_bullet.scenes.recognition.surroundings import surroundings_alone
from spherefunc_bullet.scenes.segmentation.clusters import bounding_box
from spherefunc_bullet.scenes.virtual_rooms.furnishing import PlacedObject, VirtualRoom, transformed
from spherefunc_bullet.scenes.virtual_rooms.kinect import Kinect
from spherefunc_bullet.scenes.virtual_rooms.scans import Resolution, VirtualScan, close_ups, scan_room
from spherefunc_bullet.settling.cached_runs import settle_cached
from spherefunc_bullet.settling.drops import DropsByRadius
from spherefunc_bullet.settling.settling import settle
from spherefunc_bullet.simulator import make_simulator

_SPHERE_RADIUS = 0.01  # metres, of the spheres that show which surfaces of an object carry or hold
_NEAR = 0.04  # metres from the centre of such a sphere to a point of the scan that shows the surface
_OBJECT_OVERLAP, _PART_OVERLAP = 0.4, 0.25  # least overlap of a proposal that is an object, and that may be one
_VISIBLE_SHARE = 0.25  # least share of such places: the back of a chair alone, or the legs of a table, show no function


@dataclass(frozen=True, kw_only=True)
class ScanSetup:
    """How a room is scanned."""

    views: int | None  # number of views that are fused; None: all surfaces, as a CAD model has them
    noise: float  # of the views, as a multiple of the noise of a Kinect
    leaf: float | None = None  # metres: side of the voxels that a fused scan is thinned to
    window: int = 1  # pixels, see `Kinect`
    blur: float = 0.0  # pixels, see `Kinect`
    close: int = 4  # number of single views of one object each, from close up


# Used in turn: a robot that drives around, a single view, sparse and dense fusion, a CAD model.
SCAN_SETUPS = (
    ScanSetup(views=3, noise=1.0),
    ScanSetup(views=1, noise=0.5, window=7),
    ScanSetup(views=2, noise=1.0, leaf=0.03),
    ScanSetup(views=5, noise=1.0, leaf=0.01, window=7),
    ScanSetup(views=1, noise=1.5),
    ScanSetup(views=4, noise=0.5, leaf=0.02, window=7),
    ScanSetup(views=None, noise=1.0),
)
# Stereo cameras, whose filters half fill mugs.
STEREO_SETUPS = (
    ScanSetup(views=1, noise=0.5, window=5, blur=2.0, close=8),
    ScanSetup(views=1, noise=0.5, window=5, blur=3.0, close=8),
    ScanSetup(views=3, noise=0.5, window=5, blur=1.5, close=8),
    ScanSetup(views=1, noise=0.5, window=9, blur=5.0, close=8),
)


@dataclass(frozen=True, kw_only=True, eq=False)
class TrainingExample:
    """A training example: where spheres settled on it, and the object that it is, or is a part of."""

    name: str
    source: str  # name of the object that it overlaps most, the same in all rooms; empty for none
    functions: frozenset[str]  # of that object
    unlabelled: frozenset[str] = frozenset()  # functions of which it is neither a positive nor a negative example
    overlap: float = 1.0  # intersection over union of the two
    visible: float = 1.0  # share of the places where spheres rest on the object that the scan shows
    settled: DropsByRadius
    surroundings: np.ndarray  # (S,) quantities of its surroundings


def room_examples(room: VirtualRoom, setup: ScanSetup, model: FunctionClassifier, seed: int) -> list[TrainingExample]:
    """Return the training examples of a room: all proposals in its scans."""
    places_of = [resting_places(placed, model) for placed in room.objects]
    resolution, sensor = Resolution(leaf=setup.leaf, points=None), Kinect(window=setup.window, blur=setup.blur)
    of_room = [scan_room(room, setup.views, setup.noise, seed, resolution, sensor)]
    examples = []
    for view, scan in enumerate(chain(of_room, close_ups(room, setup.close, setup.noise, seed, sensor))):
        visible = [share_visible(scan, number, places) for number, places in enumerate(places_of)]
        for place, example in enumerate(proposed_examples(scan.points, scan.labels, model.simulator)):
            name = f"{room.name}_{view}_{example.by}_{place}"
            item = None if example.nearest < 0 else room.objects[example.nearest].item
            settled = settle(example.cloud, model.simulator, model.radii, model.seed, model.run_limit)
            examples.append(proposal_example(name, example, item, settled, visible[example.nearest]))
    return examples


def proposal_example(
    name: str, example: Example, item: DatasetObject | None, settled: DropsByRadius, visible: float
) -> TrainingExample:
    """Return the training example of a proposal, labelled by the object that it overlaps most, if any."""
    common = {"name": name, "settled": settled, "surroundings": example.surroundings}
    if item is None:
        return TrainingExample(source="", functions=frozenset(), overlap=0.0, visible=0.0, **common)
    source, overlap = source_object(item), example.overlap
    return TrainingExample(source=source, functions=item.functions, overlap=overlap, visible=visible, **common)


def source_object(item: DatasetObject) -> str:
    """Return the name of an object that is unique among several data sets."""
    return f"{item.path.parent.name}/{item.path.name}"


def whole_model_example(item: DatasetObject, cloud: Cloud, model: FunctionClassifier) -> TrainingExample:
    """Return the training example of a whole model."""
    settled = settle_cached(cloud, model.simulator, model.radii, model.seed, model.run_limit)
    around = surroundings_alone(cloud.points, bounding_box(cloud.points).size)
    about = {"name": item.path.name, "source": source_object(item), "functions": item.functions}
    return TrainingExample(**about, settled=settled, surroundings=around)


def resting_places(placed: PlacedObject, model: FunctionClassifier) -> np.ndarray:
    """Return the places (S, 3) where small spheres rest on an object of a room, metres, in the frame of the room."""
    settled = settle_cached(placed.cloud, model.simulator, model.radii, model.seed, model.run_limit)
    return transformed(settled[_SPHERE_RADIUS].rests.astype(float), placed.T_room_object)


def share_visible(scan: VirtualScan, number: int, places: np.ndarray) -> float:
    """Return the share of the places (S, 3) of spheres at rest on an object that its points in a scan show."""
    from scipy.spatial import cKDTree

    points = scan.points[scan.labels == number]
    if not len(points) or not len(places):
        return 0.0
    return float(np.isfinite(cKDTree(points).query(places, distance_upper_bound=_NEAR)[0]).mean())


def label_by_overlap(examples: Iterable[TrainingExample]) -> Iterator[TrainingExample]:
    """Yield examples with their final labels, by overlap with their object and by what the scan shows of it.

    A proposal that overlaps its object enough has its functions, if the scan shows enough of the surface that they
    need. With less overlap, or where the surface is hidden, these functions are not labelled. Small parts, and
    proposals that hold several objects, have no function.
    """
    for example in examples:
        if example.overlap < _PART_OVERLAP:
            yield replace(example, functions=frozenset())
        elif example.overlap >= _OBJECT_OVERLAP and example.visible >= _VISIBLE_SHARE:
            yield example
        else:
            yield replace(example, functions=frozenset(), unlabelled=example.functions)


def balanced_rows(members: np.ndarray) -> np.ndarray:
    """Return the rows (K,) of all examples that have a function (N,) bool, and of as many others, evenly spread."""
    others = np.flatnonzero(~members)
    step = max(1.0, len(others) / max(members.sum(), 1))
    return np.sort(np.append(np.flatnonzero(members), others[np.arange(0, len(others), step).astype(int)]))


FORMAT = 9  # of the files; with another number rooms are scanned again


def cached_examples(
    room: VirtualRoom, setup: ScanSetup, model: FunctionClassifier, seed: int, folder: Path | None
) -> list[TrainingExample]:
    """Return the training examples of a room, read from a folder if it has them, else computed and written there.

    Raises
    ------
    InputError
        If the folder cannot be written, or holds a file of that name that cannot be read.
    """
    if folder is None:
        return room_examples(room, setup, model, seed)
    path = folder / f"{room_hash(room, setup, model, seed)}.joblib"
    if not path.is_file():
        memory = BytesIO()
        joblib.dump(room_examples(room, setup, model, seed), memory, compress=3)
        write_bytes(path, memory.getvalue())
    expected = "expected training examples of a room, as scan_model writes them"
    with explaining(f"{path}: {expected}; cannot be read", Exception):
        return joblib.load(path)


def room_hash(room: VirtualRoom, setup: ScanSetup, model: FunctionClassifier, seed: int) -> str:
    """Return the hash that names a room's file: of everything that decides its examples, except the code."""
    simulator = make_simulator(model.simulator)
    how = [simulator.name, simulator.version, simulator.options(), model.radii, model.drops, model.seed]
    digest = hashlib.sha256(json.dumps([FORMAT, room.name, asdict(setup), seed, how], default=str).encode())
    for placed in room.objects:
        digest.update(placed.item.path.name.encode() + placed.points.tobytes())
    return digest.hexdigest()[:24]
