"""From a scan to objects and what they are for (paper, §IV-C and Fig. 6)."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from spherefunc_bullet.cloud import Cloud

from .bounding import Box, bounding_box
from .cells import Cells, cells
from .completion import DEFAULT, complete
from .levelling import Levelling, level
from .scan import Scan
from .segmentation import FLOOR, LEFT_OVER, WALL, Segmentation, labelled_voxels

LARGE = 0.5  # metres: on what is larger spheres below 1 cm tell nothing that larger ones do not, and take seconds
SMALLEST_ON_LARGE = 0.01  # metres


@dataclass(frozen=True, kw_only=True, eq=False)
class SceneObject:
    """One object of a room."""

    id: int  # its label in `Room.labels`
    points: np.ndarray  # (N, 3) float64, metres, level frame
    support: float  # the height it stands on, metres
    box: Box  # in the level frame
    functions: dict[str, dict]  # name -> member (bool), score (0 to 1), radius (metres)


@dataclass(frozen=True, kw_only=True, eq=False)
class Room:
    """What was found in a scan."""

    levelling: Levelling
    labels: np.ndarray  # (N,) int32 of the scan's points: an object's id, -1 floor, -2 wall or ceiling, -3 left over
    objects: list[SceneObject]
    stages: dict[str, float] = field(default_factory=dict)  # seconds that each step took


class Stopwatch:
    """Seconds between calls, by name."""

    def __init__(self):
        self.stages: dict[str, float] = {}
        self._last = time.perf_counter()

    def lap(self, name: str):
        """Book the time since the last call."""
        now = time.perf_counter()
        self.stages[name] = self.stages.get(name, 0.0) + now - self._last
        self._last = now


def recognise(
    scan: Scan,
    model,
    simulator=None,
    *,
    up: str = "auto",
    settings: Segmentation | None = None,
    completion: Sequence[str] = DEFAULT,
) -> Room:
    """Find the objects of a scan and tell what each is for.

    Parameters
    ----------
    scan : Scan
    model : FunctionClassifier
        Trained on whole models, as the paper did, or on scans.
    simulator : Simulator, optional
        What drops the spheres; the model's own by default.
    up : str
        See `levelling.level`.
    settings : Segmentation
    completion : sequence of str
        See `completion.complete`.
    """
    settings, watch = settings or Segmentation(), Stopwatch()
    levelling = level(scan.points, up, scan.name)
    watch.lap("floor")
    thinned = cells(levelling.to_level(scan.points), settings.leaf_size)
    watch.lap("thinning")
    voxel_labels = labelled_voxels(thinned, settings, levelling.noise)
    labels = voxel_labels[thinned.cell_of]
    watch.lap("clusters")
    parts = object_points(thinned, labels, voxel_labels)
    clouds = [object_cloud(points, completion, support, f"object {k}") for k, (points, support) in enumerate(parts)]
    watch.lap("completion")
    settled = [settled_on(cloud, model, simulator) for cloud, _ in clouds]
    watch.lap("spheres")
    functions = [scored(each, model) for each in settled]
    watch.lap("classification")
    objects = [
        SceneObject(id=k, points=points, support=support, box=box, functions=functions[k])
        for k, ((points, support), (_, box)) in enumerate(zip(parts, clouds, strict=True))
    ]
    return Room(levelling=levelling, labels=labels, objects=objects, stages=watch.stages)


def object_points(thinned: Cells, labels: np.ndarray, voxel_labels: np.ndarray) -> list[tuple[np.ndarray, float]]:
    """Return the points (N, 3) of each object, as they came, and the height that it stands on, metres."""
    count = int(voxel_labels.max(initial=-1)) + 1
    order = np.argsort(labels, kind="stable")
    bounds = np.searchsorted(labels[order], np.arange(count + 1))
    parts = [thinned.points[order[bounds[k] : bounds[k + 1]]] for k in range(count)]
    return [(points, support_height(points, parts, k)) for k, points in enumerate(parts)]


def support_height(points: np.ndarray, parts: list[np.ndarray], own: int) -> float:
    """Return the height that an object stands on: the top of what is right below it, else the floor's 0."""
    from .supports import top_below

    return top_below(points, [part for k, part in enumerate(parts) if k != own])


def object_cloud(points: np.ndarray, completion: Sequence[str], support: float, name: str) -> tuple[Cloud, Box]:
    """Return an object as spheres see it, completed, standing on its support, its long side along x; and its box."""
    box = bounding_box(points)
    whole = complete(points, completion, support=support)
    own = (whole - [*box.center[:2], support]) @ box.axes.T
    return Cloud(own, name), box


def settled_on(cloud: Cloud, model, simulator=None) -> dict:
    """Return where spheres settle on an object, for each radius that the model looks at and that tells something."""
    from spherefunc_bullet.simulation import settle

    small_enough = cloud.size.max() < LARGE
    radii = [each for each in model.chosen_radii() if small_enough or each >= SMALLEST_ON_LARGE]
    return settle(cloud, simulator or model.simulator, radii, model.seed)


def scored(settled: dict, model) -> dict[str, dict]:
    """Return each function's score for an object on which the spheres have settled, whichever way it faces.

    Which side of it is the front nobody said, so its distance to a training object is that at the best of four
    quarter turns.
    """
    from spherefunc_bullet.heading import quarter_turns
    from spherefunc_bullet.method import find_method
    from spherefunc_bullet.validation import THRESHOLD, voted_scores

    turned = [{radius: quarter_turns(centers, k) for radius, centers in settled.items()} for k in range(4)]
    distances = {radius: model.distances(turned, radius).min(axis=0, keepdims=True) for radius in settled}
    functions = {}
    for name, members in zip(model.functions_, model.members_.T, strict=True):
        weights = {radius: weight for radius, weight in model.weights_[name].items() if radius in settled}
        total = sum(weights.values())
        weights = {radius: weight / total for radius, weight in weights.items()}
        score = float(voted_scores(distances, members, weights, find_method(model.method))[0]) if weights else 0.0
        member = bool(score > THRESHOLD)
        functions[name] = {"member": member, "score": round(score, 4), "radius": model.radius_[name]}
    return functions


__all__ = ["FLOOR", "LEFT_OVER", "WALL", "Room", "SceneObject", "recognise"]
