"""A fitted forest as plain arrays, which model files hold and which are evaluated in microseconds.

scikit-learn fits the trees; its own evaluation of one object takes tens of milliseconds, nearly all of it overhead.
`SceneForests` classify parts of scans from their surroundings as well as from how spheres rest on them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from ...formats import FormatError
from .calibration import Calibration, calibrated

if TYPE_CHECKING:
    from sklearn.ensemble import ExtraTreesClassifier

LEAF = -1  # in place of a feature
SCENES, SCREENING = "scenes_", "screening_"  # prefixes of the arrays of scene forests, and of their screening


@dataclass(frozen=True, kw_only=True, eq=False)
class Forest:
    """Binary decision trees, the nodes of all in one array.

    A node sends values up to its threshold to the node ``below``, and others to the node after that one. Children come
    after their parent.
    """

    roots: np.ndarray  # (T,) int32, the root node of each tree
    feature: np.ndarray  # (M,) int16, the quantity that is compared, or LEAF
    threshold: np.ndarray  # (M,) float64
    below: np.ndarray  # (M,) int32, node
    vote: np.ndarray  # (M,) float32, weighted share of members in a leaf; 0 in other nodes

    def votes(self, X: np.ndarray) -> np.ndarray:
        """Return the mean vote (N,) of all trees for objects given as quantities (N, Q)."""
        X = np.asarray(X, np.float32).astype(np.float64)  # as when they were fitted
        return self.vote[self.leaves(X)].astype(float).mean(axis=1)

    def leaves(self, X: np.ndarray) -> np.ndarray:
        """Return the leaf of each tree (N, T) that objects given as quantities (N, Q) reach, a level at a time."""
        node, row = np.tile(self.roots, (len(X), 1)), np.arange(len(X))[:, None]
        while True:
            feature = self.feature[node]
            inner = feature != LEAF
            if not inner.any():
                return node
            above = X[row, feature] > self.threshold[node]  # of a leaf any quantity
            node = np.where(inner, self.below[node] + above, node)

    def to_float32(self) -> Forest:
        """Return the forest with thresholds rounded to float32, so that files compress; no vote changes."""
        rounded = self.threshold.astype(np.float32)
        down = np.where(rounded > self.threshold, np.nextafter(rounded, np.float32(-np.inf)), rounded)
        return replace(self, threshold=down.astype(np.float64))

    def arrays(self) -> dict[str, np.ndarray]:
        """Return the arrays of the forest by name."""
        return dict(vars(self))

    def require_whole(self, quantities: int):
        """Raise FormatError if the arrays are not trees over this number of quantities, as in a forged file."""
        count, inner = len(self.feature), np.flatnonzero(self.feature != LEAF)
        lengths = {len(values) for values in (self.feature, self.threshold, self.below, self.vote)}
        whole = (
            lengths == {count}
            and self.roots.ndim == 1
            and len(self.roots) > 0
            and ((self.roots >= 0) & (self.roots < count)).all()
            and ((self.feature >= LEAF) & (self.feature < quantities)).all()
            and ((self.below[inner] > inner) & (self.below[inner] < count - 1)).all()
            and np.isfinite(self.threshold).all()
            and ((self.vote >= 0) & (self.vote <= 1)).all()
        )
        if not whole:
            raise FormatError(f"expected trees over {quantities} quantities, got {count} nodes that form none")


def forest_from_sklearn(fitted: ExtraTreesClassifier) -> Forest:
    """Return a forest of the classes False and True that scikit-learn fitted."""
    trees = [in_pairs(estimator.tree_) for estimator in fitted.estimators_]
    starts = np.cumsum([0, *(len(tree["feature"]) for tree in trees)])[:-1]
    for tree, start in zip(trees, starts, strict=True):
        tree["below"] = tree["below"] + start
    joined = {name: np.concatenate([tree[name] for tree in trees]) for name in trees[0]}
    kinds = {"feature": np.int16, "threshold": np.float64, "below": np.int32, "vote": np.float32}
    return Forest(roots=starts.astype(np.int32), **{name: joined[name].astype(kind) for name, kind in kinds.items()})


def forest_arrays(forests: Sequence[Forest | None]) -> dict[str, np.ndarray]:
    """Return the arrays of forests by name and index; without ``below`` where it follows from the others."""
    joined = {}
    for index, forest in enumerate(forests):
        if forest is None:
            continue
        arrays = forest.arrays()
        if np.array_equal(forest.below, below_in_pairs(forest.roots, forest.feature)):
            del arrays["below"]
        joined |= {f"{name}_{index}": values for name, values in arrays.items()}
    return joined


def below_in_pairs(roots: np.ndarray, feature: np.ndarray) -> np.ndarray:
    """Return ``below`` (M,) of trees whose nodes are ordered as by `in_pairs`; of a leaf, the root of its tree."""
    inner, sizes = feature != LEAF, np.diff(np.append(roots, len(feature)))
    before = np.cumsum(inner, dtype=np.int32) - inner
    first = np.repeat(roots + 1 - 2 * before[roots], sizes)
    return np.where(inner, first + 2 * before, np.repeat(roots, sizes)).astype(np.int32, copy=False)


def of_prefix(arrays: Mapping[str, np.ndarray], prefix: str) -> dict[str, np.ndarray]:
    """Return the arrays whose names begin with a prefix, by the rest of their names."""
    return {name.removeprefix(prefix): arrays[name] for name in arrays if name.startswith(prefix)}


def rebuilt_forests(arrays: Mapping[str, np.ndarray], count: int) -> list[Forest | None]:
    """Return a number of forests from the arrays of `forest_arrays`; None where a function has none."""
    return [rebuilt(arrays, index) if f"roots_{index}" in arrays else None for index in range(count)]


def rebuilt(arrays: Mapping[str, np.ndarray], index: int) -> Forest:
    """Return the forest with an index; its ``below`` is in the arrays or follows from them."""
    nodes = {name: arrays[f"{name}_{index}"] for name in ("roots", "feature", "threshold", "vote")}
    below = f"below_{index}"
    return Forest(**nodes, below=arrays[below] if below in arrays else below_in_pairs(nodes["roots"], nodes["feature"]))


def in_pairs(tree: Any) -> dict[str, np.ndarray]:
    """Return the nodes of a scikit-learn tree level by level; the two children of a node follow one another."""
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


@dataclass(frozen=True, kw_only=True, eq=False)
class Screening:
    """A forest over the surroundings of an object alone, which says where spheres cannot find a function."""

    forest: Forest
    threshold: float  # of its votes, below which no sphere is dropped

    def passes(self, surroundings: np.ndarray) -> np.ndarray:
        """Return which objects with surroundings (N, S) may have a function, (N,) bool."""
        return self.forest.votes(surroundings) >= self.threshold


@dataclass(frozen=True, kw_only=True, eq=False)
class SceneForests:
    """A forest for each function, over the quantities of an object followed by those of its surroundings."""

    names: tuple[str, ...]  # of the quantities of the surroundings
    forests: Sequence[Forest]
    calibrations: Sequence[Calibration]
    screening: Screening | None = None  # None: spheres are dropped on all objects

    def scores(self, profiles: np.ndarray, surroundings: np.ndarray) -> np.ndarray:
        """Return the scores (N, F) of objects from their quantities (N, R * Q) and surroundings (N, S)."""
        if not len(profiles):
            return np.zeros((0, len(self.forests)))
        X = np.hstack([profiles, surroundings])
        pairs = zip(self.forests, self.calibrations, strict=True)
        return np.column_stack([calibrated(forest.votes(X), calibration) for forest, calibration in pairs])

    def only(self, column: int) -> SceneForests:
        """Return the forest of one function only."""
        return replace(self, forests=[self.forests[column]], calibrations=[self.calibrations[column]])


def scene_forest_parts(scenes: SceneForests) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
    """Return the JSON header and the arrays of scene forests in a model file."""
    about: dict[str, Any] = {"surroundings": list(scenes.names)}
    arrays = {SCENES + name: values for name, values in forest_arrays(scenes.forests).items()}
    arrays[f"{SCENES}lines"] = np.array(scenes.calibrations, float)
    if scenes.screening is not None:
        about["screening"] = scenes.screening.threshold
        arrays |= {SCREENING + name: values for name, values in forest_arrays([scenes.screening.forest]).items()}
    return about, arrays


def calibrations_in(lines: np.ndarray, count: int) -> list[tuple[float, float]]:
    """Return the slope and the offset of each of ``count`` forests from an array of a model file."""
    if not np.isfinite(lines).all():
        raise ValueError("calibrations that are not finite")
    return [(float(slope), float(offset)) for slope, offset in lines.reshape(count, 2)]


def rebuilt_scene_forests(
    about: dict[str, Any], arrays: Mapping[str, np.ndarray], quantities: int
) -> SceneForests | None:
    """Return the scene forests of a model file over this number of quantities; None if it has none."""
    names = tuple(about.get("surroundings", ()))
    if not names:
        return None
    scene_arrays = of_prefix(arrays, SCENES)
    forests = rebuilt_forests(scene_arrays, len(about["functions"]))
    for forest in forests:
        if forest is None:
            raise ValueError("forests and functions differ in number")
        forest.require_whole(quantities + len(names))
    calibrations = calibrations_in(scene_arrays["lines"], len(forests))
    scenes = SceneForests(names=names, forests=forests, calibrations=calibrations)
    if "screening" not in about:
        return scenes
    forest = rebuilt(of_prefix(arrays, SCREENING), 0)
    forest.require_whole(len(names))
    return replace(scenes, screening=Screening(forest=forest, threshold=float(about["screening"])))
