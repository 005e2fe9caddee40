"""An object that is to be impaired or harmlessly changed, and what makes it work."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from spherefunc_bullet.clouds.cloud import Cloud

from .cavities import Cavity, find_cavity
from .levels import Level, find_level
from .surfaces import Surface, surface_of

HEIGHTS = {"sittable": (0.15, 0.95), "table": (0.2, 1.3)}  # metres: of seats, of table tops


@dataclass(frozen=True, eq=False)
class Specimen:
    """A whole object with its function."""

    cloud: Cloud
    function: str

    @cached_property
    def surface(self) -> Surface:
        """The object's triangles, or its points."""
        return surface_of(self.cloud)

    @cached_property
    def level(self) -> Level | None:
        """The seat or the table top, where one is found."""
        return find_level(self.surface, *HEIGHTS[self.function]) if self.function in HEIGHTS else None

    @cached_property
    def cavity(self) -> Cavity | None:
        """Where the cup holds water, where it does."""
        return find_cavity(self.surface) if self.function == "cup" else None

    @cached_property
    def back(self) -> np.ndarray | None:
        """Level unit vector (2,) from the seat's middle to what rises above it, None where nothing does.

        Along x or y, whichever is nearer: furniture is made square.
        """
        seat, centres = self.level, self.surface.centres
        above = centres[:, 2] > seat.upper + 0.15
        if above.sum() < 0.02 * len(centres):
            return None
        toward = centres[above, :2].mean(axis=0) - seat.box.mean(axis=0)
        if np.abs(toward).max() < 0.1 * (seat.box[1] - seat.box[0]).min():
            return None
        axis = int(np.abs(toward).argmax())
        return np.sign(toward[axis]) * np.eye(2)[axis]
