"""One cloud, one simulator, some radii: the settled centres, timed."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import suppress

import numpy as np

from ..clouds.cloud import Cloud, Mesh
from ..errors import InputError
from ..processes.memory import forget_peak, peak_bytes
from ..processes.tasks import run_tasks
from ..simulator import DropSettings, Simulator, isolated, make_simulator, sphere_limit
from .drops import WIDTH, drop_array

# Radius in metres -> where spheres settled, centres (S, 3), metres; or, of runs of a stated number of drops, what
# became of each, (D, 5); see `drops`.
Settled = dict[float, np.ndarray]

_warm: set[str] = set()  # the simulators that have run in this process


def settle(
    cloud: Cloud, simulator: str | Simulator, radii: Sequence[float], seed: int = 0, drops: int | None = None
) -> Settled:
    """Return the settled centres (S, 3) float32 of a cloud for each radius, in metres.

    With a number of ``drops`` exactly so many spheres fall, and what became of each is returned, (D, 5) float32; see
    `drop_array`. Where the sphere is larger than the object nothing can settle, and there are none.
    """
    simulator = make_simulator(simulator)
    return {radius: drop_or_nothing(cloud, simulator, radius, seed, drops)[0] for radius in radii}


def settle_all(
    clouds: Sequence[Cloud],
    simulator: str | Simulator,
    radii: Sequence[Sequence[float]],
    seed: int,
    names: Sequence,
    drops: int | None = None,
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
    tasks = [(cloud, simulator, lengths, seed, drops) for cloud, lengths in zip(clouds, radii, strict=True)]
    yield from run_tasks(settle, tasks, names, isolate=isolated(simulator))


def drop_or_nothing(
    cloud: Cloud, simulator: Simulator, radius: float, seed: int, drops: int | None
) -> tuple[np.ndarray, float, int]:
    """Return the settled centres (S, 3) or the drops (D, 5) float32, the seconds and the drops of one radius."""
    if radius > cloud.size.max():
        return np.empty((0, 3 if drops is None else WIDTH), np.float32), 0.0, 0
    result = simulator.drop(cloud, drop_settings(simulator, radius, drops), seed)
    rows = result.centers.astype(np.float32) if drops is None else drop_array(result)
    return rows, result.seconds, result.drops


def drop_settings(simulator: Simulator, radius: float, drops: int | None = None) -> DropSettings:
    """Return the settings of a run whose spheres become features: until 50 misses, or of so many drops."""
    if drops is None:
        return DropSettings(radius=radius, max_spheres=sphere_limit(simulator))
    return DropSettings(radius=radius, miss_limit=drops, max_drops=drops)


def measured_run(
    cloud: Cloud, simulator: Simulator, radius: float, seed: int, drops: int | None
) -> dict[str, np.ndarray]:
    """Return a cache entry: where spheres settled, the drops, the seconds and, where it is known, the peak of memory.

    Entries that were made before memory was measured lack it.
    """
    warm_up(simulator)
    forget_peak()
    rows, seconds, count = drop_or_nothing(cloud, simulator, radius, seed, drops)
    run = {"centers": rows, "seconds": np.array(seconds), "drops": np.array(count)}
    peak = peak_bytes()
    return run if peak is None or not count else run | {"memory": np.array(peak)}


def warm_up(simulator: Simulator):
    """Have a simulator compile or load its code before the first run of this process is timed."""
    kind = f"{simulator.name} {simulator.options()}"
    if kind in _warm:
        return
    _warm.add(kind)
    with suppress(InputError):  # what is wrong with the simulator is said of the object
        simulator.drop(small_plate(), DropSettings(radius=0.02, max_spheres=1))


def small_plate() -> Cloud:
    """Return a level square of 10 cm in the air, with its mesh; made here, since sampling has code of its own."""
    x, y = np.mgrid[-0.05:0.05:21j, -0.05:0.05:21j]
    points = np.column_stack([x.ravel(), y.ravel(), np.full(x.size, 0.1)])
    corners = np.array([[-0.05, -0.05, 0.1], [0.05, -0.05, 0.1], [0.05, 0.05, 0.1], [-0.05, 0.05, 0.1]])
    return Cloud(points, "plate", Mesh(corners, np.array([[0, 1, 2], [0, 2, 3]])))
