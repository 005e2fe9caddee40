"""The score of real scans as a person reads it: by function, and by scan."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from spherefunc_bullet.console import print_table, show
from spherefunc_bullet.formats.writing import writing
from spherefunc_bullet.scenes.recognition.recognition import Room
from spherefunc_bullet.scenes.report.picture import room_picture
from spherefunc_bullet.scenes.scans.scan import Scan

from .matching import Row, Score, Verdict, score_of
from .truth import read_rows

Verdicts = Sequence[Verdict]


def inferred_row(claims: Verdicts) -> Row:
    """Return how many of the claims of what was not seen are true, and of what."""
    return {
        "claims": len(claims),
        "backs": sum(one.outcome == "back found" for one in claims),
        "seen": sum(one.outcome == "found" for one in claims),
    }


def scores_by_function(verdicts: Verdicts) -> dict[str, Score]:
    """Return each function's score."""
    names = sorted({verdict.function for verdict in verdicts})
    return {name: score_of(verdict for verdict in verdicts if verdict.function == name) for name in names}


def known_row(verdicts: Verdicts) -> Row:
    """Return how what was recognised in a scan compares with what is known of it."""
    score = score_of(verdicts)

    def named(outcome: str) -> list[str]:
        return [verdict.true.name for verdict in verdicts if verdict.outcome == outcome]

    return {
        "functions": {name: own.row() for name, own in scores_by_function(verdicts).items()},
        "found": named("found"),
        "missed": named("missed"),
        "wrong": [verdict.function for verdict in verdicts if verdict.outcome == "false"],
        "backs_found": named("back found"),
        "disputed": named("disputed"),
        "recall": score.row()["recall"],
        "precision": score.row()["precision"],
    }


def print_inferred(inferred: Verdicts):
    """Print what was inferred and not seen, which counts nowhere."""
    row = inferred_row(inferred)
    true = f"{row['backs']} are chairs of which only the back shows, {row['seen']} others"
    show(f"inferred from backs at tables, and counted nowhere: {row['claims']}, of which {true}\n")


def print_scans(rows: Sequence[Row]):
    """Print a line for each scan."""
    names = sorted({name for row in rows for name in row.get("functions", {})})
    columns = ["scan", "points", "level by", "parts", *names, "claims true", "backs", "disputed", "seconds"]
    table = [
        [row["scan"].removesuffix(".ply"), row["points"], row["up_from"], row["objects"]]
        + scan_cells(row, names)
        + [f"{row['seconds']:.2f}"]
        for row in rows
    ]
    print_table("Each scan: found of those seen; a dash where there is none, or nothing is known", columns, table)
    show()


def scan_cells(row: Row, names: Sequence[str]) -> list[str]:
    """Return a scan's counts: by function, of claims, of backs, and of what is disputed."""
    known = row.get("functions")
    if known is None:
        claims = f"{len(row['functional'])} claims, no truth" if row["functional"] else "-"
        return ["-" for _ in names] + [claims, "-", "-"]
    empty = Score().row()
    own = [known.get(name, empty) for name in names]
    sums = {key: sum(score[key] for score in known.values()) for key in empty if key not in ("recall", "precision")}
    shares = [plain(score["found"], score["seen"]) for score in own]
    claims, backs = plain(sums["true_claims"], sums["claims"]), plain(sums["backs_found"], sums["backs"])
    return [*shares, claims, backs, str(sums["disputed"] or "-")]


def plain(some: int, of: int) -> str:
    """Return a count of how many, a dash where there are none."""
    return f"{some}/{of}" if of else "-"


RESTRICTED = ("research", "non-commercial", "no licence", "unknown")  # words of licences that forbid publishing


def write_picture(folder: Path | None, path: Path, scan: Scan, room: Room):
    """Write a small picture of few colours, as documents take it, of a scan whose licence allows it."""
    if folder is not None and may_be_shown(path):
        file = folder / f"scene_{path.stem}.png"
        with writing(file):
            room_picture(scan, room, size=(560, 420)).quantize(96).save(file, optimize=True)


def may_be_shown(path: Path) -> bool:
    """Return whether a scan's licence, in the manifest beside it, allows a picture of it to be published."""
    manifest = path.with_name("manifest.csv")
    licences = {row["file"]: row["license"] for row in read_rows(manifest)} if manifest.exists() else {}
    licence = licences.get(path.name, "")
    return bool(licence) and not any(word in licence.lower() for word in RESTRICTED)
