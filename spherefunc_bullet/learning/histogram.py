"""The feature: how many spheres settled in each cube of space (paper, §III-B, Fig. 2).

Space is divided into cubes of side three to four sphere diameters. A sofa and a cup share one vector space:
the matrix is sparse, and has a column for every cube in which a training object held a sphere, and one more.
"""

from __future__ import annotations

import numpy as np
from scipy import sparse
from sklearn.base import BaseEstimator, TransformerMixin
from sklearn.utils.validation import check_is_fitted

from ..errors import InputError
from .heading import HEADINGS, turned

DIAMETERS = 3.5  # side of a cube in sphere diameters
ANCHORS = ("centre", "corner")
COUNTS = ("raw", "sqrt")
_BITS = 21  # of a cube's index along each axis; two million cubes either way of the axis
_OFFSET = 1 << (_BITS - 1)


def cube_keys(centers: np.ndarray, side: float, anchor: str = "centre") -> np.ndarray:
    """Return one int64 per centre that names its cube.

    Parameters
    ----------
    centers : (S, 3) float
        Metres, z up, the object centred on the z axis and standing on z = 0.
    side : float
        Of a cube, metres.
    anchor : {'centre', 'corner'}
        Whether the grid's middle cube is centred on the z axis, or its first begins at the spheres' lowest x
        and y. The floor is always a boundary.
    """
    corner = centers.min(axis=0) if anchor == "corner" and len(centers) else np.full(3, -side / 2)
    indices = np.floor((centers - [corner[0], corner[1], 0.0]) / side).astype(np.int64) + _OFFSET
    return (indices[:, 0] << 2 * _BITS) | (indices[:, 1] << _BITS) | indices[:, 2]


def cube_indices(keys: np.ndarray) -> np.ndarray:
    """Return the cubes (V, 3) int64 that keys name: ix, iy, iz, 0 at the anchor and the floor."""
    mask = (1 << _BITS) - 1
    return np.stack([keys >> 2 * _BITS, keys >> _BITS & mask, keys & mask], axis=1) - _OFFSET


def counted_cubes(points: np.ndarray, side: float, anchor: str = "centre") -> tuple[np.ndarray, np.ndarray]:
    """Return the keys (V,) of the cubes that hold points (S, 3), ascending, and how many each holds (V,) float."""
    keys, counts = np.unique(cube_keys(points, side, anchor), return_counts=True)
    return keys, counts.astype(float)


