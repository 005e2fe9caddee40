"""The histogram explained in two dimensions: a vertical slice through one object (paper, Fig. 2)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import EllipseCollection
from matplotlib.figure import Figure

from spherefunc_bullet.formats.units import format_length
from spherefunc_bullet.learning.histogram import counted_cubes, cube_indices, histogram_of

from ..pages.plates import COLOURS, DOUBLE, GREY, INK, Plate
from .evaluated_data import EvaluatedData
from .typical_objects import exhibits, picture_radius

CUBES_ACROSS = 6  # cubes along the object's largest extent, about: enough to see a shape, few enough to read
PANEL, HIGHEST, TITLES = 2.1, 2.2, 0.65  # inches: a panel's width and largest height, and what stands around it


@dataclass(frozen=True, kw_only=True)
class Slice:
    """The middle layer of an object's cubes, seen from the side."""

    index: int  # in the data
    axis: int  # the axis to the right: 0 for x, 1 for y
    radius: float  # metres
    side: float  # of a cube, metres
    centers: np.ndarray  # (S, 2) of the spheres in the layer, metres
    cubes: np.ndarray  # (V, 2) int, across and up
    counts: np.ndarray  # (V,) int, spheres in each


def histogram_slice(data: EvaluatedData) -> Plate:
    """Return Fig. 2: spheres at rest, the cubes around them, and the number of spheres in each cube."""
    shown = [exhibit.index for exhibit in exhibits(data) if exhibit.score is not None]
    cut = max((cut_slice(data, index, axis) for index in shown for axis in (0, 1)), key=variety)
    points = data.cloud(cut.index).points
    across, up = np.ptp(frame(cut, points[:, [cut.axis, 2]]), axis=0)
    name = data.simulated.objects[cut.index].path.name
    return Plate(
        stem="fig2_histogram",
        caption=f"The histogram, explained in the middle layer of the cubes around {name} ({data.name}). "
        f"(a) The object's points, dark in the layer and pale outside it, and the spheres of "
        f"{format_length(cut.radius)} radius that came to rest in the layer, which is one cube thick. (b) Space is "
        f"divided into cubes of {format_length(cut.side)}, {data.evaluation.method.diameters:g} sphere diameters; a "
        "sphere belongs to the cube that holds its centre. (c) The number of spheres in each cube is one entry of the "
        "feature vector; empty cubes are zeros.",
        size=(DOUBLE, TITLES + min(PANEL * up / across, HIGHEST)),
        draw=lambda figure: draw_slice(figure, points, cut),
        rows=[
            {"across": int(x), "up": int(z), "spheres": int(count), "cube_side": cut.side, "radius": cut.radius}
            for (x, z), count in zip(cut.cubes, cut.counts, strict=True)
        ],
    )


def variety(cut: Slice) -> tuple[bool, int]:
    """Return how informative a slice is: spheres at several heights, and many full and empty cubes."""
    if not len(cut.cubes):
        return False, -1
    columns, rows = np.ptp(cut.cubes[:, 0]) + 1, cut.cubes[:, 1].max() + 1
    return bool(np.ptp(cut.cubes[:, 1])), int(len(cut.cubes) * (columns * rows - len(cut.cubes)))


def cut_slice(data: EvaluatedData, index: int, axis: int) -> Slice:
    """Return an object's slice along x (``axis`` 0) or y (1)."""
    method = data.evaluation.method
    radius = picture_radius(data, index, CUBES_ACROSS * 2 * method.diameters)
    histogram = histogram_of(method, radius)
    centers = np.asarray(data.simulated.records[index].centers(radius), float)
    layer = centers[np.abs(centers[:, 1 - axis]) < histogram.side / 2]
    keys, counts = counted_cubes(layer, histogram.side)
    return Slice(
        index=index,
        axis=axis,
        radius=radius,
        side=histogram.side,
        centers=layer[:, [axis, 2]],
        cubes=cube_indices(keys)[:, [axis, 2]],
        counts=counts.astype(int),
    )


