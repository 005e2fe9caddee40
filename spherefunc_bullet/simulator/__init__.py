"""The interface between simulators and everything that uses them.

A simulator takes a cloud, settings and a seed and returns where the spheres came to rest (paper, §III-A).
Backends are found through the entry-point group ``spherefunc.backends``, so that another package can add one.
"""

from __future__ import annotations

import enum
import math
from dataclasses import asdict, dataclass, field, is_dataclass, replace
from functools import cache
from importlib.metadata import EntryPoint, entry_points
from typing import TYPE_CHECKING, Any, Protocol, runtime_checkable

import numpy as np

from ..clouds.cloud import Cloud
from ..errors import InputError, explaining

if TYPE_CHECKING:
    from _typeshed import DataclassInstance  # the settings of any ability

MISS_LIMIT = 50  # consecutive spheres not placed that end a run (§III-A)
SPHERE_LIMIT = 20_000  # settled spheres that end a run for features: what holds more of the smallest is no cup


class Outcome(enum.IntEnum):
    """How one sphere's drop ended."""

    SETTLED = 0
    ROLLED_OFF = 1  # reached the ground
    REJECTED = 2  # came to rest on spheres alone, outside the object's bounding box
    TIMED_OUT = 3  # never came to rest within the simulator's limit


class Stop(enum.IntEnum):
    """Why the run ended."""

    MISSES = 0  # the miss limit of the paper: consecutive spheres were not placed
    SPHERE_LIMIT = 1  # the stated cap on settled spheres was reached
    DROP_LIMIT = 2  # the requested number of spheres has been dropped


@dataclass(frozen=True, kw_only=True)
class DropSettings:
    """The settings of a run that the paper fixes (§III-A), the same for every backend."""

    radius: float  # of the spheres, metres
    miss_limit: int = MISS_LIMIT  # consecutive spheres not placed that end the run
    max_spheres: int = 5_000_000  # settled spheres at which the run stops, a cap on memory
    max_drops: int | None = None  # drops at which the run stops, whatever became of them; None: as many as it takes

    def __post_init__(self):
        if not (math.isfinite(self.radius) and self.radius > 0):
            raise InputError(f"radius {self.radius}: expected more than zero metres")
        if self.miss_limit < 1 or self.max_spheres < 1 or (self.max_drops is not None and self.max_drops < 1):
            raise InputError("miss_limit, max_spheres and max_drops: expected at least 1")


@dataclass(frozen=True, kw_only=True)
class DropResult:
    """Where the spheres came to rest, and the outcomes of the others.

    A backend fills in all of it. ``columns`` and ``outcomes`` may be left out by one that does not know what became of
    every drop; then the resting profile, the default method, sees no losses, and the conformance suite complains.

    Raises
    ------
    ValueError
        If the provenance lacks what every command reads: backend, version, settings, seed.
    """

    centers: np.ndarray  # (S, 3) float64, metres, the object's frame, in the order in which they settled
    on_object: np.ndarray  # (S,) bool: touches the object (True) or only spheres (False)
    rolled_off: int
    rejected: int
    timed_out: int
    stop: Stop
    seconds: float  # wall time of the simulation alone
    # Every drop in the order in which they ended, the settled ones in the order of ``centers``; empty where a backend
    # does not tell.
    columns: np.ndarray = field(default_factory=lambda: np.empty((0, 2)))  # (D, 2) float64, where it began, metres
    outcomes: np.ndarray = field(default_factory=lambda: np.empty(0, np.int8))  # (D,) int8, each an `Outcome`
    provenance: dict[str, Any]  # what made it, see `provenance_of`; more entries are welcome, JSON-ready

    def __post_init__(self):
        missing = sorted({"backend", "version", "settings", "seed"} - self.provenance.keys())
        if missing:
            raise ValueError(
                f"provenance: expected backend, version, settings and seed, got none of {', '.join(missing)}; "
                "use provenance_of(simulator, settings, seed)"
            )

    @property
    def settled(self) -> int:
        return len(self.centers)

    @property
    def drops(self) -> int:
        return self.settled + self.rolled_off + self.rejected + self.timed_out


