"""Virtual scans on disk: a labelled PLY and a table of its objects each, and the objects alone as a data set.

The convention is that of labelled real scans: ``label`` is 1 for the floor, 0 for walls and ceiling, and from 2 on the
number of an object in ``NAME_instances.csv``.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from spherefunc_bullet.datasets.catalogue import COLUMNS, write_manifest
from spherefunc_bullet.datasets.dataset import DatasetObject, label_text
from spherefunc_bullet.formats.files import write_bytes, write_csv
from spherefunc_bullet.formats.ply import ply_bytes

from .furnishing import FLOOR, WALL
from .scans import VirtualScan

FILE_LABELS = {"wall": 0, "floor": 1}
FIRST_OBJECT = 2
SHELL = {FLOOR: "floor", WALL: "wall"}  # what objects stand on or hang on that is no object
INSTANCES = ("label", "name", "function_label", "also", "category", "standing_on", "points", "seen")


@dataclass
class RoomFolder:
    """A folder that scans are written to, with a manifest of all their objects in its folder ``objects``."""

    directory: Path
    group: str  # the source that the manifest names
    rows: list[tuple[str, ...]] = field(default_factory=list)
    scans: list[str] = field(default_factory=list)

    def write(self, scan: VirtualScan, clouds: Iterable[np.ndarray]):
        """Write one scan, and a cloud for each of its seen objects.

        Parameters
        ----------
        clouds : iterable of (N, 3) float64, metres
            In the order of ``scan.seen()``.

        Raises
        ------
        InputError
            If the folder cannot be written.
        """
        name = scan.room.name
        write_labelled(self.directory / f"{name}.ply", scan.points, file_labels(scan.labels))
        write_csv(self.directory / f"{name}_instances.csv", INSTANCES, instance_rows(scan))
        for number, points in zip(scan.seen(), clouds, strict=True):
            item = scan.room.objects[number].item
            self.write_object(f"{name}_{number + FIRST_OBJECT:02d}_{item.path.stem}", item, points)
        self.scans.append(f"{name}.ply")

    def write_object(self, name: str, item: DatasetObject, points: np.ndarray):
        """Write what a scan holds of one object, for training on partial views."""
        write_labelled(self.directory / "objects" / f"{name}.ply", points)
        self.rows.append((f"{name}.ply", *described(item), self.group))

    def close(self) -> Path:
        """Write the manifest of the objects and return its path."""
        return write_manifest(self.directory / "objects", COLUMNS, self.rows)


def described(item: DatasetObject) -> tuple[str, str, str]:
    """Return an object's label, what else it is for, and its category, as manifests have them."""
    return label_text(item.functions), ";".join(sorted(item.also)), item.category


def file_labels(labels: np.ndarray) -> np.ndarray:
    """Return a scan's labels (N,) as files have them, uint8."""
    shell = np.where(labels == FLOOR, FILE_LABELS["floor"], FILE_LABELS["wall"])
    return np.where(labels >= 0, labels + FIRST_OBJECT, shell).astype(np.uint8)


def instance_rows(scan: VirtualScan) -> Iterator[tuple[str | int, ...]]:
    """Yield one row for each object of the room, seen or not."""
    counts = np.bincount(scan.labels[scan.labels >= 0], minlength=len(scan.room.objects))
    seen = set(scan.seen().tolist())
    for number, placed in enumerate(scan.room.objects):
        item = placed.item
        support = SHELL.get(placed.support, placed.support + FIRST_OBJECT)
        counted = (support, int(counts[number]), int(number in seen))
        yield (number + FIRST_OBJECT, item.path.stem, *described(item), *counted)


def write_labelled(path: Path, points: np.ndarray, labels: np.ndarray | None = None):
    """Write points (N, 3) in metres, and a label (N,) uint8 each where there are any, as binary PLY."""
    write_bytes(path, ply_bytes(points, "metres, z up", **({} if labels is None else {"label": labels})))
