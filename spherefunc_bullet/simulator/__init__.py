"""The interface between simulators and everything that uses them.

A simulator takes a cloud, settings and a seed and returns where the spheres came to rest (paper, §III-A).
Backends are found through the entry-point group ``spherefunc.backends``, so that another package can add one.
"""

from __future__ import annotations

import enum
from dataclasses import MISSING, asdict, dataclass, field, is_dataclass, replace
from functools import cache
from importlib.metadata import EntryPoint, entry_points
from inspect import signature
from typing import TYPE_CHECKING, Any, Protocol, runtime_checkable

import numpy as np

from ..clouds.cloud import Cloud
from ..errors import CheckedSettings, InputError, amount, blaming, explaining, one_line, require_amount

if TYPE_CHECKING:
    from _typeshed import DataclassInstance  # the settings of any ability

MISS_LIMIT = 50  # consecutive spheres not placed that end a run (§III-A)
LIMIT = 10**18 - 1  # of every limit: kernels count in 64 bits
PLASTIC = 1.32471795724474602596  # the root of x³ = x + 1
R2 = np.array([1 / PLASTIC, 1 / PLASTIC**2])  # steps of the R2 sequence
SPHERE_LIMIT = 20_000  # settled spheres that end a run for features; no cup holds more of the smallest spheres


class Outcome(enum.IntEnum):
    """How one sphere's drop ended."""

    SETTLED = 0
    ROLLED_OFF = 1  # reached the ground
    REJECTED = 2  # came to rest on spheres alone, outside the object's bounding box
    TIMED_OUT = 3  # never came to rest within the simulator's limit


class Stop(enum.IntEnum):
    """Why the run ended."""

    MISSES = 0  # the miss limit of the paper: consecutive spheres were not placed
    SPHERE_LIMIT = 1  # the limit of settled spheres was reached
    DROP_LIMIT = 2  # the requested number of spheres has been dropped


@dataclass(frozen=True, kw_only=True)
class DropSettings(CheckedSettings):
    """The settings of a run that the paper fixes (§III-A), the same for every backend."""

    radius: float = amount(MISSING, above=0.0)  # of the spheres, metres
    # Consecutive spheres not placed that end the run.
    miss_limit: int = amount(MISS_LIMIT, least=1, most=LIMIT)
    # Settled spheres at which the run stops, to limit memory.
    max_spheres: int = amount(5_000_000, least=1, most=LIMIT)
    # Drops at which the run stops, whatever their outcomes; None: no limit.
    max_drops: int | None = amount(None, least=1, most=LIMIT)
    even_columns: bool = False  # whether columns are spread evenly instead of drawn at random


@dataclass(frozen=True, kw_only=True)
class DropResult:
    """Where the spheres came to rest, and the outcomes of the others.

    A backend sets all fields. One that does not know the outcome of every drop may omit ``columns`` and ``outcomes``;
    then the resting profile, the default method, sees no losses, and the conformance suite fails.

    Raises
    ------
    ValueError
        If the provenance lacks an entry that all commands read: backend, version, settings or seed; if centres are not
        finite, or the outcomes do not match them.
    """

    centers: np.ndarray  # (S, 3) float64, metres, the object's frame, in the order in which they settled
    on_object: np.ndarray  # (S,) bool: touches the object (True) or only spheres (False)
    rolled_off: int
    rejected: int
    timed_out: int
    stop: Stop
    seconds: float  # wall time of the simulation alone
    # Of all drops in the order in which they ended, the settled ones in the order of ``centers``; empty if the backend
    # does not provide them.
    columns: np.ndarray = field(default_factory=lambda: np.empty((0, 2)))  # (D, 2) float64, metres: of each drop
    outcomes: np.ndarray = field(default_factory=lambda: np.empty(0, np.int8))  # (D,) int8, each an `Outcome`
    provenance: dict[str, Any]  # see `provenance_of`; a backend may add entries, JSON-ready

    def __post_init__(self):
        missing = sorted({"backend", "version", "settings", "seed"} - self.provenance.keys())
        if missing:
            raise ValueError(
                f"provenance: expected backend, version, settings and seed, got none of {', '.join(missing)}; "
                "use provenance_of(simulator, settings, seed)"
            )
        centers = self.centers  # checked here, since caches and ledgers would keep a wrong result
        if not isinstance(centers, np.ndarray) or centers.dtype.kind != "f" or centers.shape[1:] != (3,):
            about = f"{centers.dtype} {centers.shape}" if isinstance(centers, np.ndarray) else type(centers).__name__
            raise ValueError(f"centers: expected an array of floats (S, 3), got {about}")
        if not np.isfinite(centers).all():
            raise ValueError("centers: expected finite numbers, got NaN or infinity")
        settled = np.count_nonzero(np.asarray(self.outcomes) == Outcome.SETTLED)
        if len(self.columns) != len(self.outcomes) or len(self.outcomes) and settled != len(centers):
            raise ValueError(
                f"outcomes: expected a column for each, and {len(centers)} settled as in centers, got "
                f"{len(self.columns)} columns, {len(self.outcomes)} outcomes, {settled} of them settled"
            )

    @property
    def settled(self) -> int:
        return len(self.centers)

    @property
    def drops(self) -> int:
        return self.settled + self.rolled_off + self.rejected + self.timed_out


