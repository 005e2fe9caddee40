"""Does it still work? A picture of the impaired copies that are still classified by their function, by each feature."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from spherefunc_bullet.errors import InputError
from spherefunc_bullet.formats.files import write_bytes

from ..evaluation import impaired
from ..evaluation.robustness.corruptions import CLEAN, Corruptions, Rates
from ..pages.plates import GREY, INK, figure_bytes, new_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.collections import QuadMesh
    from matplotlib.colors import LinearSegmentedColormap
    from matplotlib.figure import Figure

ENDINGS = (".png", ".svg")
COLUMNS = {  # feature set -> its name in the picture, and what that means
    "spheres": ("spheres", "where spheres that fall on the object come to rest"),
    "points": ("points", "the object's own points, read the same way"),
    "occupancy_sqrt": ("occupancy sqrt", "square roots of how full cubes of space are"),
    "rules": ("rules", "height, area, flatness"),
    "examiner": ("examiner", "a person of boxes, or a ball, tries it"),
}
NOT_DRAWN = ("bounding_box", "occupancy", "height_map", "always_no")  # no better than the drawn ones
KINDS = {  # function and kind, or kind -> the label of its row
    "hole": "hole in the bottom",
    "slit": "slit in the wall",
    "lid": "lid on top",
    "filled": "filled to the brim",
    "on_side": "on its side",
    "sittable missing": "seat missing",
    "table missing": "top missing",
    "sittable tilted": "seat tilted",
    "table tilted": "top tilted",
    "gaps": "gaps in the seat",
    "occupied": "box on the seat",
    "on_back": "on its back",
    "half": "half of the top gone",
    "spikes": "spikes on the top",
    "whole": "unchanged",
    "no_handle": "without handle",
    "no_arms": "without arms",
    "smaller": "a tenth smaller",
    "larger": "a tenth larger",
    "turned": "turned around",
    "sensor": "as a sensor sees it",
    "triangulation": "other triangles",
}
TITLES = {False: "useless: should be 0 %", True: "still works: should be 100 %"}
MEAN = "mean of those below"
WRONG, EVEN, RIGHT = "#D55E00", "#f4f4f4", "#0072B2"  # colours that everyone can distinguish (Okabe and Ito)
DPI = 200  # of a PNG
ROW, COLUMN, LABELS = 0.22, 0.46, 1.6  # inches: a row, a column, the kinds' names
AROUND = 3.2  # inches: the headline, the columns' names, the key
NARROWEST, LETTER = 9.2, 0.09  # inches, which the key needs; a letter of the headline


def draw_impaired(shares: impaired.Shares, path: Path) -> Path:
    """Draw the shares of impaired copies that are still classified by their function, and return the file's path.

    There is a panel for each function, with useless kinds above harmless ones, and a column for each feature. Blue
    cells are right: useless copies that are rejected, harmless ones that are still recognised. Orange cells are wrong.

    Parameters
    ----------
    path : Path
        Of a ``.png`` or ``.svg`` file.

    Raises
    ------
    InputError
        If the file has another ending, or cannot be written.
    """
    require_ending(path)
    columns = columns_of(shares)
    blocks = {function: blocks_of(kinds, columns) for function, kinds in shares.items()}
    rows = [max(1, *(len(groups[works]) for groups in blocks.values())) for works in TITLES]
    lines = ["Does it still work?", *headline(shares, columns)]
    width = max(len(shares) * (LABELS + len(columns) * COLUMN), NARROWEST, LETTER * max(map(len, lines)))
    with new_figure((width, AROUND + ROW * sum(rows)), DPI) as figure:
        panels = figure.subplots(2, len(blocks), squeeze=False, height_ratios=rows)
        for (function, groups), own in zip(blocks.items(), panels.T, strict=True):
            for (works, block), count, axes in zip(groups.items(), rows, own, strict=True):
                cells = draw_block(axes, function, block, columns, works)
                axes.set_ylim(count, 0)
            name_columns(own[0], function, columns)
        figure.suptitle("\n".join(lines), x=0.01, ha="left", fontsize=12)
        draw_key(figure, cells, columns)
        return write_bytes(path, figure_bytes(figure, path.suffix.lower()))


def require_ending(path: Path):
    """Raise InputError if a file's name has no ending of a picture that can be drawn."""
    if path.suffix.lower() not in ENDINGS:
        raise InputError(f"--picture {path}: expected a file that ends in {' or '.join(ENDINGS)}")


