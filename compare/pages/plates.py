"""Figures in a journal's format: its widths, its font size, colours that everyone can distinguish, two files each.

The PNG is for a manuscript or a slide, the SVG for editing; the numbers are in a CSV file next to them.
"""

from __future__ import annotations

import io
import textwrap
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from spherefunc_bullet.formats.files import write_bytes, write_csv

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SINGLE, DOUBLE = 3.5, 7.16  # inches: one and two columns of an IEEE journal
DPI = 300
WRAP = 16  # letters
INK, GREY, PALE = "#1a1a1a", "#767676", "#c8c8c8"

# Okabe and Ito's colours without yellow, which is too pale for lines, the darkest first.
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
MARKERS = ("o", "s", "^", "D", "v", "P", "X")
DASHES = ("-", "--", "-.", ":", (0, (5, 1, 1, 1, 1, 1)), (0, (8, 2)), (0, (1, 1)))

STYLE = {
    "font.family": "DejaVu Sans",  # matplotlib brings it, so that a figure is the same on every machine
    "font.size": 8,
    "axes.titlesize": 8,
    "axes.labelsize": 8,
    "xtick.labelsize": 7,
    "ytick.labelsize": 7,
    "legend.fontsize": 7,
    "legend.frameon": False,
    "axes.linewidth": 0.6,
    "axes.edgecolor": INK,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "lines.linewidth": 1.2,
    "svg.fonttype": "none",  # text stays text: it can be searched, and a journal may set it in its own face
    "svg.hashsalt": "spherefunc",  # the same numbers give the same file
}


@dataclass(frozen=True, kw_only=True)
class Plate:
    """One figure of the paper: its drawing, its numbers, and its caption."""

    stem: str  # of its files' names
    caption: str
    size: tuple[float, float]  # inches
    draw: Callable[[Figure], None]
    rows: Sequence[Mapping[str, Any]]  # of the CSV


def look(index: int) -> dict[str, Any]:
    """Return the colour, marker and line style of a function by its index; no two are the same."""
    return {
        "color": COLOURS[index % len(COLOURS)],
        "marker": MARKERS[index % len(MARKERS)],
        "linestyle": DASHES[(index + index // len(COLOURS)) % len(DASHES)],
    }


def wrapped(name: str) -> str:
    """Return a function's name for the side of a figure, in several lines if it is long."""
    return textwrap.fill(name, WRAP, break_long_words=False)


def bounded_spread(row: Mapping[str, Any]) -> tuple[float, float]:
    """Return the lengths of an error bar below and above an F-measure, limited to 0 to 1."""
    value, spread = row["f_measure"], row["f_measure_std"] or 0.0
    return min(spread, value), min(spread, 1 - value)


@contextmanager
def new_figure(size: tuple[float, float], dpi: int = DPI, **style: object) -> Iterator[Figure]:
    """Yield a figure of a size in inches, which is drawn and saved in `STYLE`.

    It does not use pyplot, which would look for a display.
    """
    import matplotlib
    from matplotlib.figure import Figure

    with matplotlib.rc_context(STYLE | style):
        yield Figure(figsize=size, dpi=dpi, layout="constrained")


def figure_bytes(figure: Figure, ending: str) -> bytes:
    """Return a figure as a file with the ending .png or .svg; the same drawing gives the same bytes."""
    file = io.BytesIO()
    figure.savefig(file, format=ending[1:], metadata={"Date": None} if ending == ".svg" else None)
    return file.getvalue()


def write_plate(plate: Plate, out: Path) -> list[Path]:
    """Write a figure as PNG, SVG and CSV, with empty cells for unknown values; return the paths.

    Raises
    ------
    InputError
        If they cannot be written.
    """
    with new_figure(plate.size) as figure:
        plate.draw(figure)
        paths = [write_bytes(out / f"{plate.stem}{end}", figure_bytes(figure, end)) for end in (".png", ".svg")]
    columns = list(plate.rows[0])
    rows = ([row.get(name) for name in columns] for row in plate.rows)
    return [*paths, write_csv(out / f"{plate.stem}.csv", columns, rows)]
