"""The scores of every object when all others are learnt, grouped by label (paper, Fig. 5)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from spherefunc_bullet.datasets.dataset import label_text
from spherefunc_bullet.learning.validation import THRESHOLD

from ..pages.plates import DOUBLE, GREY, INK, PALE, Plate, look
from .evaluated_data import EvaluatedData

PAGE = 8.5  # inches: the largest height of all panels together
CROWD = 100  # objects: fewer get larger marks
GAP = 0.02  # between groups, as a share of all objects
NARROW = 0.07  # of the axis: the names of narrower groups would overlap


@dataclass(frozen=True, eq=False)
class Group:
    """Objects with one label, side by side."""

    label: str
    objects: np.ndarray  # (G,) int, rows of the data, highest score first
    places: np.ndarray  # (G,) float, places on the axis


def membership(data: EvaluatedData) -> Plate:
    """Return Fig. 5: every object's score for every function, with all other objects learnt."""
    return Plate(
        stem="fig5_membership",
        caption=f"Membership of every object of {data.name} when it is left out and all others are learnt, "
        "grouped by label; the same order in all panels, within a group by score. Above the line an object is "
        "predicted to have the function. Filled: labelled and predicted; hollow: labelled, but missed; crosses: "
        "predicted, but neither labelled nor true as well; plus signs: predicted, true as well, but not the label.",
        size=(DOUBLE, 0.75 + min(1.15 * len(data.labels.functions), PAGE)),
        draw=lambda figure: draw_membership(figure, data),
        rows=membership_rows(data),
    )


def membership_rows(data: EvaluatedData) -> list[dict[str, Any]]:
    """Return one row for each object and function, in the order in which they are drawn."""
    rows = []
    for group in groups_of(data):
        for i in group.objects:
            item = data.simulated.objects[i]
            for column, name in enumerate(data.labels.functions):
                score = float(data.evaluation.scores[i, column])
                truth = {"labelled": int(name in item.functions), "also": int(data.labels.also[i, column])}
                answer = {"function": name, "score": round(score, 4), "said": int(score > THRESHOLD)}
                rows.append({"file": item.path.name, "label": group.label} | answer | truth)
    return rows


def groups_of(data: EvaluatedData) -> list[Group]:
    """Return the groups in the order of the axis: those with one function, with several, with none."""
    sets, scores = [item.functions for item in data.simulated.objects], data.evaluation.scores
    order = sorted(set(sets), key=lambda functions: (not functions, len(functions), label_text(functions, "; ")))
    groups, at = [], 0.0
    for functions in order:
        members = np.array([i for i, own in enumerate(sets) if own == functions])
        columns = [data.labels.functions.index(name) for name in functions] or slice(None)
        members = members[np.argsort(-scores[members][:, columns].max(axis=1), kind="stable")]
        groups.append(Group(label_text(functions, "; "), members, at + np.arange(len(members))))
        at += len(members) + GAP * len(sets)
    return groups


def draw_membership(figure: Figure, data: EvaluatedData):
    """Draw a panel for each function."""
    names, groups = data.labels.functions, groups_of(data)
    panels = figure.subplots(len(names), 1, sharex=True, squeeze=False)[:, 0]
    for column, axes in enumerate(panels):
        draw_panel(axes, data, groups, column)
    end = groups[-1].places[-1]
    panels[0].set_xlim(-0.01 * end - 0.7, 1.01 * end + 0.7)
    name_groups(panels[-1], groups, end)
    figure.supylabel("leave-one-out score", fontsize=8)
    # In grey, since each panel has its own shape and colour.
    marks = [each for _, each in marked(*np.zeros((3, 1), bool), {"marker": "o", "color": GREY, "markersize": 4})]
    words = ("neither", "labelled and predicted", "missed", "false positive", "predicted, true as well")
    keys = [Line2D([], [], linestyle="none", label=label, **each) for each, label in zip(marks, words, strict=True)]
    figure.legend(handles=keys, loc="outside upper center", ncols=5, columnspacing=1.4, handletextpad=0.3)


def draw_panel(axes: Axes, data: EvaluatedData, groups: list[Group], column: int):
    """Draw one function's scores of all objects."""
    style = look(column) | {"markersize": 3 if len(data.evaluation.scores) > CROWD else 4.5}
    for group in groups:
        axes.axvspan(group.places[0] - 0.5, group.places[-1] + 0.5, color="#f2f2f2", linewidth=0)
        scores = data.evaluation.scores[group.objects, column]
        members, also = data.labels.members[group.objects, column], data.labels.also[group.objects, column]
        for chosen, marks in marked(members, also, scores > THRESHOLD, style):
            axes.plot(group.places[chosen], scores[chosen], linestyle="none", **marks)
    axes.axhline(THRESHOLD, color=INK, linewidth=0.6, linestyle="--")
    axes.set(ylim=(-0.04, 1.04), yticks=[0, 0.5, 1])
    axes.set_title(data.labels.functions[column], loc="left", fontweight="bold", color=style["color"], pad=2)
    axes.tick_params(bottom=False)


def marked(
    members: np.ndarray, also: np.ndarray, predicted: np.ndarray, style: dict[str, Any]
) -> list[tuple[np.ndarray, dict[str, Any]]]:
    """Return the masks (G,) of objects with their marks, which distinguish right and wrong without colour."""
    size = style["markersize"]
    marker = {"marker": style["marker"], "color": style["color"], "markersize": size, "markeredgewidth": 0.7}
    wrong = {"color": INK, "markeredgewidth": 0.9}
    return [
        (~members & ~predicted, {"marker": ".", "color": GREY, "markersize": 0.8 * size, "markeredgewidth": 0}),
        (members & predicted, marker),
        (members & ~predicted, marker | {"markerfacecolor": "white"}),
        (~members & predicted & ~also, wrong | {"marker": "x", "markersize": 1.2 * size}),
        (~members & predicted & also, wrong | {"marker": "+", "markersize": 1.5 * size}),
    ]


def name_groups(axes: Axes, groups: list[Group], end: float):
    """Write the labels below their groups, slanted if they would overlap."""
    middles = [group.places.mean() for group in groups]
    narrow = bool(np.min(np.diff(middles), initial=np.inf) < NARROW * 1.5 * end)
    slant = {"rotation": 25, "ha": "right", "rotation_mode": "anchor"} if narrow else {}
    axes.set_xticks(middles, [f"{group.label} ({len(group.objects)})" for group in groups], **slant)
    axes.spines["bottom"].set_color(PALE)
    axes.set_xlabel("objects by label (number)")