def draw_slice(figure: Figure, points: np.ndarray, cut: Slice):
    """Draw the three panels: spheres, cubes, counts; with the object's points (N, 3) in metres."""
    inside = np.abs(points[:, 1 - cut.axis]) < cut.side / 2
    points = points[:, [cut.axis, 2]]
    low, high = frame(cut, points)
    panels = figure.subplots(1, 3, sharex=True, sharey=True)
    titles = ("spheres at rest", "cubes of space", "spheres in each cube")
    for axes, letter, words in zip(panels, "abc", titles, strict=True):
        # Thousands of points: as an image they keep the SVG small.
        dots = {"marker": ".", "linestyle": "none", "markersize": 1, "markeredgewidth": 0, "rasterized": True}
        axes.plot(*points[~inside].T, color="#dddddd", zorder=0.3, **dots)
        axes.plot(*points[inside].T, color=GREY, zorder=1, **dots)
        axes.set_title(f"({letter}) {words}", loc="left", fontweight="bold")
        axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal")
        axes.set_xlabel(f"{'xy'[cut.axis]} (m)")
        axes.locator_params(axis="x", nbins=5)
    panels[0].set_ylabel("height z (m)")
    draw_spheres(panels[0], cut, filled=True)
    draw_spheres(panels[1], cut, filled=False)
    for axes in panels[1:]:
        draw_grid(axes, cut, low, high)
    draw_counts(panels[2], cut)


def frame(cut: Slice, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the lowest and highest corner (2,) of the cubes around all points and spheres, metres."""
    seen = np.concatenate([points, cut.centers - cut.radius, cut.centers + cut.radius, [[0.0, 0.0]]])
    half = np.array([0.5, 0.0])
    low = (np.floor(seen.min(axis=0) / cut.side + half) - half) * cut.side
    low[1] = 0.0  # the floor, below which nothing is counted
    return low, (np.floor(seen.max(axis=0) / cut.side + half) - half + 1) * cut.side


def draw_spheres(axes: Axes, cut: Slice, filled: bool):
    """Draw the spheres as circles in their true size, filled or with their centres."""
    style = {"facecolors": COLOURS[5], "alpha": 0.6} if filled else {"facecolors": "none", "alpha": 0.35}
    style |= {"edgecolors": COLOURS[0], "linewidths": 0.4, "zorder": 2}
    diameter, at = 2 * cut.radius, {"offsets": cut.centers, "offset_transform": axes.transData}
    axes.add_collection(EllipseCollection(diameter, diameter, 0, units="xy", **at, **style))
    if not filled:
        axes.plot(*cut.centers.T, ".", color=COLOURS[0], markersize=2.2, markeredgewidth=0, zorder=3)


def draw_grid(axes: Axes, cut: Slice, low: np.ndarray, high: np.ndarray):
    """Draw the boundaries between cubes."""
    for draw, lowest, highest in zip((axes.axvline, axes.axhline), low, high, strict=True):
        for line in np.arange(lowest, highest + cut.side / 2, cut.side):
            draw(line, color=GREY, linewidth=0.5, zorder=0.5, clip_on=False)


def draw_counts(axes: Axes, cut: Slice):
    """Fill the cubes with the colour of their number of spheres, and write the number."""
    import matplotlib

    ramp, most = matplotlib.colormaps["cividis"], cut.counts.max()
    for (x, z), count in zip(cut.cubes, cut.counts, strict=True):
        # The middle cube is centred on the axis; the floor is a boundary.
        corner = ((x - 0.5) * cut.side, z * cut.side)
        box = matplotlib.patches.Rectangle(corner, cut.side, cut.side, color=ramp(count / most), alpha=0.9, zorder=2)
        axes.add_patch(box)
        middle = (corner[0] + cut.side / 2, corner[1] + cut.side / 2)
        axes.text(*middle, count, ha="center", va="center", color=INK if count > most / 2 else "white", zorder=3)
