"""The Bullet backend: rigid spheres on a collision shape made of the cloud, each frozen when it comes to rest."""

from .backend import BulletSimulator

__all__ = ["BulletSimulator"]
