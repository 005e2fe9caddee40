"""Each function's chosen radius, F-measure and accuracy, beside the published ones (paper, Fig. 3b)."""

from __future__ import annotations

from collections import Counter

from spherefunc_bullet.lengths import format_length

from .journal import DOUBLE, GREY, INK, Plate, look
from .study import Study

PAPER = {"cup": 0.80, "sittable": 0.74, "table": 0.85}  # F-measures on its authors' own 200 models


def function_quality(study: Study) -> Plate:
    """Return Fig. 3b: quality at the largest training size, and which radius the trials chose."""
    published = " Diamonds: F-measures that Hinkle and Olson (2013) report on their own 200 models, not on these."
    return Plate(
        stem="fig3b_functions",
        caption=f"(a) F-measure and accuracy of each function at {study.half} training examples, "
        f"{study.simulated.name}; bars: standard deviation over {study.protocol.trials} trials."
        f"{published if PAPER.keys() & set(study.labels.functions) else ''} "
        "(b) In how many of the trials each radius was the one that counted most.",
        size=(DOUBLE, 1.25 + 0.3 * len(study.labels.functions)),
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
    left.legend(*legend_entries(left), loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=3, columnspacing=1.2)


def draw_measures(axes, rows: list[dict]):
    """Draw F-measure, accuracy and the paper's F-measure of each function on a line."""
    for index, row in enumerate(rows):
        colour = look(index)["color"]
        spread = row["f_measure_std"] or 0.0
        axes.errorbar(row["f_measure"], index, xerr=spread, color=colour, marker="o", capsize=2, label="F-measure")
        axes.plot(row["accuracy"], index, "s", color=colour, markerfacecolor="white", label="accuracy")
        if row["paper_f_measure"] is not None:
            axes.plot(row["paper_f_measure"], index, "D", color=INK, markerfacecolor="none", label="F-measure (paper's)")
    low = min(min(row["f_measure"] - (row["f_measure_std"] or 0), row["paper_f_measure"] or 1) for row in rows)
    axes.set_xlim(min(0.5, int(max(low, 0) * 10) / 10) - 0.01, 1.01)
    axes.set_xlabel("F-measure, accuracy")
    axes.grid(axis="x", linewidth=0.3, color="#dddddd")
    axes.set_title("(a)", loc="left", fontweight="bold")


def legend_entries(axes):
    """Return each kind of marker once, in grey: the colours are the functions', which the axis names."""
    from copy import copy

    handles = {}
    for handle, label in zip(*axes.get_legend_handles_labels(), strict=True):
        handles.setdefault(label, copy(handle))
    return list(handles.values()), list(handles)


def draw_radii(axes, study: Study):
    """Draw how many trials chose each radius, as numbers on a map."""
    trials = study.protocol.trials
    counts = [[radius_counts(study, name)[radius] for radius in study.radii] for name in study.labels.functions]
    axes.imshow(counts, cmap="cividis", vmin=0, vmax=trials, aspect="auto")
    for y, row in enumerate(counts):
        for x, count in enumerate(row):
            axes.text(x, y, count, ha="center", va="center", fontsize=7, color=INK if count > trials / 2 else "white")
    axes.set_xticks(range(len(study.radii)), [format_length(radius) for radius in study.radii])
    axes.set_xlabel("sphere radius")
    axes.tick_params(left=False, labelleft=False)
    axes.set_title("(b)", loc="left", fontweight="bold")
    axes.set_title(f"trials of {trials} that chose it", color=GREY, fontsize=7)
