"""What is true of real scans, by boxes or points and how much was seen, and what was recognised in the same terms."""

from __future__ import annotations

import csv
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from spherefunc_bullet.datasets.dataset import parse_functions
from spherefunc_bullet.errors import InputError, explaining
from spherefunc_bullet.formats.sources import read_geometry
from spherefunc_bullet.scenes.recognition.recognition import Room, SceneObject
from spherefunc_bullet.scenes.scans.scan import Scan
from spherefunc_bullet.scenes.segmentation.clusters import Box

SEEN = ("full", "part")  # enough of an object's functional surface is in the scan: it is asked for
BACK_ONLY = "back-only"  # of a chair only the back shows: counted separately
HIDDEN = "none"  # outside the view: not asked for
VISIBLE = (*SEEN, BACK_ONLY, HIDDEN)
DISPUTED = "cup"  # the function that people dispute of bowls, open pots and what may be a cup
SUPPORT, SUPPORTS = "support", "table"  # what a surface is labelled that serves as ground, and what it is if claimed
UNCLEAR = frozenset({"cup", "sittable", "table"})  # of an object that its row calls unclear, all count neither way
_STEPS = 24  # per axis, of the places at which two boxes are compared


@dataclass(frozen=True, kw_only=True, eq=False)
class TrueObject:
    """An object that someone labelled: by a box in the scan's frame, or by its points."""

    name: str
    functions: frozenset[str]  # that it has by its label
    disputed: frozenset[str] = frozenset()  # functions that people would dispute: a claim counts neither way
    visible: str = "full"  # one of VISIBLE
    box: Box | None = None
    points: np.ndarray | None = None  # (N,) bool, of the scan's


@dataclass(frozen=True, kw_only=True, eq=False)
class RecognisedObject:
    """An object that was recognised, in the same terms."""

    functions: frozenset[str]
    box: Box
    points: np.ndarray  # (N,) bool


def true_objects(scan_file: Path) -> list[TrueObject] | None:
    """Return the objects of ``NAME_boxes.csv`` or ``NAME_instances.csv`` beside a scan NAME.ply; None without either.

    Raises
    ------
    InputError
        If such a table lacks a column or holds what is none of its values.
    """
    boxes, instances = (scan_file.with_name(f"{scan_file.stem}_{kind}.csv") for kind in ("boxes", "instances"))
    if instances.exists():
        labels = read_geometry(scan_file).labels
        return [from_points(row, labels, instances) for row in read_rows(instances)]
    return [from_box(row, boxes) for row in read_rows(boxes)] if boxes.exists() else None


