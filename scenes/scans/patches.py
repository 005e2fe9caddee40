"""Small flat pieces of a scan's surfaces: what floor, walls and gravity are found by."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..settings import SCAN
from .cells import cells


@dataclass(frozen=True, eq=False)
class Patches:
    """Pieces of surface, each about as large as a cell of the grid that they come from."""

    centers: np.ndarray  # (P, 3) float64, metres
    normals: np.ndarray  # (P, 3) float64, unit vectors, of either sign
    areas: np.ndarray  # (P,) float64, square metres, about
    thickness: np.ndarray  # (P,) float64, standard deviation across the surface, metres

    def __getitem__(self, chosen: np.ndarray) -> Patches:
        return Patches(self.centers[chosen], self.normals[chosen], self.areas[chosen], self.thickness[chosen])

    def __len__(self) -> int:
        return len(self.centers)


def find_patches(points: np.ndarray) -> Patches:
    """Return the flat pieces of a scan (N, 3), metres, of three sizes.

    Noise of a few centimetres, as of a Kinect at four metres, leaves small patches no direction; then the large ones
    still have one. Each counts a third of its area, so that what is flat in all sizes counts once.
    """
    sizes = [patches_of_size(points, side) for side in SCAN.patch_sides]
    names = ("centers", "normals", "areas", "thickness")
    return Patches(*(np.concatenate([getattr(size, name) for size in sizes]) for name in names))


def patches_of_size(points: np.ndarray, side: float) -> Patches:
    """Return the flat pieces of one size, metres."""
    grid = cells(points, side)
    spread, axes = np.linalg.eigh(grid.covariances)
    spread = np.sqrt(np.maximum(spread, 0))
    flat = (spread[:, 0] < SCAN.patch_thickness * spread[:, 1]) & (spread[:, 1] > 0.1 * side)
    flat &= grid.counts >= SCAN.patch_points
    # A square of side a spreads by a / sqrt(12) along each of its axes.
    areas = np.minimum(12 * spread[:, 1] * spread[:, 2], 1.5 * side**2) / len(SCAN.patch_sides)
    return Patches(grid.means[flat], axes[flat, :, 0], areas[flat], spread[flat, 0])
