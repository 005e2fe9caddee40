"""The benchmark of real scans: recall and precision by object and by place, by function and source, with intervals.

By *object* a claim is correct if its box, or its points, overlap those of a true object of that function. By *place* it
is correct if the best place of that function on it, to sit, to put or to pour, lies in a true object's box.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from spherefunc_bullet.console import print_table, show
from spherefunc_bullet.formats.files import write_text
from spherefunc_bullet.scenes.recognition.partial_places import room_places
from spherefunc_bullet.scenes.recognition.room import Room
from spherefunc_bullet.scenes.scans.scan import Scan

from ..pages.plates import DOUBLE, GREY, Plate, look, write_plate
from .matching import MatchResult, Row, Score, rounded, score_of, score_row
from .truth import RecognisedObject, TrueObject, aligned_box

OBJECT, PLACE = "object", "place"
ALL = "all"
MARGIN = 0.05  # metres around a box drawn by hand, within which a place is on its object
RESAMPLED, SHARE = 2000, 0.95  # bootstrap samples of the scans, and the share of them in the interval

Interval = tuple[float | None, float | None]


@dataclass(frozen=True, kw_only=True, eq=False)
class BenchmarkScan:
    """The results of one scan, by object and by place."""

    source: str  # the first word of its name
    verdicts: Mapping[str, Sequence[MatchResult]]

    def score(self, unit: str, function: str = ALL) -> Score:
        """Return the score by object or by place, of one function or of all."""
        return score_of(verdict for verdict in self.verdicts[unit] if function in (ALL, verdict.function))


def source_of(path: Path) -> str:
    """Return the source of a scan.

    Examples
    --------
    >>> source_of(Path("sun3d_home_38.ply"))
    'sun3d'
    """
    return path.stem.split("_")[0]


def match_places(
    truth: Sequence[TrueObject], scan: Scan, room: Room, recognised: Sequence[RecognisedObject]
) -> list[MatchResult]:
    """Compare the best place of each claimed function of each object with the true boxes, in the scan's frame.

    A true object is found once; a second place on it counts neither way.
    """
    found, claims = room_places(scan, room), []
    for item, claim in zip(room.objects, recognised, strict=True):
        for name in sorted(claim.functions):
            places = [place for place in found.get(item.id, ()) if place.function == name]
            if places:
                claims.append((max(places, key=lambda place: place.score), claim))
    verdicts, true_functions = [], [one.functions | one.disputed for one in truth]
    for name in sorted(set().union(*true_functions, *(claim.functions for _, claim in claims))):
        wanted = [one for one, functions in zip(truth, true_functions, strict=True) if name in functions]
        taken: dict[int, RecognisedObject] = {}
        for place, claim in claims:
            if place.function == name:
                holder = holder_of(place.position, wanted, scan)
                if holder is None:
                    verdicts.append(MatchResult(function=name, claim=claim))
                else:
                    taken.setdefault(holder, claim)
        verdicts += [MatchResult(function=name, true=one, claim=taken.get(k)) for k, one in enumerate(wanted)]
    return verdicts


def holder_of(position: np.ndarray, truth: Sequence[TrueObject], scan: Scan) -> int | None:
    """Return the true object whose box holds a position (3,), metres, and has the nearest middle; None without one."""
    distances = {}
    for number, one in enumerate(truth):
        box = one.box or aligned_box(scan.points[one.points])
        if (np.abs(box.to_own(position[None])[0]) <= box.size / 2 + MARGIN).all():
            distances[number] = float(np.linalg.norm(box.center - position))
    return min(distances, key=distances.get, default=None)


def interval(scores: Sequence[Score], figure: Callable[[np.ndarray], np.ndarray]) -> Interval:
    """Return the bootstrap interval of a figure over the scans; None where the figure is undefined.

    Parameters
    ----------
    scores : sequence of Score
        Of each scan.
    figure : callable
        From counts found, missed and false (R, 3) to the figure of each sample (R,).
    """
    counts = np.array([[score[name] for name in ("found", "missed", "false")] for score in scores]).reshape(-1, 3)
    if not counts.sum():
        return None, None
    chosen = np.random.default_rng(0).integers(len(counts), size=(RESAMPLED, len(counts)))
    with np.errstate(invalid="ignore"):
        values = figure(counts[chosen].sum(axis=1))
    if np.isnan(values).all():
        return None, None
    low, high = np.nanpercentile(values, [50 * (1 - SHARE), 50 * (1 + SHARE)])
    return rounded(float(low), 3), rounded(float(high), 3)


def benchmark_rows(scans: Sequence[BenchmarkScan]) -> list[Row]:
    """Return the rows of the benchmark: all, by function and by source, each by object and by place."""
    functions = sorted({verdict.function for scan in scans for unit in scan.verdicts.values() for verdict in unit})
    sources = sorted({scan.source for scan in scans})
    rows = []
    for unit in (OBJECT, PLACE):
        rows += [benchmark_row(unit, name, [scan.score(unit, name) for scan in scans]) for name in (ALL, *functions)]
        for source in sources:
            rows.append(benchmark_row(unit, source, [scan.score(unit) for scan in scans if scan.source == source]))
    return rows


def benchmark_row(unit: str, of: str, scores: Sequence[Score]) -> Row:
    """Return one row from the scores of its scans."""
    return {
        "by": unit,
        "of": of,
        "scans": len(scores),
        **score_row(sum(scores, Score())),
        "recall_interval": interval(scores, lambda counts: counts[:, 0] / counts[:, :2].sum(axis=1)),
        "precision_interval": interval(scores, lambda counts: counts[:, 0] / counts[:, ::2].sum(axis=1)),
    }


def print_benchmark(rows: Sequence[Row]):
    """Print the benchmark as a table."""
    table = [
        [row["by"], row["of"], row["scans"]]
        + [count_with_interval(row["found"], row["seen"], row["recall"], row["recall_interval"])]
        + [count_with_interval(row["true_claims"], row["claims"], row["precision"], row["precision_interval"])]
        + [f"{row['true_sure_claims']}/{row['sure_claims']}"]
        + [f"{row['backs_found']}/{row['backs']}" if row["backs"] else "-", row["disputed"] or "-"]
        for row in rows
    ]
    columns = ["by", "of", "scans", "found of seen", "claims true", "sure ones", "backs", "disputed"]
    print_table(f"The benchmark, with {SHARE:.0%} intervals by bootstrap over scans", columns, table)
    show()


def count_with_interval(some: int, of: int, share: float | None, between: Interval) -> str:
    """Return a count with its share and interval; a dash if there is nothing to count."""
    if share is None or between[0] is None:
        return "-"
    return f"{some}/{of} {share:.2f} ({between[0]:.2f} to {between[1]:.2f})"


WHOLE = "whole"


def room_curves(about: Row, measured: Sequence[Row]) -> Plate:
    """Return the plot of figures over views, and over noise at the most common number of views."""
    return Plate(
        stem="rooms",
        caption=f"Virtual rooms of {about['data']}, {about['backend']}: F-measure of each function from scan to label, "
        "and recall of objects at IoU 0.5. Thin: the same objects as whole models, by the same classifier.",
        size=(DOUBLE, 2.8),
        draw=lambda figure: draw_curves(figure, measured),
        rows=curve_rows(measured),
    )


def curve_rows(measured: Sequence[Row]) -> list[Row]:
    """Return one row for each scan and function, and for each scan's segmentation."""
    rows: list[Row] = []
    for scan in measured:
        start = {"views": scan["views"], "noise": scan["noise"]}
        rows.append(start | {"curve": "objects found", "value": scan["segmentation"]["recall"], "whole": None})
        for name, function in scan["functions"].items():
            rows.append(start | {"curve": name, "value": function["f_measure"], "whole": function["f_measure_whole"]})
    return rows


