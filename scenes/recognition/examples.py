"""Training examples from scans with known objects: all proposals, also those of no object; and the paper's method."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from spherefunc_bullet.clouds.cloud import Cloud
from spherefunc_bullet.formats.units import Stopwatch
from spherefunc_bullet.function_model import FunctionModel
from spherefunc_bullet.simulator import Simulator

from ..scans.cells import cells
from ..scans.depth_image import filled
from ..scans.levelling import level, level_by_ransac
from ..scans.scan import Scan
from ..segmentation.clusters import euclidean_clusters, members_of
from ..segmentation.segmentation import FLOOR, LEFT_OVER, WALL, Segmentation, is_floor, numbered_by_size, segment
from ..settings import POOL
from .completion import DEFAULT
from .judging import RecognitionContext, classify_proposals, is_fragment, object_cloud
from .proposals import CLUSTERS, Proposal, Scene, propose
from .recognition import Room, scene_object
from .surroundings import ScanSurroundings


@dataclass(frozen=True, kw_only=True, eq=False)
class Example:
    """A completed proposal, and the object that it overlaps most."""

    cloud: Cloud
    nearest: int  # number of that object, -1 if it overlaps none
    overlap: float  # their intersection over union
    by: str  # the source of the proposal
    surroundings: np.ndarray  # (S,) see `surroundings`


def proposed_examples(points: np.ndarray, truth: np.ndarray, simulator: str | Simulator = "fast") -> Iterator[Example]:
    """Yield the proposals of a scan, completed as in recognition.

    Pools are cut out cautiously: models that had learnt half-guessed objects recognised seats less well.

    Parameters
    ----------
    points : (N, 3) float64, metres
    truth : (N,) int
        The object of each point from 0, negative for none.
    simulator
        See `propose`.
    """
    levelling, settings = level(points), Segmentation()
    dense = filled(levelling.to_level(points), settings.leaf_size)
    labels = segment(dense, settings, noise=levelling.noise)
    scene = Scene(points=dense, labels=labels, on_table=levelling.source == "table top")
    sizes, place = np.bincount(truth[truth >= 0]), ScanSurroundings(points=dense, is_wall=labels == WALL)
    for proposal in propose(scene, simulator, cautious=True):
        seen = proposal.members[proposal.members < len(points)]
        if len(seen) < POOL.min_points:
            continue
        number, overlap = best_object(truth[seen], sizes)
        part = dense[proposal.members]
        cloud, box = object_cloud(part, DEFAULT, proposal.support, proposal.pool)
        if not is_fragment(part, box, proposal.support):
            nearest, around = number if overlap > 0 else -1, place.of(part, box.size, proposal.support)
            yield Example(cloud=cloud, nearest=nearest, overlap=overlap, by=proposal.by, surroundings=around)


def best_object(truth: np.ndarray, sizes: np.ndarray) -> tuple[int, float]:
    """Return the object that points of objects (K,) overlap most, and their intersection over union.

    Parameters
    ----------
    truth : (K,) int
    sizes : (T,) int
        The points of each object in the scan.
    """
    if not len(sizes):
        return -1, 0.0
    shared = np.bincount(truth[truth >= 0], minlength=len(sizes))
    overlaps = shared / np.maximum(len(truth) + sizes - shared, 1)
    best = int(np.argmax(overlaps))
    return best, float(overlaps[best])


PAPER = "paper"  # the method's name


def recognise_as_paper(
    scan: Scan, model: FunctionModel, *, up: str | ArrayLike = "auto", settings: Segmentation | None = None
) -> Room:
    """Find the objects of a scan and classify each, as in the paper.

    Walls are clusters like any others, nothing is joined, divided or completed, and every cluster stands on its own
    lowest point, as models do.

    Parameters
    ----------
    scan, up, settings
        See `recognise`.
    model : FunctionModel
        Learnt from whole models: ``spherefunc train DATA --method paper``.
    """
    settings, watch = settings or Segmentation(), Stopwatch()
    levelling = level_by_ransac(scan.points, up, scan.name)
    watch.lap("floor")
    points = levelling.to_level(scan.points)
    labels = clusters_over_floor(points, settings)
    watch.lap("clusters")
    parts = [(members, float(points[members, 2].min())) for members in members_of(labels)]
    proposals = [Proposal(by=CLUSTERS, members=members, support=lowest) for members, lowest in parts]
    found = classify_proposals(points, proposals, RecognitionContext(model=model, completion=()), watch)
    objects = [scene_object(number, points, one) for number, one in enumerate(found)]
    return Room(levelling=levelling, labels=labels, objects=objects, proposals=objects, stages=watch.seconds)


def clusters_over_floor(points: np.ndarray, settings: Segmentation) -> np.ndarray:
    """Return the label (N,) int32 of each point (N, 3): its cluster's number, -1 floor, -3 too small or below it."""
    voxels = cells(points, settings.leaf_size)
    labels = np.full(len(voxels.keys), LEFT_OVER, np.int32)
    labels[is_floor(voxels.means, None)] = FLOOR
    rest = np.flatnonzero((labels == LEFT_OVER) & (voxels.means[:, 2] > 0))
    clusters = euclidean_clusters(voxels.means[rest], settings.cluster_tolerance)
    labels[rest] = numbered_by_size(clusters, settings)
    return labels[voxels.cell_of]
