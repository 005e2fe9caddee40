"""Training examples as recognition meets them: proposals of a scan whose truth is known, the useless ones too."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from spherefunc_bullet.clouds.cloud import Cloud
from spherefunc_bullet.simulator import Simulator

from ..pools.cutting import STRICT_CUTS
from ..scans.filling import filled
from ..scans.levelling import level
from ..segmentation.segmentation import WALL, Segmentation, segment
from .completion import DEFAULT
from .judging import is_fragment, object_cloud
from .proposals import KINDS, Scene, propose
from .surroundings import Surroundings

_OBJECT = 0.4  # intersection over union from which on a proposal is an object
_PART = 0.25  # from here to there it is disputed, and no example
_FEWEST = 20  # points of the scan in an example


@dataclass(frozen=True, kw_only=True, eq=False)
class Example:
    """A proposal as the spheres meet it, and the object that it overlaps most."""

    cloud: Cloud
    nearest: int  # number of that object, -1 if it overlaps none
    overlap: float  # their intersection over union
    by: str  # what proposed it
    beside: np.ndarray  # (S,) what surrounds it, see `surroundings`

    @property
    def number(self) -> int | None:
        """The object that it is; None where it is none: a shelf, a part, several objects at once."""
        return self.nearest if self.overlap >= _OBJECT else None

    @property
    def disputed(self) -> bool:
        """Whether it is neither an object nor none."""
        return _PART <= self.overlap < _OBJECT


def proposed_examples(
    points: np.ndarray,
    truth: np.ndarray,
    simulator: str | Simulator = "fast",
    *,
    kinds: Sequence[str] = KINDS,
    completion: Sequence[str] = DEFAULT,
) -> Iterator[Example]:
    """Yield the proposals of a scan, completed as recognition completes them, the disputed ones too.

    Pools are cut out cautiously: taught by what half is guessed, models recognised seats less well.

    Parameters
    ----------
    points : (N, 3) float64, metres
    truth : (N,) int
        The object of each point from 0, or below 0 for none.
    simulator, kinds
        See `propose`.
    completion
        See `complete`.
    """
    levelling, settings = level(points), Segmentation()
    dense = filled(levelling.to_level(points), settings.leaf_size)
    labels = segment(dense, settings, noise=levelling.noise)
    scene = Scene(points=dense, labels=labels, on_table=levelling.source == "table top")
    sizes, place = np.bincount(truth[truth >= 0]), Surroundings(points=dense, is_wall=labels == WALL)
    for proposal in propose(scene, simulator, kinds, how=STRICT_CUTS):
        seen = proposal.members[proposal.members < len(points)]
        if len(seen) < _FEWEST:
            continue
        number, shared = best_object(truth[seen], sizes)
        own = dense[proposal.members]
        cloud, box = object_cloud(own, completion, proposal.support, proposal.pool)
        if not is_fragment(own, box, proposal.support):
            nearest = number if shared > 0 else -1
            beside = place.of(own, box.size, proposal.support)
            yield Example(cloud=cloud, nearest=nearest, overlap=shared, by=proposal.by, beside=beside)


def best_object(truth: np.ndarray, sizes: np.ndarray) -> tuple[int, float]:
    """Return the object that points of objects (K,) overlap most, and their intersection over union.

    Parameters
    ----------
    truth : (K,) int
    sizes : (T,) int
        The points of each object in the scan.
    """
    if not len(sizes):
        return -1, 0.0
    shared = np.bincount(truth[truth >= 0], minlength=len(sizes))
    overlaps = shared / np.maximum(len(truth) + sizes - shared, 1)
    best = int(np.argmax(overlaps))
    return best, float(overlaps[best])