@runtime_checkable
class Simulator(Protocol):
    """What a backend provides: a name, a version, ``options`` and ``drop``.

    A class, registered under its ``name`` in the entry-point group ``spherefunc.backends``; keyword arguments of its
    constructor are its options, and one that it does not know is a TypeError. docs/backends.md has a whole one, and
    ``pytest --pyargs spherefunc_bullet.conformance --backend NAME`` holds one to what is written here.

    Attributes
    ----------
    name : str
        As it is registered.
    version : str
        Of what it computes: results are kept under it, so another result needs another version.
    isolate : bool, optional
        True: native code that may crash. The command line and `simulate_objects` then run it in a process of its own,
        where a crash costs one object and not the run; for that it can be pickled. A call of ``drop`` itself always
        runs where it is made.
    sphere_limit : int, optional
        Settled spheres that end a run for features, where the simulator needs a limit of its own.
    as_drawn : bool, optional
        An option of a simulator that may drop spheres in another order than their columns are drawn in, which True
        forbids; spheres of runs to the end that become features are dropped so.
    """

    name: str
    version: str

    def drop(self, cloud: Cloud, settings: DropSettings, seed: int = 0) -> DropResult:
        """Drop spheres on a cloud until one of the limits is reached, in this order: misses, spheres, drops.

        Columns are drawn uniformly over the bounding box, a sphere comes straight down its column, and one at rest is
        static for ever. A sphere at rest keeps off the points by its radius, may rest on spheres alone only while its
        centre is within the bounding box (else `Outcome.REJECTED`), and one that reaches the ground z = 0 beside the
        object has rolled off. The limits cut a run short and change nothing else: the drops of a shorter run are the
        first ones of a longer, at least of one with the attribute ``as_drawn``.

        Parameters
        ----------
        cloud : Cloud
            Points in metres, z up, standing on z = 0, with ``cloud.mesh`` where there is one; left as it was.
        settings : DropSettings
        seed : int
            The same cloud, settings and seed give the same result, bit for bit, on one machine. The order of the
            points does not matter, another seed gives other spheres.

        Raises
        ------
        InputError
            In one line, if nothing can be dropped on this cloud; of a sphere larger than it by `require_fitting`.
        """
        ...

    def options(self) -> dict[str, Any]:
        """Return the options of this simulator (shape, time step, …) as JSON values.

        Results are kept under them, so all that decides where spheres settle is among them.
        """
        ...


def provenance_of(simulator: Simulator, settings: DataclassInstance, seed: int) -> dict[str, Any]:
    """Return the provenance of a result as JSON values: backend, version, options, settings and seed."""
    return {
        "backend": simulator.name,
        "version": simulator.version,
        "options": simulator.options(),
        "settings": asdict(settings),
        "seed": seed,
    }


def one_by_one(simulator: Simulator) -> Simulator:
    """Return the simulator set to drop one sphere after another, as in the paper."""
    if is_dataclass(simulator) and hasattr(simulator, "as_drawn"):
        return replace(simulator, as_drawn=True)
    return simulator


def require_fitting(cloud: Cloud, radius: float):
    """Raise InputError if a sphere of a radius in metres is larger than the whole object."""
    if radius > cloud.size.max():
        raise InputError(
            f"{cloud.name}: expected a radius smaller than the object's {cloud.size.max():.3g} m, "
            f"got {radius:g} m; are the units right?"
        )


def isolated(simulator: Simulator) -> bool:
    """Return whether a simulator is declared to run in a process of its own."""
    return getattr(simulator, "isolate", False)


def sphere_limit(simulator: Simulator) -> int:
    """Return the number of settled spheres that ends a simulator's runs for features."""
    return getattr(simulator, "sphere_limit", SPHERE_LIMIT)


@cache
def backend_entry_points() -> dict[str, EntryPoint]:
    """Return the registered backends by name, without importing them."""
    return {point.name: point for point in entry_points(group="spherefunc.backends")}


def backend_names(text: str) -> list[str]:
    """Return the backends of a comma-separated list such as ``fast,bullet``, without repeats."""
    names = list(dict.fromkeys(name.strip() for name in text.split(",") if name.strip()))
    if not names:
        raise InputError(f"backend {text!r}: expected at least one name, such as fast or fast,bullet")
    return names


def make_simulator(simulator: str | Simulator, **options) -> Simulator:
    """Return a simulator by its registered name; a simulator object is returned unchanged.

    Raises
    ------
    InputError
        If no backend has that name, its package is missing, or an option is not one of its own.
    """
    if not isinstance(simulator, str):
        return simulator
    points = backend_entry_points()
    if simulator not in points:
        raise InputError(f"backend {simulator!r}: expected one of {', '.join(sorted(points)) or 'none installed'}")
    with explaining(f"backend {simulator!r} cannot be imported", ImportError, why=": "):
        backend = points[simulator].load()
    with explaining(f"backend {simulator!r}", TypeError, why=": "):
        return backend(**options)
