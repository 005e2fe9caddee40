"""Pouring: spheres that stand for a volume leave a spout that moves to and fro above the opening."""

from __future__ import annotations

import numpy as np

from ...simulator import generator_of
from ...simulator.proofs import HELD, PourUse, ProofResult, ProofSettings
from ..engine import pybullet
from .stage import G, Stage

RATE = 360.0
PACKED = 0.55  # share of a volume that poured spheres fill
OPENING = 0.4  # of the radius of the opening: the largest sphere
WANDER = 0.3  # of the radius of the opening: how far the spout moves to either side
EVERY = 6  # steps between spheres
CLEAR = 2.1  # radii that a sphere has fallen when the next one leaves the spout
CALM = 0.3  # seconds to wait after the last sphere; half of it after the vessel was carried
SOLVED = 20, 50  # iterations of the solver: few suffice for light spheres in a low pile; and the engine's default
CARRIED = 0.05, 0.3  # sideways acceleration in g, and its duration in seconds: carried level


def pour(stage: Stage, use: PourUse, settings: ProofSettings, seed: int) -> ProofResult:
    """Return whether the poured spheres stay inside."""
    p = pybullet()
    radius = sphere_radius(use, settings.spheres)
    shape = p.createCollisionShape(p.GEOM_SPHERE, radius=radius, **stage.engine)
    p.setPhysicsEngineParameter(numSolverIterations=SOLVED[0], **stage.engine)
    rng, bodies, pause = generator_of(seed), [], EVERY / RATE
    # Each sphere has left the spout before the next one starts: overlapping spheres would push each other out.
    leaving = max(0.0, (CLEAR * radius - G * pause**2 / 2) / pause)
    for number in range(settings.spheres):
        aside = WANDER * use.radius * np.sin(2 * np.pi * number / 20)
        jitter = rng.uniform(-0.1, 0.1, 2) * use.radius
        place = use.position + [aside + jitter[0], jitter[1], radius]
        bodies.append(
            p.createMultiBody(0.01, shape, stage.visual, place.tolist(), useMaximalCoordinates=1, **stage.engine)
        )
        p.changeDynamics(bodies[-1], -1, lateralFriction=0.3, linearDamping=0.3, **stage.engine)
        p.resetBaseVelocity(bodies[-1], [0, 0, -leaving], **stage.engine)
        stage.steps(pause, RATE)
    stage.steps(CALM, RATE)
    for side in (1, -1):
        p.setGravity(side * CARRIED[0] * G, 0, -G, **stage.engine)
        stage.steps(CARRIED[1] / 2, RATE)
    p.setGravity(0, 0, -G, **stage.engine)
    stage.steps(CALM / 2, RATE)
    p.setPhysicsEngineParameter(numSolverIterations=SOLVED[1], **stage.engine)
    places = np.array([p.getBasePositionAndOrientation(body, stage.client)[0] for body in bodies])
    for body in bodies:
        p.removeBody(body, **stage.engine)
    inside = ((places >= use.low - radius) & (places <= use.high + [radius, radius, 2 * radius])).all(axis=1)
    share = float(inside.mean())
    why = HELD if share >= settings.kept else "spilled"
    return ProofResult(held=why == HELD, why=why, moved=1 - share, tilt_deg=0.0)


def sphere_radius(use: PourUse, count: int) -> float:
    """Return the radius of ``count`` spheres that stand for a volume."""
    full = (PACKED * use.volume / count * 3 / (4 * np.pi)) ** (1 / 3)
    return float(min(full, OPENING * use.radius))