def draw_curves(figure: Figure, measured: Sequence[Row]):
    """Draw views on the left and, where several levels were measured, noise on the right."""
    rows = curve_rows(measured)
    noises = sorted({row["noise"] for row in rows if row["views"] != WHOLE})
    panels = figure.subplots(1, 2 if len(noises) > 1 else 1, sharey=True, squeeze=False)[0]
    usual = 1.0 if 1.0 in noises or not noises else noises[0]
    by_views = [row for row in rows if row["views"] == WHOLE or row["noise"] == usual]
    draw_panel(
        panels[0], sorted(by_views, key=lambda row: row["views"] == WHOLE), "views", f"scan; views have noise {usual:g}"
    )
    if len(noises) > 1:
        views = list(dict.fromkeys(row["views"] for row in rows if row["views"] != WHOLE))
        often = max(views, key=lambda name: sum(row["views"] == name for row in rows))
        by_noise = [row for row in rows if row["views"] == often]
        draw_panel(panels[1], by_noise, "noise", f"noise, times a Kinect's; {often}")
    panels[0].set(ylabel="F-measure; recall of objects", ylim=(0, 1.04))
    figure.legend(*panels[0].get_legend_handles_labels(), loc="outside upper center", ncols=5, handlelength=3.2)


def draw_panel(axes: Axes, rows: Sequence[Row], across: str, label: str):
    """Draw each curve over one of the columns."""
    places = {value: place for place, value in enumerate(dict.fromkeys(row[across] for row in rows))}
    for index, name in enumerate(dict.fromkeys(row["curve"] for row in rows)):
        curve = [row for row in rows if row["curve"] == name]
        style = look(index) | ({"color": GREY} if name == "objects found" else {})
        x = [places[row[across]] for row in curve]
        axes.plot(x, [row["value"] for row in curve], **style, markersize=4, label=name)
        if curve[0]["whole"] is not None:
            axes.plot(x, [row["whole"] for row in curve], color=style["color"], linewidth=0.5)
    axes.plot([], [], color=GREY, linewidth=0.5, label="as whole models")
    axes.set_xticks(list(places.values()), [value if across == "views" else f"{value:g}" for value in places])
    axes.set_xlabel(label)
    axes.grid(axis="y", linewidth=0.3, color="#dddddd")


def write_report(folder: Path, about: Row, measured: Sequence[Row]):
    """Write ``rooms.json``, and the plot as PNG, SVG and CSV."""
    write_text(folder / "rooms.json", json.dumps(about | {"conditions": list(measured)}, indent=2) + "\n")
    write_plate(room_curves(about, measured), folder)
