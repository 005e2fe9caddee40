"""All that is asked about objects: the spheres as a method reads them, and every baseline, each with its classifier."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

from spherefunc_bullet.batch.simulated import Simulated
from spherefunc_bullet.learning.method import CUBES, AnyMethod, Method

from .evaluation import Evaluation, Trial, evaluate, run_trial
from .features import SPHERES, Distances, baseline_distances, sphere_distances
from .profiled import POINTS, points_profiled, spheres_profiled
from .protocol import Labels, Split, Splits, labels_of
from .related.fixed import related


class Reading(Protocol):
    """One way to tell functions, on objects that it has been prepared for."""

    def trials(self, asked: Sequence[Sequence[Split]]) -> list[Trial]:
        """Return several trials, each what is said of the objects that its splits test by what that split learns."""

    def evaluation(self, splits: Splits) -> Evaluation:
        """Return what is said of the objects under a protocol."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Neighbours:
    """Nearest neighbours by distances between all objects."""

    distances: Distances
    labels: Labels
    method: Method

    def trials(self, asked: Sequence[Sequence[Split]]) -> list[Trial]:
        """Return several trials, each what is said of the objects that one split tests."""
        return [run_trial(self.distances, self.labels, split, self.method) for (split,) in asked]

    def evaluation(self, splits: Splits) -> Evaluation:
        """Return what is said of the objects under a protocol."""
        return evaluate(self.distances, self.labels, self.method, splits)


def readings(simulated: Simulated, radii: tuple[float, ...], method: AnyMethod) -> dict[str, Reading]:
    """Return the spheres as a method reads them, and what they have to beat: shapes, points and related work."""
    return {SPHERES: spheres_read(simulated, radii, method)} | baselines_read(simulated, radii, method)


def spheres_read(simulated: Simulated, radii: tuple[float, ...], method: AnyMethod) -> Reading:
    """Return the spheres as a method reads them."""
    labels = labels_of(simulated)
    if isinstance(method, Method):
        return Neighbours(distances=sphere_distances(simulated, radii, method), labels=labels, method=method)
    return spheres_profiled(simulated, labels, radii)


def baselines_read(simulated: Simulated, radii: tuple[float, ...], method: AnyMethod) -> dict[str, Reading]:
    """Return what the spheres have to beat: their own points, shapes and related work."""
    points = points_profiled(simulated, labels_of(simulated), radii)
    return {POINTS: points} | shapes_read(simulated, radii, method)


def shapes_read(simulated: Simulated, radii: tuple[float, ...], method: AnyMethod) -> dict[str, Reading]:
    """Return baselines that are quickly asked: shapes, and related work.

    Shapes are scored with the neighbours, votes and choice of radius of the method, if it has such.
    """
    labels, neighbours = labels_of(simulated), method if isinstance(method, Method) else CUBES
    shapes = {
        name: Neighbours(distances=distances, labels=labels, method=neighbours)
        for name, distances in baseline_distances(simulated.records, radii).items()
    }
    return shapes | related(simulated.records, labels)
