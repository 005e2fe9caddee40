"""Proofs: rigid bodies use a place: a person sits down, an object is put down, a stream is poured."""

from __future__ import annotations

from collections.abc import Sequence

from ...clouds.cloud import Cloud
from ...simulator.proofs import PourUse, ProofResult, ProofSettings, PutUse, SitUse, Use
from .setting_down import put_down
from .sitter import sat_down
from .stage import Stage
from .stream import poured


def proved(cloud: Cloud, uses: Sequence[Use], settings: ProofSettings, seed: int) -> list[ProofResult]:
    """Return the result of each use of a static object."""
    with Stage(cloud, settings.friction) as stage:
        return [used(stage, use, settings, seed) for use in uses]


def used(stage: Stage, use: Use, settings: ProofSettings, seed: int) -> ProofResult:
    """Return the result of one use."""
    match use:
        case SitUse():
            return sat_down(stage, use, settings)
        case PutUse():
            return put_down(stage, use, settings)
        case PourUse():
            return poured(stage, use, settings, seed)
