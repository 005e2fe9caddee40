"""Accuracy against time, and time against spheres, drawn as SVG for the comparison's page."""

from __future__ import annotations

import io
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from ..evaluation.protocol import PAPER
from ..pages.plates import GREY, INK, PALE, STYLE, look
from .entries import Contest, Entry

ACROSS = 3  # functions in a row
WIDE, HIGH = 8.4, 3.2  # inches of a row
SHORTEST = 1e-4  # seconds: what took less stands there, on an axis of logarithms
DPI = 200  # of what is drawn as pixels
FEWEST_RUNS = 5  # in a bin of the median line


@dataclass(frozen=True, kw_only=True)
class Mark:
    """A simulator with some radii: what it takes, and how well it tells one function."""

    backend: int  # by its place in the report
    label: str  # the radius in centimetres, or nothing for all of them
    seconds: float  # of the median object
    f_measure: float
    spread: float | None


def accuracy_chart(report: dict) -> str:
    """Return F-measures against seconds per object, one panel a function, with the Pareto front, as SVG."""
    functions = list(report["functions"])
    rows = -(-len(functions) // ACROSS)

    def draw(figure):
        """Draw the panels and what the marks mean."""
        panels = figure.subplots(rows, min(ACROSS, len(functions)), sharex=True, sharey=True, squeeze=False)
        for axes in panels.flat[len(functions) :]:
            axes.remove()
        for axes, function in zip(panels.flat, functions, strict=False):
            draw_function(axes, report, function)
        for axes in panels[:, 0]:
            axes.set_ylabel("F-measure")
        figure.supxlabel("time per object, median of all objects (logarithmic)", fontsize=8)
        figure.legend(handles=keys(report), loc="outside upper left", ncols=6, handlelength=1.8)

    return svg((WIDE * min(ACROSS, len(functions)) / ACROSS, HIGH * rows), draw)


def marks(report: dict, function: str) -> list[Mark]:
    """Return all marks of one function."""
    found = []
    for place, each in enumerate(report["backends"].values()):
        rows = [(f"{100 * row['radius']:g}", row) for row in each["by_radius"]]
        for label, row in [*(rows if len(rows) > 1 else []), ("", each)]:
            quality = row["functions"][function]
            seconds = max(row["seconds_per_object"], SHORTEST)
            found.append(
                Mark(
                    backend=place,
                    label=label,
                    seconds=seconds,
                    f_measure=quality["f_measure"],
                    spread=quality["f_measure_std"],
                )
            )
    return found


def front(found: Sequence[Mark]) -> list[Mark]:
    """Return the marks that no other beats in both time and F-measure, the quickest first."""
    best: list[Mark] = []
    for mark in sorted(found, key=lambda each: (each.seconds, -each.f_measure)):
        if not best or mark.f_measure > best[-1].f_measure:
            best.append(mark)
    return best


def draw_function(axes, report: dict, function: str):
    """Draw one function's marks, front, best baseline and the paper's number."""
    from matplotlib.ticker import FuncFormatter, LogLocator

    found = marks(report, function)
    axes.set(xscale="log", ylim=(0, 1.02))
    axes.xaxis.set_major_locator(LogLocator())
    axes.xaxis.set_major_formatter(FuncFormatter(lambda seconds, _: spoken_tick(seconds)))
    edge = front(found)
    last = max(each.seconds for each in found) * 3
    axes.step(
        [each.seconds for each in edge] + [last],
        [each.f_measure for each in edge] + [edge[-1].f_measure],
        where="post",
        color=PALE,
        linewidth=4,
        zorder=1,
    )
    axes.axhline(best_baseline(report, function), color=GREY, linestyle="--", linewidth=1, zorder=2)
    if function in PAPER:
        axes.axhline(PAPER[function], color=INK, linestyle=":", linewidth=1, zorder=2)
    for each in found:
        draw_mark(axes, each)
    axes.set_title(f"{function} ({report['functions'][function]} of {report['objects']})", fontweight="bold")
    axes.grid(axis="y", linewidth=0.3, color="#dddddd")


def spoken_tick(seconds: float) -> str:
    """Return a power of ten of seconds as a label.

    Examples
    --------
    >>> spoken_tick(0.01), spoken_tick(10)
    ('10 ms', '10 s')
    """
    return f"{1000 * seconds:g} ms" if seconds < 1 else f"{seconds:g} s"


def draw_mark(axes, mark: Mark):
    """Draw one mark: all radii together filled and with their spread, one radius open and with its number."""
    style = {"color": look(mark.backend)["color"], "linestyle": "none", "clip_on": False}
    if not mark.label:
        spread = None if mark.spread is None else [[mark.spread], [min(mark.spread, 1 - mark.f_measure)]]
        shape = look(mark.backend)["marker"]
        style |= {"markersize": 9, "capsize": 2.5, "zorder": 4}
        axes.errorbar(mark.seconds, mark.f_measure, spread, marker=shape, **style)
        return
    axes.plot(mark.seconds, mark.f_measure, "o", markersize=11, markerfacecolor="white", zorder=3, **style)
    at = {"ha": "center", "va": "center_baseline", "fontsize": 6.5 if len(mark.label) < 3 else 5}
    axes.text(mark.seconds, mark.f_measure, mark.label, color=style["color"], zorder=3, **at)


def best_baseline(report: dict, function: str) -> float:
    """Return the F-measure of the baseline that tells a function best."""
    return max(each["functions"][function]["f_measure"] for each in report["baselines"].values())


def keys(report: dict) -> list:
    """Return what the marks and lines mean."""
    from matplotlib.lines import Line2D

    plain = {"linestyle": "none"}
    found = [
        Line2D([], [], **plain | {key: look(place)[key] for key in ("color", "marker")}, markersize=8, label=name)
        for place, name in enumerate(report["backends"])
    ]
    circle = {"marker": "o", "markersize": 10, "markerfacecolor": "white", "color": INK}
    found.append(Line2D([], [], **plain, **circle, label="one radius alone, cm"))
    found.append(Line2D([], [], color=PALE, linewidth=4, label="Pareto front"))
    found.append(Line2D([], [], color=GREY, linestyle="--", linewidth=1, label="best baseline, no spheres"))
    if PAPER.keys() & report["functions"].keys():
        found.append(Line2D([], [], color=INK, linestyle=":", linewidth=1, label="the paper, its own models"))
    return found


def cost_chart(contest: Contest) -> str:
    """Return the seconds of every run against its drops, with each simulator's median, as SVG."""

    def draw(figure):
        """Draw the points and lines of every simulator."""
        axes = figure.add_subplot()
        for place, entry in enumerate(contest.entries):
            drops, seconds = runs(entry)
            style = {"color": look(place)["color"], "marker": look(place)["marker"]}
            points = {"linestyle": "none", "markersize": 2.5, "alpha": 0.35, "markeredgewidth": 0}
            axes.plot(drops, seconds, **style, **points, rasterized=True)  # thousands of shapes would weigh megabytes
            axes.plot(*median_line(drops, seconds), color=style["color"], linewidth=2, label=entry.contestant.name)
        axes.set(xscale="log", yscale="log", xlabel="spheres dropped in one run", ylabel="seconds of the run")
        axes.grid(linewidth=0.3, color="#dddddd")
        figure.legend(loc="outside upper left", ncols=4)

    return svg((5.4, 3.4), draw)


def runs(entry: Entry) -> tuple[np.ndarray, np.ndarray]:
    """Return the drops and the seconds of each run in which spheres were dropped, of all objects and radii."""
    pairs = [
        (record.drops[radius], max(record.seconds[radius], SHORTEST))
        for record in entry.simulated.records
        for radius in entry.contestant.radii
        if record.drops[radius]
    ]
    drops, seconds = np.array(pairs, float).reshape(-1, 2).T
    return drops, seconds


def median_line(drops: np.ndarray, seconds: np.ndarray) -> tuple[list[float], list[float]]:
    """Return the medians of drops and of seconds in bins of half a power of ten, where there are enough runs."""
    bins = np.floor(2 * np.log10(drops))
    held = [bins == each for each in np.unique(bins)]
    held = [each for each in held if each.sum() >= FEWEST_RUNS]
    return [float(np.median(drops[each])) for each in held], [float(np.median(seconds[each])) for each in held]


def svg(size: tuple[float, float], draw: Callable) -> str:
    """Return a drawing of a size in inches as SVG; letters as paths, since a reader's machine may lack the font."""
    import matplotlib
    from matplotlib.figure import Figure

    with matplotlib.rc_context(STYLE | {"svg.fonttype": "path"}):
        figure = Figure(figsize=size, layout="constrained")
        draw(figure)
        buffer = io.StringIO()
        figure.savefig(buffer, format="svg", dpi=DPI, metadata={"Date": None})
    return buffer.getvalue()
