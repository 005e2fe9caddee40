"""Putting down: an object is released from a height of 1 cm, checked, pushed, and checked again."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from ...simulator.mechanics import Material
from ...simulator.proofs import HELD, ProofResult, ProofSettings, PutUse
from ...simulator.statics.body import Body, body_of
from ..engine import pybullet
from .stage import G, Stage

ABOVE = 0.01  # metres
RATE = 240.0
PUSHED = 0.25  # seconds
LIGHT = 0.3  # of its weight: a harder push would move a light object wherever it stands
MOVED, TILTED_DEG = 0.02, 5.0  # metres and degrees: by no more may it leave its pose


def put_down(stage: Stage, use: PutUse, settings: ProofSettings) -> ProofResult:
    """Return whether an object stays where it is put down."""
    p, free = pybullet(), body_of(use.cloud, Material())
    shape = p.createCollisionShape(p.GEOM_MESH, vertices=(free.corners - free.center).tolist(), **stage.engine)
    start = use.pose[:3, :3] @ free.center + use.pose[:3, 3]
    turn = Rotation.from_matrix(use.pose[:3, :3])
    body = p.createMultiBody(
        free.mass, shape, stage.visual, (start + [0, 0, ABOVE]).tolist(), turn.as_quat().tolist(), **stage.engine
    )
    p.changeDynamics(body, -1, localInertiaDiagonal=inertia_of(free), **stage.engine)
    stage.set_friction(body)
    moved, tilt = displacement(stage, body, start, turn, settings.put_time)
    if moved <= MOVED and tilt <= TILTED_DEG:
        stage.push(body, min(settings.push, LIGHT * free.mass * G), 0.0, PUSHED, RATE)
        moved, tilt = displacement(stage, body, start, turn, settings.put_time / 2)
    p.removeBody(body, **stage.engine)
    why = "tipped" if tilt > TILTED_DEG else "slid" if moved > MOVED else HELD
    return ProofResult(held=why == HELD, why=why, moved=moved, tilt_deg=tilt)


def inertia_of(free: Body) -> list[float]:
    """Return the inertia about the axes x, y and z, which are nearly the principal axes of vessels and plates."""
    return np.diag(free.inertia).tolist()


def displacement(stage: Stage, body: int, start: np.ndarray, turn: Rotation, seconds: float) -> tuple[float, float]:
    """Return how far a body has moved after some seconds, metres, and by how much it has tilted, degrees."""
    stage.steps(seconds, RATE)
    place, turned = pybullet().getBasePositionAndOrientation(body, stage.client)
    up = (Rotation.from_quat(turned) * turn.inv()).apply([0.0, 0.0, 1.0])
    return float(np.linalg.norm(np.array(place) - start)), float(np.degrees(np.arccos(np.clip(up[2], -1, 1))))
