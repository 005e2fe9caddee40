"""Each function's chosen radius, F-measure and accuracy, beside the published ones (paper, Fig. 3b)."""

from __future__ import annotations

from collections import Counter

from spherefunc_bullet.lengths import format_length

from .journal import DOUBLE, GREY, INK, Plate, look
from .study import Study

PAPER = {"cup": 0.80, "sittable": 0.74, "table": 0.85}  # F-measures on its authors' own 200 models
PAPER_MARK = {"marker": "D", "color": INK, "markerfacecolor": "none"}
ABOVE, BELOW = 9, -9  # points, of a number from its marker


def function_quality(study: Study) -> Plate:
    """Return Fig. 3b: quality at the largest training size, and which radius the trials chose."""
    published = " Diamonds: F-measures that Hinkle and Olson (2013) report on their own 200 models, not on these."
    return Plate(
        stem="fig3b_functions",
        caption=f"(a) F-measure and accuracy of each function at {study.half} training examples, "
        f"{study.simulated.name}; bars: standard deviation over {study.protocol.trials} trials."
        f"{published if PAPER.keys() & set(study.labels.functions) else ''} "
        "(b) In how many of the trials each radius was the one that counted most.",
        size=(DOUBLE, 1.15 + 0.38 * len(study.labels.functions)),
        draw=lambda figure: draw_quality(figure, study),
        rows=quality_rows(study),
    )


def quality_rows(study: Study) -> list[dict]:
    """Return one row a function, with the paper's F-measure where it has that function."""
    rows = []
    for name, row in study.measured(study.half).items():
        counted = radius_counts(study, name)
        chosen = {f"trials_choosing_{format_length(r).replace(' ', '')}": counted[r] for r in study.radii}
        start = {"function": name, "train_size": study.half, "trials": study.protocol.trials}
        rows.append(start | row | {"paper_f_measure": PAPER.get(name)} | chosen)
    return rows


def radius_counts(study: Study, name: str) -> Counter[float]:
    """Return in how many trials each radius counted most for a function."""
    column = study.labels.functions.index(name)
    weights = [run.weights[column] for run in study.runs[study.half]]
    return Counter(max(each, key=each.get) for each in weights)


def draw_quality(figure, study: Study):
    """Draw the qualities and, beside them, the choices of radius."""
    left, right = figure.subplots(1, 2, width_ratios=(1.5, 1), sharey=True)
    rows = quality_rows(study)
    draw_measures(left, rows)
    draw_radii(right, study)
    left.set_yticks(range(len(rows)), [row["function"] for row in rows])
    left.set_ylim(len(rows) - 0.5, -0.5)
    # Above the panel: inside it any place may hold a number.
    entries = legend_entries()[: 3 if PAPER.keys() & set(study.labels.functions) else 2]
    left.legend(handles=entries, loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=3, columnspacing=1.2)


def draw_measures(axes, rows: list[dict]):
    """Draw F-measure, accuracy and the paper's F-measure of each function on a line, each with its number."""
    for index, row in enumerate(rows):
        own = {"color": look(index)["color"]}
        draw_number(axes, row["f_measure"], index, ABOVE, own | {"marker": "o"}, row["f_measure_std"])
        draw_number(axes, row["accuracy"], index, ABOVE, own | {"marker": "s", "markerfacecolor": "white"})
        if row["paper_f_measure"] is not None:
            draw_number(axes, row["paper_f_measure"], index, BELOW, PAPER_MARK)
    lows = [min(row["f_measure"] - (row["f_measure_std"] or 0), row["paper_f_measure"] or 1) for row in rows]
    axes.set_xlim(max(min(lows) - 0.05, -0.03), 1.03)
    axes.set_xlabel("F-measure, accuracy")
    axes.grid(axis="x", linewidth=0.3, color="#dddddd")
    axes.set_title("(a)", loc="left", fontweight="bold")


def draw_number(axes, value: float, line: int, beside: int, marks: dict, spread: float | None = None):
    """Draw a marker and write its value ``beside`` points higher."""
    axes.errorbar(value, line, xerr=spread or None, capsize=2, markersize=5, **marks)
    offset = {"xytext": (0, beside), "textcoords": "offset points", "ha": "center", "va": "center"}
    axes.annotate(f"{value:.2f}", (value, line), **offset, fontsize=6.5, color=marks["color"])


def legend_entries() -> list:
    """Return each kind of marker, in grey: the colours are the functions', which the axis names."""
    from matplotlib.lines import Line2D

    grey = {"color": GREY, "linestyle": "none", "markersize": 5}
    return [
        Line2D([], [], marker="o", label="F-measure", **grey),
        Line2D([], [], marker="s", markerfacecolor="white", label="accuracy", **grey),
        Line2D([], [], linestyle="none", label="F-measure in the paper", markersize=5, **PAPER_MARK),
    ]


def draw_radii(axes, study: Study):
    """Draw how many trials chose each radius, as numbers on a map."""
    trials = study.protocol.trials
    counts = [[radius_counts(study, name)[radius] for radius in study.radii] for name in study.labels.functions]
    axes.imshow(counts, cmap="cividis", vmin=0, vmax=trials, aspect="auto")
    for y, row in enumerate(counts):
        for x, count in enumerate(row):
            colour, weight = INK if count > trials / 2 else "white", "bold" if count == max(row) else "normal"
            axes.text(x, y, count, ha="center", va="center", fontsize=7, color=colour, fontweight=weight)
    axes.set_xticks(range(len(study.radii)), [format_length(radius) for radius in study.radii])
    axes.set_xlabel("sphere radius")
    axes.tick_params(left=False, labelleft=False)
    axes.set_title("(b)", loc="left", fontweight="bold")
    axes.set_title(f"trials of {trials} that chose it", color=GREY, fontsize=7)
