"""The engine with a static object whose places are tested; in metres, seconds and kilograms."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ...clouds.cloud import Cloud
from ..collision.shape import CollisionShape, collision_shape
from ..engine import Engine, pybullet
from ..loading import load_shape

G = 9.81  # m/s2
SPANNED = 0.02  # of the largest extent: radius for which the surface of a cloud is built, within `SPANS`
SPANS = 0.006, 0.02  # metres


class Stage(Engine):
    """An engine with a static object on the ground."""

    def __init__(self, cloud: Cloud, friction: float):
        super().__init__(enableFileCaching=0)
        p, self.friction = pybullet(), friction
        p.setGravity(0, 0, -G, **self.engine)
        self.ground = self.add_static(p.createCollisionShape(p.GEOM_PLANE, **self.engine))
        self.object = self.add_static(load_shape(shape_of(cloud), 1.0, self.client))

    def add_static(self, shape: int) -> int:
        """Return a new static body."""
        body = pybullet().createMultiBody(0.0, shape, self.visual, **self.engine)
        self.set_friction(body)
        return body

    def set_friction(self, body: int):
        """Set the friction of all links of a body; the engine multiplies the values of two bodies, hence the root."""
        for link in range(-1, pybullet().getNumJoints(body, **self.engine)):
            pybullet().changeDynamics(body, link, lateralFriction=np.sqrt(self.friction), **self.engine)

    def steps(self, seconds: float, rate: float):
        """Advance by a time in seconds, with ``rate`` steps per second."""
        pybullet().setTimeStep(1 / rate, **self.engine)
        for _ in range(round(seconds * rate)):
            pybullet().stepSimulation(self.client)

    def push(self, body: int, newtons: float, heading: float, seconds: float, rate: float):
        """Push a body horizontally along a heading, radians, at the centre of mass of its base."""
        p, force = pybullet(), [newtons * np.cos(heading), newtons * np.sin(heading), 0.0]
        for _ in range(round(seconds * rate)):
            place, _ = p.getBasePositionAndOrientation(body, self.client)
            p.applyExternalForce(body, -1, force, place, p.WORLD_FRAME, **self.engine)
            p.stepSimulation(self.client)


def shape_of(cloud: Cloud) -> CollisionShape:
    """Return the mesh of a cloud, or else a surface between its points, in metres."""
    if cloud.mesh is not None:
        return collision_shape(cloud, 1.0, "mesh")
    radius = float(np.clip(SPANNED * cloud.size.max(), *SPANS))
    shape = collision_shape(cloud, radius, "voxel")
    return replace(shape, vertices=shape.vertices * radius, columns=shape.columns * radius, voxel_size=None, gap=None)


def tilt_of(quaternion: tuple[float, float, float, float]) -> float:
    """Return the angle in degrees between a body's own z and the vertical."""
    matrix = pybullet().getMatrixFromQuaternion(quaternion)
    return float(np.degrees(np.arccos(np.clip(matrix[8], -1.0, 1.0))))
