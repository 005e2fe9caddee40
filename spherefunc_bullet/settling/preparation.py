"""Objects as spheres are to meet them: standing level, without gaps between sparse points."""

from __future__ import annotations

from ..clouds.cloud import Cloud
from ..clouds.filling import filled
from ..simulator.statics.levelling import levelled


def prepare(cloud: Cloud) -> Cloud:
    """Return an object ready for spheres to be dropped on; one that is level and dense, as most are, is itself."""
    return cloud.cached("prepared", lambda: filled(levelled(cloud)))
