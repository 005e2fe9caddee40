"""Proofs: a backend may test a place by using it.

They are an optional part of the interface, like the mechanics: the method `prove`. A use describes what is tried, in
the frame of the cloud; a backend does not need to know where uses come from.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np

from ..clouds.cloud import Cloud
from ..errors import CheckedSettings, amount

HELD = ""  # value of `why` for a use that held
REASONS = ("slid", "tipped", "sank", "moved", "knees hit", "sharp", "spilled")


@dataclass(frozen=True, kw_only=True)
class ProofSettings(CheckedSettings):
    """How places are tested."""

    person: float = amount(1.75, least=0.6, most=2.5)  # metres, height of a sitter
    sitting_time: float = amount(1.0, above=0.0)  # seconds after which a sitter is checked
    lean: float = amount(40.0)  # newtons, with which a sitter 1.75 m tall is then pushed from each side
    friction: float = amount(0.6)  # cloth on wood; a mug on wood
    put_time: float = amount(1.0, above=0.0)  # seconds to the check of what was put down; half as long after the push
    push: float = amount(1.0)  # newtons
    spheres: int = amount(60, least=1)  # number of spheres that are poured
    kept: float = amount(0.9, most=1.0)  # share of the spheres that must be inside at the end


@dataclass(frozen=True, kw_only=True, eq=False)
class SitUse:
    """A person sits down."""

    position: np.ndarray  # (3,) under the pelvis, metres
    heading: float  # radians from +x, the way the person faces


@dataclass(frozen=True, kw_only=True, eq=False)
class PutUse:
    """An object is put down."""

    cloud: Cloud  # of the object
    pose: np.ndarray  # (4, 4) from the object's frame


@dataclass(frozen=True, kw_only=True, eq=False)
class PourUse:
    """A stream is poured in."""

    position: np.ndarray  # (3,) of the spout, metres
    radius: float  # of the opening about the spout
    volume: float  # m3 that is poured
    low: np.ndarray  # (3,) corner of the box around the inside
    high: np.ndarray  # (3,)


Use = SitUse | PutUse | PourUse


@dataclass(frozen=True, kw_only=True)
class ProofResult:
    """The result of testing one use."""

    held: bool
    why: str  # one of `REASONS`; empty if it held
    moved: float  # metres; for poured spheres, the share that is not inside
    tilt_deg: float


@runtime_checkable
class ProvesPlaces(Protocol):
    """A backend that can test places."""

    def prove(self, cloud: Cloud, uses: Sequence[Use], settings: ProofSettings, seed: int = 0) -> list[ProofResult]:
        """Return the result of each use of an object, which does not move; reproducible bit for bit."""
        ...