def counts_matrix(counted, keys: np.ndarray) -> sparse.csr_matrix:
    """Return counts (N, V + 1) of objects given as cubes and counts; the last column is what no key (V,) names."""
    rows, columns, values = [], [], []
    for row, (cubes, counts) in enumerate(counted):
        known = np.minimum(np.searchsorted(keys, cubes), max(len(keys) - 1, 0))
        inside = keys[known] == cubes if len(keys) else np.zeros(len(cubes), bool)
        columns += [known[inside], [len(keys)]]
        values += [counts[inside], [np.sqrt(np.sum(counts[~inside] ** 2))]]
        rows.append(np.full(inside.sum() + 1, row))
    shape = (len(rows), len(keys) + 1)
    if not rows:
        return sparse.csr_matrix(shape)
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
    anchor : {'centre', 'corner'}
        Where the grid of cubes begins, see `cube_keys`.
    heading : {'as_given', 'long_side', 'front'}
        How objects are turned about z before they are compared, see `heading.turned`.
    counts : {'raw', 'sqrt'}
        Square roots make a cube with many spheres count less beside many cubes with few.

    Attributes
    ----------
    keys_ : (V,) int64
        The cubes that have a column, ascending.
    """

    def __init__(self, radius=0.02, *, diameters=DIAMETERS, anchor="centre", heading="as_given", counts="raw"):
        self.radius = radius
        self.diameters = diameters
        self.anchor = anchor
        self.heading = heading
        self.counts = counts

    @property
    def side(self) -> float:
        """Side of a cube, metres."""
        return self.diameters * 2 * self.radius

    def fit(self, X, y=None):
        """Learn which cubes have a column.

        Parameters
        ----------
        X : sequence of (S, 3) float
            Settled centres of each object, metres.
        """
        self.fit_transform(X)
        return self

    def fit_transform(self, X, y=None) -> sparse.csr_matrix:
        """Learn the cubes of objects given as settled centres, and return their counts (len(X), V + 1)."""
        self._check_options()
        self.keys_ = np.empty(0, np.int64)
        return self._learn(X)

    def partial_fit(self, X, y=None):
        """Give the cubes of more objects a column too; see `widened` for matrices made before."""
        self._check_options()
        self.keys_ = getattr(self, "keys_", np.empty(0, np.int64))
        self._learn(X)
        return self

    def transform(self, X) -> sparse.csr_matrix:
        """Return the counts (len(X), V + 1) of objects given as settled centres."""
        check_is_fitted(self)
        return counts_matrix([self._counted(centers) for centers in X], self.keys_)

    def _learn(self, X) -> sparse.csr_matrix:
        counted = [self._counted(centers) for centers in X]
        self.keys_ = np.unique(np.concatenate([self.keys_, *(keys for keys, _ in counted)]))
        return counts_matrix(counted, self.keys_)

    def _check_options(self):
        for name, value, allowed in (
            ("anchor", self.anchor, ANCHORS),
            ("heading", self.heading, HEADINGS),
            ("counts", self.counts, COUNTS),
        ):
            if value not in allowed:
                raise InputError(f"{name}: expected one of {', '.join(allowed)}, got {value!r}")

    def _counted(self, centers) -> tuple[np.ndarray, np.ndarray]:
        """Return the keys (V,) of the cubes that hold spheres, and their counts (V,) float."""
        centers = turned(np.asarray(centers, dtype=np.float64).reshape(-1, 3), self.heading)
        keys, counts = counted_cubes(centers, self.side, self.anchor)
        return keys, np.sqrt(counts) if self.counts == "sqrt" else counts


def widened(matrix: sparse.csr_matrix, before: np.ndarray, after: np.ndarray) -> sparse.csr_matrix:
    """Return training rows (N, V + 1) made with the cubes ``before``, with a column for each of ``after``."""
    columns = np.append(np.searchsorted(after, before), len(after))
    shape = (matrix.shape[0], len(after) + 1)
    return sparse.csr_matrix((matrix.data, columns[matrix.indices], matrix.indptr), shape=shape)


class SphereHistogram(TransformerMixin, BaseEstimator):
    """Drop spheres on clouds and count where they settle: clouds in, sparse matrix out.

    Parameters
    ----------
    simulator : str or Simulator
        A registered backend's name (``fast``, ``bullet``) or a simulator.
    radius : float
        Of the spheres, metres.
    seed : int
        Of the drops.
    diameters, anchor, heading, counts
        See `CubeHistogram`.

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
        simulator="fast",
        radius=0.02,
        *,
        seed=0,
        diameters=DIAMETERS,
        anchor="centre",
        heading="as_given",
        counts="raw",
    ):
        self.simulator = simulator
        self.radius = radius
        self.seed = seed
        self.diameters = diameters
        self.anchor = anchor
        self.heading = heading
        self.counts = counts

    def fit(self, X, y=None):
        """Learn the cubes of clouds."""
        self.fit_transform(X)
        return self

    def fit_transform(self, X, y=None) -> sparse.csr_matrix:
        """Learn the cubes of clouds and return their counts, simulating each cloud once."""
        options = {name: getattr(self, name) for name in ("diameters", "anchor", "heading", "counts")}
        self.cubes_ = CubeHistogram(self.radius, **options)
        return self.cubes_.fit_transform(self._settled(X))

    def transform(self, X) -> sparse.csr_matrix:
        """Return the counts of clouds in the cubes learnt."""
        check_is_fitted(self)
        return self.cubes_.transform(self._settled(X))

    def _settled(self, clouds) -> list[np.ndarray]:
        from ..settling.settling import settle

        return [settle(cloud, self.simulator, [self.radius], self.seed)[self.radius] for cloud in clouds]
