"""Real scans with known objects: how many objects with functions are found, and how many claims are correct.

    python -m spherefunc_bullet.compare.rooms.real_scans DATA [--only NAME] [--json]

Every scan of a folder, by object and by place.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated

import typer

from spherefunc_bullet.console import Failures, print_json, print_table, run, say, show
from spherefunc_bullet.datasets.dataset import csv_table
from spherefunc_bullet.errors import InputError
from spherefunc_bullet.formats.files import prepare_folder
from spherefunc_bullet.function_model import FunctionModel
from spherefunc_bullet.learning.model_file import load_model, shipped_model
from spherefunc_bullet.scenes.recognition.recognition import compile_kernels, recognise
from spherefunc_bullet.scenes.report.picture import room_picture
from spherefunc_bullet.scenes.scans.scan import load_scan
from spherefunc_bullet.settling.settling import warm_up
from spherefunc_bullet.simulator import make_simulator
from spherefunc_bullet.viewer.mechanics_pictures import write_picture

from .benchmark import OBJECT, PLACE, BenchmarkScan, benchmark_rows, match_places, print_benchmark, source_of
from .matching import MatchResult, Row, Score, match_by_place, match_objects, score_of, score_row
from .truth import inferred_in, recognised_in, true_objects

Verdicts = Sequence[MatchResult]


@dataclass(kw_only=True)
class ScanResults:
    """The results of all scans so far."""

    rows: list[Row] = field(default_factory=list)
    verdicts: list[MatchResult] = field(default_factory=list)
    inferred: list[MatchResult] = field(default_factory=list)  # of objects that were inferred and not seen
    examined: list[BenchmarkScan] = field(default_factory=list)

    def json(self) -> dict[str, object]:
        """Return the results for JSON."""
        return {
            "scans": self.rows,
            **score_row(score_of(self.verdicts)),
            "functions": {name: score_row(score) for name, score in scores_by_function(self.verdicts).items()},
            "benchmark": benchmark_rows(self.examined),
            "inferred": inferred_row(self.inferred),
        }

    def print(self):
        """Print the results as tables."""
        print_scans(self.rows)
        print_benchmark(benchmark_rows(self.examined))
        claims, backs, seen = inferred_row(self.inferred).values()
        show(f"chairs inferred at tables, in no count above: {claims}; for {backs} only the back of a chair shows,")
        show(f"for {seen} more of a chair shows, for {claims - backs - seen} no chair is there\n")
        score = score_row(score_of(self.verdicts))
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


def measure(path: Path, model: FunctionModel, pictures: Path | None, measured: ScanResults):
    """Recognise one scan and add its results.

    Raises
    ------
    InputError
        If the scan, or its ground truth, cannot be used.
    """
    truth, scan = true_objects(path), load_scan(path, report=say)
    started = time.process_time()  # of one core, whatever else is running
    room = recognise(scan, model)
    row = {
        "scan": path.name,
        "points": len(scan),
        "up_from": room.levelling.source,
        "objects": len(room.objects),
        "functional": sorted(name for item in room.objects for name in item.members),
        "seconds": round(time.process_time() - started, 2),
        "stages": {name: round(lap, 3) for name, lap in room.stages.items()},
    }
    if truth is not None:
        recognised = recognised_in(scan, room)
        verdicts = match_objects(truth, recognised)
        row |= known_row(verdicts)
        measured.verdicts += verdicts
        measured.inferred += match_by_place(truth, inferred_in(scan, room))
        units = {OBJECT: verdicts, PLACE: match_places(truth, scan, room, recognised)}
        measured.examined.append(BenchmarkScan(source=source_of(path), verdicts=units))
    measured.rows.append(row)
    if pictures is not None and may_be_shown(path):  # a small picture, for the documents
        write_picture(room_picture(scan, room, size=(560, 420)), pictures / f"scene_{path.stem}.png")


def main(
    data: Annotated[Path, typer.Argument(help="Folder of scans, with NAME_boxes.csv or NAME_instances.csv.")],
    model: Annotated[Path | None, typer.Option(help="A model file. Default: the package's model.")] = None,
    only: Annotated[str, typer.Option(help="Only scans whose names contain one of these.")] = "",
    pictures: Annotated[Path | None, typer.Option(help="Folder for pictures of scans whose licence allows it.")] = None,
    seed: Annotated[int | None, typer.Option(min=0, help="Random seed of the spheres. Default: the model's.")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON on stdout.")] = False,
):
    """Measure recognition on real scans."""
    paths, failures, measured = scan_files(data, only), Failures(), ScanResults()
    classifier = load_model(model or shipped_model("fast", scans=True))
    classifier.seed = classifier.seed if seed is None else seed
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


def inferred_row(claims: Verdicts) -> Row:
    """Return how many inferred objects are claimed, and how many of them are backs and others in the ground truth."""
    return {
        "claims": len(claims),
        "backs": sum(seat.outcome == "back found" for seat in claims),
        "seen": sum(seat.outcome == "found" for seat in claims),
    }


def scores_by_function(verdicts: Verdicts) -> dict[str, Score]:
    """Return each function's score."""
    names = sorted({verdict.function for verdict in verdicts})
    return {name: score_of(verdict for verdict in verdicts if verdict.function == name) for name in names}


