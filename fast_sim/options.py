"""The options of the fast backend."""

from __future__ import annotations

import os
from dataclasses import dataclass, fields

from spherefunc_bullet.errors import InputError


@dataclass(frozen=True, kw_only=True)
class FastOptions:
    """How spheres roll."""

    cores: int = 1  # that a large object's drops are shared among; the same bits on any number of them
    as_drawn: bool = False  # drop one after another, as the paper does, and not a large object's strip by strip
    flat_angle_deg: float = 5.0  # a slope that still counts as flat: more than sampling noise, less than a ramp

    def __post_init__(self):
        if not 1 <= self.cores <= (os.cpu_count() or 1):
            raise InputError(f"backend 'fast': cores: expected 1 to {os.cpu_count()}, got {self.cores}")

    def options(self) -> dict:
        """Return what is not as by default, by name (see `Simulator.options`)."""
        return {"flat_angle_deg": self.flat_angle_deg} | {
            field.name: getattr(self, field.name)
            for field in fields(self)
            if field.name != "cores" and getattr(self, field.name) != field.default
        }
