"""Methods: how settled spheres become features, and features scores.

``paper`` follows Hinkle and Olson exactly where their description is clear; ``cubes`` counts spheres in cubes as they
do, and differs where a measured comparison shows that it does better; ``profile``, the default, reads drops as named
quantities (docs/method.md; docs/paper.md has the tables and the commands).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from ..errors import InputError
from ..settling.drops import DROPS, RunLimit
from .profiles.profile_model import PROFILE

DIAMETERS = 3.5  # side of a cube in sphere diameters
RADII = (0.005, 0.01, 0.02, 0.03, 0.05)  # metres
PROFILE_RADII = (0.005, 0.01, 0.03)  # metres


@dataclass(frozen=True, kw_only=True)
class Method:
    """The choices between settled spheres and scores; see `CubeHistogram` and `member_scores`."""

    name: str
    diameters: float = DIAMETERS  # side of a cube
    neighbors: tuple[int, ...] = (1, 3)  # nearest members, and as many others; for several numbers the mean score
    vote: bool = False  # whether all radii vote, instead of the best one alone
    of_all: bool = False  # whether the nearest of all examples count, instead of equal numbers of either side
    splits: int = 20  # of the training set, to choose the radius: with one, that of a rare function depends on luck
    tied: str = "largest"  # which of equally good radii is chosen, "largest" or "smallest"
    to_the_end: bool = False  # whether runs end by the paper's rule alone, without a limit of settled spheres
    radii: ClassVar[tuple[float, ...]] = RADII  # default radii of the spheres, metres

    @property
    def run_limit(self) -> RunLimit:
        """The limit of its runs."""
        return RunLimit(to_the_end=self.to_the_end)


@dataclass(frozen=True, kw_only=True)
class ProfileMethod:
    """The resting profile: a few drops at each radius, read as quantities; see `FunctionClassifier`."""

    name: str = PROFILE
    radii: tuple[float, ...] = PROFILE_RADII
    run_limit: RunLimit = RunLimit(drops=DROPS)


PAPER = Method(name="paper", neighbors=(3,), of_all=True, splits=1, to_the_end=True)
CUBES = Method(name="cubes", vote=True)
AnyMethod = Method | ProfileMethod
METHODS: dict[str, AnyMethod] = {PROFILE: ProfileMethod(), "paper": PAPER, "cubes": CUBES}


def find_method(method: str | AnyMethod) -> AnyMethod:
    """Return the method with a name; a method is returned as it is."""
    if isinstance(method, AnyMethod):
        return method
    if not isinstance(method, str) or method not in METHODS:
        raise InputError(f"method {method!r}: expected one of {', '.join(METHODS)}")
    return METHODS[method]


def find_cube_method(method: str | AnyMethod) -> Method:
    """Return a method as `find_method` does; InputError if it does not count spheres in cubes."""
    chosen = find_method(method)
    if not isinstance(chosen, Method):
        raise InputError(f"method {chosen.name!r}: expected cubes or paper, which count spheres in cubes")
    return chosen
