"""Keeping: drinking vessels against plates, trays, shelves and tables, by what they keep when they are tilted.

Beside them the same vessels with a hole in the wall, at heights that are known: the lower it is, the less they keep.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from spherefunc_bullet.clouds.cloud import cloud_from_mesh, load_cloud
from spherefunc_bullet.datasets.dataset import DatasetObject
from spherefunc_bullet.scenes.impairment.holed import holed_copies
from spherefunc_bullet.scenes.impairment.specimen import Specimen
from spherefunc_bullet.settling.records import Loading
from spherefunc_bullet.simulator import Simulator
from spherefunc_bullet.simulator.mechanics import CarrySettings

from .tasks import Score, Verdict, asked, evenly, score_of

OTHERS = ("plate", "tray", "shelf", "shelves", "bookshelf", "bookcase")  # categories, beside all tables
SHARE = 0.5  # of what it would be filled with, at least, is still in a vessel at the farthest angle
WHOLE, OTHER = "whole", "other"
Curve = tuple[float, ...]  # share kept at each angle


@dataclass(frozen=True, kw_only=True)
class KeepScore:
    """How well one backend tells vessels, and the mean curves of either side."""

    score: Score
    verdicts: tuple[Verdict, ...]
    angles_deg: tuple[float, ...]
    vessels: Curve  # in the mean
    others: Curve
    holed: tuple[HoledScore, ...]


@dataclass(frozen=True, kw_only=True)
class HoledScore:
    """What vessels keep that have a hole in the wall at one height."""

    kind: str
    asked: int
    kept: Curve  # in the mean
    told: float  # share that is still classified as a vessel


def carried(path: Path, simulator: Simulator, loading: Loading, holed: bool) -> dict[str, Curve]:
    """Return what a file's object keeps, and what is left of that with a hole in it, each by its kind."""
    cloud = load_cloud(path, up=loading.up, units=loading.units)
    variants = {WHOLE: cloud}
    for kind, surface in holed_copies(Specimen(cloud, "cup"), path.name, 0) if holed else ():
        variants[kind.kind] = cloud_from_mesh(*surface.mesh(), path.name)
    return {kind: simulator.carry(variant, CarrySettings(), 0).kept for kind, variant in variants.items()}


def score_keeping(
    objects: Sequence[DatasetObject], simulator: Simulator, count: int | None, loading: Loading
) -> KeepScore | None:
    """Return how well a backend tells vessels from what only carries; None where there are none of either."""
    vessels = evenly([item for item in objects if "cup" in item.functions], count)
    flat = [item for item in objects if item.category in OTHERS or "table" in item.functions]
    verdicts, seconds = [], []
    curves: dict[str, list[Curve]] = {WHOLE: [], OTHER: []}
    for true, items in ((True, vessels), (False, evenly(flat, count))):
        for item, kept, taken in asked(carried, items, simulator, "carrying", loading, true):
            seconds.append(taken / len(kept))
            whole = kept.pop(WHOLE)
            curves[WHOLE if true else OTHER].append(whole)
            for kind, curve in kept.items():
                curves.setdefault(kind, []).append(curve)
            holds = whole[-1] >= SHARE
            verdicts.append(Verdict(name=item.path.name, kind=item.category, true=true, told=holds, value=whole[-1]))
    if not curves[WHOLE] or not curves[OTHER]:
        return None
    return KeepScore(
        score=score_of(simulator.name, verdicts, float(np.mean(seconds))),
        verdicts=tuple(verdicts),
        angles_deg=CarrySettings().angles_deg,
        vessels=mean_curve(curves.pop(WHOLE)),
        others=mean_curve(curves.pop(OTHER)),
        holed=tuple(holed_score(kind, kept) for kind, kept in sorted(curves.items())),
    )


def holed_score(kind: str, curves: Sequence[Curve]) -> HoledScore:
    """Return what vessels with one kind of hole keep."""
    share = float(np.mean([curve[-1] >= SHARE for curve in curves]))
    return HoledScore(kind=kind, asked=len(curves), kept=mean_curve(curves), told=share)


def mean_curve(curves: Sequence[Curve]) -> Curve:
    """Return the mean share at each angle."""
    return tuple(np.mean(curves, axis=0).round(4).tolist())
