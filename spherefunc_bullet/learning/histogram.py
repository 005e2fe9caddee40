"""The feature: how many spheres settled in each cube of space (paper, §III-B, Fig. 2).

Space is divided into cubes of side three to four sphere diameters. A sofa and a cup share one vector space: the matrix
is sparse, with a column for every cube in which a training object held a sphere, and one for all other cubes.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Unpack

import numpy as np
from scipy import sparse
from sklearn.base import BaseEstimator, TransformerMixin
from sklearn.utils.validation import check_is_fitted

from ..clouds.conversion import Anything, as_clouds
from ..errors import require_amount
from ..settling.cached_runs import settle_prepared
from ..simulator import Simulator
from .classifier import BackendAlias, simulator_argument
from .method import DIAMETERS, Method

Counts = tuple[np.ndarray, np.ndarray]  # keys (V,) int64 of cubes, ascending, and the count of each (V,) float
_BITS = 21  # of a cube's index along each axis; two million cubes either way of the axis
_OFFSET = 1 << (_BITS - 1)


def cube_keys(centers: np.ndarray, side: float) -> np.ndarray:
    """Return one int64 per centre that names its cube.

    Parameters
    ----------
    centers : (S, 3) float
        Metres, z up, the object centred on the z axis and standing on z = 0.
    side : float
        Of a cube, metres. The middle cube is centred on the z axis; the floor is a boundary.
    """
    indices = np.floor((centers - [-side / 2, -side / 2, 0.0]) / side).astype(np.int64) + _OFFSET
    return (indices[:, 0] << 2 * _BITS) | (indices[:, 1] << _BITS) | indices[:, 2]


def cube_indices(keys: np.ndarray) -> np.ndarray:
    """Return the cubes (V, 3) int64 that keys name: ix, iy, iz, 0 at the axis and the floor."""
    mask = (1 << _BITS) - 1
    return np.stack([keys >> 2 * _BITS, keys >> _BITS & mask, keys & mask], axis=1) - _OFFSET


def counted_cubes(points: np.ndarray, side: float) -> Counts:
    """Return the cubes that hold points (S, 3), and how many each holds; see `cube_keys`."""
    keys, counts = np.unique(cube_keys(points, side), return_counts=True)
    return keys, counts.astype(float)


def quarter_turns(centers: np.ndarray, turns: int) -> np.ndarray:
    """Return centres (S, 3) turned counterclockwise about z by a number of quarter turns, without rounding."""
    x, y, z = centers.T
    turned_xy = [(x, y), (-y, x), (-x, -y), (y, -x)][turns % 4]
    return np.column_stack([*turned_xy, z])


def counts_matrix(counted: Sequence[Counts], keys: np.ndarray) -> sparse.csr_matrix:
    """Return counts (N, V + 1) of objects given as cubes and counts; the last column is for cubes not in keys (V,)."""
    shape = (len(counted), len(keys) + 1)
    if not counted:
        return sparse.csr_matrix(shape)
    rows, columns, values = [], [], []
    for row, (cubes, counts) in enumerate(counted):
        inside = np.isin(cubes, keys)
        columns += [np.searchsorted(keys, cubes[inside]), [len(keys)]]
        values += [counts[inside], [np.sqrt(np.sum(counts[~inside] ** 2))]]
        rows.append(np.full(inside.sum() + 1, row))
    at = np.concatenate(rows), np.concatenate(columns)
    matrix = sparse.csr_matrix((np.concatenate(values), at), shape=shape)
    matrix.eliminate_zeros()
    return matrix


class CubeHistogram(TransformerMixin, BaseEstimator):
    """Turn settled centres into a sparse matrix of counts per cube.

    The last column, "elsewhere", is the Euclidean norm of an object's counts in cubes where no training object
    held a sphere. Distances to training objects come out as if every cube of space had a column.

    Parameters
    ----------
    radius : float
        Of the spheres, metres.
    diameters : float
        Side of a cube in sphere diameters.

    Attributes
    ----------
    keys_ : (V,) int64
        The cubes that have a column, ascending.
    """

    def __init__(self, radius: float = 0.02, *, diameters: float = DIAMETERS):
        self.radius = radius
        self.diameters = diameters

    @property
    def side(self) -> float:
        """Side of a cube, metres."""
        require_amount("radius", self.radius, above=0.0)
        require_amount("diameters", self.diameters, above=0.0)
        return self.diameters * 2 * self.radius

    def fit(self, X: Sequence[np.ndarray], y: object = None) -> CubeHistogram:
        """Learn which cubes have a column.

        Parameters
        ----------
        X : sequence of (S, 3) float
            Settled centres of each object, metres.
        """
        self.fit_transform(X)
        return self

    def fit_transform(self, X: Sequence[np.ndarray], y: object = None) -> sparse.csr_matrix:
        """Learn the cubes of objects given as settled centres, and return their counts (len(X), V + 1)."""
        self.keys_ = np.empty(0, np.int64)
        return self._learn(X)

    def partial_fit(self, X: Sequence[np.ndarray], y: object = None) -> CubeHistogram:
        """Add columns for the cubes of more objects; `widened` adapts matrices that were made before."""
        self.keys_ = getattr(self, "keys_", np.empty(0, np.int64))
        self._learn(X)
        return self

    def transform(self, X: Sequence[np.ndarray]) -> sparse.csr_matrix:
        """Return the counts (len(X), V + 1) of objects given as settled centres."""
        check_is_fitted(self)
        return counts_matrix([self._counted(centers) for centers in X], self.keys_)

    def _learn(self, X: Sequence[np.ndarray]) -> sparse.csr_matrix:
        counted = [self._counted(centers) for centers in X]
        self.keys_ = np.unique(np.concatenate([self.keys_, *(keys for keys, _ in counted)]))
        return counts_matrix(counted, self.keys_)

    def _counted(self, centers: np.ndarray) -> Counts:
        return counted_cubes(np.asarray(centers, dtype=np.float64).reshape(-1, 3), self.side)


def histogram_of(method: Method, radius: float) -> CubeHistogram:
    """Return the histogram of a method that counts spheres in cubes, for a radius in metres."""
    return CubeHistogram(radius, diameters=method.diameters)


def widened(matrix: sparse.csr_matrix, before: np.ndarray, after: np.ndarray) -> sparse.csr_matrix:
    """Return training rows (N, V + 1) made with the cubes ``before``, with a column for each cube of ``after``."""
    columns = np.append(np.searchsorted(after, before), len(after))
    shape = (matrix.shape[0], len(after) + 1)
    return sparse.csr_matrix((matrix.data, columns[matrix.indices], matrix.indptr), shape=shape)


class SphereHistogram(TransformerMixin, BaseEstimator):
    """Turn objects, anything that `as_cloud` takes, into sparse counts of the spheres that settle on them.

    Parameters
    ----------
    simulator : str or Simulator
        A registered backend's name (``fast``, ``bullet``) or a simulator; ``backend=`` is the same.
    radius : float
        Of the spheres, metres.
    seed : int
        Of the drops.
    diameters : float
        Side of a cube in sphere diameters.
    cache : bool
        Whether spheres that have fallen on the same cloud before are looked up in the user's cache.

    Examples
    --------
    >>> import numpy as np
    >>> from spherefunc_bullet import Cloud
    >>> x, y = np.meshgrid(np.linspace(-0.2, 0.2, 101), np.linspace(-0.2, 0.2, 101))
    >>> plate = Cloud(np.column_stack([x.ravel(), y.ravel(), np.full(x.size, 0.4)]), "plate")
    >>> matrix = SphereHistogram(simulator="fast", radius=0.02).fit_transform([plate])
    >>> matrix.shape[0], bool(matrix.sum() > 40)
    (1, True)
    """

    def __init__(
        self,
        simulator: str | Simulator = "fast",
        radius: float = 0.02,
        *,
        seed: int = 0,
        diameters: float = DIAMETERS,
        cache: bool = True,
        **alias: Unpack[BackendAlias],
    ):
        self.simulator = simulator_argument(self, simulator, alias)
        self.radius = radius
        self.seed = seed
        self.diameters = diameters
        self.cache = cache

    def fit(self, X: Iterable[Anything], y: object = None) -> SphereHistogram:
        """Learn the cubes of clouds."""
        self.fit_transform(X)
        return self

    def fit_transform(self, X: Iterable[Anything], y: object = None) -> sparse.csr_matrix:
        """Learn the cubes of clouds and return their counts, simulating each cloud once."""
        self.cubes_ = CubeHistogram(self.radius, diameters=self.diameters)
        return self.cubes_.fit_transform(self._settled(X))

    def transform(self, X: Iterable[Anything]) -> sparse.csr_matrix:
        """Return the counts of clouds in the cubes learnt."""
        check_is_fitted(self)
        return self.cubes_.transform(self._settled(X))

    def _settled(self, X: Iterable[Anything]) -> list[np.ndarray]:
        how = self.simulator, [self.radius], self.seed
        settled = [settle_prepared(cloud, *how, cache=self.cache) for cloud in as_clouds(X)]
        return [drops[self.radius].rests for drops in settled]
