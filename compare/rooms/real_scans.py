"""Real scans with known objects: how many of the functional ones are found, and how much of what is found is true.

    python -m spherefunc_bullet.compare.rooms.real_scans DATA [--only NAME] [--json]

Every scan of a folder, by object and by place.
"""

from __future__ import annotations

import time
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated

import typer

from spherefunc_bullet.console import Failures, print_json, run, say, show
from spherefunc_bullet.errors import InputError
from spherefunc_bullet.formats.writing import prepare_folder
from spherefunc_bullet.function_model import FunctionModel
from spherefunc_bullet.learning.model_file import load_model, shipped_model
from spherefunc_bullet.scenes.recognition.recognition import Room, compile_kernels, recognise
from spherefunc_bullet.scenes.scans.scan import Scan, load_scan
from spherefunc_bullet.settling.settling import warm_up
from spherefunc_bullet.simulator import make_simulator

from .exam import OBJECT, PLACE, ExaminedScan, exam_rows, judged_places, print_exam, source_of
from .matching import Verdict, judged, judged_by_place, score_of
from .proposals import RecognisedScan
from .scan_report import (
    Row,
    inferred_row,
    known_row,
    print_inferred,
    print_scans,
    scores_by_function,
    write_picture,
)
from .truth import true_objects


@dataclass(kw_only=True)
class Measured:
    """What was measured of all scans so far."""

    rows: list[Row] = field(default_factory=list)
    verdicts: list[Verdict] = field(default_factory=list)
    inferred: list[Verdict] = field(default_factory=list)  # of what nobody saw: each claim's
    examined: list[ExaminedScan] = field(default_factory=list)

    def json(self) -> dict[str, object]:
        """Return it for JSON."""
        return {
            "scans": self.rows,
            **score_of(self.verdicts).row(),
            "functions": {name: score.row() for name, score in scores_by_function(self.verdicts).items()},
            "exam": exam_rows(self.examined),
            "inferred": inferred_row(self.inferred),
        }

    def print(self):
        """Print it for people."""
        print_scans(self.rows)
        print_exam(exam_rows(self.examined))
        print_inferred(self.inferred)
        score = score_of(self.verdicts).row()
        show(f"all: {score['found']} of {score['seen']} found, {score['found']} of {score['claims']} claims true")


def scan_files(data: Path, only: str) -> list[Path]:
    """Return the scans of a folder whose names hold one of some words.

    Raises
    ------
    InputError
        If there is none.
    """
    paths = sorted(file for file in data.glob("*.ply") if any(part in file.name for part in only.split(",")))
    if not paths:
        raise InputError(f"{data}: expected scans NAME.ply{f' with {only} in their names' if only else ''}, found none")
    return paths


def scan_row(path: Path, scan: Scan, room: Room, seconds: float) -> Row:
    """Return what was recognised in one scan."""
    return {
        "scan": path.name,
        "points": len(scan),
        "up_from": room.levelling.source,
        "objects": len(room.objects),
        "functional": sorted(name for item in room.objects for name in item.members),
        "seconds": round(seconds, 2),
        "stages": {name: round(lap, 3) for name, lap in room.stages.items()},
    }


def measure(path: Path, model: FunctionModel, pictures: Path | None, measured: Measured):
    """Recognise one scan and add what came of it.

    Raises
    ------
    InputError
        If the scan, or what is known of it, cannot be used.
    """
    truth, scan = true_objects(path), load_scan(path, report=say)
    started = time.process_time()  # of one core, whatever else is running
    room = recognise(scan, model)
    row = scan_row(path, scan, room, time.process_time() - started)
    if truth is not None:
        seen = RecognisedScan(scan=scan, room=room)
        recognised = seen.objects()
        verdicts = judged(truth, recognised)
        row |= known_row(verdicts)
        measured.verdicts += verdicts
        measured.inferred += judged_by_place(truth, seen.inferred())
        units = {OBJECT: verdicts, PLACE: judged_places(truth, scan, room, recognised)}
        measured.examined.append(ExaminedScan(source=source_of(path), verdicts=units))
    measured.rows.append(row)
    write_picture(pictures, path, scan, room)


def main(
    data: Annotated[Path, typer.Argument(help="Folder of scans, with NAME_boxes.csv or NAME_instances.csv.")],
    model: Annotated[Path | None, typer.Option(help="A model file; without one, the model that ships.")] = None,
    only: Annotated[str, typer.Option(help="Scans whose names hold this, or one of these.")] = "",
    pictures: Annotated[Path | None, typer.Option(help="Folder for pictures, where the licence allows them.")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
):
    """Measure recognition on real scans."""
    paths, failures, measured = scan_files(data, only), Failures(), Measured()
    classifier = load_model(model or shipped_model("fast", scans=True))
    prepare_folder(pictures)
    warm_up(make_simulator(classifier.simulator))
    compile_kernels()
    for path in paths:
        try:
            measure(path, classifier, pictures, measured)
        except InputError as error:
            failures.add(error)
    print_json(measured.json()) if as_json else measured.print()
    failures.exit()


if __name__ == "__main__":
    run(lambda: typer.run(main))
