"""Where objects find room: footprints on a grid, free places on a floor and on table tops."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

CELL = 0.02  # metres, of the grids that footprints are drawn on
LEVEL = 0.005  # metres: what a top may vary by and still carry a cup


@dataclass(frozen=True, eq=False)
class Ground:
    """A level ground with what stands on it: the floor, or a table top."""

    corner: np.ndarray  # (2,) x and y of the grid's corner, metres
    height: float  # metres
    blocked: np.ndarray  # (X, Y) bool, cells that carry nothing
    taken: np.ndarray  # (X, Y) bool, cells below what stands there already

    def place(self, points: np.ndarray, gap: float, rng: np.random.Generator) -> np.ndarray | None:
        """Return a free place (3,) for an object, at random, and take it; None if there is none.

        Parameters
        ----------
        points : (N, 3) float64, metres
            The object as it will stand, about the origin of x and y.
        gap : float, metres
            The least distance to what stands on the ground already, seen from above.
        """
        own = footprint(points[:, :2])
        free = fits(self.blocked, own) & fits(self.taken, widened(own, gap))
        places = np.argwhere(free)
        if not len(places):
            return None
        place = places[rng.integers(len(places))]
        self.stamp(own, place)
        return np.append(self.corner + (place + 0.5) * CELL, self.height)

    def stamp(self, own: np.ndarray, place: np.ndarray):
        """Take the cells of a footprint."""
        half = np.array(own.shape) // 2
        cells = np.argwhere(own) + place - half
        self.taken[tuple(cells.T)] = True


def floor_of(width: float, depth: float) -> Ground:
    """Return the empty floor of a room whose walls stand at x = 0, x = width, y = 0 and y = depth."""
    shape = (int(width / CELL), int(depth / CELL))
    return Ground(np.zeros(2), 0.0, np.zeros(shape, bool), np.zeros(shape, bool))


def top_of(points: np.ndarray) -> Ground:
    """Return the largest level top of an object that stands in a room, seen from above.

    Parameters
    ----------
    points : (N, 3) float64, metres
        In the room's frame, no farther from each other than a cell.
    """
    corner = points[:, :2].min(axis=0)
    cells = ((points[:, :2] - corner) / CELL).astype(int)
    heights = np.full(cells.max(axis=0) + 1, -np.inf)
    np.maximum.at(heights, tuple(cells.T), points[:, 2])
    steps = np.round(heights[np.isfinite(heights)] / LEVEL).astype(int)
    height = np.argmax(np.bincount(steps)) * LEVEL
    level = np.abs(heights - height) <= LEVEL
    return Ground(corner, float(heights[level].max()), ~level, np.zeros(level.shape, bool))


def footprint(xy: np.ndarray) -> np.ndarray:
    """Return the cells below points (N, 2), a bool array of odd sides with the origin in the middle."""
    cells = np.floor(xy / CELL + 0.5).astype(int)
    half = np.abs(cells).max(axis=0)
    own = np.zeros(2 * half + 1, bool)
    own[tuple((cells + half).T)] = True
    return own


def widened(own: np.ndarray, gap: float) -> np.ndarray:
    """Return a footprint with all cells within a gap of it."""
    from scipy.ndimage import distance_transform_edt

    padded = np.pad(own, int(np.ceil(gap / CELL)))
    return distance_transform_edt(~padded) * CELL <= gap


def fits(occupied: np.ndarray, own: np.ndarray) -> np.ndarray:
    """Return the cells at which a footprint's middle may stand so that it lies on no occupied cell, nor outside."""
    from scipy.signal import correlate

    padded = np.pad(occupied, [(side // 2, side // 2) for side in own.shape], constant_values=True)
    overlap = correlate(padded.astype(np.float32), own.astype(np.float32), mode="valid", method="fft")
    return overlap < 0.5
