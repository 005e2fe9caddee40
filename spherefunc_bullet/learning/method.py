"""Methods: how settled spheres become features, and features scores.

``paper`` is Hinkle and Olson's method to the letter where the letter is clear; ``cubes`` counts spheres in cubes as
they do, and differs where a measured comparison shows that it does better; ``profile``, the default, reads drops as
named quantities (docs/method.md; docs/paper.md has the tables and the commands).
"""

from __future__ import annotations

from dataclasses import dataclass

from ..errors import InputError
from ..settling.drops import DROPS, RunLimit
from .histogram import DIAMETERS, CubeHistogram
from .profiles.profile_model import PROFILE

RADII = (0.005, 0.01, 0.02, 0.03, 0.05)  # metres
PROFILE_RADII = (0.005, 0.01, 0.03)  # metres


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

    @property
    def run_limit(self) -> RunLimit:
        """How long its runs are."""
        return RunLimit(to_the_end=self.to_the_end)

    @property
    def radii(self) -> tuple[float, ...]:
        """Of the spheres, where nobody says otherwise, metres."""
        return RADII

    def histogram(self, radius: float) -> CubeHistogram:
        """Return the histogram of this method for a radius in metres."""
        return CubeHistogram(radius, diameters=self.diameters)


@dataclass(frozen=True, kw_only=True)
class ProfileMethod:
    """The resting profile: a few drops at each radius, read as quantities; see `ProfileClassifier`."""

    name: str = PROFILE
    radii: tuple[float, ...] = PROFILE_RADII
    run_limit: RunLimit = RunLimit(drops=DROPS)


PAPER = Method(name="paper", neighbors=(3,), of_all=True, splits=1, to_the_end=True)
CUBES = Method(name="cubes", vote=True)
AnyMethod = Method | ProfileMethod
METHODS: dict[str, AnyMethod] = {
    PROFILE: ProfileMethod(),
    "paper": PAPER,
    "cubes": CUBES,
}


def find_method(method: str | AnyMethod) -> AnyMethod:
    """Return a method by its name; one that is already made passes through."""
    if not isinstance(method, str):
        return method
    if method not in METHODS:
        raise InputError(f"method {method!r}: expected one of {', '.join(METHODS)}")
    return METHODS[method]


def find_cube_method(method: str | AnyMethod) -> Method:
    """Return a method that counts spheres in cubes, for what only such a one can do.

    Raises
    ------
    InputError
        If it is none.
    """
    chosen = find_method(method)
    if not isinstance(chosen, Method):
        raise InputError(f"method {chosen.name!r}: expected cubes or paper, which count spheres in cubes")
    return chosen