@runtime_checkable
class Simulator(Protocol):
    """The interface of a backend: a name, a version, ``options`` and ``drop``.

    A backend is a class registered under its ``name`` in the entry-point group ``spherefunc.backends``. The keyword
    arguments of its constructor are its options; an unknown one is a TypeError. docs/backends.md has a complete
    example, and ``pytest --pyargs spherefunc_bullet.conformance --backend NAME`` tests a backend against this
    interface.

    Attributes
    ----------
    name : str
        The registered name.
    version : str
        The version of the computation. Results are cached under it, so a change of results needs a new version.
    isolate : bool, optional
        True for native code that may crash. The command line and `simulate_objects` then run it in a separate process,
        where a crash costs one object and not the run; for that it must be picklable. A direct call of ``drop`` always
        runs in the calling process.
    sphere_limit : int, optional
        Settled spheres that end a run for features, if the simulator needs its own limit.
    as_drawn : bool, optional
        An option of a simulator that may drop spheres in another order than that in which their columns are drawn; True
        forbids that. Runs to the end whose spheres become features set it.
    """

    name: str
    version: str

    def drop(self, cloud: Cloud, settings: DropSettings, seed: int = 0) -> DropResult:
        """Drop spheres on a cloud until one of the limits is reached, checked in this order: misses, spheres, drops.

        `Columns` draws columns over the bounding box, each sphere falls straight down its column, and a sphere at rest
        is static for ever. A sphere at rest does not overlap the points. It may rest on spheres alone only if its
        centre is within the bounding box (else `Outcome.REJECTED`). A sphere that reaches the ground z = 0 next to the
        object has rolled off. The limits cut a run short and change nothing else: the drops of a shorter run are the
        first ones of a longer run, at least with the attribute ``as_drawn``.

        Parameters
        ----------
        cloud : Cloud
            Points in metres, z up, standing on z = 0, with ``cloud.mesh`` if there is a mesh; it is not changed.
        settings : DropSettings
        seed : int
            The same cloud, settings and seed give the same result, bit for bit, on one machine. The order of the
            points does not matter; another seed gives other spheres.

        Raises
        ------
        InputError
            In one line, if nothing can be dropped on this cloud; `require_fitting` raises it for a sphere that is
            larger than the cloud.
        """
        ...

    def options(self) -> dict[str, Any]:
        """Return the options of this simulator (shape, time step, …) as JSON values.

        Results are cached under them, so they must include everything that decides where spheres settle.
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
    """Raise InputError for what is no cloud, or if a sphere, by its radius in metres, is larger than the object."""
    if not isinstance(cloud, Cloud):
        raise InputError(f"cloud: expected a Cloud, got {type(cloud).__name__}; as_cloud makes one of it")
    if radius > cloud.size.max():
        raise InputError(
            f"{cloud.name}: expected a radius smaller than the object's {cloud.size.max():.3g} m, "
            f"got {radius:g} m; are the units right?"
        )


def generator_of(seed: int) -> np.random.Generator:
    """Return the random numbers of a seed; without one, a run could not be repeated."""
    require_amount("seed", seed, whole=True)
    return np.random.default_rng(seed)


class Columns:
    """Draws the columns of a run: uniformly at random (§III-A), or spread evenly.

    Columns that are spread evenly are the R2 sequence (Roberts, 2018), moved as a whole by the seed: every first part
    of it covers the rectangle without clusters and gaps. So what is counted varies less from seed to seed.

    Parameters
    ----------
    low, high : (2,) float64
        Corners of the rectangle, in the unit of the columns.
    """

    def __init__(self, low: np.ndarray, high: np.ndarray, settings: DropSettings, seed: int):
        self.low, self.high, self.even = low, high, settings.even_columns
        self.generator = generator_of(seed)
        self.shift, self.drawn = self.generator.uniform(size=2) if self.even else np.zeros(2), 0

    def draw(self, count: int) -> np.ndarray:
        """Return the next columns, (count, 2) float64."""
        if not self.even:
            return self.generator.uniform(self.low, self.high, size=(count, 2))
        numbers = np.arange(self.drawn, self.drawn + count)[:, None]
        self.drawn += count
        return self.low + (self.shift + numbers * R2) % 1.0 * (self.high - self.low)


def drop_on(cloud: Cloud, simulator: Simulator, settings: DropSettings, seed: int = 0) -> DropResult:
    """Drop spheres on a cloud; InputError names it and the simulator for whatever a backend of others may raise."""
    with blaming(f"{cloud.name}: backend {simulator.name!r}"):
        return simulator.drop(cloud, settings, seed)


def isolated(simulator: Simulator) -> bool:
    """Return whether a simulator declares that it must run in a separate process."""
    return getattr(simulator, "isolate", False)


def sphere_limit(simulator: Simulator) -> int:
    """Return the number of settled spheres that ends a simulator's runs for features."""
    return getattr(simulator, "sphere_limit", SPHERE_LIMIT)


