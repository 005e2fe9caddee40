"""Spheres at rest on typical objects of each function, and on one that has none (paper, Fig. 1)."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure

from spherefunc_bullet.datasets.dataset import label_text
from spherefunc_bullet.formats.units import format_length
from spherefunc_bullet.viewer import pictures
from spherefunc_bullet.viewer.colours import HEIGHT_COLOURS

from ..pages.plates import DOUBLE, GREY, Plate
from .evaluated_data import EvaluatedData

KINDS = 2  # categories of each function, those with most objects, such as chairs and sofas
MANY = 4  # functions: if there are more, one category each
ABREAST = 4  # pictures in a row
LONGEST = 27  # letters above a picture
VIEW = pictures.CameraView(size=(560, 470))  # somewhat more than 300 dpi


@dataclass(frozen=True, kw_only=True)
class TypicalObject:
    """One object that is shown."""

    index: int  # in the data
    radius: float  # metres
    score: float | None  # for its function, left out; None where it has none


def typical_objects(data: EvaluatedData) -> Plate:
    """Return Fig. 1: settled spheres on the most typical objects of a data set."""
    shown = exhibits(data)
    rows = -(-(len(shown) + 1) // ABREAST)
    return Plate(
        stem="fig1_settled",
        caption=f"Where spheres come to rest on objects of {data.name} (not shown to scale): of each "
        "function those with the clearest score when left out, and an ordinary object without a function. Spheres "
        "are coloured by height within each picture; objects smaller than half a metre are cut open.",
        size=(DOUBLE, rows * 1.72),
        draw=lambda figure: draw_exhibits(figure, data, shown),
        rows=[exhibit_row(data, exhibit) for exhibit in shown],
    )


def exhibits(data: EvaluatedData) -> list[TypicalObject]:
    """Return the objects to show: the most typical ones of each function, then an ordinary one without a function."""
    chosen: dict[int, float | None] = {}
    kinds = KINDS if len(data.labels.functions) <= MANY else 1
    for column in range(len(data.labels.functions)):
        for index in typical_members(data, column, kinds):
            chosen.setdefault(index, float(data.evaluation.scores[index, column]))
    outside = ordinary_outsider(data)
    if outside is not None:
        chosen[outside] = None
    radii = [picture_radius(data, index, pictures.SPHERES_ACROSS) for index in chosen]
    shown = zip(chosen.items(), radii, strict=True)
    return [TypicalObject(index=index, radius=radius, score=score) for (index, score), radius in shown]


def typical_members(data: EvaluatedData, column: int, kinds: int) -> list[int]:
    """Return the member with the highest score of each of a function's most numerous categories.

    Members that have no other function come first.
    """
    members = np.flatnonzero(data.labels.members[:, column])
    objects, functions = data.simulated.objects, data.labels.members[members].sum(axis=1)
    best = members[np.lexsort((-data.evaluation.scores[members, column], functions))]
    categories = Counter(objects[i].category for i in members).most_common(kinds)
    return [next(int(i) for i in best if objects[i].category == category) for category, _ in categories]


def ordinary_outsider(data: EvaluatedData) -> int | None:
    """Return the object without a function whose highest score is the middle one."""
    outside = np.flatnonzero(~data.labels.members.any(axis=1))
    if not len(outside):
        return None
    ordered = outside[np.argsort(data.evaluation.scores[outside].max(axis=1), kind="stable")]
    return int(ordered[len(ordered) // 2])


def picture_radius(data: EvaluatedData, index: int, across: float) -> float:
    """Return the radius, of those with settled spheres, that fits about ``across`` times in an object's extent."""
    record = data.simulated.records[index]
    filled = [radius for radius in data.radii if len(record.centers(radius))] or data.radii
    return pictures.fitting_radius(filled, record.size, across)


def exhibit_row(data: EvaluatedData, exhibit: TypicalObject) -> dict[str, Any]:
    """Return the row of a shown object."""
    item = data.simulated.objects[exhibit.index]
    return {
        "file": item.path.name,
        "label": label_text(item.functions, "; "),
        "category": item.category,
        "leave_one_out_score": None if exhibit.score is None else round(exhibit.score, 4),
        "radius": exhibit.radius,
        "settled": len(data.simulated.records[exhibit.index].centers(exhibit.radius)),
    }


def draw_exhibits(figure: Figure, data: EvaluatedData, shown: list[TypicalObject]):
    """Draw the pictures in rows, and the key in the last place."""
    rows = -(-(len(shown) + 1) // ABREAST)
    grid = figure.subplots(rows, ABREAST, squeeze=False)
    figure.get_layout_engine().set(wspace=0, hspace=0, w_pad=0.03, h_pad=0.02)
    for axes in grid.flat:
        axes.set_axis_off()
    clouds = [data.cloud(exhibit.index) for exhibit in shown]
    for number, (axes, exhibit, cloud) in enumerate(zip(grid.flat, shown, clouds, strict=False)):
        settled = data.simulated.records[exhibit.index].centers(exhibit.radius)
        axes.imshow(pictures.object_picture(cloud, settled, exhibit.radius, VIEW))
        row = exhibit_row(data, exhibit)
        axes.set_title(f"({chr(97 + number)}) {title(row)}", fontsize=7.5, loc="left", pad=2)
        below = f"r = {format_length(exhibit.radius)}, {row['settled']:,} spheres"
        score = "" if exhibit.score is None else f", score {exhibit.score:.2f}"
        axes.text(0, -0.02, below + score, transform=axes.transAxes, va="top", fontsize=6.5, color=GREY)
    draw_key(grid.flat[len(shown)], any(pictures.is_cut(cloud) and cloud.mesh is not None for cloud in clouds))


def title(row: Mapping[str, str]) -> str:
    """Return an object's label with its category, or else with its file's name."""
    name = row["category"] if row["category"] not in ("", row["label"]) else row["file"].rsplit(".", 1)[0]
    words = f"{row['label']}: {name.replace('_', ' ')}"
    return words if len(words) <= LONGEST else words[: LONGEST - 1] + "…"


def draw_key(axes: Axes, cut: bool):
    """Draw the meaning of the colours."""
    ramp = LinearSegmentedColormap.from_list("height", HEIGHT_COLOURS)
    axes.set(xlim=(0, 1), ylim=(0, 1))
    axes.imshow(np.linspace(0, 1, 64)[:, None], cmap=ramp, extent=(0.12, 0.22, 0.38, 0.86), origin="lower")
    axes.set(xlim=(0, 1), ylim=(0, 1), aspect="auto")
    axes.text(0.27, 0.86, "highest sphere", va="top", fontsize=7)
    axes.text(0.27, 0.38, "lowest sphere", va="bottom", fontsize=7)
    if not cut:
        return
    axes.fill([0.12, 0.22, 0.22, 0.12], [0.16, 0.16, 0.26, 0.26], color=pictures.CUT_COLOUR)
    axes.text(0.27, 0.21, "cut through the object", va="center", fontsize=7)
