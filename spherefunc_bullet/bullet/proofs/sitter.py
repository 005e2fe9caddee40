"""Sitting down: an articulated body is lowered onto the place, holds itself upright, is pushed, and checked."""

from __future__ import annotations

from collections.abc import Sequence
from importlib.resources import as_file, files

import numpy as np

from ...simulator.proofs import HELD, ProofResult, ProofSettings, SitUse
from ..engine import pybullet
from .stage import G, Stage, tilt_of

TALL = 1.75  # metres: height of the person in the URDF
ABOVE = 0.02  # metres above the seat at which the person is released
CENTER = 0.30  # metres from the seat to the centre of mass of the trunk, whose position the engine returns
RATE = 120.0  # steps per second
HIP, KNEE = 60.0, 15.0  # newton metres: largest torques with which joints return to sitting
STRETCHED = -1.3  # radians: the knees are stretched at first, and the shanks come down
PUSHED, CALM = 0.2, 0.2  # seconds: duration of each push on the trunk, and of the wait after it
TIPPED_DEG, RECLINED_DEG = 15.0, 30.0  # largest tilt forwards and sideways, and backwards against a back
BREADTH = 0.08  # metres, the width of a hand: a narrower support is not a seat
SUNK, SLID, STILL = 0.08, 0.08, 0.25  # metres, metres, metres per second
WEIGHT, WEDGED = 75.0 * G, 4.0  # newtons, of the URDF's person; and weights: what presses harder sticks in the person


def sit_down(stage: Stage, use: SitUse, settings: ProofSettings) -> ProofResult:
    """Return whether a person who sits down stays when pushed from behind, from the sides and from the front."""
    p, scale = pybullet(), settings.person / TALL
    start = np.array(use.position) + [0, 0, ABOVE]
    turn = p.getQuaternionFromEuler([0, 0, use.heading])
    with as_file(files(__package__) / "sitter.urdf") as path:
        body = p.loadURDF(str(path), start.tolist(), turn, globalScaling=scale, **stage.engine)
    stage.set_friction(body)
    hold(stage, body, scale)
    stage.steps(settings.sitting_time, RATE)
    verdict = sitting_result(stage, body, use, scale)
    for quarter in range(4):
        if not verdict.held:
            break
        stage.push(body, settings.lean * scale**3, use.heading + quarter * np.pi / 2, PUSHED, RATE)
        stage.steps(CALM, RATE)
        verdict = sitting_result(stage, body, use, scale)
    p.removeBody(body, **stage.engine)
    return verdict


def sitting_result(stage: Stage, body: int, use: SitUse, scale: float) -> ProofResult:
    """Return how a person currently sits."""
    p = pybullet()
    place, turned = p.getBasePositionAndOrientation(body, stage.client)
    speed, _ = p.getBaseVelocity(body, stage.client)
    contacts = p.getContactPoints(body, stage.object, **stage.engine)
    wedged = sum(contact[9] for contact in contacts) > WEDGED * WEIGHT * scale**3
    breadth = 0.0 if wedged else spread_of(contacts)
    up = np.array(p.getMatrixFromQuaternion(turned)).reshape(3, 3)[:, 2]
    moved = np.array(place) - CENTER * scale * up - use.position
    ahead = np.array([np.cos(use.heading), np.sin(use.heading)])
    reclined = bool(up[:2] @ ahead < 0 and abs(up[:2] @ ahead) > 0.9 * np.linalg.norm(up[:2]))
    tilt = tilt_of(turned)
    tipped = tilt > (RECLINED_DEG if reclined else TIPPED_DEG)
    why = why_not(moved, tipped, float(np.linalg.norm(speed)), breadth, scale)
    return ProofResult(held=why == HELD, why=why, moved=float(np.linalg.norm(moved[:2])), tilt_deg=tilt)


def hold(stage: Stage, body: int, scale: float):
    """Let motors return the joints of a person to sitting; the knees start stretched."""
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


def why_not(moved: np.ndarray, tipped: bool, speed: float, breadth: float, scale: float) -> str:
    """Return why a person does not sit there; `HELD` if the person does."""
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
    return "sharp" if breadth < BREADTH * scale else HELD


def spread_of(contacts: Sequence[tuple]) -> float:
    """Return the breadth of the support, metres: twice the largest standard deviation of the contact forces."""
    forces = np.array([contact[9] for contact in contacts])
    if forces.sum() <= 0:
        return 0.0
    places = np.array([contact[6][:2] for contact in contacts])
    return 2 * float(np.sqrt(np.linalg.eigvalsh(np.cov(places.T, aweights=forces, ddof=0))[-1]))
