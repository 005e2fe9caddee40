"""Virtual scans on disk: for each a labelled PLY and a table of its objects, and all objects alone as a data set.

Labels are those of labelled real scans: ``label`` is 1 for the floor, 0 for walls and ceiling, and from 2 on the number
of an object in ``NAME_instances.csv``.
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

FIRST_OBJECT = 2
SHELL = {FLOOR: "floor", WALL: "wall"}  # what carries objects without being one
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
        labels = np.where(scan.labels >= 0, scan.labels + FIRST_OBJECT, scan.labels == FLOOR).astype(np.uint8)
        write_bytes(self.directory / f"{name}.ply", ply_bytes(scan.points, "metres, z up", label=labels))
        write_csv(self.directory / f"{name}_instances.csv", INSTANCES, instance_rows(scan))
        for number, points in zip(scan.seen(), clouds, strict=True):
            item = scan.room.objects[number].item
            file = f"{name}_{number + FIRST_OBJECT:02d}_{item.path.stem}.ply"
            write_bytes(self.directory / "objects" / file, ply_bytes(points, "metres, z up"))
            self.rows.append((file, *described(item), self.group))
        self.scans.append(f"{name}.ply")

    def close(self) -> Path:
        """Write the manifest of the objects and return its path."""
        return write_manifest(self.directory / "objects", COLUMNS, self.rows)


def described(item: DatasetObject) -> tuple[str, str, str]:
    """Return an object's label, the other functions that are true of it, and its category, as in manifests."""
    return label_text(item.functions), ";".join(sorted(item.also)), item.category


def instance_rows(scan: VirtualScan) -> Iterator[tuple[str | int, ...]]:
    """Yield one row for each object of the room, seen or not."""
    counts = np.bincount(scan.labels[scan.labels >= 0], minlength=len(scan.room.objects))
    seen = set(scan.seen().tolist())
    for number, placed in enumerate(scan.room.objects):
        item = placed.item
        support = SHELL.get(placed.support, placed.support + FIRST_OBJECT)
        counted = (support, int(counts[number]), int(number in seen))
        yield (number + FIRST_OBJECT, item.path.stem, *described(item), *counted)
