"""What a simulator costs: seconds, drops and memory, from what the cache keeps of each run."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from spherefunc_bullet.settling.records import ObjectRecord

from .entries import Entry


def costs(entry: Entry) -> dict:
    """Return one simulator's costs over all objects and radii.

    Seconds are those of the simulation alone, measured when the run was made: without loading, sampling and
    compilation. An object's seconds are those of all radii together.
    """
    records, radii = entry.simulated.records, entry.contestant.radii
    memory = [bytes_ for each in (*records, *entry.again.records) for bytes_ in each.memory.values()]
    return timing(records, radii) | {
        "settled_share": settled_share(records, radii),
        "peak_memory": max(memory, default=None),  # bytes of a whole process, interpreter and libraries included
        "peak_memory_runs": len(memory),  # of how many runs it is known: those of an older cache lack it
        "failed": len(entry.failed),
    }


def timing(records: Sequence[ObjectRecord], radii: Iterable[float]) -> dict:
    """Return the seconds that an object takes (median, 95th percentile, total) and the drops per second."""
    seconds = np.array([object_seconds(each, radii) for each in records])
    drops = sum(each.drops[radius] for each in records for radius in radii)
    total = float(seconds.sum())
    return {
        "seconds_per_object": round(float(np.median(seconds)), 6),
        "seconds_per_object_p95": round(float(np.percentile(seconds, 95)), 6),
        "seconds_total": round(total, 4),
        "drops": int(drops),
        "drops_per_second": round(drops / total, 1) if total > 0 else None,
    }


def object_seconds(record: ObjectRecord, radii: Iterable[float]) -> float:
    """Return the seconds of one object's runs."""
    return sum(record.seconds[radius] for radius in radii)


def settled_share(records: Sequence[ObjectRecord], radii: Iterable[float]) -> float | None:
    """Return the share of all spheres that settled."""
    drops = sum(each.drops[radius] for each in records for radius in radii)
    return round(sum(len(each.settled[radius]) for each in records for radius in radii) / drops, 4) if drops else None
