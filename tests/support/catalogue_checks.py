"""What every object of a built-in catalogue must be, whichever catalogue it is of."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import trimesh
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from spherefunc_bullet.scenes.household.parts.legs import CatalogueObject

Range = tuple[float, float]  # metres


def flaws(objects: Sequence[CatalogueObject]) -> dict[str, list[str]]:
    """Return by name what is wrong with those objects that are not sound.

    Sound is a small mesh that is centred on the ground, closed as promised, and also for no function unheard of.
    """
    found = {}
    for item in objects:
        low, high = item.mesh.bounds
        also = set(filter(None, item.also.split(";")))
        holds = {
            "finite": np.isfinite(item.mesh.vertices).all(),
            "small": len(item.mesh.faces) <= 5000,
            # float64 round-off of a shift by at most a few metres
            "on the ground": abs(low[2]) < 1e-9,
            "centred": np.abs(low[:2] + high[:2]).max() < 1e-9,
            "closed as promised": item.mesh.is_watertight == item.watertight,
            "for other functions": also <= {"cup", "table", "sittable"} - {item.label},
        }
        found[item.name] = [name for name, true in holds.items() if not true]
    return {name: wrong for name, wrong in found.items() if wrong}


def odd_sizes(objects: Sequence[CatalogueObject], sizes: Mapping[str, tuple[Range, Range]]) -> dict[str, np.ndarray]:
    """Return by name the extents of objects whose height or larger horizontal side is not one of their label's."""
    found = {}
    for item in objects:
        (least, most), (narrow, wide) = sizes[item.label]
        width, depth, height = item.mesh.extents
        if not (least <= height <= most and narrow <= max(width, depth) <= wide):
            found[item.name] = item.mesh.extents
    return found


def unchanged(others: Sequence[CatalogueObject], objects: Sequence[CatalogueObject]) -> list[str]:
    """Return the names of those objects that have the same vertices in both catalogues, which name the same objects."""
    assert [item.name for item in others] == [item.name for item in objects]
    pairs = zip(others, objects, strict=True)
    return [item.name for other, item in pairs if np.array_equal(other.mesh.vertices, item.mesh.vertices)]


def identical(others: Sequence[CatalogueObject], objects: Sequence[CatalogueObject]) -> bool:
    """Return whether two catalogues are the same, bit for bit."""
    one, other = (
        [(item.name, item.mesh.vertices.tobytes(), item.mesh.faces.tobytes()) for item in catalogue]
        for catalogue in (others, objects)
    )
    return one == other


def groups_that_touch(mesh: trimesh.Trimesh) -> int:
    """Return how many groups of pieces there are, of which those of one group touch by their boxes, within 2 mm."""
    links = coo_matrix((np.ones(len(mesh.edges)), mesh.edges.T), shape=(len(mesh.vertices),) * 2)
    count, piece = connected_components(links, directed=False)
    lows = np.array([mesh.vertices[piece == k].min(axis=0) for k in range(count)])
    highs = np.array([mesh.vertices[piece == k].max(axis=0) for k in range(count)])
    apart = (lows[:, None] > highs[None] + 0.002).any(axis=2)
    return connected_components(~(apart | apart.T), directed=False, return_labels=False)
