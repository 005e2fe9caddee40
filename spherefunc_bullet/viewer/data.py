"""The data of a display, as JSON: an object, its settled spheres, and the cubes of its histogram (paper, Fig. 2).

Positions are 16-bit steps from the lowest corner, finer than a fifteenth of a millimetre up to 4 m.
"""

from __future__ import annotations

import base64
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ..clouds.cloud import Cloud, Mesh
from .colours import FLAT, HEIGHT_COLOURS

if TYPE_CHECKING:
    from ..learning.reasons.cubes import Cubes

MAX_FACES = 100_000  # of a mesh; finer ones are thinned, so that a page of 8 MB holds several displays
MAX_POINTS = 60_000  # of a cloud, for the same reason
STEPS = 65_535  # along the longest side


@dataclass(frozen=True, kw_only=True, eq=False)
class Layer:
    """The content of a panel for one radius."""

    radius: float  # metres
    centers: np.ndarray  # (S, 3) float, settled spheres, metres, the object's frame
    cubes: Cubes
    note: str  # plain text below the picture
    details: str = ""  # HTML below the note


@dataclass(frozen=True, kw_only=True, eq=False)
class Panel:
    """One of several pictures side by side, of one backend or about one function."""

    title: str
    layers: Sequence[Layer]  # one per radius


def display(cloud: Cloud, panels: Sequence[Panel], radius: float | None = None) -> dict:
    """Return one object in several panels, which turn and switch together, ready for JSON.

    Parameters
    ----------
    cloud : Cloud
        Drawn as its mesh where it has one.
    panels : sequence of Panel
        Where cubes have ``speaks_for``, they are coloured by it, and spheres are hidden at first.
    radius : float, optional
        Of the layers shown at first, metres; by default that of the first layer of the first panel.
    """
    layers = [layer for panel in panels for layer in panel.layers]
    spheres = {id(layer.centers): layer for layer in layers}  # panels about functions share their spheres
    names = {key: number for number, key in enumerate(spheres)}
    explains = any(layer.cubes.speaks_for is not None for layer in layers)
    radius = layers[0].radius if radius is None else radius
    low, high = frame(cloud, layers, radius)
    return {
        "name": cloud.name,
        "explains": explains,
        "radius": radius,
        "low": rounded(low),
        "high": rounded(high),
        "object": object_data(cloud),
        "height_colours": rounded(HEIGHT_COLOURS),
        "flat": FLAT,
        "spheres": [quantised(layer.centers) | {"radius": layer.radius} for layer in spheres.values()],
        "panels": [panel_data(panel, names) for panel in panels],
    }


def panel_data(panel: Panel, names: dict[int, int]) -> dict:
    """Return a panel for JSON, with its spheres given by number."""
    layers = [
        {
            "radius": layer.radius,
            "spheres": names[id(layer.centers)],
            "cubes": cubes_data(layer.cubes),
            "note": layer.note,
            "details": layer.details,
        }
        for layer in panel.layers
    ]
    return {"title": panel.title, "layers": layers}


def frame(cloud: Cloud, layers: Sequence[Layer], radius: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the lowest and highest corner (3,) of the object, spheres of a radius, and cubes that explain, metres."""
    points = [cloud.bounds]
    for layer in (shown for shown in layers if shown.radius == radius):
        centers, held = np.reshape(layer.centers, (-1, 3)), layer.cubes.corners[layer.cubes.counts > 0]
        points += [centers - radius, centers + radius]
        points += [held, held + layer.cubes.side] if layer.cubes.speaks_for is not None else []
    every = np.concatenate(points)
    return every.min(axis=0), every.max(axis=0)


def sphere_layer(radius: float, centers: np.ndarray, note: str) -> Layer:
    """Return the layer of settled centres (S, 3), metres, with the cubes that hold them."""
    return Layer(radius=radius, centers=centers, cubes=histogram_cubes(centers, radius), note=note)


def histogram_cubes(centers: np.ndarray, radius: float) -> Cubes:
    """Return the cubes of the default histogram that hold centres (S, 3), metres."""
    # Not above, since they load scikit-learn, which takes a second, and pages of scans show no cubes.
    from ..learning.histogram import CubeHistogram, counted_cubes
    from ..learning.reasons.cubes import Cubes, corners

    histogram = CubeHistogram(radius)
    keys, counts = counted_cubes(np.asarray(centers, float), histogram.side)
    return Cubes(side=histogram.side, corners=corners(keys, histogram.side), counts=counts)


def cubes_data(cubes: Cubes) -> dict:
    """Return cubes for JSON."""
    names = ["corners", "counts"] + ["members", "others", "speaks_for"] * (cubes.speaks_for is not None)
    return {"side": cubes.side} | {name: packed(getattr(cubes, name).ravel(), np.float32) for name in names}


def object_data(cloud: Cloud) -> dict:
    """Return a cloud's mesh, or its points and the radius to draw them with, for JSON."""
    if cloud.mesh is not None:
        mesh = thinned(cloud.mesh)
        kind = np.uint16 if len(mesh.vertices) <= STEPS else np.uint32
        faces = {"faces": packed(mesh.faces.ravel(), kind), "wide": kind is np.uint32}
        return quantised(mesh.vertices) | faces
    points = cloud.points[:: -(-len(cloud.points) // MAX_POINTS)]
    return quantised(points) | {"radius": 0.6 * Cloud(points).spacing}


def thinned(mesh: Mesh) -> Mesh:
    """Return a mesh of at most MAX_FACES faces, in which the vertices within a cell are merged."""
    cells = 1024  # along the longest side
    while len(mesh.faces) > MAX_FACES:
        mesh = clustered(mesh, np.ptp(mesh.vertices, axis=0).max() / cells)
        cells = int(cells / 1.3)
    return mesh


def clustered(mesh: Mesh, cell: float) -> Mesh:
    """Return a mesh whose vertices within a cell, of a side in metres, are merged, without faces that vanish."""
    cells = np.floor((mesh.vertices - mesh.vertices.min(axis=0)) / cell).astype(np.int64)
    _, first, merged = np.unique(cells, axis=0, return_index=True, return_inverse=True)
    faces = merged.ravel()[mesh.faces]
    differ = (faces != np.roll(faces, 1, axis=1)).all(axis=1)
    return Mesh(mesh.vertices[first], faces[differ])


def quantised(points: np.ndarray) -> dict:
    """Return points (N, 3) in metres as steps from their lowest corner."""
    points = np.asarray(points, float).reshape(-1, 3)
    low = points.min(axis=0) if len(points) else np.zeros(3)
    step = max(float(np.ptp(points, axis=0).max()) if len(points) else 0.0, 1e-9) / STEPS
    return {"start": low.tolist(), "step": step, "positions": packed(np.rint((points - low) / step).ravel(), np.uint16)}


def packed(values: np.ndarray, kind: type) -> str:
    """Return numbers as base64 of their little-endian bytes."""
    return base64.b64encode(np.ascontiguousarray(values, np.dtype(kind).newbyteorder("<")).tobytes()).decode()


def rounded(values: np.ndarray) -> list:
    """Return numbers rounded to five decimals, as lists."""
    return np.round(values, 5).tolist()
