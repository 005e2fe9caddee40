"""Methods: how settled spheres become features, and features scores.

``paper`` is Hinkle and Olson's method to the letter where the letter is clear; ``default`` differs where a
measured comparison shows that it does better (docs/method.md has the table and the command).
"""

from __future__ import annotations

from dataclasses import dataclass

from ..errors import InputError
from .histogram import DIAMETERS, CubeHistogram


@dataclass(frozen=True, kw_only=True)
class Method:
    """The choices between settled spheres and scores; see `CubeHistogram` and `member_scores`."""

    name: str
    diameters: float = DIAMETERS  # side of a cube
    neighbors: tuple[int, ...] = (1, 3)  # nearest of either side; the mean score over several such numbers
    vote: bool = False  # over radii, instead of the best one alone
    of_all: bool = False  # the nearest of all examples instead, whichever side they are on
    splits: int = 20  # of the training set, that choose the radius: with one, a rare function's is a matter of luck
    tied: str = "largest"  # radius that is chosen of equally good ones, or "smallest"
    to_the_end: bool = False  # runs end by the paper's rule alone, without a limit of settled spheres

    def histogram(self, radius: float) -> CubeHistogram:
        """Return the histogram of this method for a radius in metres."""
        return CubeHistogram(radius, diameters=self.diameters)


METHODS = {
    "paper": Method(name="paper", neighbors=(3,), of_all=True, splits=1, to_the_end=True),
    "default": Method(name="default", vote=True),
}


def find_method(method: str | Method) -> Method:
    """Return a method by its name; one that is already made passes through."""
    if isinstance(method, Method):
        return method
    if method not in METHODS:
        raise InputError(f"method {method!r}: expected one of {', '.join(METHODS)}")
    return METHODS[method]
