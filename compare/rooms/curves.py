"""F-measure against the number of views and against noise, on virtual rooms."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import TypedDict

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from spherefunc_bullet.formats.writing import write_text

from ..pages.plates import DOUBLE, GREY, Plate, look, write_plate
from .trials import ConditionRow

WHOLE = "whole"


class ReportHead(TypedDict):
    """What was measured, as ``rooms.json`` begins."""

    data: str
    model: str
    backend: str
    tolerance: float  # metres
    large_tolerance: float  # metres
    completion: list[str]
    proposals: list[str]
    lived_in: dict[str, float]  # kind of disorder -> share of the rooms that have it
    resolution: dict[str, float | None]  # leaf in metres, points
    seed: int


class CurvePoint(TypedDict):
    """One point of a curve."""

    views: str
    noise: float
    curve: str  # a function, or "objects found"
    value: float | None
    whole: float | None  # of the same objects as whole models


def room_curves(about: ReportHead, measured: Sequence[ConditionRow]) -> Plate:
    """Return the plot: on the left what views do, on the right what noise does at the most common number of views."""
    return Plate(
        stem="rooms",
        caption=f"Virtual rooms of {about['data']}, {about['backend']}: F-measure of each function from scan to label, "
        "and recall of objects at IoU 0.5. Thin: the same objects as whole models, by the same classifier.",
        size=(DOUBLE, 2.8),
        draw=lambda figure: draw_curves(figure, measured),
        rows=curve_rows(measured),
    )


def curve_rows(measured: Sequence[ConditionRow]) -> list[CurvePoint]:
    """Return one row for each scan and function, and for each scan's segmentation."""
    rows: list[CurvePoint] = []
    for scan in measured:
        start = {"views": scan["views"], "noise": scan["noise"]}
        rows.append(start | {"curve": "objects found", "value": scan["segmentation"]["recall"], "whole": None})
        for name, function in scan["functions"].items():
            rows.append(start | {"curve": name, "value": function["f_measure"], "whole": function["f_measure_whole"]})
    return rows


def draw_curves(figure: Figure, measured: Sequence[ConditionRow]):
    """Draw views on the left and, where several levels were measured, noise on the right."""
    rows = curve_rows(measured)
    noises = sorted({row["noise"] for row in rows if row["views"] != WHOLE})
    panels = figure.subplots(1, 2 if len(noises) > 1 else 1, sharey=True, squeeze=False)[0]
    usual = 1.0 if 1.0 in noises or not noises else noises[0]
    by_views = [row for row in rows if row["views"] == WHOLE or row["noise"] == usual]
    draw_panel(panels[0], sorted(by_views, key=lambda row: row["views"] == WHOLE), "views", f"scan, noise {usual:g}")
    if len(noises) > 1:
        views = list(dict.fromkeys(row["views"] for row in rows if row["views"] != WHOLE))
        often = max(views, key=lambda name: sum(row["views"] == name for row in rows))
        by_noise = [row for row in rows if row["views"] == often]
        draw_panel(panels[1], by_noise, "noise", f"noise, times a Kinect's; {often}")
    panels[0].set(ylabel="F-measure; recall of objects", ylim=(0, 1.02))
    figure.legend(*panels[0].get_legend_handles_labels(), loc="outside upper center", ncols=5, handlelength=3.2)


def draw_panel(axes: Axes, rows: Sequence[CurvePoint], across: str, label: str):
    """Draw each curve over one of the columns."""
    places = {value: place for place, value in enumerate(dict.fromkeys(row[across] for row in rows))}
    for index, name in enumerate(dict.fromkeys(row["curve"] for row in rows)):
        own = [row for row in rows if row["curve"] == name]
        style = look(index) | ({"color": GREY} if name == "objects found" else {})
        x = [places[row[across]] for row in own]
        axes.plot(x, [row["value"] for row in own], **style, markersize=4, label=name)
        if own[0]["whole"] is not None:
            axes.plot(x, [row["whole"] for row in own], color=style["color"], linewidth=0.5)
    axes.plot([], [], color=GREY, linewidth=0.5, label="as whole models")
    axes.set_xticks(list(places.values()), [value if across == "views" else f"{value:g}" for value in places])
    axes.set_xlabel(label)
    axes.grid(axis="y", linewidth=0.3, color="#dddddd")


def write_report(folder: Path, about: ReportHead, measured: Sequence[ConditionRow]):
    """Write ``rooms.json``, and the plot as PNG, SVG and CSV."""
    write_text(folder / "rooms.json", json.dumps(about | {"conditions": list(measured)}, indent=2) + "\n")
    write_plate(room_curves(about, measured), folder)