def columns_of(shares: impaired.Shares) -> dict[str, str]:
    """Return the names in the picture of the feature sets that are drawn: simulators, and those of `COLUMNS`."""
    names = list(next(iter(next(iter(shares.values())).values()))["share"])
    plain = [name for name in names if not name.endswith((impaired.HELD, impaired.COPIES_LEARNT, impaired.UNSEEN_KIND))]
    simulators = {name: name for name in plain if name not in {*COLUMNS, *NOT_DRAWN}}
    return simulators | {name: words for name, (words, _) in COLUMNS.items() if name in names}


def blocks_of(
    kinds: Mapping[str, impaired.KindShare], columns: Mapping[str, str]
) -> dict[bool, dict[str, impaired.KindShare]]:
    """Return the useless kinds and the harmless ones of a function, by whether they work.

    Unchanged objects come first, then the mean, then the kinds.
    """
    means, blocks = dict(impaired.mean_rows(kinds, list(columns))), {}
    for works, name in ((False, impaired.USELESS), (True, impaired.HARMLESS)):
        rows = {kind: row for kind, row in kinds.items() if row["works"] == works}
        first = {kind: rows.pop(kind) for kind in ("whole",) if kind in rows}
        blocks[works] = first | ({MEAN: means[name]} if name in means else {}) | rows
    return blocks


def headline(shares: impaired.Shares, columns: Mapping[str, str]) -> list[str]:
    """Return the results in two sentences, as means over functions."""
    sentences, means = [], impaired.mean_shares(shares, list(columns))
    for name, words in ((impaired.USELESS, "useless copies"), (impaired.HARMLESS, "harmless copies")):
        if not np.isnan(list(means[name].values())).all():
            means_text = ", ".join(f"{column} {per_cent(means[name][key])} %" for key, column in columns.items())
            sentences.append(f"Share of {words} still classified as useful: {means_text}.")
    return sentences


def per_cent(share: float) -> str:
    """Return a share in per cent, without decimals."""
    return f"{100 * share:.0f}"


def kind_words(function: str, kind: str) -> str:
    """Return the label of a kind's row."""
    return KINDS.get(f"{function} {kind}", KINDS.get(kind, kind.replace("_", " ")))


def draw_block(
    axes: Axes, function: str, block: Mapping[str, impaired.KindShare], columns: Mapping[str, str], works: bool
) -> QuadMesh:
    """Draw the useless or the harmless kinds of one function, a row each, and return the coloured cells."""
    shares = np.array([[row["share"][name] for name in columns] for row in block.values()]).reshape(-1, len(columns))
    right = shares if works else 1 - shares
    cells = axes.pcolormesh(right, cmap=colours(), vmin=0, vmax=1, edgecolors="white", linewidth=1)
    weights = ["bold" if kind == MEAN else "normal" for kind in block]
    for (y, x), share in np.ndenumerate(shares):
        ink = "white" if abs(right[y, x] - 0.5) > 0.35 else INK
        at = {"ha": "center", "va": "center_baseline", "fontsize": 8}
        axes.text(x + 0.5, y + 0.5, per_cent(share), color=ink, **at, fontweight=weights[y])
    axes.set_title(TITLES[works] if block else "", loc="left", fontweight="bold", color=GREY)
    axes.set_xticks([])
    axes.set_yticks(np.arange(len(block)) + 0.5, [kind_words(function, kind) for kind in block], fontsize=8)
    axes.tick_params(length=0)
    axes.spines[:].set_visible(False)
    return cells


