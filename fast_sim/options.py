"""The options of the fast backend, and what the paper leaves open of it."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass, fields

from spherefunc_bullet.errors import InputError


@dataclass(frozen=True, kw_only=True)
class FastOptions:
    """How spheres roll."""

    cores: int = 1  # that a large object's drops are shared among; the same bits on any number of them
    as_drawn: bool = False  # drop one after another, as the paper does, and not a large object's strip by strip
    flat_angle_deg: float = 5.0  # a slope that still counts as flat: more than sampling noise, less than a ramp
    # What the paper leaves open (§III-A), in other readings (docs/paper.md).
    columns: str = "box"  # over which spheres begin: the object's, or the "points": squares of 5 mm that hold some
    inside: str = "centre"  # of a sphere on spheres alone that is to lie within the object's box, or the whole "sphere"
    stalled_steps: int = 4  # steps that get no lower by which a sphere counts as blocked; 0: no such rule

    def __post_init__(self):
        require_one_of("columns", self.columns, ("box", "points"))
        require_one_of("inside", self.inside, ("centre", "sphere"))
        if not 1 <= self.cores <= (os.cpu_count() or 1):
            raise InputError(f"backend 'fast': cores: expected 1 to {os.cpu_count()}, got {self.cores}")
        if self.stalled_steps < 0:
            raise InputError(f"backend 'fast': stalled_steps: expected 0 or more, got {self.stalled_steps}")

    def options(self) -> dict:
        """Return what is not as by default, by name (see `Simulator.options`)."""
        return {"flat_angle_deg": self.flat_angle_deg} | {
            field.name: getattr(self, field.name)
            for field in fields(self)
            if field.name != "cores" and getattr(self, field.name) != field.default
        }


def require_one_of(name: str, value: str, expected: Sequence[str]):
    """Raise InputError unless an option is one of those there are."""
    if value not in expected:
        raise InputError(f"backend 'fast': {name}: expected one of {', '.join(expected)}, got {value!r}")
