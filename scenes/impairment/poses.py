"""Ways to lay an object down, the same for everything that is to be useless afterwards."""

from __future__ import annotations

import numpy as np

from .surfaces import Surface


def turn(axis: np.ndarray, angle: float) -> np.ndarray:
    """Return the rotation matrix (3, 3) by an angle, radians, about a unit vector (3,)."""
    x, y, z = axis
    across = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * across + (1 - np.cos(angle)) * across @ across


def turned(surface: Surface, rotation: np.ndarray) -> Surface:
    """Return a surface rotated (3, 3), and standing on the ground again."""
    return surface.mapped(lambda points: points @ rotation.T).standing()


def upside_down(surface: Surface, rng: np.random.Generator) -> Surface:
    """Return a surface turned over, about x or about y."""
    return turned(surface, turn(np.eye(3)[rng.integers(2)], np.pi))


def laid(surface: Surface, toward: np.ndarray) -> Surface:
    """Return a surface laid on the side that a level unit vector (2,) points to."""
    return turned(surface, turn(np.array([-toward[1], toward[0], 0.0]), np.pi / 2))


def level_direction(angle: float) -> np.ndarray:
    """Return the level unit vector (2,) at an angle from +x, radians."""
    return np.array([np.cos(angle), np.sin(angle)])
