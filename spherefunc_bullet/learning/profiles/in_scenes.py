"""What a model tells of parts of scans, where it knows what surrounds them beside how spheres rest on them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from .calibration import Line, calibrated
from .forest import Forest, forest_batch, kept_forests, of_prefix, rebuilt_forests

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
