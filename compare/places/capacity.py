"""Does a vessel hold as much as water does? Columns of water in a flood over solid voxels that shares no code."""

from __future__ import annotations

import numpy as np
import trimesh
from scipy import ndimage

from spherefunc_bullet.clouds.cloud import Cloud

CELLS = 110  # along the largest extent


def water_ml(cloud: Cloud) -> float:
    """Return what a mesh holds, millilitres: per layer, cells from which no way leads out at or below that layer.

    Walls are voxels that the surface meets; half of each that borders water is added.
    """
    mesh = trimesh.Trimesh(cloud.mesh.vertices, cloud.mesh.faces, process=False)
    pitch = float(cloud.size.max()) / CELLS
    wall = np.pad(mesh.voxelized(pitch).matrix, 2)
    wet = np.zeros_like(wall)
    below = np.zeros_like(wall)
    for layer in range(2, wall.shape[2] - 2):
        below[:, :, : layer + 1] = True
        dry = ndimage.label(~wall & below)[0]
        outside = dry[0, 0, 0]
        wet |= below & ~wall & (dry != outside) & open_above(wall, dry, outside, layer)
    halves = ndimage.binary_dilation(wet) & wall
    return float((wet.sum() + 0.5 * halves.sum()) * pitch**3 * 1e6)


def open_above(wall: np.ndarray, dry: np.ndarray, outside: int, layer: int) -> np.ndarray:
    """Return the cells of bodies whose uppermost layer is under the sky somewhere."""
    sky = ~np.logical_or.accumulate(wall[:, :, ::-1], axis=2)[:, :, ::-1]
    named = np.unique(dry[:, :, layer][sky[:, :, layer] & (dry[:, :, layer] != outside)])
    return np.isin(dry, named[named > 0])