def known_row(verdicts: Verdicts) -> Row:
    """Return the comparison of the objects recognised in a scan with its ground truth."""
    score = score_row(score_of(verdicts))

    def named(outcome: str) -> list[str]:
        return [verdict.true.name for verdict in verdicts if verdict.outcome == outcome]

    return {
        "functions": {name: score_row(of_function) for name, of_function in scores_by_function(verdicts).items()},
        "found": named("found"),
        "missed": named("missed"),
        "wrong": [verdict.function for verdict in verdicts if verdict.outcome == "false"],
        "backs_found": named("back found"),
        "disputed": named("disputed"),
        "recall": score["recall"],
        "precision": score["precision"],
    }


def print_scans(rows: Sequence[Row]):
    """Print a line for each scan."""
    names = sorted({name for row in rows for name in row.get("functions", {})})
    columns = ["scan", "points", "level by", "parts", *names, "claims true", "backs", "disputed", "seconds"]
    table = []
    for row in rows:
        start = [row["scan"].removesuffix(".ply"), row["points"], row["up_from"], row["objects"]]
        table.append([*start, *scan_cells(row, names), f"{row['seconds']:.2f}"])
    print_table("Each scan: found of those seen; a dash where there is none, or nothing is known", columns, table)
    show()


def scan_cells(row: Row, names: Sequence[str]) -> list[str]:
    """Return a scan's counts: by function, of claims, of backs, and of disputed objects."""
    known = row.get("functions")
    if known is None:
        claims = f"{len(row['functional'])} claims, no truth" if row["functional"] else "-"
        return ["-" for _ in names] + [claims, "-", "-"]
    empty = score_row(Score())
    scores = [known.get(name, empty) for name in names]
    sums = {key: sum(score[key] for score in known.values()) for key in empty if key not in ("recall", "precision")}
    shares = [count_text(score["found"], score["seen"]) for score in scores]
    claims, backs = count_text(sums["true_claims"], sums["claims"]), count_text(sums["backs_found"], sums["backs"])
    return [*shares, claims, backs, str(sums["disputed"] or "-")]


def count_text(some: int, of: int) -> str:
    """Return a count out of a total; a dash if the total is 0."""
    return f"{some}/{of}" if of else "-"


RESTRICTED = ("research", "non-commercial", "no licence", "unknown")  # words of licences that forbid publishing


def may_be_shown(path: Path) -> bool:
    """Return whether a scan's licence, in the manifest beside it, allows a picture of it to be published."""
    manifest = path.with_name("manifest.csv")
    rows = csv_table(manifest, "file", "license") if manifest.exists() else []
    licence = next((row["license"].lower() for row in rows if row["file"] == path.name), "")
    return bool(licence) and not any(word in licence for word in RESTRICTED)


if __name__ == "__main__":
    run(lambda: typer.run(main))
