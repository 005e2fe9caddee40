"""Scans recognised, judged and counted one by one: by the spheres, and by baselines on the same proposals."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from spherefunc_bullet.console import say
from spherefunc_bullet.function_model import FunctionModel
from spherefunc_bullet.scenes.recognition.recognition import Room
from spherefunc_bullet.scenes.scans.scan import Scan, load_scan
from spherefunc_bullet.settling.records import ObjectRecord

from .baselines import Baseline, shape_record
from .causes import CauseRow, cause_rows
from .exam import OBJECT, PLACE, ExaminedScan, exam_rows, judged_places, source_of
from .matching import JudgedScan, ScoreRow, Verdict, judged, judged_by_place, score_of
from .proposals import Asked, Scores
from .scan_report import SPHERES, Pictures, ScanRow, inferred_row, known_row, scores_by_function
from .trials import Recognition
from .truth import RecognisedObject, TrueObject, true_objects


@dataclass(kw_only=True)
class Measured:
    """What was measured of all scans so far."""

    rows: list[ScanRow] = field(default_factory=list)
    readings: dict[str, list[Verdict]] = field(default_factory=dict)  # of the spheres and of every baseline
    inferred: list[Verdict] = field(default_factory=list)  # of what nobody saw: each claim's
    misses: list[CauseRow] = field(default_factory=list)
    false_claims: list[CauseRow] = field(default_factory=list)
    examined: list[ExaminedScan] = field(default_factory=list)

    def json(self) -> dict[str, object]:
        """Return it for JSON."""
        score = score_of(self.readings.get(SPHERES, ()))
        return {
            "scans": self.rows,
            **score.row(),
            "functions": by_function(self.readings.get(SPHERES, ())),
            "exam": exam_rows(self.examined),
            "baselines": {name: by_function(own) for name, own in self.readings.items() if name != SPHERES},
            "inferred": inferred_row(self.inferred),
            "misses": self.misses,
            "false_claims": self.false_claims,
        }


@dataclass(frozen=True, kw_only=True, eq=False)
class Trial(Recognition):
    """How scans are recognised, and what else tells what was proposed."""

    model: FunctionModel
    baselines: dict[str, Baseline]

    def classified_by_baselines(self, asked: Asked) -> dict[str, Sequence[RecognisedObject]]:
        """Return what the same proposals become as every baseline tells them."""
        if not self.baselines or not asked.room.proposals:
            return dict.fromkeys(self.baselines, ())
        clouds = asked.clouds(self.completion)
        records = [shape_record(cloud, Path(str(number))) for number, cloud in enumerate(clouds)]
        return {name: asked.classified_by(function_scores_of(own, records)) for name, own in self.baselines.items()}


def function_scores_of(baseline: Baseline, records: Sequence[ObjectRecord]) -> list[Scores]:
    """Return the score of each function of each object."""
    return [dict(zip(baseline.functions, row, strict=True)) for row in baseline.scores(records).tolist()]


def by_function(verdicts: Sequence[Verdict]) -> dict[str, ScoreRow]:
    """Return each function's score for JSON."""
    return {name: score.row() for name, score in scores_by_function(verdicts).items()}


def some_points(scan: Scan, count: int | None) -> Scan:
    """Return a scan with at most so many of its points, the truth then being that of boxes only."""
    if count is None or count >= len(scan):
        return scan
    chosen = np.sort(np.random.default_rng(0).permutation(len(scan))[:count])
    colors = None if scan.colors is None else scan.colors[chosen]
    return replace(scan, points=scan.points[chosen], colors=colors)


def scan_row(path: Path, scan: Scan, room: Room, seconds: float) -> ScanRow:
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


def measure(path: Path, points: int | None, trial: Trial, pictures: Pictures, measured: Measured):
    """Recognise one scan and add what came of it.

    Raises
    ------
    InputError
        If the scan, or what is known of it, cannot be used.
    """
    truth = true_objects(path)
    scan = some_points(load_scan(path, report=say), points)
    if points is not None:
        truth = without_points(truth, len(scan))
    started = time.process_time()  # of one core, whatever else is running
    room = trial.recognised(scan, trial.model)
    row = scan_row(path, scan, room, time.process_time() - started)
    asked, verdicts = Asked(scan=scan, room=room), []
    if truth is not None:
        recognised = asked.objects()
        verdicts = judged(truth, recognised)
        judged_scan = JudgedScan(
            name=path.name,
            points=scan.points,
            labels=room.labels,
            truth=truth,
            recognised=recognised,
            proposals=asked.proposals(),
            verdicts=verdicts,
        )
        row |= known_row(verdicts)
        misses, false_claims = cause_rows(judged_scan)
        measured.misses += misses
        measured.false_claims += false_claims
        measured.inferred += judged_by_place(truth, asked.inferred())
        measured.readings.setdefault(SPHERES, []).extend(verdicts)
        by_place = judged_places(truth, scan, room, recognised)
        units = {OBJECT: verdicts, PLACE: by_place}
        measured.examined.append(ExaminedScan(source=source_of(path), verdicts=units))
        for name, others in trial.classified_by_baselines(asked).items():
            measured.readings.setdefault(name, []).extend(judged(truth, others))
    measured.rows.append(row)
    pictures.write(path, scan, room, verdicts)


def without_points(truth: list[TrueObject] | None, count: int) -> list[TrueObject] | None:
    """Return what is known of a scan of so many points; None where it is known by labels of others."""
    by_label = any(true.points is not None and len(true.points) != count for true in truth or ())
    return None if by_label else truth
