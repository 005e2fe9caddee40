"""Spheres dropped on a whole scene: where they come to rest on it, each as if it were alone.

The paper drops spheres on objects. On a scene they find what carries and what holds before anything is an object.
"""

from __future__ import annotations

import numpy as np

from spherefunc_bullet.clouds.cloud import MIN_POINTS, Cloud
from spherefunc_bullet.errors import InputError
from spherefunc_bullet.processes.tasks import run_tasks
from spherefunc_bullet.simulator import DropSettings, Simulator, isolated, make_simulator

from ..settings import POOL


def resting_places(points: np.ndarray, simulator: str | Simulator, radius: float, *, seed: int = 0) -> np.ndarray:
    """Return where spheres rest that touch a scene, their centres (S, 3), metres.

    Several runs of few spheres: they lie apart, and what rests on other spheres is left out, so nothing piles up.

    Parameters
    ----------
    points : (N, 3) float64, metres, level frame
        Of the scene above its ground z = 0, without the ground's own.
    simulator : str or Simulator
    radius : float
        Metres.
    seed : int

    Raises
    ------
    InputError
        What the simulator says of a scene that it cannot do.
    """
    points = points[points[:, 2] > 0]
    if len(points) < MIN_POINTS or np.ptp(points, axis=0).max() < radius:
        return np.empty((0, 3))
    scene, simulator = Cloud(points, "scene"), make_simulator(simulator)
    count = max(int(POOL.density * np.prod(scene.size[:2]) / radius**2), POOL.min_spheres)
    settings = DropSettings(radius=radius, miss_limit=count, max_drops=count)
    tasks = [(scene, simulator, settings, seed + run) for run in range(POOL.runs)]
    found = []
    for _, outcome in run_tasks(centers_on, tasks, ["scene"] * POOL.runs, isolate=isolated(simulator)):
        if isinstance(outcome, InputError):
            raise outcome
        found.append(outcome)
    return np.vstack(found)


def centers_on(scene: Cloud, simulator: Simulator, settings: DropSettings, seed: int) -> np.ndarray:
    """Return the centres (S, 3) of the spheres of one run that rest on the scene itself, metres."""
    result = simulator.drop(scene, settings, seed)
    return result.centers[result.on_object]
