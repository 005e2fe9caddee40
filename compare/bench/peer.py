"""The peer: what one would write with PyBullet at first, without this package.

One rigid body per sphere, the default 240 Hz, frozen by setting its mass to 0 when it is slow. It is here to be
measured, not used; the ``bullet`` backend does better.
"""

from __future__ import annotations

import os
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from spherefunc_bullet.clouds.cloud import placed
from spherefunc_bullet.formats.reading import read_geometry

if TYPE_CHECKING:
    from pybullet_utils.bullet_client import BulletClient

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


@dataclass(frozen=True, kw_only=True)
class NaiveRun:
    """What came of the script, as far as it got."""

    drops: int
    centers: np.ndarray  # (S, 3) metres, where spheres settled
    ends: np.ndarray  # (S, 3) metres, where they are in the end: mass 0 alone does not hold them
    seconds: float


def run_naively(path: Path, radius: float, seconds: float, most: int) -> NaiveRun:
    """Drop spheres of a radius in metres on a mesh until so many seconds or drops are over.

    For a process of its own: stdout is closed to PyBullet, which prints on it and would spoil JSON.
    """
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())
    import pybullet as p
    from pybullet_utils.bullet_client import BulletClient

    geometry = read_geometry(path)
    vertices = placed(geometry.vertices)  # where the simulator has it
    client = BulletClient(connection_mode=p.DIRECT)
    client.setGravity(0, 0, GRAVITY)
    add_object(client, vertices, geometry.faces)
    sphere = client.createCollisionShape(p.GEOM_SPHERE, radius=radius)
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    columns, top = np.random.default_rng(0), high[2]
    drops, centers, settled = 0, [], []
    started, spent = time.perf_counter(), 0.0
    while spent < seconds and drops < most:
        x, y = columns.uniform(low[:2], high[:2])
        center = drop_naively(client, sphere, [x, y, top + 2 * radius], radius)
        drops += 1
        if center is not None:
            top = max(top, center[2] + radius)
            centers.append(center)
            settled.append(client.getBodyUniqueId(client.getNumBodies() - 1))
        spent = time.perf_counter() - started
    ends = [client.getBasePositionAndOrientation(body)[0] for body in settled]
    client.disconnect()
    centers, ends = (np.array(places, float).reshape(-1, 3) for places in (centers, ends))
    return NaiveRun(drops=drops, centers=centers, ends=ends, seconds=spent)


def add_object(client: BulletClient, vertices: np.ndarray, faces: np.ndarray):
    """Add a mesh as a static body, hollows and all."""
    import pybullet as p
    import trimesh

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "object.obj"
        trimesh.Trimesh(vertices, faces, process=False).export(path)
        shape = client.createCollisionShape(p.GEOM_MESH, fileName=str(path), flags=p.GEOM_FORCE_CONCAVE_TRIMESH)
    client.createMultiBody(0, shape)


def drop_naively(
    client: BulletClient, sphere: int, start: Sequence[float], radius: float
) -> tuple[float, float, float] | None:
    """Return where one sphere comes to rest, metres, or None if it misses or never does."""
    body = client.createMultiBody(MASS, sphere, basePosition=start)
    slow = 0
    for _ in range(MAX_STEPS):
        client.stepSimulation()
        center = client.getBasePositionAndOrientation(body)[0]
        slow = slow + 1 if np.linalg.norm(client.getBaseVelocity(body)[0]) < SLOW else 0
        if center[2] < radius:
            break
        if slow == SLOW_STEPS:
            client.changeDynamics(body, -1, mass=0)
            return center
    client.removeBody(body)
    return None
