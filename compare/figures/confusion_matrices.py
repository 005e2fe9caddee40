"""What is taken for what, after few and after many training examples (paper, Fig. 4)."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..evaluation.confusion import Confusion, count_confusion
from ..pages.plates import DOUBLE, INK, SINGLE, Plate, wrapped
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
    """Return how many matrices stand in a row."""
    return min(len(data.protocol.train_sizes), ABREAST if len(data.labels.functions) < FEW else 2)


def matrices_size(data: EvaluatedData) -> tuple[float, float]:
    """Return the width and height of the figure in inches."""
    across, count = abreast(data), len(data.protocol.train_sizes)
    large = len(data.labels.functions) >= FEW
    side, width = (LARGE_SIDE, DOUBLE) if large else (SIDE[across], WIDTH[across])
    names = 0.05 * max(map(len, data.labels.functions))  # slanted below the columns
    return width, -(-count // across) * (side + 0.5 + names)


def shares(confusion: Confusion) -> np.ndarray:
    """Return of each label's objects the share (F + 1, F + 1) that was said to have each function."""
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
    """Draw the matrices beside each other, with one key."""
    sizes = data.protocol.train_sizes
    across = abreast(data)
    grid = figure.subplots(-(-len(sizes) // across), across, squeeze=False)
    for index, axes in enumerate(grid.flat):
        if index >= len(sizes):
            axes.set_axis_off()
            continue
        image = draw_matrix(axes, count_confusion(data.labels, *data.evaluation.trials[sizes[index]]))
        axes.set_title(f"({chr(97 + index)}) {sizes[index]} training examples", fontweight="bold", loc="left")
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
        # An empty row is no share of anything.
        words = f"{value:.0f}" if confusion.objects[y] else "–"
        axes.text(x, y, words, ha="center", va="center", fontsize=size, color=INK if value > 50 else "white")
    turned = 0 if len(percent) <= 3 else 35
    side = "center" if turned == 0 else "right"
    axes.set_xticks(range(len(percent)), confusion.labels, rotation=turned, ha=side, rotation_mode="anchor")
    axes.set_yticks(range(len(percent)), list(map(wrapped, confusion.labels)))
    axes.tick_params(length=0)
    axes.spines[:].set_visible(False)
    return image
