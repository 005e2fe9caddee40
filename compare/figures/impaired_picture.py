"""Does it still work? One picture of which impaired copies are still called by their function, and by what."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from spherefunc_bullet.errors import InputError
from spherefunc_bullet.formats.files import writing

from ..evaluation.impaired import (
    COPIES_LEARNT,
    HARMLESS,
    HELD,
    UNSEEN_KIND,
    USELESS,
    KindShare,
    Shares,
    mean_rows,
    mean_shares,
)
from ..evaluation.robustness.corruptions import CLEAN, Corruptions, Rates
from ..pages.plates import GREY, INK, STYLE

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.colors import LinearSegmentedColormap
    from matplotlib.figure import Figure


ENDINGS = (".png", ".svg")
COLUMNS = {  # feature set -> what the picture calls it, and what that means
    "spheres": ("spheres", "where spheres that fall on the object come to rest"),
    "points": ("points", "the object's own points, read the same way"),
    "occupancy_sqrt": ("occupancy", "the cubes of space that it fills"),
    "rules": ("rules", "height, area, flatness"),
    "examiner": ("examiner", "a person of boxes, or a ball, tries it"),
}
NOT_DRAWN = ("bounding_box", "occupancy", "height_map", "always_no")  # no better than those that are
KINDS = {  # function and kind, or kind -> what is drawn beside its row
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
DOTS = 200  # an inch, of a PNG
ROW, COLUMN, LABELS, GAP = 0.21, 0.46, 1.4, 0.25  # inches: a row, a column, the kinds' names, between panels
ABOVE, BELOW = 1.85, 0.85  # inches: the headline and the columns' names, the key
NARROWEST = 9.2  # inches, which the headline needs
SPACE = 0.5  # rows between useless and harmless


def draw_impaired(shares: Shares, path: Path) -> Path:
    """Draw the shares of impaired copies that are still called by their function, and return the file's path.

    A panel for each function, useless kinds above, harmless ones below; a column for each way to tell. The colour says
    how right it is: blue where useless copies are seen through or harmless ones still known, orange where not.

    Parameters
    ----------
    path : Path
        Of a ``.png`` or ``.svg`` file.

    Raises
    ------
    InputError
        If the file has another ending, or cannot be written.
    """
    import matplotlib
    from matplotlib.figure import Figure

    require_ending(path)
    columns, tops = columns_of(shares), block_tops(shares)
    blocks = {function: blocks_of(kinds, columns) for function, kinds in shares.items()}
    rows = tops[True] + max(len(groups[True]) for groups in blocks.values())
    panel = LABELS + len(columns) * COLUMN + GAP
    wide, high = max(len(shares) * panel + GAP, NARROWEST), ABOVE + ROW * rows + BELOW
    with matplotlib.rc_context(STYLE), writing(path):
        figure = Figure(figsize=(wide, high), dpi=DOTS)
        for place, (function, groups) in enumerate(blocks.items()):
            left, size = GAP + place * panel + LABELS, (len(columns) * COLUMN / wide, ROW * rows / high)
            axes = figure.add_axes((left / wide, BELOW / high, *size), xlim=(0, len(columns)), ylim=(rows, 0))
            draw_heads(axes, function, columns)
            for works, block in groups.items():
                draw_block(axes, function, block, columns, tops[works], works)
        draw_words(figure, headline(shares, columns), columns)
        path.parent.mkdir(parents=True, exist_ok=True)
        figure.savefig(path, dpi=DOTS, metadata={"Date": None} if path.suffix.lower() == ".svg" else None)
    return path


def require_ending(path: Path):
    """Raise InputError if a picture cannot be drawn in a file of such a name."""
    if path.suffix.lower() not in ENDINGS:
        raise InputError(f"--picture {path}: expected a file that ends in {' or '.join(ENDINGS)}")


def columns_of(shares: Shares) -> dict[str, str]:
    """Return which feature sets are drawn, and what they are called: simulators by name, and those of `COLUMNS`."""
    there = next(iter(next(iter(shares.values())).values()))["share"]
    simulators = [
        name
        for name in there
        if name not in {*COLUMNS, *NOT_DRAWN} and not name.endswith((HELD, COPIES_LEARNT, UNSEEN_KIND))
    ]
    others = {name: words for name, (words, _) in COLUMNS.items() if name in there}
    return dict(zip(simulators, simulators, strict=True)) | others


def blocks_of(kinds: Mapping[str, KindShare], columns: Mapping[str, str]) -> dict[bool, dict[str, KindShare]]:
    """Return the useless kinds and the harmless ones of a function, by whether they work.

    The means come before what they are of; what is unchanged, before these.
    """
    means, blocks = dict(mean_rows(kinds, list(columns))), {}
    for works, name in ((False, USELESS), (True, HARMLESS)):
        rows = {kind: row for kind, row in kinds.items() if row["works"] == works}
        first = {kind: rows.pop(kind) for kind in ("whole",) if kind in rows}
        blocks[works] = first | ({MEAN: means[name]} if name in means else {}) | rows
    return blocks


def block_tops(shares: Shares) -> dict[bool, float]:
    """Return at which row the useless and the harmless kinds begin, the same in all panels, below a title."""
    columns = columns_of(shares)
    most = max(len(blocks_of(kinds, columns)[False]) for kinds in shares.values())
    return {False: 1.0, True: 2.0 + most + SPACE}


def headline(shares: Shares, columns: Mapping[str, str]) -> list[str]:
    """Return what comes of it in two sentences, each a mean over functions."""
    sentences, means = [], mean_shares(shares, list(columns))
    for name, words in ((USELESS, "useless copies"), (HARMLESS, "harmless copies")):
        if not np.isnan(list(means[name].values())).all():
            means_text = ", ".join(f"{column} {per_cent(means[name][key])} %" for key, column in columns.items())
            sentences.append(f"Share of {words} that are still called useful: {means_text}.")
    return sentences


def per_cent(share: float) -> str:
    """Return a share in per cent, without decimals."""
    return f"{100 * share:.0f}"


def kind_words(function: str, kind: str) -> str:
    """Return what a kind of change is called beside its row."""
    return KINDS.get(f"{function} {kind}", KINDS.get(kind, kind.replace("_", " ")))


def draw_heads(axes: Axes, function: str, columns: Mapping[str, str]):
    """Write the function and the names of the columns above a panel."""
    axes.set_axis_off()
    at = {"xycoords": "axes fraction", "textcoords": "offset points", "va": "bottom"}
    axes.annotate(function, (0, 1), xytext=(-72 * LABELS, 3), ha="left", fontsize=13, fontweight="bold", **at)
    for place, words in enumerate(columns.values()):
        slant = {"rotation": 40, "rotation_mode": "anchor", "fontweight": "bold" if place == 0 else "normal"}
        axes.annotate(words, ((place + 0.45) / len(columns), 1), xytext=(0, 2), ha="left", fontsize=8, **at, **slant)


def draw_block(
    axes: Axes, function: str, block: Mapping[str, KindShare], columns: Mapping[str, str], top: float, works: bool
):
    """Draw the useless or the harmless kinds of one function, a row each, from a row on."""
    from matplotlib.patches import Rectangle

    if block:
        axes.text(-LABELS / COLUMN, top - 0.4, TITLES[works], va="center", fontsize=8, fontweight="bold", color=GREY)
    for line, (kind, row) in enumerate(block.items()):
        at = {"va": "center_baseline", "fontsize": 8, "fontweight": "bold" if kind == MEAN else "normal"}
        axes.text(-0.15, top + line + 0.5, kind_words(function, kind), ha="right", color=INK, **at)
        for place, name in enumerate(columns):
            share = row["share"][name]
            right = float(share if works else 1 - share)  # of a whole number Matplotlib takes a colour by its index
            colour = colours()(right)
            axes.add_patch(Rectangle((place, top + line), 1, 1, facecolor=colour, edgecolor="white", linewidth=1))
            ink = "white" if abs(right - 0.5) > 0.35 else INK
            axes.text(place + 0.5, top + line + 0.5, per_cent(share), ha="center", color=ink, **at)


def colours() -> LinearSegmentedColormap:
    """Return the colours from wrong, 0, to right, 1."""
    from matplotlib.colors import LinearSegmentedColormap

    return LinearSegmentedColormap.from_list("right", [WRONG, EVEN, RIGHT])


def draw_words(figure: Figure, sentences: Sequence[str], columns: Mapping[str, str]):
    """Write the headline above the panels, and what the colours mean below them."""
    wide, high = figure.get_size_inches()
    figure.text(GAP / wide, 1 - 0.3 / high, "Does it still work?", fontsize=17, fontweight="bold", va="center")
    for line, sentence in enumerate(sentences):
        figure.text(GAP / wide, 1 - (0.65 + 0.23 * line) / high, sentence, fontsize=11, va="center")
    key = figure.add_axes((GAP / wide, 0.52 / high, 1.4 / wide, 0.13 / high))
    key.imshow(np.linspace(0, 1, 64)[None], aspect="auto", cmap=colours())
    key.set_axis_off()
    words = "wrong to right.  In each cell: how many per cent of the copies are still called by the function."
    figure.text((GAP + 1.5) / wide, 0.585 / high, words, fontsize=8, va="center", color=GREY)
    meanings = [f"{words}: {COLUMNS[name][1]}." for name, words in columns.items() if name in COLUMNS]
    for line, said in enumerate((meanings[:-2], meanings[-2:])):
        figure.text(GAP / wide, (0.34 - 0.16 * line) / high, "  ".join(said), fontsize=8, va="center", color=GREY)


WIDE, HIGH, ACROSS = 2.1, 1.9, 5  # inches of a panel, and panels in a row
LINES = {  # share -> what it is called, and its colour (Okabe and Ito)
    "told": ("classified by its function", "#0072B2"),
    "unsure": ("unsure", "#999999"),
    "wrong_and_sure": ("wrong and sure", "#D55E00"),
}
BASELINE = "points"  # that is drawn thin beside the spheres
KEY = "share of objects by severity, 0 clean to 5; thick: spheres, thin: the same quantities of their own points"


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
        key = {"title": KEY, "title_fontsize": 8, "loc": "outside lower center", "ncols": len(LINES)}
        figure.legend(handles, labels, frameon=False, **key)
        path.parent.mkdir(parents=True, exist_ok=True)
        figure.savefig(path, dpi=DOTS, metadata={"Date": None} if path.suffix.lower() == ".svg" else None)
    return path


def draw_kind(axes: Axes, kind: str, rows: Mapping[str, Rates]):
    """Draw one corruption, from clean objects on."""
    severities = sorted(rows, key=int)
    for name, (label, colour) in LINES.items():
        axes.plot(
            [int(severity) for severity in severities],
            [rows[severity][name] for severity in severities],
            color=colour,
            label=label,
        )
        beside = [rows[severity].get("baselines", {}).get(BASELINE, {}).get(name) for severity in severities]
        if None not in beside:
            axes.plot([int(severity) for severity in severities], beside, color=colour, linewidth=0.7, alpha=0.6)
    axes.set_title(kind.replace("_", " "), fontsize=9, color=INK)
    axes.set(ylim=(0, 1.02), xticks=range(6))
    axes.tick_params(colors=GREY, labelsize=7)
