"""Confusion after few and many training examples (paper, Fig. 4), and the learning curve (Fig. 3a)."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..evaluation.evaluation import Confusion, count_confusion
from ..pages.plates import DOUBLE, INK, SINGLE, Plate, bounded_spread, look, wrapped
from .evaluated_data import EvaluatedData

ABREAST, FEW = 3, 6  # matrices in a row, where they have so few labels
SIDE = {1: 2.1, 2: 2.1, 3: 1.65}  # inches, of a matrix, by how many are in a row
WIDTH = {1: SINGLE, 2: 5.4, 3: DOUBLE}  # inches
LARGE_SIDE = 2.9  # inches, of a matrix of many labels, two in a row


def confusion_matrices(data: EvaluatedData) -> Plate:
    """Return Fig. 4: one confusion matrix for each training size, all trials counted together."""
    return Plate(
        stem="fig4_confusion",
        caption="Of the tested objects with a label (row), how many per cent were said to have a function (column), "
        f"{data.name}, {data.protocol.trials} trials together. An object may be said to have several "
        "functions, and then counts in each, so a row may add up to more than 100; none is said of what got no "
        "function. An object labelled with several functions counts in each of their rows.",
        size=matrices_size(data),
        draw=lambda figure: draw_matrices(figure, data),
        rows=confusion_rows(data),
    )


def abreast(data: EvaluatedData) -> int:
    """Return the number of matrices in a row."""
    return min(len(data.protocol.train_sizes), ABREAST if len(data.labels.functions) < FEW else 2)


def matrices_size(data: EvaluatedData) -> tuple[float, float]:
    """Return the width and height of the figure in inches."""
    across, count = abreast(data), len(data.protocol.train_sizes)
    large = len(data.labels.functions) >= FEW
    side, width = (LARGE_SIDE, DOUBLE) if large else (SIDE[across], WIDTH[across])
    names = 0.05 * max(map(len, data.labels.functions))  # slanted below the columns
    return width, -(-count // across) * (side + 0.5 + names)


def shares(confusion: Confusion) -> np.ndarray:
    """Return the share (F + 1, F + 1) of each label's objects that were predicted to have each function."""
    return confusion.counts / np.maximum(confusion.objects, 1)[:, None]


def confusion_rows(data: EvaluatedData) -> list[dict]:
    """Return one row for each cell of each matrix."""
    rows = []
    for size in data.protocol.train_sizes:
        confusion = count_confusion(data.labels, *data.evaluation.trials[size])
        share = shares(confusion)
        for (i, j), count in np.ndenumerate(confusion.counts):
            start = {"train_size": size, "trials": data.protocol.trials, "labelled": confusion.labels[i]}
            counts = {"said": confusion.labels[j], "tested": int(confusion.objects[i]), "count": int(count)}
            rows.append(start | counts | {"share": round(float(share[i, j]), 4)})
    return rows


def draw_matrices(figure: Figure, data: EvaluatedData):
    """Draw the matrices next to each other, with one key."""
    sizes, across = data.protocol.train_sizes, abreast(data)
    grid = figure.subplots(-(-len(sizes) // across), across, squeeze=False)
    for axes in grid.flat[len(sizes) :]:
        axes.set_axis_off()
    for index, (axes, size) in enumerate(zip(grid.flat, sizes, strict=False)):
        image = draw_matrix(axes, count_confusion(data.labels, *data.evaluation.trials[size]))
        axes.set_title(f"({chr(97 + index)}) {size} training examples", fontweight="bold", loc="left")
        axes.set_xlabel("said to be")
        if index % across == 0:
            axes.set_ylabel("labelled")
    key = figure.colorbar(image, ax=grid, fraction=0.04, aspect=22, shrink=0.72)
    key.set_label("share of a row's objects (%)")
    key.outline.set_visible(False)


def draw_matrix(axes: Axes, confusion: Confusion):
    """Draw one matrix with its numbers, and return the image for the key."""
    percent = 100 * shares(confusion)
    image = axes.imshow(percent, cmap="cividis", vmin=0, vmax=100)
    size = 7.5 if len(percent) < 6 else 5
    for (y, x), value in np.ndenumerate(percent):
        words = f"{value:.0f}" if confusion.objects[y] else "–"
        axes.text(x, y, words, ha="center", va="center", fontsize=size, color=INK if value > 50 else "white")
    turned = 0 if len(percent) <= 3 else 35
    side = "center" if turned == 0 else "right"
    axes.set_xticks(range(len(percent)), confusion.labels, rotation=turned, ha=side, rotation_mode="anchor")
    axes.set_yticks(range(len(percent)), list(map(wrapped, confusion.labels)))
    axes.tick_params(length=0)
    axes.spines[:].set_visible(False)
    return image


DODGE = 0.006  # of the axis: between the marks of functions, so that their spreads do not hide one another


def learning_curve(data: EvaluatedData) -> Plate:
    """Return Fig. 3a: each function's mean F-measure over the trials, with its standard deviation."""
    trials = data.protocol.trials
    spread = f"mean and standard deviation over {trials} random halves" if trials > 1 else "one random half"
    return Plate(
        stem="fig3a_learning_curve",
        caption=f"F-measure against the number of training examples, {data.name}, "
        f"{len(data.simulated.objects)} objects: {spread}, tested on the other half. The sets of training examples "
        "are nested. Markers stand a little beside their number, so that spreads do not hide one another.",
        size=(SINGLE, 2.5 + 0.14 * -(-len(data.labels.functions) // key_columns(data))),
        draw=lambda figure: draw_curve(figure, data),
        rows=curve_rows(data),
    )


def curve_rows(data: EvaluatedData) -> list[dict]:
    """Return the quality of each function at each training size."""
    return [
        {"train_size": size, "trials": data.protocol.trials, "function": name, **row}
        for size in data.evaluation.trials
        for name, row in data.evaluation.quality(size).items()
    ]


def draw_curve(figure: Figure, data: EvaluatedData):
    """Draw the curves of all functions."""
    axes, rows = figure.add_subplot(), curve_rows(data)
    for index, name in enumerate(data.labels.functions):
        curve = [row for row in rows if row["function"] == name]
        shift = (index - (len(data.labels.functions) - 1) / 2) * DODGE * data.half
        sizes, values = [row["train_size"] + shift for row in curve], [row["f_measure"] for row in curve]
        spreads = np.transpose([bounded_spread(row["f_measure"], row["f_measure_std"]) for row in curve])
        style = look(index) | {"markersize": 3.5, "capsize": 1.5, "elinewidth": 0.7}
        axes.errorbar(sizes, values, spreads, **style, label=name)
    axes.set(xlabel="training examples (all functions and none)", ylabel="F-measure", ylim=(0, 1.02))
    axes.set_xlim(0, data.half * 1.04)
    axes.set_yticks(np.linspace(0, 1, 6))
    axes.grid(axis="y", linewidth=0.3, color="#dddddd")
    axes.locator_params(axis="x", integer=True)
    # Above the curves, since no place below them is free for all data.
    figure.legend(loc="outside upper center", ncols=key_columns(data), handlelength=3.2, columnspacing=1.2)


def key_columns(data: EvaluatedData) -> int:
    """Return the number of columns in which the functions' names fit."""
    longest = max(map(len, data.labels.functions))
    return 3 if longest <= 10 else 2 if longest <= 20 else 1
