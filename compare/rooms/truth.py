"""What is known of real scans: boxes or points of their objects, and what those are for."""

from __future__ import annotations

import csv
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from spherefunc_bullet.datasets.dataset import parse_functions
from spherefunc_bullet.errors import InputError
from spherefunc_bullet.formats.reading import read_geometry
from spherefunc_bullet.scenes.segmentation.box import Box

_STEPS = 24  # per axis, of the places at which two boxes are compared


@dataclass(frozen=True, kw_only=True, eq=False)
class TrueObject:
    """An object that someone labelled: by a box in the scan's frame, by its points, or both."""

    name: str
    functions: frozenset[str]
    ambiguous: bool = False  # whose function people would dispute: neither missed nor wrong
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

    A scan that is a frame of a fused one, ``X_frame000.ply``, is described by ``X_fused_boxes.csv``.
    """
    stem = scan_file.stem
    boxes = scan_file.with_name(f"{stem}_boxes.csv")
    if not boxes.exists():
        boxes = scan_file.with_name(f"{stem.split('_frame')[0]}_fused_boxes.csv")
    instances = scan_file.with_name(f"{stem}_instances.csv")
    if instances.exists():
        labels = read_geometry(scan_file).labels
        return [from_points(row, labels, instances) for row in read_rows(instances)]
    return [from_box(row, boxes) for row in read_rows(boxes)] if boxes.exists() else None


def read_rows(path: Path) -> list[dict[str, str]]:
    """Return the rows of a table."""
    with open(path, newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def functions_of(row: dict[str, str], path: Path) -> frozenset[str]:
    """Return the functions that a row names."""
    try:
        label = row["function_label"]
    except KeyError as error:
        raise InputError(f"{path.name}: expected a column function_label, found none") from error
    return frozenset() if label == "support" else parse_functions(label.split(" ")[0])


def from_box(row: dict[str, str], path: Path) -> TrueObject:
    """Return the object of a row of boxes; those of VoteNet's label files are turned clockwise."""
    center, size = (np.array([float(row[f"{kind}{axis}"]) for axis in "xyz"]) for kind in "cd")
    comment = row.get("comment", "")
    yaw = float(row["yaw_rad"]) * (-1 if "votenet" in comment else 1)
    return TrueObject(
        name=row["class"],
        functions=functions_of(row, path),
        ambiguous="ambiguous" in comment,
        box=Box(center=center, size=size, yaw=yaw),
    )


def from_points(row: dict[str, str], labels: np.ndarray | None, path: Path) -> TrueObject:
    """Return the object of a row of instances, by the points that carry its label."""
    if labels is None:
        raise InputError(f"{path.name}: expected a scan with a label for each point, found none")
    return TrueObject(
        name=row["name"],
        functions=functions_of(row, path),
        ambiguous="ambiguous" in row.get("pose", ""),
        points=labels == int(row["label"]),
    )


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
