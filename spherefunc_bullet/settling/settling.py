"""One cloud, one simulator, some radii: what becomes of the spheres, timed."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

import numpy as np

from ..clouds.cloud import Cloud, Mesh
from ..clouds.preparation import SAFE, headed, reach_around
from ..errors import InputError
from ..processes.tasks import run_tasks
from ..simulator import DropSettings, Simulator, isolated, make_simulator, one_by_one, sphere_limit
from ..simulator.mechanics import LEVEL, Material, StandSettings
from .drops import DROPS, LIMITED, NO_DROPS, Drops, DropsByRadius, RunLimit, drops_of, resting_drops

DENSE = 0.5  # radii between points, about, that few drops pay for
SMALL = 0.005  # metres: of spheres among which water is to stand
FINE, HANDHELD = 0.01, 0.4  # metres: spheres smaller than this fall only on what a hand can hold, if drops are few
FALLS_DEG = 20.0  # by which an object would turn: no useful one of 382 models by other people does so (tests)
STATUS, RESET = Path("/proc/self/status"), Path("/proc/self/clear_refs")  # Linux

_warm: set[str] = set()  # the simulators that have run in this process


def settle(
    cloud: Cloud, simulator: str | Simulator, radii: Sequence[float], seed: int = 0, length: RunLimit = LIMITED
) -> DropsByRadius:
    """Return what becomes of the spheres of each radius (metres) that are dropped on a cloud.

    Where the sphere is larger than the object nothing can settle, and there are none. See `drop_settings`.
    """
    simulator = make_simulator(simulator)
    return {radius: drop_or_nothing(cloud, simulator, radius, seed, length)[0] for radius in radii}


def loses_water(cloud: Cloud) -> bool:
    """Return whether water runs out from among small spheres that stay in an object; never of points alone.

    The spheres say only where a vessel of its form would hold them: those of ``fast`` do, whichever simulator is asked.
    """
    if cloud.mesh is None:
        return False
    from ..clouds.water import leaks  # of cups alone

    simulator = make_simulator("fast")
    return leaks(cloud, simulator.drop(cloud, drop_settings(simulator, SMALL, RunLimit(drops=DROPS)), 0).centers)


def settle_all(
    clouds: Sequence[Cloud],
    simulator: str | Simulator,
    radii: Sequence[Sequence[float]],
    seed: int,
    names: Sequence,
    length: RunLimit = LIMITED,
) -> Iterator[tuple[int, DropsByRadius | InputError]]:
    """Settle several clouds, each at radii of its own; a simulator that may crash does so in another process.

    Parameters
    ----------
    names : sequence
        What errors call each cloud, such as its file's path.

    Yields
    ------
    index, outcome : int, DropsByRadius or InputError
        In the order of the clouds.
    """
    simulator = make_simulator(simulator)
    tasks = [(cloud, simulator, lengths, seed, length) for cloud, lengths in zip(clouds, radii, strict=True)]
    yield from run_tasks(settle, tasks, names, isolate=isolated(simulator))


def drop_or_nothing(
    cloud: Cloud, simulator: Simulator, radius: float, seed: int, length: RunLimit
) -> tuple[Drops, float, int]:
    """Return what becomes of the spheres of one radius, the seconds, and how many were dropped."""
    if too_fine(radius, cloud, length) or radius > cloud.size.max():
        return no_drops(radius, length), 0.0, 0
    if length.drops is None:
        simulator = one_by_one(simulator)
        result = simulator.drop(cloud, drop_settings(simulator, radius, length), seed)
        drops = replace(resting_drops(radius, result.centers.astype(np.float32)), provenance=result.provenance)
        return drops, result.seconds, result.drops
    cloud, angle = headed(cloud)
    result = simulator.drop(cloud, drop_settings(simulator, radius, length), seed)
    drops = drops_of(result, cloud.thinned(DENSE * radius), radius).turned(-angle)
    return drops, result.seconds, result.drops


def too_fine(radius: float, cloud: Cloud, length: RunLimit) -> bool:
    """Return whether spheres of a radius are too small, of a stated number of them, to tell of so large an object."""
    return length.drops is not None and radius < FINE and cloud.size.max() > HANDHELD


def no_drops(radius: float, length: RunLimit) -> Drops:
    """Return what becomes of no spheres."""
    return replace(NO_DROPS, radius=radius, losses_known=length.drops is not None)


def drop_settings(simulator: Simulator, radius: float, length: RunLimit = LIMITED) -> DropSettings:
    """Return the settings of a run whose spheres become features.

    Runs to the end stop by the paper's rule alone (§III-A), unless the simulator declares a limit of its own.
    """
    if length.drops is not None:
        return DropSettings(radius=radius, miss_limit=length.drops, max_drops=length.drops)
    if length.to_the_end and not hasattr(simulator, "sphere_limit"):
        return DropSettings(radius=radius, miss_limit=length.miss_limit)
    return DropSettings(radius=radius, miss_limit=length.miss_limit, max_spheres=sphere_limit(simulator))


def measured_run(
    cloud: Cloud, simulator: Simulator, radius: float, seed: int, length: RunLimit = LIMITED
) -> dict[str, np.ndarray]:
    """Return a cache entry: the drops as `Drops.rows`, their number, the seconds and, where it is known, the memory.

    Entries that were made before memory was measured, or outcomes were kept, lack them.
    """
    warm_up(simulator, length)
    reset_peak()
    drops, seconds, count = drop_or_nothing(cloud, simulator, radius, seed, length)
    run = {"centers": drops.rows(), "seconds": np.array(seconds), "drops": np.array(count)}
    if drops.losses_known:
        run["outcomes"] = drops.outcomes
    peak = peak_bytes()
    return run if peak is None or not count else run | {"memory": np.array(peak)}


def warm_up(simulator: Simulator, length: RunLimit = LIMITED):
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


def falls_over(cloud: Cloud) -> bool:
    """Return whether an object turns by more than 20 degrees when it is let go as it stands.

    Of points alone nobody knows: what the sensor did not see has weight, too, and feet. Nor does a sheet fall.
    """
    if cloud.mesh is None or stands_safely(cloud):
        return False
    from ..simulator.statics.body import body_of  # scipy's hull, which takes longer to load than most answers
    from ..simulator.statics.standing import stand

    try:
        body = body_of(cloud, Material())
    except InputError:
        return False
    return stand(body, StandSettings()).tilt_deg > FALLS_DEG


def stands_safely(cloud: Cloud) -> bool:
    """Return whether an object's weight acts well within the polygon of its feet: most do, which is quickly seen."""
    vertices, extent = cloud.mesh.vertices, cloud.size.max()
    feet = vertices[vertices[:, 2] < vertices[:, 2].min() + LEVEL * extent, :2]
    return bool(reach_around(feet, cloud) > SAFE * extent)


def reset_peak():
    """Begin to measure anew, where the system can: on Linux. Elsewhere the peak is since the process began."""
    with suppress(OSError):
        RESET.write_text("5", encoding="ascii")


def peak_bytes() -> int | None:
    """Return the most memory that this process has had, interpreter and libraries included; None if unknown."""
    with suppress(OSError):
        for line in STATUS.read_text(encoding="ascii", errors="replace").splitlines():
            if line.startswith("VmHWM:"):
                return int(line.split()[1]) * 1024
    try:
        import resource
    except ImportError:  # Windows
        return None
    unit = 1 if sys.platform == "darwin" else 1024  # macOS counts bytes, others kibibytes
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit
