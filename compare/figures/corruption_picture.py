"""Objects as sensors give them: a panel for each corruption, with the shares classified, unsure, and wrong and sure."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from spherefunc_bullet.formats.writing import writing

from ..evaluation.robustness.corruptions import CLEAN, Corruptions, Rates
from ..pages.plates import GREY, INK, STYLE
from .impaired_picture import DOTS, require_ending

if TYPE_CHECKING:
    from matplotlib.axes import Axes

WIDE, HIGH, ACROSS = 2.1, 1.9, 5  # inches of a panel, and panels in a row
LINES = {  # share -> what it is called, and its colour (Okabe and Ito)
    "told": ("classified by its function", "#0072B2"),
    "unsure": ("unsure", "#999999"),
    "wrong_and_sure": ("wrong and sure", "#D55E00"),
}
BASELINE = "points"  # that is drawn thin beside the spheres


def draw_corruptions(rates: Corruptions, path: Path) -> Path:
    """Draw the rates under each corruption against its severity, thin those of the objects' own points.

    Raises
    ------
    InputError
        If the file ends in something else than .png or .svg, or cannot be written.
    """
    import matplotlib
    from matplotlib.figure import Figure

    require_ending(path)
    kinds = [kind for kind in rates if kind != CLEAN]
    rows = -(-len(kinds) // ACROSS)
    with matplotlib.rc_context(STYLE), writing(path):
        figure = Figure(figsize=(WIDE * ACROSS, HIGH * rows + 0.5), dpi=DOTS, layout="constrained")
        panels = figure.subplots(rows, ACROSS, sharex=True, sharey=True, squeeze=False).ravel()
        for axes, kind in zip(panels, kinds, strict=False):
            draw_kind(axes, kind, rates[CLEAN] | rates[kind])
        for axes in panels[len(kinds) :]:
            axes.set_axis_off()
        handles, labels = panels[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=len(LINES), frameon=False)
        path.parent.mkdir(parents=True, exist_ok=True)
        figure.savefig(path, dpi=DOTS, metadata={"Date": None} if path.suffix.lower() == ".svg" else None)
    return path


def draw_kind(axes: Axes, kind: str, rows: Mapping[str, Rates]):
    """Draw one corruption, from clean objects on."""
    severities = sorted(rows, key=int)
    for name, (label, colour) in LINES.items():
        axes.plot([int(one) for one in severities], [rows[one][name] for one in severities], color=colour, label=label)
        beside = [rows[one].get("baselines", {}).get(BASELINE, {}).get(name) for one in severities]
        if None not in beside:
            axes.plot([int(one) for one in severities], beside, color=colour, linewidth=0.7, alpha=0.6)
    axes.set_title(kind.replace("_", " "), fontsize=9, color=INK)
    axes.set(ylim=(0, 1.02), xticks=range(6))
    axes.tick_params(colors=GREY, labelsize=7)
