"""Settling: the drops of one simulator on one cloud at several radii, timed."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

import numpy as np

from ..clouds.cloud import Cloud, Mesh
from ..clouds.preparation import headed, surround_centre
from ..errors import InputError, one_line, require_amount
from ..formats.units import format_length
from ..simulator import DropSettings, Simulator, drop_on, make_simulator, one_by_one, sphere_limit
from ..simulator.mechanics import LEVEL, Material, StandSettings
from .drops import DROPS, LIMITED, NO_DROPS, Drops, DropsByRadius, RunLimit, drops_of, resting_drops

DENSE = 0.5  # radii, approximate spacing of the points that walls are looked for in
SMALL = 0.005  # metres, radius of the spheres that test whether water stands in an object
FINE, HANDHELD = 0.01, 0.4  # metres: spheres smaller than FINE are dropped only on objects up to HANDHELD
COVERING = 0.6  # spacings of a cloud's points: smaller spheres fall through, half the diagonal of a lattice is 0.7
FALLS_DEG = 20.0  # degrees by which an object that falls over tilts at least; no useful one of 382 real models does
STATUS, RESET = Path("/proc/self/status"), Path("/proc/self/clear_refs")  # Linux

_warm: set[str] = set()  # the simulators that have run in this process


def settle(
    cloud: Cloud, simulator: str | Simulator, radii: Sequence[float], seed: int = 0, run_limit: RunLimit = LIMITED
) -> DropsByRadius:
    """Return the drops of each radius (metres) on a cloud.

    There are none where the sphere is larger than the object. See `drop_settings`.
    """
    simulator = make_simulator(simulator)
    return {radius: drop_if_useful(cloud, simulator, radius, seed, run_limit)[0] for radius in checked_radii(radii)}


def checked_radii(radii: Sequence[float]) -> tuple[float, ...]:
    """Return the radii of spheres, metres; InputError if they are no numbers above zero."""
    if isinstance(radii, str) or not isinstance(radii, Iterable):
        raise InputError(f"radii: expected lengths in metres, such as (0.01, 0.02), got {one_line(repr(radii)):.200}")
    for radius in (radii := tuple(radii)):
        require_amount("radii", radius, above=0.0)
    return radii


def mesh_leaks(cloud: Cloud) -> bool:
    """Return whether water runs out of an object through a hole; False without a mesh."""
    return cloud.mesh is not None and loses_water(cloud)


def points_leak(cloud: Cloud) -> bool:
    """Return whether water would run out between the points of an object that has no mesh."""
    return cloud.mesh is None and loses_water(cloud)


def loses_water(cloud: Cloud) -> bool:
    """Return whether water runs out of an object where small spheres stay in it.

    The spheres only show where a vessel would hold water, so ``fast`` drops them, whatever the simulator.
    """
    from ..clouds.water import leaks  # needed for cups only

    simulator = make_simulator("fast")
    return leaks(cloud, simulator.drop(cloud, drop_settings(simulator, SMALL, RunLimit(drops=DROPS)), 0).centers)


def drop_if_useful(
    cloud: Cloud, simulator: Simulator, radius: float, seed: int, run_limit: RunLimit
) -> tuple[Drops, float, int]:
    """Return the drops of one radius, the seconds they took, and their number; none if nothing can be learnt."""
    if too_fine(radius, cloud, run_limit) or radius > cloud.size.max():
        return no_drops(radius, run_limit), 0.0, 0
    if run_limit.drops is None:
        simulator = one_by_one(simulator)
        result = drop_on(cloud, simulator, drop_settings(simulator, radius, run_limit), seed)
        drops = replace(resting_drops(radius, result.centers.astype(np.float32)), provenance=result.provenance)
        return drops, result.seconds, result.drops
    cloud, angle = headed(cloud)
    result = drop_on(cloud, simulator, drop_settings(simulator, radius, run_limit), seed)
    drops = drops_of(result, cloud.thinned(DENSE * radius), radius).turned(-angle)
    return drops, result.seconds, result.drops


def too_fine(radius: float, cloud: Cloud, run_limit: RunLimit) -> bool:
    """Return whether spheres are too small for a limited number of them to say anything about so large an object."""
    return run_limit.drops is not None and radius < FINE and cloud.size.max() > HANDHELD


def warn_of_gaps(cloud: Cloud, radius: float, report: Callable[[str], object]):
    """Report a line if spheres of a radius, metres, may fall through between the points of a cloud."""
    spacing = cloud.spacing
    if radius < COVERING * spacing:
        small, apart, least = map(format_length, (radius, float(f"{spacing:.2g}"), float(f"{COVERING * spacing:.2g}")))
        report(f"{cloud.name}: spheres of radius {small} may fall through points {apart} apart; use at least {least}")


def no_drops(radius: float, run_limit: RunLimit) -> Drops:
    """Return an empty set of drops."""
    return replace(NO_DROPS, radius=radius, losses_known=run_limit.drops is not None)


def drop_settings(simulator: Simulator, radius: float, run_limit: RunLimit = LIMITED) -> DropSettings:
    """Return the settings of a run whose drops become features.

    Runs to the end stop by the rule of the paper only (§III-A), unless the simulator declares a limit of its own.
    """
    if run_limit.drops is not None:
        return DropSettings(radius=radius, miss_limit=run_limit.drops, max_drops=run_limit.drops, even_columns=True)
    if run_limit.to_the_end and not hasattr(simulator, "sphere_limit"):
        return DropSettings(radius=radius, miss_limit=run_limit.miss_limit)
    return DropSettings(radius=radius, miss_limit=run_limit.miss_limit, max_spheres=sphere_limit(simulator))


def measured_run(
    cloud: Cloud, simulator: Simulator, radius: float, seed: int, run_limit: RunLimit = LIMITED
) -> dict[str, np.ndarray]:
    """Return a cache entry: the drops as `Drops.rows`, their number, the seconds and, if known, the peak memory.

    Entries of earlier versions lack memory and outcomes.
    """
    warm_up(simulator, run_limit)
    reset_peak()
    drops, seconds, count = drop_if_useful(cloud, simulator, radius, seed, run_limit)
    run = {"centers": drops.rows(), "seconds": np.array(seconds), "drops": np.array(count)}
    if drops.losses_known:
        run["outcomes"] = drops.outcomes
    peak = peak_bytes()
    return run if peak is None or not count else run | {"memory": np.array(peak)}


def warm_up(simulator: Simulator, run_limit: RunLimit = LIMITED):
    """Have a simulator compile or load its code, so that the first timed run of this process does not include it."""
    few = None if run_limit.drops is None else 1
    kind = f"{simulator.name} {simulator.options()} {few}"
    if kind in _warm:
        return
    _warm.add(kind)
    with suppress(InputError):  # the run on the object will report what is wrong
        drop_on(small_plate(), simulator, DropSettings(radius=0.02, max_spheres=1, max_drops=few))


def small_plate() -> Cloud:
    """Return a level square of 10 cm, 10 cm above the ground, with its mesh; made without the code for sampling."""
    x, y = np.mgrid[-0.05:0.05:21j, -0.05:0.05:21j]
    points = np.column_stack([x.ravel(), y.ravel(), np.full(x.size, 0.1)])
    corners = np.array([[-0.05, -0.05, 0.1], [0.05, -0.05, 0.1], [0.05, 0.05, 0.1], [-0.05, 0.05, 0.1]])
    return Cloud(points, "plate", Mesh(corners, np.array([[0, 1, 2], [0, 2, 3]])))


def falls_over(cloud: Cloud) -> bool:
    """Return whether an object tilts by more than 20 degrees when it is released as it stands.

    False without a mesh, since unseen parts have weight and feet too; and for an object without volume.
    """
    if cloud.mesh is None or stands_safely(cloud):
        return False
    from ..simulator.statics.body import body_of  # imported here: loading scipy's hull takes longer than most answers
    from ..simulator.statics.standing import stand

    try:
        body = body_of(cloud, Material())
    except InputError:
        return False
    return stand(body, StandSettings()).tilt_deg > FALLS_DEG


def stands_safely(cloud: Cloud) -> bool:
    """Return whether the centre of mass is well inside the support polygon, by a quick test that most objects pass."""
    vertices = cloud.mesh.vertices
    return surround_centre(vertices[vertices[:, 2] < vertices[:, 2].min() + LEVEL * cloud.size.max(), :2], cloud)


def reset_peak():
    """Reset the peak memory of this process, where that is possible (Linux)."""
    with suppress(OSError):
        RESET.write_text("5", encoding="ascii")


def peak_bytes() -> int | None:
    """Return the peak memory of this process in bytes, including the interpreter; None if unknown."""
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
