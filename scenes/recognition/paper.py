"""The paper's own way (§IV-C): floor by RANSAC, clusters at 2 cm, each as it is, classified by whole models."""

from __future__ import annotations

import numpy as np

from spherefunc_bullet.formats.units import Stopwatch
from spherefunc_bullet.function_model import FunctionModel

from ..scans.cells import cells
from ..scans.plane import level_by_ransac
from ..scans.scan import Scan
from ..segmentation.clusters import euclidean_clusters, members_of
from ..segmentation.segmentation import FLOOR, LEFT_OVER, Segmentation, is_floor, numbered_by_size
from .choosing import Candidate
from .judging import RecognitionContext, judged
from .proposals import CLUSTERS, Proposal
from .recognition import Room, scene_object

PAPER = "paper"  # the method's name


def recognise_as_paper(
    scan: Scan, model: FunctionModel, *, up: str = "auto", settings: Segmentation | None = None
) -> Room:
    """Find the objects of a scan and tell what each is for, as the paper did.

    Walls are clusters like any others, nothing is joined, parted or completed, and every cluster stands on its own
    lowest point, as models do.

    Parameters
    ----------
    scan, up, settings
        See `recognise`; of the settings, the voxels, the tolerance and the clusters' sizes count.
    model : FunctionModel
        Learnt from whole models: ``spherefunc train DATA --method paper``.
    """
    settings, watch = settings or Segmentation(), Stopwatch()
    levelling = level_by_ransac(scan.points, up, scan.name)
    watch.lap("floor")
    points = levelling.to_level(scan.points)
    labels = clusters_over_floor(points, settings)
    watch.lap("clusters")
    proposals = [
        Proposal(by=CLUSTERS, members=members, support=float(points[members, 2].min()))
        for members in members_of(labels)
    ]
    objects = [
        scene_object(number, points, Candidate(proposal=one.proposal, functions=one.functions, place=number))
        for number, one in enumerate(judged(points, proposals, RecognitionContext(model=model, completion=()), watch))
    ]
    return Room(levelling=levelling, labels=labels, objects=objects, proposals=objects, stages=watch.seconds)


def clusters_over_floor(points: np.ndarray, settings: Segmentation) -> np.ndarray:
    """Return the label (N,) int32 of each point (N, 3): its cluster's number, -1 floor, -3 too few or below it."""
    voxels = cells(points, settings.leaf_size)
    labels = np.full(len(voxels.keys), LEFT_OVER, np.int32)
    labels[is_floor(voxels.means, None)] = FLOOR
    rest = np.flatnonzero((labels == LEFT_OVER) & (voxels.means[:, 2] > 0))
    clusters = euclidean_clusters(voxels.means[rest], settings.cluster_tolerance)
    labels[rest] = numbered_by_size(clusters, settings)
    return labels[voxels.cell_of]
