"""A grown forest as plain arrays: what is kept in model files, and asked in microseconds.

scikit-learn grows the trees; asking it about one object takes tens of milliseconds, nearly all of it bookkeeping.
`SceneForests` tell of parts of scans, where it is known what surrounds them beside how spheres rest on them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from ...errors import InputError

if TYPE_CHECKING:
    from sklearn.ensemble import ExtraTreesClassifier


from .calibration import Line, calibrated

LEAF = -1  # in place of a feature


@dataclass(frozen=True, kw_only=True, eq=False)
class Forest:
    """Binary decision trees, all nodes in one row.

    A node sends what is at most its threshold to ``below``, the rest to the node after that. Children come after
    their parent.
    """

    roots: np.ndarray  # (T,) int32, the node that each tree begins at
    feature: np.ndarray  # (M,) int16, the quantity that is looked at, or LEAF
    threshold: np.ndarray  # (M,) float64
    below: np.ndarray  # (M,) int32, node
    vote: np.ndarray  # (M,) float32, the share of members in a leaf, each side weighted alike; 0 of other nodes

    def votes(self, X: np.ndarray) -> np.ndarray:
        """Return the mean vote (N,) of all trees for members, of objects (N, Q) given as quantities."""
        return forest_batch([self]).votes(X)[0]

    def to_float32(self) -> Forest:
        """Return it with thresholds as short as what is compared with them, so that files compress; no vote changes."""
        short = self.threshold.astype(np.float32)
        below = np.where(short > self.threshold, np.nextafter(short, np.float32(-np.inf)), short)
        return replace(self, threshold=below.astype(np.float64))

    def arrays(self) -> dict[str, np.ndarray]:
        """Return what `Forest` is made of, by name."""
        return dict(vars(self))

    def require_whole(self, quantities: int):
        """Raise InputError if these are not trees over so many quantities, as where a file was tampered with."""
        count = len(self.feature)
        inner = np.flatnonzero(self.feature != LEAF)
        lengths = {len(values) for values in (self.feature, self.threshold, self.below, self.vote)}
        whole = (
            lengths == {count}
            and len(self.roots) > 0
            and ((self.roots >= 0) & (self.roots < count)).all()
            and ((self.feature >= LEAF) & (self.feature < quantities)).all()
            and ((self.below[inner] > inner) & (self.below[inner] < count - 1)).all()
            and np.isfinite(self.threshold).all()
            and ((self.vote >= 0) & (self.vote <= 1)).all()
        )
        if not whole:
            raise InputError(f"expected trees over {quantities} quantities, got {count} nodes that are none")


@dataclass(frozen=True, kw_only=True, eq=False)
class ForestBatch:
    """Several forests that are asked together, in steps of all their trees: leaves lead to themselves."""

    sizes: tuple[int, ...]  # trees of each forest
    roots: np.ndarray  # (T,) int32, of all trees, forest by forest
    feature: np.ndarray  # (M,) int16, a quantity, any of a leaf
    threshold: np.ndarray  # (M,) float64, infinite of a leaf
    below: np.ndarray  # (M,) int32, of a leaf itself
    vote: np.ndarray  # (M,) float32

    def votes(self, X: np.ndarray) -> list[np.ndarray]:
        """Return each forest's mean votes (N,), of objects (N, Q) given as quantities."""
        X = np.asarray(X, np.float32).astype(np.float64)  # as when they grew
        parts = np.split(self.vote[self.leaves(X)].astype(float), np.cumsum(self.sizes)[:-1], axis=1)
        return [np.ascontiguousarray(part).mean(axis=1) for part in parts]

    def leaves(self, X: np.ndarray) -> np.ndarray:
        """Return the leaf of each tree (N, T) that objects (N, Q) end in."""
        quantities, first = X.ravel(), X.shape[1] * np.arange(len(X))[:, None]
        node = np.tile(self.roots, (len(X), 1))
        while True:
            above = quantities[first + self.feature[node]] > self.threshold[node]
            following = self.below[node] + above
            if np.array_equal(following, node):
                return node
            node = following


def forest_batch(forests: Sequence[Forest]) -> ForestBatch:
    """Return forests joined."""
    starts = np.cumsum([0, *(len(one.feature) for one in forests)])[:-1].astype(np.int32)
    feature, threshold, vote = (
        np.concatenate([getattr(one, name) for one in forests]) for name in ("feature", "threshold", "vote")
    )
    below = np.concatenate([one.below + start for one, start in zip(forests, starts, strict=True)])
    leaf = np.flatnonzero(feature == LEAF)
    feature[leaf], threshold[leaf], below[leaf] = 0, np.inf, leaf
    return ForestBatch(
        sizes=tuple(len(one.roots) for one in forests),
        roots=np.concatenate([one.roots + start for one, start in zip(forests, starts, strict=True)]),
        feature=feature,
        threshold=threshold,
        below=below,
        vote=vote,
    )


