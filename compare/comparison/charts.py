"""Charts of accuracy against time, and of time against drops, as SVG for the comparison's page."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.ticker import EngFormatter

from ..evaluation.protocol import PAPER
from ..pages.plates import GREY, INK, PALE, figure_bytes, look, new_figure
from .entries import ComparedRun, Comparison
from .significance import Report

ACROSS = 3  # functions in a row
WIDE, HIGH = 8.4, 3.2  # inches of a row
SHORTEST = 1e-4  # seconds: shorter times are drawn there, since the axis is logarithmic
PATHS = {"svg.fonttype": "path"}  # of letters, since a reader's machine may lack the font
DPI = 200  # of the parts that are drawn as pixels
FEWEST_RUNS = 5  # in a bin of the median line


@dataclass(frozen=True, kw_only=True)
class ChartMark:
    """The time of a simulator with some radii, and its F-measure for one function."""

    backend: int  # its place in the report
    label: str  # the radius in centimetres, or nothing for all radii
    seconds: float  # of the median object
    f_measure: float
    spread: float | None


def accuracy_chart(report: Report) -> str:
    """Return F-measures against seconds per object, one panel for each function, with the Pareto front, as SVG."""
    functions = list(report["functions"])
    rows = -(-len(functions) // ACROSS)
    with new_figure((WIDE * min(ACROSS, len(functions)) / ACROSS, HIGH * rows), DPI, **PATHS) as figure:
        panels = figure.subplots(rows, min(ACROSS, len(functions)), sharex=True, sharey=True, squeeze=False)
        for axes in panels.flat[len(functions) :]:
            axes.remove()
        for axes, function in zip(panels.flat, functions, strict=False):
            draw_function(axes, report, function)
        for axes in panels[:, 0]:
            axes.set_ylabel("F-measure")
        figure.supxlabel("time per object, median of all objects (logarithmic)", fontsize=8)
        figure.legend(handles=keys(report), loc="outside upper left", ncols=6, handlelength=1.8)
        return figure_bytes(figure, ".svg").decode()


def marks(report: Report, function: str) -> list[ChartMark]:
    """Return all marks of one function; a radius that is dropped on less than half of the objects has no median."""
    drawn = []
    for place, backend in enumerate(report["backends"].values()):
        alone = [(f"{100 * row['radius']:g}", row) for row in backend["by_radius"] if row["seconds_per_object"]]
        for label, row in [*(alone if len(backend["by_radius"]) > 1 else []), ("", backend)]:
            quality, seconds = row["functions"][function], max(row["seconds_per_object"], SHORTEST)
            figures = {"f_measure": quality["f_measure"], "spread": quality["f_measure_std"]}
            drawn.append(ChartMark(backend=place, label=label, seconds=seconds, **figures))
    return drawn


def front(drawn: Sequence[ChartMark]) -> list[ChartMark]:
    """Return the marks that no other mark dominates in time and F-measure, the quickest first."""
    best: list[ChartMark] = []
    for mark in sorted(drawn, key=lambda mark: (mark.seconds, -mark.f_measure)):
        if not best or mark.f_measure > best[-1].f_measure:
            best.append(mark)
    return best


def draw_function(axes: Axes, report: Report, function: str):
    """Draw one function's marks, front, best baseline and the paper's number."""
    drawn = marks(report, function)
    axes.set_xscale("log")
    axes.xaxis.set_major_formatter(EngFormatter(unit="s"))
    edge = front(drawn)
    seconds = [mark.seconds for mark in edge] + [3 * max(mark.seconds for mark in drawn)]
    f_measures = [mark.f_measure for mark in edge] + [edge[-1].f_measure]
    axes.step(seconds, f_measures, where="post", color=PALE, linewidth=4, zorder=1)
    baseline = max(row["functions"][function]["f_measure"] for row in report["baselines"].values())
    axes.axhline(baseline, color=GREY, linestyle="--", linewidth=1, zorder=2)
    if function in PAPER:
        axes.axhline(PAPER[function], color=INK, linestyle=":", linewidth=1, zorder=2)
    for mark in drawn:
        draw_mark(axes, mark)
    axes.set_title(f"{function} ({report['functions'][function]} of {report['objects']})", fontweight="bold")
    axes.grid(axis="y", linewidth=0.3, color="#dddddd")


def draw_mark(axes: Axes, mark: ChartMark):
    """Draw one mark: filled and with its spread for all radii together, open and with its number for one radius."""
    style = {"color": look(mark.backend)["color"], "linestyle": "none", "clip_on": False}
    if not mark.label:
        spread = None if mark.spread is None else [[mark.spread], [min(mark.spread, 1 - mark.f_measure)]]
        style |= {"marker": look(mark.backend)["marker"], "markersize": 9, "capsize": 2.5, "zorder": 4}
        axes.errorbar(mark.seconds, mark.f_measure, spread, **style)
        return
    axes.plot(mark.seconds, mark.f_measure, "o", markersize=11, markerfacecolor="white", zorder=3, **style)
    at = {"ha": "center", "va": "center_baseline", "fontsize": 6.5 if len(mark.label) < 3 else 5}
    axes.text(mark.seconds, mark.f_measure, mark.label, color=style["color"], zorder=3, **at)


def keys(report: Report) -> list:
    """Return the legend's entries."""
    plain = {"linestyle": "none", "color": INK}
    lines = [
        Line2D([], [], **plain | {key: look(place)[key] for key in ("color", "marker")}, markersize=8, label=name)
        for place, name in enumerate(report["backends"])
    ]
    lines += [
        Line2D([], [], **plain, marker="o", markersize=10, markerfacecolor="white", label="one radius alone (in cm)"),
        Line2D([], [], color=PALE, linewidth=4, label="best within the time"),
        Line2D([], [], color=GREY, linestyle="--", linewidth=1, label="best without spheres"),
    ]
    if PAPER.keys() & report["functions"].keys():
        lines.append(Line2D([], [], color=INK, linestyle=":", linewidth=1, label="the paper, on its own models"))
    return lines


