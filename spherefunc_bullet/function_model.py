"""The interface of fitted models: from drops to scores, without the code for training."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from .clouds.cloud import Cloud
from .errors import InputError, renamed, warn_renamed
from .formats.units import format_length
from .settling.cached_runs import DropConfig, LoadOptions
from .settling.drops import DropsByRadius, RunLimit
from .simulator import Simulator

# Limits of models: a model file may come from anybody, and its runs must end.
SPHERES = (0.0005, 0.2)  # metres, smallest and largest radius: larger spheres do not rest on a seat
MOST_RADII, MOST_DROPS = 20, 10_000  # drops at each radius
THRESHOLD = 0.5  # score above which an object is a member


@dataclass(frozen=True, kw_only=True)
class Membership:
    """Whether an object has a function, and its score."""

    member: bool
    score: float  # 0 to 1, to four places
    radius: float  # of the spheres that count most for the function, metres


@dataclass(frozen=True, kw_only=True, eq=False)
class Reading:
    """The drops of one object, the quantities that a model computes from them, and the scores."""

    drops: DropsByRadius
    scores: np.ndarray  # (F,) float, 0 to 1
    model: FunctionModel  # that computed the scores: the model itself, or its model of the first drops
    profile: np.ndarray | None = None  # (R * Q,) float, quantities; None for models by cubes

    @property
    def rounded(self) -> list[float]:
        """The scores rounded to four decimals, as they are reported."""
        return [round(score, 4) for score in self.scores.tolist()]


class FunctionModel(ABC):
    """A model that classifies objects from the drops on them."""

    simulator: str | Simulator
    radii: Sequence[float]  # metres
    seed: int  # of the drops
    functions_: tuple[str, ...]
    names_: list[str]  # of the training objects
    members_: np.ndarray  # (N, F) bool
    radius_: dict[str, float]  # radius that counts most for each function, metres
    checks_stability = False  # whether an object that would fall over has no function
    length = renamed("FunctionModel.length", "run_limit")
    dropping = renamed("FunctionModel.dropping", "drop_config")

    @property
    @abstractmethod
    def run_limit(self) -> RunLimit:
        """The limit of its runs."""

    @abstractmethod
    def score_settled(self, settled: Sequence[DropsByRadius], *, any_heading: bool = False) -> np.ndarray:
        """Return the scores (N, F) of objects from their drops."""

    @abstractmethod
    def chosen_radii(self) -> list[float]:
        """Return the radii that some function uses, ascending, metres."""

    @abstractmethod
    def only(self, name: str) -> FunctionModel:
        """Return a copy for one function only."""

    def read(self, drop: Callable[[RunLimit], DropsByRadius]) -> Reading:
        """Return the reading of as many drops as an answer needs; ``drop`` returns the drops of a run with a limit."""
        return self.reading_of(drop(self.run_limit))

    def settled_by(self, drop: Callable[[RunLimit], DropsByRadius]) -> DropsByRadius:
        """Return the drops of `read`, under its old name."""
        warn_renamed("settled_by", "read, whose result holds the drops")
        return self.read(drop).drops

    def reading_of(self, drops: DropsByRadius) -> Reading:
        """Return the reading of the drops of one object."""
        return Reading(drops=drops, scores=self.score_settled([drops])[0], model=self)

    def sentences(self, reading: Reading) -> list[str]:
        """Return sentences that explain the scores; none if the model cannot explain them."""
        return []

    def objects_on_table(self, cloud: Cloud, reading: Reading) -> int:
        """Return how many objects stand on a table; 0 if the model cannot count them."""
        return 0

    def doubts(self, reading: Reading) -> list[str]:
        """Return why the answer is unsure, each a sentence; none if it is sure."""
        return []

    def drop_config(self, loading: LoadOptions | None = None) -> DropConfig:
        """Return how spheres are dropped on the objects that the model classifies."""
        return DropConfig(
            simulator=self.simulator,
            radii=tuple(self.chosen_radii()),
            seed=self.seed,
            loading=loading or LoadOptions(),
            run_limit=self.run_limit,
        )

    def column_of(self, name: str) -> int:
        """Return the column of a function in ``members_``.

        Raises
        ------
        InputError
            If the model does not have the function.
        """
        if name not in self.functions_:
            raise InputError(f"function {name!r}: expected one of {', '.join(self.functions_)}")
        return self.functions_.index(name)

    def memberships_of(
        self, settled: Sequence[DropsByRadius], *, any_heading: bool = False
    ) -> list[dict[str, Membership]]:
        """Return the memberships of each object by function; see `score_settled`."""
        return self.memberships_by(self.score_settled(settled, any_heading=any_heading))

    def memberships_by(self, scores: np.ndarray) -> list[dict[str, Membership]]:
        """Return the memberships of objects from their scores (N, F)."""
        radius = self.radius_
        return [
            {
                name: Membership(member=score > THRESHOLD, score=round(score, 4), radius=radius[name])
                for name, score in zip(self.functions_, row, strict=True)
            }
            for row in scores.tolist()
        ]


def require_bounds(radii: Sequence[float], drops: int | None, path: str | Path):
    """Raise InputError for a model whose radii or drops are outside the limits."""
    if not (0 < len(radii) <= MOST_RADII and all(SPHERES[0] <= radius <= SPHERES[1] for radius in radii)):
        expected = f"1 to {MOST_RADII} radii from {format_length(SPHERES[0])} to {format_length(SPHERES[1])}"
        raise InputError(f"{path}: expected a model of {expected}, got {', '.join(map(str, radii[:MOST_RADII]))} m")
    if drops is not None and not 0 < drops <= MOST_DROPS:
        raise InputError(f"{path}: expected a model of 1 to {MOST_DROPS:,} drops at each radius, got {drops:,}")
