"""Keeping: drinking vessels against plates, trays, shelves and tables, by what they keep when they are tilted."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from spherefunc_bullet.clouds.cloud import load_cloud
from spherefunc_bullet.datasets.dataset import DatasetObject
from spherefunc_bullet.simulator import Simulator
from spherefunc_bullet.simulator.mechanics import CarryResult, CarrySettings

from .tasks import Score, Verdict, asked, evenly, score_of

OTHERS = ("plate", "tray", "shelf", "shelves", "bookshelf", "bookcase")  # categories, beside all tables
SHARE = 0.5  # of the spheres, at least, are still in a vessel at the farthest angle


@dataclass(frozen=True, kw_only=True)
class KeepScore:
    """How well one backend tells vessels, and the mean curves of either side."""

    score: Score
    verdicts: tuple[Verdict, ...]
    angles_deg: tuple[float, ...]
    vessels: tuple[float, ...]  # share kept at each angle, in the mean
    others: tuple[float, ...]


def carried(path: Path, simulator: Simulator) -> CarryResult:
    """Return what a file's object keeps."""
    return simulator.carry(load_cloud(path), CarrySettings(), 0)


def score_keeping(objects: Sequence[DatasetObject], simulator: Simulator, count: int | None) -> KeepScore:
    """Return how well a backend tells vessels from what only carries."""
    vessels = [item for item in objects if "cup" in item.functions]
    flat = [item for item in objects if item.category in OTHERS or "table" in item.functions]
    verdicts, curves, seconds = [], {True: [], False: []}, []
    for item, result, taken in asked(carried, [*vessels, *evenly(flat, count)], simulator, "carrying"):
        true = "cup" in item.functions
        curves[true].append(result.kept)
        seconds.append(taken)
        kept = result.kept[-1]
        verdicts.append(Verdict(name=item.path.name, kind=item.category, true=true, told=kept >= SHARE, value=kept))
    return KeepScore(
        score=score_of(simulator.name, verdicts, float(np.mean(seconds))),
        verdicts=tuple(verdicts),
        angles_deg=CarrySettings().angles_deg,
        vessels=tuple(np.mean(curves[True], axis=0).round(4).tolist()),
        others=tuple(np.mean(curves[False], axis=0).round(4).tolist()),
    )
