"""Is what a scan's places to put stand on seen, and is nothing above them?"""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np
from scipy.spatial import cKDTree

from spherefunc_bullet.learning.model_file import inference_model, shipped_model
from spherefunc_bullet.scenes.recognition.recognition import recognise
from spherefunc_bullet.scenes.recognition.room_places import room_places
from spherefunc_bullet.scenes.scans.scan import load_scan

DISC, ABOVE, NEAR = 0.04, 0.15, 0.02  # metres: radius, free height, and how far from its level a point supports it
SUPPORTED = 0.9  # of the disc's area


def scan_examined(file: Path) -> dict[str, object]:
    """Return how many places to put a scan has, how many are supported and free, and the seconds they took.

    Those of surfaces that were seen in part are counted apart, as inferred.
    """
    scan = load_scan(file)
    room = recognise(scan, inference_model(shipped_model("fast", scans=True), "fast"))
    started = time.perf_counter()
    found = room_places(scan, room)
    seconds = time.perf_counter() - started
    points = room.levelling.to_level(scan.points)
    tree, spacing = cKDTree(points[:, :2]), spacing_of(points)
    kinds = [place.kind for places in found.values() for place in places]
    row: dict[str, object] = {"file": file.name, "sit": kinds.count("sit"), "seconds": seconds}
    for kind, inferred in (("put", False), ("inferred", True)):
        put = [one for places in found.values() for one in places if one.kind == "put" and one.inferred == inferred]
        middles = room.levelling.to_level(np.array([place.position for place in put]).reshape(-1, 3))
        good = [stands_free(points[tree.query_ball_point(middle[:2], 0.1)], middle, spacing) for middle in middles]
        row |= {kind: len(put), f"{kind} good": sum(good)}
    return row


def spacing_of(points: np.ndarray) -> float:
    """Return the median distance of a point to the next, metres."""
    some = np.random.default_rng(0).integers(len(points), size=2000)
    return float(np.median(cKDTree(points).query(points[some], k=2)[0][:, 1]))


def stands_free(near: np.ndarray, middle: np.ndarray, spacing: float) -> bool:
    """Return whether a disc at a place (3,) is supported by points (N, 3), and none is above it."""
    steps = np.arange(-DISC, DISC + 1e-9, 0.01)
    offsets = np.stack(np.meshgrid(steps, steps), -1).reshape(-1, 2)
    disc = middle[:2] + offsets[np.linalg.norm(offsets, axis=1) <= DISC]
    carrying = near[np.abs(near[:, 2] - middle[2]) < NEAR]
    if not len(carrying):
        return False
    supported = cKDTree(carrying[:, :2]).query(disc)[0] <= max(0.01, 1.5 * spacing)
    over = near[np.linalg.norm(near[:, :2] - middle[:2], axis=1) < DISC, 2] - middle[2]
    return bool(supported.mean() >= SUPPORTED and not ((over > NEAR) & (over < ABOVE)).any())
