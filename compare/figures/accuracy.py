"""Accuracy: learning curve (paper, Fig. 3a), quality and radius of each function (Fig. 3b), confusion (Fig. 4)."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from spherefunc_bullet.formats.units import format_length

from ..evaluation.evaluation import Confusion, count_confusion, radius_counts
from ..evaluation.protocol import PAPER
from ..pages.plates import DOUBLE, GREY, INK, SINGLE, Plate, bounded_spread, look, wrapped
from .evaluated_data import EvaluatedData

ABREAST, FEW = 3, 6  # matrices in a row, where they have so few labels
SIDE = {1: 2.1, 2: 2.1, 3: 1.65}  # inches, of a matrix, by how many are in a row
WIDTH = {1: SINGLE, 2: 5.4, 3: DOUBLE}  # inches
LARGE_SIDE = 2.9  # inches, of a matrix of many labels, two in a row


def confusion_matrices(data: EvaluatedData) -> Plate:
    """Return Fig. 4: one confusion matrix for each training size, all trials counted together."""
    return Plate(
        stem="fig4_confusion",
        caption="Percentage of the tested objects with a label (row) that were predicted to have a function (column), "
        f"{data.name}, {data.protocol.trials} trials together. An object that is predicted to have several functions "
        "counts in each, so a row may add up to more than 100; none stands for objects without a predicted function. "
        "An object labelled with several functions counts in each of their rows.",
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
        axes.set_xlabel("predicted")
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
        spreads = np.transpose(list(map(bounded_spread, curve)))
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


PAPER_MARK = {"marker": "D", "color": INK, "markerfacecolor": "none"}


def function_quality(data: EvaluatedData) -> Plate:
    """Return Fig. 3b: quality at the largest training size, and the radii that the trials chose."""
    published = " Diamonds: F-measures that Hinkle and Olson (2013) report on their own 200 models, not on these."
    return Plate(
        stem="fig3b_functions",
        caption=f"(a) F-measure and accuracy of each function at {data.half} training examples, "
        f"{data.name}; bars: standard deviation over {data.protocol.trials} trials. The radius is the one "
        "that most trials chose. (b) In how many of the trials each radius was the one that counted most."
        f"{published if PAPER.keys() & set(data.labels.functions) else ''}",
        size=(DOUBLE, 1.2 + 0.3 * len(data.labels.functions)),
        draw=lambda figure: draw_quality(figure, data),
        rows=quality_rows(data),
    )


def quality_rows(data: EvaluatedData) -> list[dict]:
    """Return one row for each function, with the paper's F-measure if it has that function."""
    rows = []
    for column, (name, row) in enumerate(data.evaluation.quality(data.half).items()):
        counts = radius_counts(data.evaluation.trials[data.half], column)
        chosen = {f"trials_choosing_{format_length(r).replace(' ', '')}": counts[r] for r in data.radii}
        start = {"function": name, "train_size": data.half, "trials": data.protocol.trials}
        rows.append(start | row | {"paper_f_measure": PAPER.get(name)} | chosen)
    return rows


def draw_quality(figure: Figure, data: EvaluatedData):
    """Draw the quality of each function, the same in numbers, and the choices of radius."""
    left, middle, right = figure.subplots(1, 3, width_ratios=(1.5, 1.1, 1.1), sharey=True)
    rows = quality_rows(data)
    known = bool(PAPER.keys() & set(data.labels.functions))
    draw_measures(left, rows)
    draw_numbers(middle, rows, known)
    draw_radii(right, data, rows)
    left.set_yticks(range(len(rows)), [wrapped(row["function"]) for row in rows])
    left.set_ylim(len(rows) - 0.5, -0.5)
    grey = {"color": GREY, "linestyle": "none", "markersize": 5}  # the colours are the functions', which the axis names
    entries = [
        Line2D([], [], marker="o", label="F-measure", **grey),
        Line2D([], [], marker="s", markerfacecolor="white", label="accuracy", **grey),
        Line2D([], [], linestyle="none", label="F-measure in the paper", markersize=5, **PAPER_MARK),
    ]
    figure.legend(handles=entries[: 3 if known else 2], loc="outside upper center", ncols=3, columnspacing=1.2)


def draw_measures(axes: Axes, rows: list[dict]):
    """Draw F-measure, accuracy and the paper's F-measure of each function on a line."""
    for index, row in enumerate(rows):
        style = {"color": look(index)["color"], "markersize": 5}
        spread = np.reshape(bounded_spread(row), (2, 1))
        axes.errorbar(row["f_measure"], index, xerr=spread, marker="o", capsize=2, **style)
        axes.plot(row["accuracy"], index, marker="s", markerfacecolor="white", **style)
        if row["paper_f_measure"] is not None:
            axes.plot(row["paper_f_measure"], index, markersize=5, **PAPER_MARK)
    lows = [min(row["f_measure"] - (row["f_measure_std"] or 0), row["paper_f_measure"] or 1) for row in rows]
    axes.set_xlim(max(min(lows) - 0.05, -0.03), 1.03)
    axes.set_xlabel("F-measure, accuracy")
    axes.grid(axis="x", linewidth=0.3, color="#dddddd")
    axes.set_title("(a)", loc="left", fontweight="bold")


def draw_numbers(axes: Axes, rows: list[dict], known: bool):
    """Write the numbers next to the markers; the paper's only if it has some of the functions."""
    columns = {
        "radius": [format_length(row["radius"]) for row in rows],
        "F": [number(row["f_measure"], row["f_measure_std"]) for row in rows],
        "accuracy": [number(row["accuracy"]) for row in rows],
    }
    if known:
        columns["paper's F"] = [number(row["paper_f_measure"]) for row in rows]
    for place, (name, words) in zip((0.08, 0.36, 0.65, 0.91), columns.items(), strict=False):
        # In points above the panel, whatever its height.
        offset = {"xytext": (0, 5), "textcoords": "offset points", "ha": "center"}
        axes.annotate(name, (place, 1), xycoords="axes fraction", **offset, fontsize=6.5, color=GREY)
        for line, word in enumerate(words):
            axes.text(place, line, word, ha="center", va="center", fontsize=6.5)
    axes.set_xlim(0, 1)
    axes.set_axis_off()


def number(value: float | None, spread: float | None = None) -> str:
    """Return a number with its spread; a dash if there is none."""
    if value is None:
        return "–"
    return f"{value:.2f}" if spread is None else f"{value:.2f} ± {spread:.2f}"


def draw_radii(axes: Axes, data: EvaluatedData, rows: list[dict]):
    """Draw the number of trials that chose each radius on a heat map; the table's radius in bold."""
    trials = data.protocol.trials
    chosen = [radius_counts(data.evaluation.trials[data.half], column) for column in range(len(rows))]
    counts = [[by_radius[radius] for radius in data.radii] for by_radius in chosen]
    axes.imshow(counts, cmap="cividis", vmin=0, vmax=trials, aspect="auto")
    for (y, x), count in np.ndenumerate(counts):
        colour = INK if count > trials / 2 else "white"
        weight = "bold" if data.radii[x] == rows[y]["radius"] else "normal"
        axes.text(x, y, count, ha="center", va="center", fontsize=7, color=colour, fontweight=weight)
    axes.set_xticks(range(len(data.radii)), [format_length(radius) for radius in data.radii])
    axes.set_xlabel("sphere radius")
    axes.tick_params(left=False, labelleft=False)
    axes.set_title("(b)", loc="left", fontweight="bold")
    axes.set_title(f"trials of {trials} that chose it", color=GREY, fontsize=7)
