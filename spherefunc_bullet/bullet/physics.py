"""What the Bullet backend's spheres are made of, and how finely their motion is computed.

Everything is in the sphere's own units: lengths in radii, times in sqrt(radius / g), which is the time in which
a sphere falls half its radius, and masses in spheres. Every radius is then the same problem to the engine, whose
tolerances are made for bodies of about one unit.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from ..errors import InputError


@dataclass(frozen=True, kw_only=True)
class Physics:
    """Material, time step, and what counts as rest."""

    friction: float = 0.5  # wood on wood, plastic on plastic
    rolling_friction: float = 0.14  # tangent of the steepest slope that holds a sphere: 8 degrees, as seats are made
    restitution: float = 0.0  # spheres start at the surface, and the paper's do not bounce
    time_step: float = 0.1  # 2 ms at a radius of 5 mm; half of it moves no result by more than a seed does
    sub_steps: int = 8  # time steps between two looks at the spheres
    iterations: int = 10  # of the engine's solver; a sphere has few contacts, and at 20 nothing that tests hold differs
    scale: float = 10.0  # length of a radius in the engine: at 1, spheres at rest overlap by 2 % instead of 0.5 %
    rest_speed: float = 0.01  # 3 mm/s at a radius of 1 cm; below it for rest_time a sphere is at rest
    rest_time: float = 1.6  # in which a sphere on a slope of one degree more than holds it gains twice that speed
    time_limit: float = 100.0  # after which a sphere is given up: 3 s at a radius of 1 cm
    in_air: int = 16  # spheres at once, where there is room for so many

    def __post_init__(self):
        positive = ("time_step", "sub_steps", "iterations", "scale", "rest_speed", "rest_time", "time_limit", "in_air")
        for name in positive:
            require(name, getattr(self, name), lambda value: value > 0, "more than 0")
        for name in ("friction", "rolling_friction"):
            require(name, getattr(self, name), lambda value: value >= 0, "0 or more")
        # At this time step the engine gives energy to what bounces back completely.
        require("restitution", self.restitution, lambda value: 0 <= value <= 0.9, "0 to 0.9")
        require("time_step", self.time_step, lambda value: value <= 0.5, "at most 0.5 of sqrt(radius / g)")

    @property
    def look(self) -> float:
        """Time between two looks at the spheres."""
        return self.time_step * self.sub_steps

    @property
    def terminal_speed(self) -> float:
        """Speed at which a sphere moves 0.4 radii in a step; what falls is held to it, so that it cannot tunnel."""
        return 0.4 / self.time_step


def require(name: str, value: float, accept: Callable[[float], bool], expected: str):
    """Raise InputError unless a setting is a number in its range."""
    if not (math.isfinite(value) and accept(value)):
        raise InputError(f"backend 'bullet': {name}: expected {expected}, got {value}")
