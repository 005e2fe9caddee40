"""Pictures of recognised scans: small ones where the licence allows them to be published, and all with the truth."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from spherefunc_bullet.formats.writing import prepare_folder, writing
from spherefunc_bullet.scenes.recognition.recognition import Room
from spherefunc_bullet.scenes.report.picture import Mark, room_picture
from spherefunc_bullet.scenes.scans.scan import Scan
from spherefunc_bullet.scenes.segmentation.box import bounding_box

from .matching import Verdict
from .truth import read_rows

RESTRICTED = ("research", "non-commercial", "no licence", "unknown")  # words of licences that forbid publishing
COLOURS = {"found": (0, 130, 60), "missed": (210, 30, 30), "false": (120, 0, 0)}
_APART = (110, 110, 110)  # of what is not counted


@dataclass(frozen=True, kw_only=True)
class Pictures:
    """Where pictures are written to, if anywhere."""

    published: Path | None = None  # of scans whose licence allows it, small
    review: Path | None = None  # of all, with the truth: to look at

    def prepare(self):
        """Make the folders, or raise InputError before anything is computed."""
        prepare_folder(self.published)
        prepare_folder(self.review)

    def write(self, path: Path, scan: Scan, room: Room, verdicts: Sequence[Verdict]):
        """Write a scan's pictures: a small one of few colours, as documents take it, and one with the truth."""
        if self.published is not None and may_be_shown(path):
            file = self.published / f"scene_{path.stem}.png"
            with writing(file):
                room_picture(scan, room, size=(560, 420)).quantize(96).save(file, optimize=True)
        if self.review is not None:
            file, marks = self.review / f"{path.stem}.png", truth_marks(scan, room, verdicts)
            with writing(file):
                room_picture(scan, room, marks=marks).save(file)


def may_be_shown(path: Path) -> bool:
    """Return whether a scan's licence, in the manifest beside it, allows a picture of it to be published."""
    manifest = path.with_name("manifest.csv")
    licences = {row["file"]: row["license"] for row in read_rows(manifest)} if manifest.exists() else {}
    licence = licences.get(path.name, "")
    return bool(licence) and not any(word in licence.lower() for word in RESTRICTED)


def truth_marks(scan: Scan, room: Room, verdicts: Sequence[Verdict]) -> list[Mark]:
    """Return the boxes of all true objects with a function: green where found, red where missed, grey if uncounted."""
    marks = []
    for verdict in [verdict for verdict in verdicts if verdict.true is not None]:
        true = verdict.true
        level, labelled = room.levelling.to_level, true.points is not None
        corners = bounding_box(level(scan.points[true.points])).corners if labelled else level(true.box.corners)
        colour = COLOURS.get(verdict.outcome, _APART)
        marks.append(Mark(corners=corners, colour=colour, text=f"{true.name}: {verdict.outcome}", thin=True))
    return marks
