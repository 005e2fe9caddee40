"""A picture that stands still, for browsers that draw no 3D: the object's points and its settled spheres."""

from __future__ import annotations

import io
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ..clouds.cloud import Cloud
from .data import Panel

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from mpl_toolkits.mplot3d import Axes3D

POINTS, SPHERES = 6_000, 3_000  # drawn at most
INCHES, DOTS = 4.0, 80  # of a panel, and per inch


def still_picture(cloud: Cloud, panels: Sequence[Panel], radius: float | None = None) -> bytes:
    """Return the panels side by side as a PNG file, from the front and the left, as they are at first.

    Parameters
    ----------
    radius : float, optional
        Of the layers that are drawn, metres; the first panel's first without it.
    """
    radius = panels[0].layers[0].radius if radius is None else radius
    settled = []
    for panel in panels:
        centers = [layer.centers for layer in panel.layers if layer.radius == radius]
        settled.append((panel.title, centers[0] if centers else np.empty((0, 3))))
    return png_of_figure(still_figure(cloud, settled))


def still_figure(cloud: Cloud, settled: Sequence[tuple[str, np.ndarray]]) -> Figure:
    """Return a figure with a panel for each title and its settled centres (S, 3), metres."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(INCHES * len(settled), INCHES), dpi=DOTS, facecolor="white")
    FigureCanvasAgg(figure)
    for number, (title, centers) in enumerate(settled, 1):
        axes = figure.add_subplot(1, len(settled), number, projection="3d")
        draw_panel(axes, cloud, centers)
        axes.set_title(title)
    return figure


def png_of_figure(figure: Figure) -> bytes:
    """Return a figure as a PNG file."""
    file = io.BytesIO()
    figure.savefig(file, format="png")
    return file.getvalue()


def draw_panel(axes: Axes3D, cloud: Cloud, centers: np.ndarray):
    """Draw the points of a cloud and settled centres (S, 3), metres, those that are higher brighter."""
    points, spheres = some(cloud.points, POINTS), some(centers, SPHERES)
    axes.scatter(*points.T, s=1, c="0.6", linewidths=0, depthshade=False)
    if len(spheres):
        axes.scatter(*spheres.T, s=14, c=spheres[:, 2], cmap="viridis", linewidths=0, depthshade=False)
    axes.set_box_aspect(np.maximum(cloud.size, 0.05 * cloud.size.max()))
    axes.view_init(elev=25, azim=-60)
    axes.set_axis_off()


def some(points: np.ndarray, count: int) -> np.ndarray:
    """Return at most so many rows, evenly chosen."""
    return points[:: max(1, -(-len(points) // count))]
