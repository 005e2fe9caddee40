"""One kind of change to objects: of which functions' objects it is made, and whether they work afterwards."""

from __future__ import annotations

import zlib
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from .specimen import Specimen
from .surfaces import Surface

FUNCTIONS = ("cup", "sittable", "table")
NONE = "none"  # of what has none of them
Change = Callable[[Specimen, np.random.Generator], Surface | None]


@dataclass(frozen=True, kw_only=True)
class Impairment:
    """One kind of change."""

    kind: str
    functions: tuple[str, ...]  # of which it is made
    works: bool  # whether what is changed still serves
    change: Change  # returns None where it cannot be made of an object
    used: bool = False  # of an object in use or as a sensor gives it, rather than of a changed one

    def applied(self, specimen: Specimen, name: str, seed: int) -> Surface | None:
        """Return a changed copy, standing on the ground, or None; the same seed gives the same bits.

        The random stream is the object's and the kind's own, so that one more of either leaves all others alone.
        """
        rng = np.random.default_rng([seed, zlib.crc32(name.encode()), zlib.crc32(self.kind.encode())])
        changed = self.change(specimen, rng)
        return None if changed is None else changed.standing()
