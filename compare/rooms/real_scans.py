"""Real scans with known objects: how many of the functional ones are found, and how much of what is found is true.

``python -m spherefunc_bullet.compare.rooms.real_scans DATA`` prints it, for every scan of a folder.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, TypedDict

import numpy as np
import typer

from spherefunc_bullet.console import Failures, print_json, print_table, run, say
from spherefunc_bullet.errors import InputError
from spherefunc_bullet.formats.writing import writing
from spherefunc_bullet.scenes.recognition.completion import steps_of
from spherefunc_bullet.scenes.recognition.recognition import Room, compile_kernels, recognise
from spherefunc_bullet.scenes.scans.scan import Scan, load_scan
from spherefunc_bullet.scenes.segmentation.segmentation import Segmentation

from .scores import ratio, rounded
from .truth import RecognisedObject, TrueObject, overlap, read_rows, true_objects

LEAST_OF_POINTS = 0.5  # intersection over union at which an object counts as found, where points are labelled
RESTRICTED = ("research", "non-commercial", "no licence", "unknown")  # words of licences that forbid publishing
LEAST_OF_BOXES = 0.25  # where boxes are: VoteNet's and SUN RGB-D's, since a scan sees only part of a box


@dataclass(frozen=True, kw_only=True)
class Tally:
    """Functions of objects: found, missed, and claimed of what has none."""

    found: tuple[str, ...] = ()
    missed: tuple[str, ...] = ()
    wrong: tuple[str, ...] = ()

    @property
    def recall(self) -> float | None:
        """Of the functions that there are, the share found; None where there are none."""
        return rounded(ratio(len(self.found), len(self.found + self.missed)), 3)

    @property
    def precision(self) -> float | None:
        """Of the functions claimed, the share that is true; None where none is claimed."""
        return rounded(ratio(len(self.found), len(self.found + self.wrong)), 3)

    def __add__(self, other: Tally) -> Tally:
        return Tally(found=self.found + other.found, missed=self.missed + other.missed, wrong=self.wrong + other.wrong)


class ScanRow(TypedDict, total=False):
    """What was recognised in one scan, as JSON has it, and how that compares with what is known, if anything is."""

    scan: str
    points: int
    up_from: str
    objects: int
    functional: list[str]
    seconds: float
    stages: dict[str, float]  # seconds
    found: Sequence[str]
    missed: Sequence[str]
    wrong: Sequence[str]
    recall: float | None
    precision: float | None


def sufficient_overlap(true: TrueObject, recognised: RecognisedObject) -> float:
    """Return how well two objects overlap, 0 where it is too little to be the same."""
    least = LEAST_OF_BOXES if true.points is None else LEAST_OF_POINTS
    shared = overlap(true, recognised)
    return shared if shared >= least else 0.0


def tally(truth: Sequence[TrueObject], recognised: Sequence[RecognisedObject]) -> Tally:
    """Compare each function of each object: the largest overlaps are matched first, each object once.

    What is disputed (`TrueObject.ambiguous`) is neither missed nor wrong.
    """
    counted = Tally()
    for name in sorted({name for item in [*truth, *recognised] for name in item.functions}):
        wanted = [item for item in truth if name in item.functions]
        claimed = [item for item in recognised if name in item.functions]
        overlaps = [[sufficient_overlap(true, claim) for claim in claimed] for true in wanted]
        pairs = best_pairs(np.array(overlaps).reshape(len(wanted), len(claimed)))
        counted += Tally(
            found=tuple(wanted[t].name for t in pairs if not wanted[t].ambiguous),
            missed=tuple(true.name for t, true in enumerate(wanted) if t not in pairs and not true.ambiguous),
            wrong=(name,) * (len(claimed) - len(pairs)),
        )
    return counted


def best_pairs(shared: np.ndarray) -> dict[int, int]:
    """Return pairs of row and column of the largest overlaps (T, F), none twice; 0 does not pair."""
    pairs: dict[int, int] = {}
    for flat in np.argsort(-shared, axis=None, kind="stable"):
        t, f = divmod(int(flat), shared.shape[1])
        if shared[t, f] > 0 and t not in pairs and f not in pairs.values():
            pairs[t] = f
    return pairs


def recognised_objects(room: Room) -> list[RecognisedObject]:
    """Return the objects of a room in the scan's frame."""
    return [
        RecognisedObject(
            functions=item.members, box=room.box_in_scan(item.box), points=room.labels == item.id
        )
        for item in room.objects
    ]


def some_points(scan: Scan, count: int | None) -> Scan:
    """Return a scan with at most so many of its points, the truth then being that of boxes only."""
    if count is None or count >= len(scan):
        return scan
    chosen = np.sort(np.random.default_rng(0).permutation(len(scan))[:count])
    colors = None if scan.colors is None else scan.colors[chosen]
    return replace(scan, points=scan.points[chosen], colors=colors)