def read_rows(path: Path) -> list[dict[str, str]]:
    """Return the rows of a table."""
    with open(path, newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def value_of(row: dict[str, str], column: str, path: Path) -> str:
    """Return what a row has in a column that its table must have."""
    value = row.get(column)
    if value is None:
        raise InputError(f"{path.name}: expected a column {column}, found {', '.join(filter(None, row))}")
    return value


def number_of(row: dict[str, str], column: str, path: Path) -> float:
    """Return the number that a row has in a column."""
    text = value_of(row, column, path)
    with explaining(f"{path.name}: expected a number in column {column}, got {text!r}", ValueError):
        return float(text)


def functions_of(row: dict[str, str], path: Path) -> frozenset[str]:
    """Return the functions that a row names."""
    label = value_of(row, "function_label", path)
    return frozenset() if label == SUPPORT else parse_functions(label.split(" ")[0])


def visible_of(row: dict[str, str], path: Path) -> str:
    """Return how much of a row's object the sensor saw: all, where the table does not say."""
    visible = row.get("visible") or "full"
    if visible not in VISIBLE:
        raise InputError(f"{path.name}: expected visible to be one of {', '.join(VISIBLE)}, got {visible!r}")
    return visible


def disputed_of(name: str, label: str, remark: str) -> frozenset[str]:
    """Return the functions that people would dispute an object to have, or not to have.

    A bowl is a drinking vessel to some, whatever its table calls it, and so is what a remark calls ambiguous or leaves
    out. The surface that serves as ground is a table to some. Of what is unclear nothing is certain.
    """
    if "unclear" in remark:
        return UNCLEAR
    if label == SUPPORT:
        return frozenset({SUPPORTS})
    is_vessel_to_some = name == "bowl" or "ambiguous" in remark or "left out of the count" in remark
    return frozenset({DISPUTED}) if is_vessel_to_some else frozenset()


def from_box(row: dict[str, str], path: Path) -> TrueObject:
    """Return the object of a row of boxes."""
    center, size = (np.array([number_of(row, f"{kind}{axis}", path) for axis in "xyz"]) for kind in "cd")
    true = object_without_place(row, "class", "comment", path)
    return replace(true, box=Box(center=center, size=size, yaw=number_of(row, "yaw_rad", path)))


def from_points(row: dict[str, str], labels: np.ndarray | None, path: Path) -> TrueObject:
    """Return the object of a row of instances, by the points that carry its label."""
    if labels is None:
        raise InputError(f"{path.name}: expected a scan with a label for each point, found none")
    true = object_without_place(row, "name", "pose", path)
    return replace(true, points=labels == int(number_of(row, "label", path)))


def object_without_place(row: dict[str, str], name: str, remark: str, path: Path) -> TrueObject:
    """Return the object of a row but its place, its name and a remark being in columns of these names."""
    called = value_of(row, name, path)
    disputed = disputed_of(called, value_of(row, "function_label", path), row.get(remark) or "")
    functions, visible = functions_of(row, path) - disputed, visible_of(row, path)
    return TrueObject(name=called, functions=functions, disputed=disputed, visible=visible)


def overlap(true: TrueObject, recognised: RecognisedObject) -> float:
    """Return intersection over union of the points where they are labelled, else of the boxes."""
    if true.points is not None:
        union = np.count_nonzero(true.points | recognised.points)
        return np.count_nonzero(true.points & recognised.points) / union if union else 0.0
    return box_overlap(true.box, recognised.box)


def box_overlap(a: Box, b: Box) -> float:
    """Return the intersection over union of two upright boxes, by a grid of places in the first.

    Examples
    --------
    >>> unit = Box(center=np.zeros(3), size=np.ones(3), yaw=0.0)
    >>> shifted = Box(center=np.array([0.5, 0.0, 0.0]), size=np.ones(3), yaw=np.pi / 2)
    >>> round(box_overlap(unit, shifted), 2)
    0.33
    """
    steps = (np.arange(_STEPS) + 0.5) / _STEPS - 0.5
    places = np.stack(np.meshgrid(steps, steps, steps, indexing="ij"), axis=-1).reshape(-1, 3) * a.size
    inside = (np.abs(b.to_own(places @ a.axes + a.center)) <= b.size / 2).all(axis=1)
    shared = inside.mean() * np.prod(a.size)
    return float(shared / (np.prod(a.size) + np.prod(b.size) - shared))


_LEVEL = np.cos(np.radians(10.0))  # a scan turned by more has its truth in tilted boxes: axis-aligned in its own frame


def recognised_in(scan: Scan, room: Room) -> list[RecognisedObject]:
    """Return the objects that the spheres found."""
    return [as_recognised(item, scan, room) for item in room.objects]


def inferred_in(scan: Scan, room: Room) -> list[RecognisedObject]:
    """Return the objects that nobody saw, of which there are boxes alone."""
    none = np.zeros(len(scan), bool)
    return [
        RecognisedObject(functions=frozenset({item.function}), box=room.box_in_scan(item.box), points=none)
        for item in room.inferred
    ]


def as_recognised(item: SceneObject, scan: Scan, room: Room) -> RecognisedObject:
    """Return one object with its points of the scan; where the scan is tilted, with their box."""
    inside = room.labels == item.id
    tilted = room.levelling.up[2] < _LEVEL and inside.any()
    return RecognisedObject(
        functions=item.members,
        box=aligned_box(scan.points[inside]) if tilted else room.box_in_scan(item.box),
        points=inside,
    )


def aligned_box(points: np.ndarray) -> Box:
    """Return the box around points (N, 3) along their frame's axes."""
    low, high = points.min(axis=0), points.max(axis=0)
    return Box(center=(low + high) / 2, size=high - low, yaw=0.0)
