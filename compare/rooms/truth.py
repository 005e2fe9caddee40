"""The ground truth of real scans, by boxes or points and visibility, and recognised objects in the same terms."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from spherefunc_bullet.datasets.dataset import csv_table, parse_functions
from spherefunc_bullet.errors import InputError, explaining
from spherefunc_bullet.formats.sources import read_geometry
from spherefunc_bullet.scenes.recognition.recognition import Room
from spherefunc_bullet.scenes.scans.scan import Scan
from spherefunc_bullet.scenes.segmentation.clusters import Box

SEEN = ("full", "part")  # enough of an object's functional surface is in the scan, so it has to be found
BACK_ONLY = "back-only"  # only the back of a chair is visible: counted separately
HIDDEN = "none"  # outside the view: not counted
VISIBLE = (*SEEN, BACK_ONLY, HIDDEN)
DISPUTED = "cup"  # the function that people dispute for bowls, open pots and possible cups
SUPPORT, SUPPORTS = "support", "table"  # the label of a surface that serves as ground, and its disputed function
UNCLEAR = frozenset({"cup", "sittable", "table"})  # the disputed functions of an object that its row calls unclear
BOX = ("cx", "cy", "cz", "dx", "dy", "dz", "yaw_rad")  # columns: middle and sides, metres, and the heading
_STEPS = 24  # grid points per axis, at which two boxes are compared


@dataclass(frozen=True, kw_only=True, eq=False)
class TrueObject:
    """An object of the ground truth, given by a box in the scan's frame, or by its points."""

    name: str
    functions: frozenset[str]  # of its label
    disputed: frozenset[str] = frozenset()  # functions that people would dispute: a claim counts neither way
    visible: str = "full"  # one of VISIBLE
    box: Box | None = None
    points: np.ndarray | None = None  # (N,) bool, of the scan's


@dataclass(frozen=True, kw_only=True, eq=False)
class RecognisedObject:
    """A recognised object, in the same terms."""

    functions: frozenset[str]
    box: Box
    points: np.ndarray  # (N,) bool
    unsure: frozenset[str] = frozenset()  # functions of which it is unsure


def true_objects(scan_file: Path) -> list[TrueObject] | None:
    """Return the objects of ``NAME_boxes.csv`` or ``NAME_instances.csv`` next to a scan NAME.ply; None without either.

    Raises
    ------
    InputError
        If such a table lacks a column or holds an invalid value.
    """
    boxes, instances = (scan_file.with_name(f"{scan_file.stem}_{kind}.csv") for kind in ("boxes", "instances"))
    if instances.exists():
        labels = read_geometry(scan_file).labels
        rows = csv_table(instances, "label", "name", "function_label")
        return [from_points(row, labels, instances) for row in rows]
    if boxes.exists():
        return [from_box(row, boxes) for row in csv_table(boxes, "class", "function_label", *BOX)]
    return None


def number_of(row: dict[str, str], column: str, path: Path) -> float:
    """Return the number of a row in a column."""
    with explaining(f"{path.name}: expected a number in column {column}, got {row[column]!r}", ValueError, TypeError):
        return float(row[column])


def disputed_of(name: str, label: str, remark: str) -> frozenset[str]:
    """Return the functions about which people would disagree.

    Some take a bowl for a drinking vessel, whatever its table says, as well as objects that a remark calls ambiguous or
    leaves out. Some take the surface that serves as ground for a table. Of unclear objects all functions are disputed.
    """
    if "unclear" in remark:
        return UNCLEAR
    if label == SUPPORT:
        return frozenset({SUPPORTS})
    is_vessel_to_some = name == "bowl" or "ambiguous" in remark or "left out of the count" in remark
    return frozenset({DISPUTED}) if is_vessel_to_some else frozenset()


def from_box(row: dict[str, str], path: Path) -> TrueObject:
    """Return the object of a row of boxes."""
    *numbers, yaw = (number_of(row, column, path) for column in BOX)
    box = Box(center=np.array(numbers[:3]), size=np.array(numbers[3:]), yaw=yaw)
    return true_object(row, "class", "comment", path, box=box)


def from_points(row: dict[str, str], labels: np.ndarray | None, path: Path) -> TrueObject:
    """Return the object of a row of instances, by the points that carry its label."""
    if labels is None:
        raise InputError(f"{path.name}: expected a scan with a label for each point, found none")
    return true_object(row, "name", "pose", path, points=labels == int(number_of(row, "label", path)))


def true_object(row: dict[str, str], name: str, remark: str, path: Path, **place: Box | np.ndarray) -> TrueObject:
    """Return the object of a row at a box or with points; its name and a remark are in columns of these names."""
    called, label = row[name], row["function_label"] or ""
    disputed = disputed_of(called, label, row.get(remark) or "")
    functions = frozenset() if label == SUPPORT else parse_functions(label.split(" ")[0])
    visible = row.get("visible") or "full"
    if visible not in VISIBLE:
        raise InputError(f"{path.name}: expected visible to be one of {', '.join(VISIBLE)}, got {visible!r}")
    return TrueObject(name=called, functions=functions - disputed, disputed=disputed, visible=visible, **place)


def overlap(true: TrueObject, recognised: RecognisedObject) -> float:
    """Return the intersection over union of the points if they are labelled, else of the boxes."""
    if true.points is not None:
        union = np.count_nonzero(true.points | recognised.points)
        return np.count_nonzero(true.points & recognised.points) / union if union else 0.0
    return box_overlap(true.box, recognised.box)


def box_overlap(a: Box, b: Box) -> float:
    """Return the intersection over union of two upright boxes, by a grid of points in the first.

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


_LEVEL = np.cos(np.radians(10.0))  # the truth of a scan that is tilted more has boxes along the axes of its own frame


def recognised_in(scan: Scan, room: Room) -> list[RecognisedObject]:
    """Return the recognised objects with their points of the scan; the box of these points if the scan is tilted."""
    recognised = []
    for item in room.objects:
        inside = room.labels == item.id
        tilted = room.levelling.up[2] < _LEVEL and inside.any()
        box = aligned_box(scan.points[inside]) if tilted else room.box_in_scan(item.box)
        unsure = frozenset(room.unsure_functions(item))
        recognised.append(RecognisedObject(functions=item.members, box=box, points=inside, unsure=unsure))
    return recognised


def inferred_in(scan: Scan, room: Room) -> list[RecognisedObject]:
    """Return the objects that were inferred and not seen, with boxes alone."""
    none, pairs = np.zeros(len(scan), bool), [(frozenset({item.function}), item.box) for item in room.inferred]
    return [RecognisedObject(functions=name, box=room.box_in_scan(box), points=none) for name, box in pairs]


def aligned_box(points: np.ndarray) -> Box:
    """Return the box around points (N, 3) along their frame's axes."""
    low, high = points.min(axis=0), points.max(axis=0)
    return Box(center=(low + high) / 2, size=high - low, yaw=0.0)