def may_be_shown(path: Path) -> bool:
    """Return whether a scan's licence, in the manifest beside it, allows a picture of it to be published."""
    manifest = path.with_name("manifest.csv")
    licences = {row["file"]: row["license"] for row in read_rows(manifest)} if manifest.exists() else {}
    licence = licences.get(path.name, "")
    return bool(licence) and not any(word in licence.lower() for word in RESTRICTED)


def write_picture(scan: Scan, room: Room, path: Path):
    """Write a small picture of a room, of few colours, as documents take it."""
    from spherefunc_bullet.scenes.report.picture import room_picture

    with writing(path):
        path.parent.mkdir(parents=True, exist_ok=True)
        room_picture(scan, room, size=(560, 420)).quantize(96).save(path, optimize=True)


def scan_row(path: Path, scan: Scan, room: Room, seconds: float) -> ScanRow:
    """Return what was recognised in one scan, and how that compares with what is known."""
    truth, recognised = true_objects(path), recognised_objects(room)
    row: ScanRow = {
        "scan": path.name,
        "points": len(scan),
        "up_from": room.levelling.source,
        "objects": len(room.objects),
        "functional": sorted(name for item in recognised for name in item.functions),
        "seconds": round(seconds, 2),
        "stages": {name: round(lap, 3) for name, lap in room.stages.items()},
    }
    if truth is not None:
        counts = tally(truth, recognised)
        row |= {"found": counts.found, "missed": counts.missed, "wrong": counts.wrong}
        row |= {"recall": counts.recall, "precision": counts.precision}
    return row


def print_rows(rows: Sequence[ScanRow], total: Tally):
    """Print a line for each scan, and one for all of which the truth is known."""
    columns = ["scan", "points", "level by", "objects", "recall", "precision", "missed", "wrong", "seconds"]

    def share(row: ScanRow, name: str) -> str:
        return "-" if row.get(name) is None else f"{row[name]:.2f}"

    table = [
        [row["scan"], row["points"], row["up_from"], row["objects"], share(row, "recall"), share(row, "precision")]
        + [", ".join(row.get(name, ())) or "-" for name in ("missed", "wrong")] + [f"{row['seconds']:.2f}"]
        for row in rows
    ]
    print_table("Functional objects of real scans", columns, table)
    hits, all_true, claimed = len(total.found), len(total.found + total.missed), len(total.found + total.wrong)
    print(f"all: {hits} of {all_true} found, {hits} of {claimed} claims true")


def main(
    data: Annotated[Path, typer.Argument(help="Folder of scans, with NAME_boxes.csv or NAME_instances.csv.")],
    model: Annotated[Path | None, typer.Option(help="A model file; without one, the model that ships.")] = None,
    backend: Annotated[str, typer.Option(help="Whose shipped model to use.")] = "fast",
    complete: Annotated[str | None, typer.Option(help="Some of smooth,bottom,sides,mirror; or none.")] = None,
    cluster_tolerance: Annotated[float, typer.Option(help="Metres.")] = Segmentation.cluster_tolerance,
    large_tolerance: Annotated[float, typer.Option(help="Metres.")] = Segmentation.large_tolerance,
    only: Annotated[str, typer.Option(help="Scans whose names hold this, or one of these.")] = "",
    points: Annotated[int | None, typer.Option(help="Take at most so many points, of scans known by boxes.")] = None,
    pictures: Annotated[Path | None, typer.Option(help="Folder for pictures, where the licence allows them.")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
):
    """Measure recognition on real scans."""
    from spherefunc_bullet.learning.model_file import load_model, shipped_model
    from spherefunc_bullet.settling.settling import warm_up
    from spherefunc_bullet.simulator import make_simulator

    classifier = load_model(model or shipped_model(backend, scans=True))
    steps = steps_of(complete)
    settings = Segmentation(cluster_tolerance=cluster_tolerance, large_tolerance=large_tolerance)
    failures, rows = Failures(), []
    warm_up(make_simulator(classifier.simulator))
    compile_kernels()
    for path in sorted(file for file in data.glob("*.ply") if any(part in file.name for part in only.split(","))):
        try:
            scan = some_points(load_scan(path, report=say), points)
            started = time.process_time()  # of one core, whatever else is running
            room = recognise(scan, classifier, settings=settings, completion=steps)
            rows.append(scan_row(path, scan, room, time.process_time() - started))
            if pictures is not None and may_be_shown(path):
                write_picture(scan, room, pictures / f"scene_{path.stem}.png")
        except InputError as error:
            failures.add(error)
    total = sum((Tally(**{name: row.get(name, ()) for name in ("found", "missed", "wrong")}) for row in rows), Tally())
    if as_json:
        print_json({"scans": rows, "found": len(total.found), "recall": total.recall, "precision": total.precision})
    else:
        print_rows(rows, total)
    failures.exit()


if __name__ == "__main__":
    run(lambda: typer.run(main))