def cost_chart(comparison: Comparison) -> str:
    """Return the seconds of every run against its drops, with each simulator's median, as SVG."""
    with new_figure((5.4, 3.4), DPI, **PATHS) as figure:
        axes = figure.add_subplot()
        for place, entry in enumerate(comparison.entries):
            drops, seconds = runs(entry)
            style = {"color": look(place)["color"], "marker": look(place)["marker"]}
            points = {"linestyle": "none", "markersize": 2.5, "alpha": 0.35, "markeredgewidth": 0}
            axes.plot(drops, seconds, **style, **points, rasterized=True)  # thousands of shapes would weigh megabytes
            axes.plot(*median_line(drops, seconds), color=style["color"], linewidth=2, label=entry.name)
        axes.set(xscale="log", yscale="log", xlabel="spheres dropped in one run", ylabel="seconds of the run")
        axes.grid(linewidth=0.3, color="#dddddd")
        figure.legend(loc="outside upper left", ncols=4)
        return figure_bytes(figure, ".svg").decode()


def runs(entry: ComparedRun) -> tuple[np.ndarray, np.ndarray]:
    """Return the drops and the seconds of each run with drops, for all objects and radii."""
    every = [(record, radius) for record in entry.records for radius in entry.radii if record.drops[radius]]
    pairs = [(record.drops[radius], max(record.seconds[radius], SHORTEST)) for record, radius in every]
    drops, seconds = np.array(pairs, float).reshape(-1, 2).T
    return drops, seconds


def median_line(drops: np.ndarray, seconds: np.ndarray) -> tuple[list[float], list[float]]:
    """Return the medians of drops and of seconds in bins of half a decade, where there are enough runs."""
    bins = np.floor(2 * np.log10(drops))
    full = [bins == number for number in np.unique(bins) if np.sum(bins == number) >= FEWEST_RUNS]
    return [float(np.median(drops[runs])) for runs in full], [float(np.median(seconds[runs])) for runs in full]
