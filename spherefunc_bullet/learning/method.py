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
    """The choices between settled spheres and scores; see `CubeHistogram` and `inverse_distance_scores`."""

    name: str
    diameters: float = DIAMETERS  # side of a cube
    neighbors: tuple[int, ...] = (1, 3)  # nearest of either side; the mean score over several such numbers
    vote: bool = False  # over radii, instead of the best one alone

    def histogram(self, radius: float) -> CubeHistogram:
        """Return the histogram of this method for a radius in metres."""
        return CubeHistogram(radius, diameters=self.diameters)


METHODS = {
    "paper": Method(name="paper"),
    "default": Method(name="default", vote=True),
}


def find_method(method: str | Method) -> Method:
    """Return a method by its name; one that is already made passes through."""
    if isinstance(method, Method):
        return method
    if method not in METHODS:
        raise InputError(f"method {method!r}: expected one of {', '.join(METHODS)}")
    return METHODS[method]
