"""A catalogue's objects in other proportions: each wider, deeper or higher, or less so, than its builder makes it."""

from __future__ import annotations

import zlib
from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from .family import CatalogueObject


def stretched(objects: Iterable[CatalogueObject], share: float, seed: int) -> list[CatalogueObject]:
    """Return objects, each stretched along x, y and z by factors of its own.

    Parameters
    ----------
    objects : iterable of CatalogueObject
        With meshes that stand on z = 0.
    share : float
        By how much at most, up or down: 0.15 is from a factor of 1 / 1.15 to one of 1.15.
    seed : int
    """
    return [replace(item, mesh=stretched_mesh(item, share, seed)) for item in objects]


def stretched_mesh(item: CatalogueObject, share: float, seed: int):
    """Return an object's mesh, stretched; what becomes of it depends on its name and the seed alone."""
    rng = np.random.default_rng([seed, zlib.crc32(item.name.encode()), 5])
    mesh = item.mesh.copy()
    mesh.apply_scale((1 + share) ** rng.uniform(-1, 1, 3))
    return mesh
