"""Free places for objects: footprints on a grid, on a floor and on table tops."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

CELL = 0.02  # metres, of the grids that footprints are drawn on
LEVEL = 0.005  # metres by which the height of a top may vary
BOARD = 0.6  # of a shelf's footprint, the least that a board fills
THICK = 0.05  # metres: the thickest board


@dataclass(frozen=True, eq=False)
class Ground:
    """A level ground, the floor or a table top, and its occupied cells."""

    corner: np.ndarray  # (2,) x and y of the grid's corner, metres
    height: float  # metres
    blocked: np.ndarray  # (X, Y) bool, cells that carry nothing
    taken: np.ndarray  # (X, Y) bool, cells below objects that stand there already

    def place(self, points: np.ndarray, gap: float, rng: np.random.Generator) -> np.ndarray | None:
        """Return a random free place (3,) for an object, and take it; None if there is none.

        Parameters
        ----------
        points : (N, 3) float64, metres
            The object as it will stand, about the origin of x and y.
        gap : float, metres
            The least distance to objects that stand on the ground already, seen from above.
        """
        mask = footprint(points[:, :2])
        places = np.argwhere(fits(self.blocked, mask) & fits(self.taken, widened(mask, gap)))
        return self.stamp(mask, places[rng.integers(len(places))]) if len(places) else None

    def place_at_wall(
        self, points: np.ndarray, outward: np.ndarray, gap: float, rng: np.random.Generator
    ) -> np.ndarray | None:
        """Return a free place (3,) for an object at one end of the ground, and take it; None if there is none.

        Parameters
        ----------
        points, gap
            See `place`.
        outward : (2,) int
            Towards the end: 1 or -1 along x or along y, 0 along the other.
        """
        mask = footprint(points[:, :2])
        places = np.argwhere(fits(self.blocked, mask) & fits(self.taken, widened(mask, gap), outside=False))
        if not len(places):
            return None
        reach = places @ outward
        at_end = places[reach == reach.max()]
        half = (np.array(mask.shape) // 2) @ np.abs(outward)
        end = (self.taken.shape @ np.abs(outward) - 1 - half) if outward.sum() > 0 else -half
        if reach.max() < end:
            return None
        return self.stamp(mask, at_end[rng.integers(len(at_end))])

    def take(self, points: np.ndarray):
        """Take the cells below an object's points (N, 3) or (N, 2), in the ground's own frame."""
        cells = np.floor((points[:, :2] - self.corner) / CELL).astype(int)
        cells = cells[((cells >= 0) & (cells < self.taken.shape)).all(axis=1)]
        self.taken[tuple(cells.T)] = True

    def stamp(self, mask: np.ndarray, place: np.ndarray) -> np.ndarray:
        """Take the cells of a footprint about a cell; return the cell's middle (3,), metres."""
        half = np.array(mask.shape) // 2
        cells = np.argwhere(mask) + place - half
        self.taken[tuple(cells.T)] = True
        return np.append(self.corner + (place + 0.5) * CELL, self.height)


def floor_of(width: float, depth: float) -> Ground:
    """Return the empty floor of a room whose walls stand at x = 0, x = width, y = 0 and y = depth."""
    shape = (int(width / CELL), int(depth / CELL))
    return Ground(np.zeros(2), 0.0, np.zeros(shape, bool), np.zeros(shape, bool))


def top_of(points: np.ndarray, tolerance: float = LEVEL) -> Ground:
    """Return the largest level top of an object that stands in a room, seen from above.

    Parameters
    ----------
    points : (N, 3) float64, metres
        In the room's frame, at most a cell apart.
    tolerance : float, metres
        By which its height may vary.
    """
    corner = points[:, :2].min(axis=0)
    cells = ((points[:, :2] - corner) / CELL).astype(int)
    heights = np.full(cells.max(axis=0) + 1, -np.inf)
    np.maximum.at(heights, tuple(cells.T), points[:, 2])
    steps = np.round(heights[np.isfinite(heights)] / LEVEL).astype(int)
    height = np.argmax(np.bincount(steps)) * LEVEL
    level = np.abs(heights - height) <= tolerance
    return Ground(corner, float(heights[level].max()), ~level, np.zeros(level.shape, bool))


def footprint(xy: np.ndarray) -> np.ndarray:
    """Return the cells below points (N, 2), a bool array of odd sides with the origin in the middle."""
    cells = np.floor(xy / CELL + 0.5).astype(int)
    half = np.abs(cells).max(axis=0)
    mask = np.zeros(2 * half + 1, bool)
    mask[tuple((cells + half).T)] = True
    return mask


def widened(mask: np.ndarray, gap: float) -> np.ndarray:
    """Return a footprint with all cells within a gap of it."""
    from scipy.ndimage import distance_transform_edt

    padded = np.pad(mask, int(np.ceil(gap / CELL)))
    return distance_transform_edt(~padded) * CELL <= gap


def fits(occupied: np.ndarray, mask: np.ndarray, outside: bool = True) -> np.ndarray:
    """Return the cells at which a footprint's middle may be so that it covers no occupied cell.

    Parameters
    ----------
    outside : bool
        Whether everything beyond the ground's ends counts as occupied.
    """
    from scipy.signal import correlate

    padded = np.pad(occupied, [(side // 2, side // 2) for side in mask.shape], constant_values=outside)
    overlap = correlate(padded.astype(np.float32), mask.astype(np.float32), mode="valid", method="fft")
    return overlap < 0.5


def boards_of(points: np.ndarray) -> list[Ground]:
    """Return the level boards of a shelf (N, 3) in a room's frame, the lowest first, by their upper faces."""
    corner = points[:, :2].min(axis=0)
    cells = ((points[:, :2] - corner) / CELL).astype(int)
    shape = cells.max(axis=0) + 1
    steps = np.round(points[:, 2] / LEVEL).astype(int)
    upwards = np.argsort(steps, kind="stable")
    ends = np.flatnonzero(np.diff(steps[upwards])) + 1
    boards: list[Ground] = []
    for rows in np.split(upwards, ends):
        level = np.zeros(shape, bool)
        level[tuple(cells[rows].T)] = True
        if level.mean() < BOARD:
            continue
        height = float(points[rows, 2].max())
        if boards and height - boards[-1].height < THICK:
            boards.pop()
        boards.append(Ground(corner, height, ~level, np.zeros(shape, bool)))
    return boards
