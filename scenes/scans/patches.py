"""Small flat pieces of a scan's surfaces: what floor, walls and gravity are found by."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .cells import cells

_MIN_POINTS = 8  # that a patch's plane is fitted to
_FLAT = 0.35  # most that a patch may be as thick as wide: noise of 4 cm over 10 cm still passes
_CELLS_ACROSS = 40  # patches along a scan, about: a table top still has hundreds
TRIED = 500  # directions or planes, of a scan that is a third floor all but certain to hold one of it
_SIDES = (0.03, 0.10)  # metres: finer, noise tilts the patches; coarser, they bridge two surfaces


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


def patch_side(points: np.ndarray) -> float:
    """Return the side in metres of the cells for a scan's patches (N, 3), by the scan's extent."""
    low, high = np.percentile(points, [5, 95], axis=0)
    return float(np.clip((high - low).max() / _CELLS_ACROSS, *_SIDES))


def find_patches(points: np.ndarray, side: float) -> Patches:
    """Return the flat pieces of a scan, of two sizes.

    Noise of a few centimetres, as of a Kinect at four metres, leaves small patches no direction; then the large ones,
    four times as wide, still have one. Where both are flat a surface counts twice, wherever it lies.

    Parameters
    ----------
    points : (N, 3) float64, metres
    side : float
        Of a patch, metres.
    """
    small, large = patches_of_size(points, side), patches_of_size(points, 4 * side)
    names = ("centers", "normals", "areas", "thickness")
    return Patches(*(np.concatenate([getattr(small, name), getattr(large, name)]) for name in names))


def patches_of_size(points: np.ndarray, side: float) -> Patches:
    """Return the flat pieces of one size, metres."""
    grid = cells(points, side)
    spread, axes = np.linalg.eigh(grid.covariances)
    spread = np.sqrt(np.maximum(spread, 0))
    flat = (grid.counts >= _MIN_POINTS) & (spread[:, 0] < _FLAT * spread[:, 1]) & (spread[:, 1] > 0.1 * side)
    # A square of side a spreads by a / sqrt(12) along each of its axes.
    areas = np.minimum(12 * spread[:, 1] * spread[:, 2], 1.5 * side**2)
    return Patches(grid.means[flat], axes[flat, :, 0], areas[flat], spread[flat, 0])