def name_columns(axes: Axes, function: str, columns: Mapping[str, str]):
    """Write the function and the names of the columns above a panel."""
    axes.xaxis.tick_top()
    slant = {"rotation": 40, "rotation_mode": "anchor", "ha": "left"}
    axes.set_xticks(np.arange(len(columns)) + 0.5, columns.values(), fontsize=8, **slant)
    axes.annotate(function, (0, 1), (-8, 12), "axes fraction", "offset points", ha="right", fontsize=13, weight="bold")


def colours() -> LinearSegmentedColormap:
    """Return the colours from wrong, 0, to right, 1."""
    from matplotlib.colors import LinearSegmentedColormap

    return LinearSegmentedColormap.from_list("right", [WRONG, EVEN, RIGHT])


def draw_key(figure: Figure, cells: QuadMesh, columns: Mapping[str, str]):
    """Draw the meaning of the colours and of the columns below the panels."""
    key = figure.colorbar(cells, ax=figure.axes, location="bottom", shrink=0.2, aspect=20, anchor=(0.0, 0.5))
    key.set_ticks([0, 1], labels=["wrong", "right"])
    key.outline.set_visible(False)
    meanings = [f"{words}: {COLUMNS[name][1]}." for name, words in columns.items() if name in COLUMNS]
    meanings.append("In each cell: per cent of the copies that are still classified by their function.")
    lines = "\n".join("  ".join(meanings[place : place + 3]) for place in range(0, len(meanings), 3))
    figure.supxlabel(lines, x=0.01, ha="left", fontsize=8, color=GREY)


WIDE, HIGH, ACROSS = 2.1, 1.9, 5  # inches of a panel, and panels in a row
LINES = {  # share -> its name, and its colour (Okabe and Ito)
    "told": ("classified by its function", "#0072B2"),
    "unsure": ("unsure", "#999999"),
    "wrong_and_sure": ("wrong and sure", "#D55E00"),
}
BASELINE = "points"  # drawn as thin lines
KEY = "share of objects by severity, 0 clean to 5; thick: spheres, thin: the same quantities of their own points"


def draw_corruptions(rates: Corruptions, path: Path) -> Path:
    """Draw the rates under each corruption against its severity, with thin lines for the objects' own points.

    Raises
    ------
    InputError
        If the file has another ending than .png or .svg, or cannot be written.
    """
    require_ending(path)
    kinds = [kind for kind in rates if kind != CLEAN]
    rows = -(-len(kinds) // ACROSS)
    with new_figure((WIDE * ACROSS, HIGH * rows + 0.5), DPI) as figure:
        panels = figure.subplots(rows, ACROSS, sharex=True, sharey=True, squeeze=False).ravel()
        for axes, kind in zip(panels, kinds, strict=False):
            draw_kind(axes, kind, rates[CLEAN] | rates[kind])
        for axes in panels[len(kinds) :]:
            axes.set_axis_off()
        handles, labels = panels[0].get_legend_handles_labels()
        key = {"title": KEY, "title_fontsize": 8, "loc": "outside lower center", "ncols": len(LINES)}
        figure.legend(handles, labels, frameon=False, **key)
        return write_bytes(path, figure_bytes(figure, path.suffix.lower()))


def draw_kind(axes: Axes, kind: str, rows: Mapping[str, Rates]):
    """Draw one corruption, from clean objects on."""
    severities = sorted(map(int, rows))
    in_order = [rows[str(severity)] for severity in severities]
    for name, (label, colour) in LINES.items():
        axes.plot(severities, [row[name] for row in in_order], color=colour, label=label)
        beside = [row.get("baselines", {}).get(BASELINE, {}).get(name) for row in in_order]
        if None not in beside:
            axes.plot(severities, beside, color=colour, linewidth=0.7, alpha=0.6)
    axes.set_title(kind.replace("_", " "), fontsize=9, color=INK)
    axes.set(ylim=(0, 1.02), xticks=range(6))
    axes.tick_params(colors=GREY, labelsize=7)