@cache
def backend_entry_points() -> dict[str, EntryPoint]:
    """Return the registered backends by name, without importing them."""
    return {point.name: point for point in entry_points(group="spherefunc.backends")}


def backend_names(text: str) -> list[str]:
    """Return the backends of a comma-separated list such as ``fast,bullet``, without duplicates."""
    with explaining(f"backend {text!r}: expected a name, such as fast", AttributeError):
        names = list(dict.fromkeys(name.strip() for name in text.split(",") if name.strip()))
    if not names:
        raise InputError(f"backend {text!r}: expected at least one name, such as fast or fast,bullet")
    return names


def make_simulator(simulator: str | Simulator, **options) -> Simulator:
    """Return a simulator by its registered name; a simulator object is returned unchanged.

    Raises
    ------
    InputError
        If no backend has that name, it cannot be imported or made, or an option is not one of its own.
    """
    points = backend_entry_points()
    if isinstance(simulator, Simulator) and not isinstance(simulator, type):
        if options:
            raise InputError(f"{', '.join(options)}: expected with a backend's name, got a simulator")
        return simulator
    if not isinstance(simulator, str) or simulator not in points:
        known = ", ".join(sorted(points)) or "none installed"
        raise InputError(f"backend {one_line(repr(simulator)):.200}: expected one of {known}")
    with explaining(f"backend {simulator!r} cannot be imported", Exception, why=": "):  # it may raise anything
        backend = points[simulator].load()
        known = signature(backend)
    names = ", ".join(known.parameters)
    expected = f"options of {names}" if names else "no options"
    with explaining(f"backend {simulator!r}: expected {expected}", TypeError, why="; "):
        known.bind(**options)
    with explaining(f"backend {simulator!r}", TypeError, OSError, RuntimeError, why=": "):  # such as a missing licence
        made = backend(**options)
    if not isinstance(made, Simulator):
        raise InputError(f"backend {simulator!r}: expected name, version, options() and drop(); see docs/backends.md")
    return made