def forest_of(grown: ExtraTreesClassifier) -> Forest:
    """Return the arrays of a forest of two classes, False and True, as scikit-learn grew it."""
    trees = [in_pairs(estimator.tree_) for estimator in grown.estimators_]
    starts = np.cumsum([0, *(len(tree["feature"]) for tree in trees)])[:-1]
    for tree, start in zip(trees, starts, strict=True):
        tree["below"] = tree["below"] + start
    joined = {name: np.concatenate([tree[name] for tree in trees]) for name in trees[0]}
    kinds = {"feature": np.int16, "threshold": np.float64, "below": np.int32, "vote": np.float32}
    return Forest(roots=starts.astype(np.int32), **{name: joined[name].astype(kind) for name, kind in kinds.items()})


def kept_forests(forests: Sequence[Forest | None]) -> dict[str, np.ndarray]:
    """Return the arrays of forests, by name and place; without ``below`` where that follows from the others."""
    kept = {}
    for place, one in enumerate(forests):
        arrays = {} if one is None else one.arrays()
        if one is not None and np.array_equal(one.below, below_in_pairs(one.roots, one.feature)):
            del arrays["below"]
        kept |= {f"{name}_{place}": values for name, values in arrays.items()}
    return kept


def below_in_pairs(roots: np.ndarray, feature: np.ndarray) -> np.ndarray:
    """Return ``below`` (M,) of trees level by level, as `in_pairs` orders them; of a leaf, its tree's root."""
    inner, sizes = feature != LEAF, np.diff(np.append(roots, len(feature)))
    before = np.cumsum(inner, dtype=np.int32) - inner
    first = np.repeat(roots + 1 - 2 * before[roots], sizes)
    return np.where(inner, first + 2 * before, np.repeat(roots, sizes)).astype(np.int32, copy=False)


def of_prefix(arrays: Mapping[str, np.ndarray], prefix: str) -> dict[str, np.ndarray]:
    """Return the arrays whose names begin with a prefix, by the rest of their names."""
    return {name.removeprefix(prefix): arrays[name] for name in arrays if name.startswith(prefix)}


def rebuilt_forests(arrays: Mapping[str, np.ndarray], count: int) -> list[Forest | None]:
    """Return so many forests of the arrays of `kept_forests`, None where there is none."""
    return [rebuilt(arrays, place) if f"roots_{place}" in arrays else None for place in range(count)]


def rebuilt(arrays: Mapping[str, np.ndarray], place: int) -> Forest:
    """Return the forest at one place, whose ``below`` is kept or follows."""
    own = {name: arrays[f"{name}_{place}"] for name in ("roots", "feature", "threshold", "vote")}
    below = f"below_{place}"
    return Forest(**own, below=arrays[below] if below in arrays else below_in_pairs(own["roots"], own["feature"]))


def in_pairs(tree: Any) -> dict[str, np.ndarray]:
    """Return the nodes of a tree, as scikit-learn holds it, level by level: two children stand side by side."""
    left, right = tree.children_left, tree.children_right
    order, below = [0], []
    for node in order:  # grows while it is read
        if left[node] < 0:
            below.append(0)
        else:
            below.append(len(order))
            order += [left[node], right[node]]
    inner = left[order] >= 0
    return {
        "feature": np.where(inner, tree.feature[order], LEAF),
        "threshold": np.where(inner, tree.threshold[order], 0.0),
        "below": np.array(below),
        "vote": np.where(inner, 0.0, tree.value[order, 0, 1]),  # shares of the two classes, which sum to one
    }


SCENES = "scenes_"  # begins the names of arrays


@dataclass(frozen=True, kw_only=True, eq=False)
class SceneForests:
    """A forest for each function, over an object's quantities followed by those of what surrounds it."""

    names: tuple[str, ...]  # of what surrounds it
    forests: Sequence[Forest]
    lines: Sequence[Line]

    def scores(self, profiles: np.ndarray, beside: np.ndarray) -> np.ndarray:
        """Return the scores (N, F) of objects by their quantities (N, R * Q) and what surrounds them (N, S)."""
        if not len(profiles):
            return np.zeros((0, len(self.forests)))
        votes = forest_batch(self.forests).votes(np.hstack([profiles, beside]))
        return np.column_stack([calibrated(own, line) for own, line in zip(votes, self.lines, strict=True)])

    def only(self, column: int) -> SceneForests:
        """Return what tells one function alone."""
        return SceneForests(names=self.names, forests=[self.forests[column]], lines=[self.lines[column]])


def scenes_kept(scenes: SceneForests) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
    """Return what is kept of it in a model file."""
    arrays = {SCENES + name: values for name, values in kept_forests(scenes.forests).items()}
    return {"surroundings": list(scenes.names)}, arrays | {f"{SCENES}lines": np.array(scenes.lines, float)}


def rebuilt_scenes(about: dict[str, Any], arrays: Mapping[str, np.ndarray], quantities: int) -> SceneForests | None:
    """Return what a model file holds of it for so many quantities, if it holds any."""
    names = tuple(about.get("surroundings", ()))
    if not names:
        return None
    own = of_prefix(arrays, SCENES)
    forests = rebuilt_forests(own, len(about["functions"]))
    for one in forests:
        if one is None:
            raise ValueError("forests and functions differ in number")
        one.require_whole(quantities + len(names))
    lines = [(float(slope), float(offset)) for slope, offset in own["lines"].reshape(len(forests), 2)]
    return SceneForests(names=names, forests=forests, lines=lines)
