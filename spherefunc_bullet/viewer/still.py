"""A still picture of an object's points and its settled spheres, for browsers that cannot draw in 3D."""

from __future__ import annotations

import io
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ..clouds.cloud import Cloud
from ..formats.units import format_length
from .data import Panel, display
from .page import display_html

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from mpl_toolkits.mplot3d import Axes3D

POINTS, SPHERES = 6_000, 3_000  # drawn at most
INCHES, DOTS = 4.0, 80  # of a panel, and per inch
FINER = 120  # dots per inch of a picture that is looked at alone


def pictured(cloud: Cloud, panels: Sequence[Panel], drawn: Sequence[Panel], radius: float | None = None) -> str:
    """Return the markup of a display of panels, with a still picture of some of them in its place; see `display`."""
    return display_html(display(cloud, panels, radius), still_picture(cloud, drawn, radius))


def still_picture(cloud: Cloud, panels: Sequence[Panel], radius: float | None = None) -> bytes:
    """Return the panels side by side as a PNG file, seen from the front left, as they are at first.

    Parameters
    ----------
    radius : float, optional
        Of the layers that are drawn, metres; by default that of the first layer of the first panel.
    """
    radius = panels[0].layers[0].radius if radius is None else radius
    settled = []
    for panel in panels:
        centers = (layer.centers for layer in panel.layers if layer.radius == radius)
        settled.append((panel.title, next(centers, np.empty((0, 3)))))
    return png_of_figure(still_figure(cloud, settled))


def still_figure(cloud: Cloud, settled: Sequence[tuple[str, np.ndarray]], dots: int = DOTS) -> Figure:
    """Return a figure with a panel for each title and its settled centres (S, 3), metres."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(INCHES * len(settled), INCHES), dpi=dots, facecolor="white")
    FigureCanvasAgg(figure)
    for number, (title, centers) in enumerate(settled, 1):
        axes = figure.add_subplot(1, len(settled), number, projection="3d")
        draw_panel(axes, cloud, centers)
        axes.set_title(title)
    return figure


def explained_figure(cloud: Cloud, title: str, centers: np.ndarray, radius: float) -> Figure:
    """Return a figure of settled centres (S, 3), metres, with a scale bar and an explanation of its colours."""
    figure = still_figure(cloud, [(title, centers)], FINER)
    length = draw_scale_bar(figure.axes[0], cloud)
    note = (
        f"Grey: the object. Dots: spheres of radius {format_length(radius)} that settled,\n"
        f"from low (violet) to high (yellow). Black bar: {format_length(length)}."
    )
    figure.text(0.5, 0.02, note, ha="center", va="bottom", fontsize=8)
    return figure


def draw_scale_bar(axes: Axes3D, cloud: Cloud) -> float:
    """Draw a bar on the ground in front of the object, along x, and return its length, metres."""
    low, high = cloud.bounds
    length = round_length(0.5 * float(cloud.size[:2].max()))
    aside = low[1] - 0.08 * float(cloud.size.max())
    axes.plot([low[0], low[0] + length], [aside, aside], [low[2], low[2]], c="black", lw=2)
    axes.set_box_aspect([np.ptp(limits) for limits in (axes.get_xlim(), axes.get_ylim(), axes.get_zlim())])
    return length


def round_length(length: float) -> float:
    """Return the largest of 1, 2, 5, 10, 20... that is at most a length, in its unit.

    Examples
    --------
    >>> round_length(0.07), round_length(0.5), round_length(2.9)
    (0.05, 0.5, 2.0)
    """
    power = 10.0 ** np.floor(np.log10(length))
    return float(f"{max(step for step in (1, 2, 5) if step * power <= length * 1.000001) * power:.1g}")


def png_of_figure(figure: Figure) -> bytes:
    """Return a figure as a PNG file."""
    file = io.BytesIO()
    figure.savefig(file, format="png")
    return file.getvalue()


def draw_panel(axes: Axes3D, cloud: Cloud, centers: np.ndarray):
    """Draw the points of a cloud and settled centres (S, 3), metres; higher ones are brighter."""
    points, spheres = some(cloud.points, POINTS), some(centers, SPHERES)
    axes.scatter(*points.T, s=1, c="0.6", linewidths=0, depthshade=False)
    if len(spheres):
        axes.scatter(*spheres.T, s=14, c=spheres[:, 2], cmap="viridis", linewidths=0, depthshade=False)
    axes.set_box_aspect(np.maximum(cloud.size, 0.05 * cloud.size.max()))
    axes.view_init(elev=25, azim=-60)
    axes.set_axis_off()


def some(points: np.ndarray, count: int) -> np.ndarray:
    """Return at most this many rows, evenly spaced."""
    return points[:: max(1, -(-len(points) // count))]
