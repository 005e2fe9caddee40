"""A person sits down: an articulated body is let down on the place, holds itself upright, is pushed, and looked at."""

from __future__ import annotations

from collections.abc import Sequence
from importlib.resources import as_file, files

import numpy as np

from ...simulator.proofs import HELD, ProofResult, ProofSettings, SitUse
from ..engine import pybullet
from .stage import Stage, tilt_of

TALL = 1.75  # metres: the person of the URDF
ABOVE = 0.02  # metres from which the person is let down
CENTER = 0.30  # metres from the seat to where the trunk's weight acts, which the engine says the place of
RATE = 120.0  # steps in a second
HIP, KNEE = 60.0, 15.0  # newton metres at most, by which joints go back to sitting
STRETCHED = -1.3  # radians: knees are stretched at first, and the shanks come down
PUSHED, CALM = 0.2, 0.2  # seconds of each push on the trunk, and after it
TIPPED_DEG, RECLINED_DEG = 15.0, 30.0  # leaning ahead and aside, and back against a back
BREADTH = 0.08  # metres, a hand's: what carries on less is no seat
SUNK, SLID, STILL = 0.08, 0.08, 0.25  # metres, metres, metres in a second


def sat_down(stage: Stage, use: SitUse, settings: ProofSettings) -> ProofResult:
    """Return what becomes of a person who sits down, and is then pushed from behind, the sides and the front."""
    p, scale = pybullet(), settings.person / TALL
    start = np.array(use.position) + [0, 0, ABOVE]
    turn = p.getQuaternionFromEuler([0, 0, use.heading])
    with as_file(files(__package__) / "sitter.urdf") as path:
        body = p.loadURDF(str(path), start.tolist(), turn, globalScaling=scale, **stage.engine)
    stage.rub(body)
    hold(stage, body, scale)
    stage.steps(settings.sitting_time, RATE)
    verdict = looked_at(stage, body, use, scale)
    for quarter in range(4):
        if not verdict.held:
            break
        stage.push(body, settings.lean * scale**3, use.heading + quarter * np.pi / 2, PUSHED, RATE)
        stage.steps(CALM, RATE)
        verdict = looked_at(stage, body, use, scale)
    p.removeBody(body, **stage.engine)
    return verdict


def looked_at(stage: Stage, body: int, use: SitUse, scale: float) -> ProofResult:
    """Return how a person sits now."""
    p = pybullet()
    place, turned = p.getBasePositionAndOrientation(body, stage.client)
    speed, _ = p.getBaseVelocity(body, stage.client)
    spread = spread_of(p.getContactPoints(body, stage.object, **stage.engine))
    up = np.array(p.getMatrixFromQuaternion(turned)).reshape(3, 3)[:, 2]
    moved = np.array(place) - CENTER * scale * up - use.position
    ahead = np.array([np.cos(use.heading), np.sin(use.heading)])
    reclined = bool(up[:2] @ ahead < 0 and abs(up[:2] @ ahead) > 0.9 * np.linalg.norm(up[:2]))
    tilt = tilt_of(turned)
    tipped = tilt > (RECLINED_DEG if reclined else TIPPED_DEG)
    why = why_not(moved, tipped, float(np.linalg.norm(speed)), spread, scale)
    return ProofResult(held=why == HELD, why=why, moved=float(np.linalg.norm(moved[:2])), tilt_deg=tilt)


def hold(stage: Stage, body: int, scale: float):
    """Have the joints of a person go back to sitting, the knees from being stretched."""
    p = pybullet()
    for joint in range(p.getNumJoints(body, **stage.engine)):
        knee = p.getJointInfo(body, joint, **stage.engine)[1].endswith(b"knee")
        if knee:
            p.resetJointState(body, joint, STRETCHED, **stage.engine)
        p.setJointMotorControl2(
            body,
            joint,
            p.POSITION_CONTROL,
            targetPosition=0.0,
            force=(KNEE if knee else HIP) * scale,
            positionGain=0.05,
            velocityGain=0.5,
            **stage.engine,
        )


def why_not(moved: np.ndarray, tipped: bool, speed: float, spread: float, scale: float) -> str:
    """Return why a person does not sit there, nothing where one does."""
    if moved[2] < -SUNK * scale:
        return "sank"
    if tipped:
        return "tipped"
    if np.linalg.norm(moved[:2]) > SLID * scale:
        return "slid"
    if moved[2] > SUNK * scale:
        return "knees hit"
    if speed > STILL:
        return "slid"
    return "sharp" if spread < BREADTH * scale else HELD


def spread_of(contacts: Sequence[tuple]) -> float:
    """Return the breadth over which contacts carry, metres: twice the deviation of their forces, the widest way."""
    forces = np.array([contact[9] for contact in contacts])
    if forces.sum() <= 0:
        return 0.0
    places = np.array([contact[6][:2] for contact in contacts])
    return 2 * float(np.sqrt(np.linalg.eigvalsh(np.cov(places.T, aweights=forces, ddof=0))[-1]))
