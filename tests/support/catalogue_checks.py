"""What every object of a built-in catalogue must be, whichever catalogue it is of."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import pytest
import trimesh
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from spherefunc_bullet.scenes.household.parts.legs import CatalogueObject

Range = tuple[float, float]  # metres


def named(objects: Sequence[CatalogueObject]) -> pytest.MarkDecorator:
    """Return what runs a test on each object, under its name."""
    return pytest.mark.parametrize("item", objects, ids=[item.name for item in objects])


def require_sound(item: CatalogueObject):
    """Require a small mesh that is centred on the ground, closed as promised, and also for no function unheard of."""
    mesh = item.mesh
    low, high = mesh.bounds
    assert np.isfinite(mesh.vertices).all() and len(mesh.faces) <= 5000
    # float64 round-off of a shift by at most a few metres
    assert abs(low[2]) < 1e-9 and np.abs(low[:2] + high[:2]).max() < 1e-9
    assert mesh.is_watertight == item.watertight
    assert set(filter(None, item.also.split(";"))) <= {"cup", "table", "sittable"} - {item.label}


def require_size(item: CatalogueObject, sizes: Mapping[str, tuple[Range, Range]]):
    """Require a height and a larger horizontal side within those of the object's label."""
    (least, most), (narrow, wide) = sizes[item.label]
    width, depth, height = item.mesh.extents
    assert least <= height <= most and narrow <= max(width, depth) <= wide


def pieces_that_touch(mesh: trimesh.Trimesh) -> tuple[int, np.ndarray, np.ndarray]:
    """Return how many groups of pieces touch by their boxes, within 2 mm, each piece's group (P,) and its lowest z."""
    links = coo_matrix((np.ones(len(mesh.edges)), mesh.edges.T), shape=(len(mesh.vertices),) * 2)
    count, piece = connected_components(links, directed=False)
    lows = np.array([mesh.vertices[piece == k].min(axis=0) for k in range(count)])
    highs = np.array([mesh.vertices[piece == k].max(axis=0) for k in range(count)])
    apart = (lows[:, None] > highs[None] + 0.002).any(axis=2)
    groups, group = connected_components(~(apart | apart.T), directed=False)
    return groups, group, lows[:, 2]


def require_others_as_sound(others, objects, sizes: Mapping[str, tuple[Range, Range]]):
    """Require that another seed's objects have the same names, other meshes, and are sound and plausible as well."""
    assert [item.name for item in others] == [item.name for item in objects]
    pairs = zip(others, objects, strict=True)
    assert not any(np.array_equal(other.mesh.vertices, item.mesh.vertices) for other, item in pairs)
    for item in others:
        require_sound(item)
        require_size(item, sizes)
