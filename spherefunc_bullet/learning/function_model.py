"""What all fitted models of functions answer, whichever way they learnt, and without what learning takes."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..errors import InputError
from ..settling.drops import Length
from ..settling.settling import Settled
from ..simulator import Simulator

THRESHOLD = 0.5  # score above which an object is a member
FALLS = "it falls over when it is put down like this, so it is for nothing, whatever spheres say of it"


@dataclass(frozen=True, kw_only=True)
class Membership:
    """Whether an object has a function."""

    member: bool
    score: float  # 0 to 1, to four places
    radius: float  # of the spheres that count most, metres


class FunctionModel(ABC):
    """A model that is asked what objects are for, by the spheres that fell on them."""

    simulator: str | Simulator
    radii: Sequence[float]  # metres
    seed: int  # of the drops
    functions_: tuple[str, ...]
    names_: list[str]  # of the training objects
    members_: np.ndarray  # (N, F) bool
    radius_: dict[str, float]  # that counts most for each function, metres
    puts_down = False  # whether what falls over when it is put down is for nothing

    @property
    @abstractmethod
    def length(self) -> Length:
        """How long its runs are."""

    @abstractmethod
    def score_settled(self, settled: Sequence[Settled], *, any_heading: bool = False) -> np.ndarray:
        """Return the scores (N, F) of objects on which spheres have fallen."""

    @abstractmethod
    def chosen_radii(self) -> list[float]:
        """Return the radii that some function uses, ascending, metres."""

    @abstractmethod
    def only(self, name: str) -> FunctionModel:
        """Return a copy that is asked for one function alone."""

    def settled_by(self, drop: Callable[[Length], Settled]) -> Settled:
        """Return what becomes of as many drops as an answer needs, of ``drop`` that makes a run of some length."""
        return drop(self.length)

    def serves_nobody(self, memberships: dict[str, Membership], falls_over: Callable[[], bool]) -> bool:
        """Return whether an object has a function by its spheres, and falls over; asked only then."""
        return self.puts_down and any(one.member for one in memberships.values()) and falls_over()

    def column_of(self, name: str) -> int:
        """Return which column of ``members_`` a function is.

        Raises
        ------
        InputError
            If it was not learnt.
        """
        if name not in self.functions_:
            raise InputError(f"function {name!r}: expected one of {', '.join(self.functions_)}")
        return self.functions_.index(name)

    def memberships_of(self, settled: Sequence[Settled], *, any_heading: bool = False) -> list[dict[str, Membership]]:
        """Return what each object is for, by the function's name; see `score_settled`."""
        return self.memberships_by(self.score_settled(settled, any_heading=any_heading))

    def memberships_by(self, scores: np.ndarray) -> list[dict[str, Membership]]:
        """Return what objects are for by their scores (N, F)."""
        radius = self.radius_
        return [
            {
                name: Membership(member=score > THRESHOLD, score=round(score, 4), radius=radius[name])
                for name, score in zip(self.functions_, row, strict=True)
            }
            for row in scores.tolist()
        ]


def of_nobody(memberships: dict[str, Membership]) -> dict[str, Membership]:
    """Return what an object is for that serves nobody as it is: nothing."""
    return {name: replace(one, member=False, score=0.0) for name, one in memberships.items()}
