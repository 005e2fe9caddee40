"""Each function's chosen radius, F-measure and accuracy, next to the published ones (paper, Fig. 3b)."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from spherefunc_bullet.formats.units import format_length

from ..evaluation.evaluation import radius_counts
from ..evaluation.protocol import PAPER
from ..pages.plates import DOUBLE, GREY, INK, Plate, bounded_spread, look, wrapped
from .evaluated_data import EvaluatedData

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
        spread = np.reshape(bounded_spread(row["f_measure"], row["f_measure_std"]), (2, 1))
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
