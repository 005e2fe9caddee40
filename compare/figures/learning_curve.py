"""F-measure against the number of training examples (paper, Fig. 3a)."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from ..pages.plates import SINGLE, Plate, bounded_spread, look
from .evaluated_data import EvaluatedData

DODGE = 0.006  # of the axis: functions stand beside each other, so that their spreads do not hide one another


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
    """Draw the curves, one a function."""
    axes = figure.add_subplot()
    rows = curve_rows(data)
    count = len(data.labels.functions)
    for index, name in enumerate(data.labels.functions):
        own = [row for row in rows if row["function"] == name]
        beside = (index - (count - 1) / 2) * DODGE * data.half
        axes.errorbar(
            [row["train_size"] + beside for row in own],
            [row["f_measure"] for row in own],
            np.transpose([bounded_spread(row["f_measure"], row["f_measure_std"]) for row in own]),
            **look(index),
            label=name,
            markersize=3.5,
            capsize=1.5,
            elinewidth=0.7,
        )
    axes.set(xlabel="training examples (all functions and none)", ylabel="F-measure", ylim=(0, 1.02))
    axes.set_xlim(0, data.half * 1.04)
    axes.set_yticks(np.linspace(0, 1, 6))
    axes.grid(axis="y", linewidth=0.3, color="#dddddd")
    axes.locator_params(axis="x", integer=True)
    # Above the curves: below them there is no place that is free on all data.
    figure.legend(loc="outside upper center", ncols=key_columns(data), handlelength=3.2, columnspacing=1.2)


def key_columns(data: EvaluatedData) -> int:
    """Return in how many columns the functions' names fit."""
    longest = max(map(len, data.labels.functions))
    return 3 if longest <= 10 else 2 if longest <= 20 else 1
