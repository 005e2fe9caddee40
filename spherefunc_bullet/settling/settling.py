"""One cloud, one simulator, some radii: the settled centres, timed."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import suppress

import numpy as np

from ..clouds.cloud import Cloud, Mesh
from ..clouds.heading import headed
from ..errors import InputError
from ..processes.memory import forget_peak, peak_bytes
from ..processes.tasks import run_tasks
from ..simulator import DropSettings, Simulator, isolated, make_simulator, one_by_one, sphere_limit
from .drops import LIMITED, NO_DROPS, Length, drop_array, turned_drops

# Radius in metres -> where spheres settled, centres (S, 3), metres; or, of runs of a stated number of drops, what
# became of each, (D, 6); see `drops`.
Settled = dict[float, np.ndarray]

DENSE = 0.5  # radii between points, about, that few drops pay for
FINE, HANDHELD = 0.01, 0.4  # metres: spheres smaller than this fall only on what a hand can hold, if drops are few

_warm: set[str] = set()  # the simulators that have run in this process


def settle(
    cloud: Cloud, simulator: str | Simulator, radii: Sequence[float], seed: int = 0, length: Length = LIMITED
) -> Settled:
    """Return the settled centres (S, 3) float32 of a cloud for each radius, in metres.

    Where the sphere is larger than the object nothing can settle, and there are none. See `drop_settings`.
    """
    simulator = make_simulator(simulator)
    return {radius: drop_or_nothing(cloud, simulator, radius, seed, length)[0] for radius in radii}


def settle_all(
    clouds: Sequence[Cloud],
    simulator: str | Simulator,
    radii: Sequence[Sequence[float]],
    seed: int,
    names: Sequence,
    length: Length = LIMITED,
) -> Iterator[tuple[int, Settled | InputError]]:
    """Settle several clouds, each at radii of its own; a simulator that may crash does so in another process.

    Parameters
    ----------
    names : sequence
        What errors call each cloud, such as its file's path.

    Yields
    ------
    index, outcome : int, Settled or InputError
        In the order of the clouds.
    """
    simulator = make_simulator(simulator)
    tasks = [(cloud, simulator, lengths, seed, length) for cloud, lengths in zip(clouds, radii, strict=True)]
    yield from run_tasks(settle, tasks, names, isolate=isolated(simulator))


def drop_or_nothing(
    cloud: Cloud, simulator: Simulator, radius: float, seed: int, length: Length
) -> tuple[np.ndarray, float, int]:
    """Return the settled centres (S, 3) or the drops (D, 6) float32, the seconds and the drops of one radius."""
    if length.drops is not None and radius < FINE and cloud.size.max() > HANDHELD:
        return NO_DROPS, 0.0, 0
    if radius > cloud.size.max():
        return np.empty((0, 3), np.float32) if length.drops is None else NO_DROPS, 0.0, 0
    if length.drops is None:
        simulator = one_by_one(simulator)
        result = simulator.drop(cloud, drop_settings(simulator, radius, length), seed)
        return result.centers.astype(np.float32), result.seconds, result.drops
    cloud, angle = headed(cloud)
    result = simulator.drop(cloud, drop_settings(simulator, radius, length), seed)
    rows = drop_array(result, cloud.thinned(DENSE * radius), radius)
    return turned_drops(rows, -angle), result.seconds, result.drops


def drop_settings(simulator: Simulator, radius: float, length: Length = LIMITED) -> DropSettings:
    """Return the settings of a run whose spheres become features.

    Runs to the end stop by the paper's rule alone (§III-A), unless the simulator declares a limit of its own.
    """
    if length.drops is not None:
        return DropSettings(radius=radius, miss_limit=length.drops, max_drops=length.drops)
    if length.to_the_end and not hasattr(simulator, "sphere_limit"):
        return DropSettings(radius=radius, miss_limit=length.miss_limit)
    return DropSettings(radius=radius, miss_limit=length.miss_limit, max_spheres=sphere_limit(simulator))


def measured_run(
    cloud: Cloud, simulator: Simulator, radius: float, seed: int, length: Length = LIMITED
) -> dict[str, np.ndarray]:
    """Return a cache entry: where spheres settled, the drops, the seconds and, where it is known, the peak of memory.

    Entries that were made before memory was measured lack it.
    """
    warm_up(simulator, length)
    forget_peak()
    rows, seconds, drops = drop_or_nothing(cloud, simulator, radius, seed, length)
    run = {"centers": rows, "seconds": np.array(seconds), "drops": np.array(drops)}
    peak = peak_bytes()
    return run if peak is None or not drops else run | {"memory": np.array(peak)}


def warm_up(simulator: Simulator, length: Length = LIMITED):
    """Have a simulator compile or load its code for runs of a length before the first one of this process is timed."""
    few = None if length.drops is None else 1
    kind = f"{simulator.name} {simulator.options()} {few}"
    if kind in _warm:
        return
    _warm.add(kind)
    with suppress(InputError):  # what is wrong with the simulator is said of the object
        simulator.drop(small_plate(), DropSettings(radius=0.02, max_spheres=1, max_drops=few))


def small_plate() -> Cloud:
    """Return a level square of 10 cm in the air, with its mesh; made here, since sampling has code of its own."""
    x, y = np.mgrid[-0.05:0.05:21j, -0.05:0.05:21j]
    points = np.column_stack([x.ravel(), y.ravel(), np.full(x.size, 0.1)])
    corners = np.array([[-0.05, -0.05, 0.1], [0.05, -0.05, 0.1], [0.05, 0.05, 0.1], [-0.05, 0.05, 0.1]])
    return Cloud(points, "plate", Mesh(corners, np.array([[0, 1, 2], [0, 2, 3]])))
