"""What a simulator costs: seconds and drops, from what the cache keeps of each run.

Seconds are those of the simulation alone, measured when the run was made: without loading, sampling and compilation.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from spherefunc_bullet.settling.records import ObjectRecord

from .report import Timing


@dataclass(frozen=True, kw_only=True)
class Runs:
    """The runs of one simulator on objects, at some radii."""

    records: Sequence[ObjectRecord]
    radii: Sequence[float]  # metres

    def alone(self, radius: float) -> Runs:
        """Return the runs of one radius."""
        return replace(self, radii=[radius])

    @property
    def seconds(self) -> list[float]:
        """Of each object, all radii together."""
        return [sum(record.seconds[radius] for radius in self.radii) for record in self.records]

    @property
    def drops(self) -> list[int]:
        """On each object, all radii together."""
        return [sum(record.drops[radius] for radius in self.radii) for record in self.records]

    @property
    def settled(self) -> list[int]:
        """Spheres on each object, all radii together."""
        return [sum(len(record.centers(radius)) for radius in self.radii) for record in self.records]

    @property
    def settled_share(self) -> float | None:
        """Of all spheres."""
        drops = sum(self.drops)
        return round(sum(self.settled) / drops, 4) if drops else None

    def timing(self) -> Timing:
        """Return the seconds that an object takes and the drops per second."""
        seconds, drops = np.array(self.seconds), sum(self.drops)
        total = float(seconds.sum())
        return {
            "seconds_per_object": round(float(np.median(seconds)), 6),
            "seconds_per_object_p95": round(float(np.percentile(seconds, 95)), 6),
            "seconds_total": round(total, 4),
            "drops": drops,
            "drops_per_second": round(drops / total, 1) if total > 0 else None,
        }
