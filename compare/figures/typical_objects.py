"""Spheres at rest on typical objects of each function, and on one that has none (paper, Fig. 1)."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, replace

import numpy as np

from spherefunc_bullet.clouds.cloud import Cloud, load_cloud
from spherefunc_bullet.quantities import format_length
from spherefunc_bullet.viewer.colours import HEIGHT_COLOURS

from ..pages.pictures import CUT_COLOUR, View, render
from ..pages.plates import DOUBLE, GREY, Plate
from .study import Study, label_name

KINDS = 2  # of each function: the categories with most objects, such as chairs and sofas
MANY = 4  # functions: of more, one kind each
ABREAST = 4  # pictures in a row
LONGEST = 27  # letters above a picture
VIEW = View(size=(560, 470))  # somewhat more than 300 dpi
CUT_BELOW = 0.5  # metres: smaller objects are cut open, because what they hold is inside
SPHERES_ACROSS = 30  # of a picture: about so many radii to an object's largest extent


@dataclass(frozen=True, kw_only=True)
class Exhibit:
    """One object that is shown."""

    index: int  # in the study
    radius: float  # metres
    score: float | None  # for its function, left out; None where it has none


def typical_objects(study: Study) -> Plate:
    """Return Fig. 1: settled spheres on the most typical objects of the user's data."""
    shown = exhibits(study)
    rows = -(-(len(shown) + 1) // ABREAST)
    return Plate(
        stem="fig1_settled",
        caption=f"Where spheres come to rest on objects of {study.simulated.name} (not shown to scale): of each "
        "function those that were told most clearly when left out, and an ordinary object without a function. Spheres "
        "are coloured by height within each picture; objects smaller than half a metre are cut open.",
        size=(DOUBLE, rows * 1.72),
        draw=lambda figure: draw_exhibits(figure, study, shown),
        rows=[exhibit_row(study, each) for each in shown],
    )


def exhibits(study: Study) -> list[Exhibit]:
    """Return the objects to show: of each function its most typical ones, then an ordinary non-member."""
    chosen: dict[int, float | None] = {}
    kinds = KINDS if len(study.labels.functions) <= MANY else 1
    for column in range(len(study.labels.functions)):
        for index in typical_members(study, column, kinds):
            chosen.setdefault(index, float(study.left_out[index, column]))
    outside = ordinary_outsider(study)
    if outside is not None:
        chosen[outside] = None
    return [
        Exhibit(index=index, radius=picture_radius(study, index, SPHERES_ACROSS), score=score)
        for index, score in chosen.items()
    ]


def typical_members(study: Study, column: int, kinds: int) -> list[int]:
    """Return the member with the highest score of each of a function's most numerous categories.

    Members that have no other function come first.
    """
    members = np.flatnonzero(study.labels.members[:, column])
    categories = [study.simulated.objects[i].category for i in members]
    functions = study.labels.members[members].sum(axis=1)
    best = members[np.lexsort((-study.left_out[members, column], functions))]
    return [
        next(int(i) for i in best if study.simulated.objects[i].category == category)
        for category, _ in Counter(categories).most_common(kinds)
    ]


def ordinary_outsider(study: Study) -> int | None:
    """Return the object without a function whose highest score is the middle one."""
    outside = np.flatnonzero(~study.labels.members.any(axis=1))
    if not len(outside):
        return None
    ordered = outside[np.argsort(study.left_out[outside].max(axis=1), kind="stable")]
    return int(ordered[len(ordered) // 2])


def picture_radius(study: Study, index: int, across: float) -> float:
    """Return the radius of which about ``across`` make an object's largest extent, of those with settled spheres."""
    record = study.simulated.records[index]
    filled = [radius for radius in study.radii if len(record.settled[radius])] or study.radii
    return min(filled, key=lambda radius: abs(radius * across - record.size.max()))


def exhibit_cloud(study: Study, index: int) -> Cloud:
    """Return an object's cloud, as it was when the spheres fell."""
    path = study.simulated.objects[index].path
    return load_cloud(path, up=study.loading.up, units=study.loading.units)


def exhibit_row(study: Study, exhibit: Exhibit) -> dict:
    """Return what is shown, in numbers."""
    each = study.simulated.objects[exhibit.index]
    return {
        "file": each.path.name,
        "label": label_name(each.functions),
        "category": each.category,
        "leave_one_out_score": None if exhibit.score is None else round(exhibit.score, 4),
        "radius": exhibit.radius,
        "settled": len(study.simulated.settled[exhibit.index][exhibit.radius]),
    }


def draw_exhibits(figure, study: Study, shown: list[Exhibit]):
    """Draw the pictures in rows, and the key in the last place."""
    rows = -(-(len(shown) + 1) // ABREAST)
    grid = figure.subplots(rows, ABREAST, squeeze=False)
    figure.get_layout_engine().set(wspace=0, hspace=0, w_pad=0.03, h_pad=0.02)
    for axes in grid.flat:
        axes.set_axis_off()
    clouds = [exhibit_cloud(study, each.index) for each in shown]
    for number, (axes, exhibit, cloud) in enumerate(zip(grid.flat, shown, clouds, strict=False)):
        settled = study.simulated.settled[exhibit.index][exhibit.radius]
        axes.imshow(picture(cloud, settled, exhibit.radius))
        row = exhibit_row(study, exhibit)
        axes.set_title(f"({chr(97 + number)}) {title(row)}", fontsize=7.5, loc="left", pad=2)
        below = f"r = {format_length(exhibit.radius)}, {row['settled']:,} spheres"
        said = "" if exhibit.score is None else f", score {exhibit.score:.2f}"
        axes.text(0, -0.02, below + said, transform=axes.transAxes, va="top", fontsize=6.5, color=GREY)
    draw_key(grid.flat[len(shown)], any(is_cut(each) and each.mesh is not None for each in clouds))


def title(row: dict) -> str:
    """Return an object's label and what it is called: its category, or else its file."""
    name = row["category"] if row["category"] not in ("", row["label"]) else row["file"].rsplit(".", 1)[0]
    words = f"{row['label']}: {name.replace('_', ' ')}"
    return words if len(words) <= LONGEST else words[: LONGEST - 1] + "…"


def picture(cloud: Cloud, centers: np.ndarray, radius: float):
    """Return the ray-traced picture of an object and its spheres, with centres (S, 3) and a radius in metres."""
    cut = is_cut(cloud)
    if cloud.mesh is not None:
        return render(cloud.mesh.vertices, cloud.mesh.faces, centers, radius, replace(VIEW, cut=cut))
    # A cloud has no surface to cut: its points in front go, and the spheres among them.
    points, centers = (each[(each @ VIEW.facing <= 0) | (not cut)] for each in (cloud.points, centers))
    return render(points, None, centers, radius, VIEW)


def is_cut(cloud: Cloud) -> bool:
    """Tell whether an object is so small that it is cut open."""
    return bool(cloud.size.max() < CUT_BELOW)


def draw_key(axes, cut: bool):
    """Draw what the colours mean."""
    from matplotlib.colors import LinearSegmentedColormap

    ramp = LinearSegmentedColormap.from_list("height", HEIGHT_COLOURS)
    axes.set(xlim=(0, 1), ylim=(0, 1))
    axes.imshow(np.linspace(0, 1, 64)[:, None], cmap=ramp, extent=(0.12, 0.22, 0.38, 0.86), origin="lower")
    axes.set(xlim=(0, 1), ylim=(0, 1), aspect="auto")
    axes.text(0.27, 0.86, "highest sphere", va="top", fontsize=7)
    axes.text(0.27, 0.38, "lowest sphere", va="bottom", fontsize=7)
    if not cut:
        return
    axes.fill([0.12, 0.22, 0.22, 0.12], [0.16, 0.16, 0.26, 0.26], color=CUT_COLOUR)
    axes.text(0.27, 0.21, "cut through the object", va="center", fontsize=7)
