"""The peer: what one would write with PyBullet at first, without this package.

One rigid body per sphere, the default 240 Hz, frozen by setting its mass to 0 when it is slow. It is here to be
measured, not used; the ``bullet`` backend does better.
"""

from __future__ import annotations

import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np

GRAVITY = -9.81  # m/s^2
MASS = 0.01  # kg, of a sphere
SLOW = 0.01  # m/s: below this a sphere counts as at rest
SLOW_STEPS = 5  # in a row: one slow step may be the top of a bounce
MAX_STEPS = 1200  # five seconds of simulated time


def peer_mug() -> Path | None:
    """Return the mug that comes with PyBullet, or None without PyBullet."""
    try:
        import pybullet_data
    except ImportError:
        return None
    return Path(pybullet_data.getDataPath()) / "objects" / "mug.obj"


@dataclass
class NaiveRun:
    """What came of the script, as far as it got."""

    settled: int = 0
    missed: int = 0
    misses: int = 0  # in a row
    seconds: float = 0.0
    finished: bool = False  # by the miss limit; otherwise the time was up

    @property
    def drops(self) -> int:
        return self.settled + self.missed


def run_naively(vertices, faces, radius: float, *, seconds: float, miss_limit: int = 50, seed: int = 0) -> NaiveRun:
    """Drop spheres on a mesh until the miss limit, or until the time is up.

    Parameters
    ----------
    vertices, faces : (N, 3) float, (M, 3) int
        Metres, z up, standing on z = 0.
    radius : float, metres
    seconds : float
        Wall time at which to stop.
    """
    import pybullet as p
    from pybullet_utils.bullet_client import BulletClient

    client = BulletClient(connection_mode=p.DIRECT)
    client.setGravity(0, 0, GRAVITY)
    add_object(client, vertices, faces)
    sphere = client.createCollisionShape(p.GEOM_SPHERE, radius=radius)
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    columns, run, top = np.random.default_rng(seed), NaiveRun(), high[2]
    started = time.perf_counter()
    while run.misses < miss_limit and run.seconds < seconds:
        x, y = columns.uniform(low[:2], high[:2])
        height = drop_naively(client, sphere, [x, y, top + 2 * radius], radius)
        run.misses = run.misses + 1 if height is None else 0
        run.missed += height is None
        run.settled += height is not None
        top = top if height is None else max(top, height + radius)
        run.seconds = time.perf_counter() - started
    run.finished = run.misses >= miss_limit
    client.disconnect()
    return run


def add_object(client, vertices, faces):
    """Add a mesh as a static body, hollows and all."""
    import pybullet as p
    import trimesh

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "object.obj"
        trimesh.Trimesh(vertices, faces, process=False).export(path)
        shape = client.createCollisionShape(p.GEOM_MESH, fileName=str(path), flags=p.GEOM_FORCE_CONCAVE_TRIMESH)
    client.createMultiBody(0, shape)


def drop_naively(client, sphere: int, start, radius: float) -> float | None:
    """Return the height in metres at which one sphere comes to rest, or None if it misses or never does."""
    body = client.createMultiBody(MASS, sphere, basePosition=start)
    slow = 0
    for _ in range(MAX_STEPS):
        client.stepSimulation()
        height = client.getBasePositionAndOrientation(body)[0][2]
        slow = slow + 1 if np.linalg.norm(client.getBaseVelocity(body)[0]) < SLOW else 0
        if height < radius:
            break
        if slow == SLOW_STEPS:
            client.changeDynamics(body, -1, mass=0)
            return height
    client.removeBody(body)
    return None
