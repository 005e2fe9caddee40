"""Proofs: rigid bodies use a place: a person sits down, an object is put down, a stream is poured."""

from __future__ import annotations

from ...simulator.proofs import PourUse, ProofResult, ProofSettings, PutUse, SitUse, Use
from .setting_down import put_down
from .sitter import sit_down
from .stage import Stage
from .stream import pour


def prove_use(stage: Stage, use: Use, settings: ProofSettings, seed: int) -> ProofResult:
    """Return the result of one use."""
    match use:
        case SitUse():
            return sit_down(stage, use, settings)
        case PutUse():
            return put_down(stage, use, settings)
        case PourUse():
            return pour(stage, use, settings, seed)
