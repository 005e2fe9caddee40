"""Euclidean clusters: points that a chain of neighbours within a tolerance connects (PCL, paper §IV-C)."""

from __future__ import annotations

import numpy as np


def euclidean_clusters(points: np.ndarray, tolerance: float) -> np.ndarray:
    """Return the cluster (N,) int32 of each point, numbered from 0.

    Parameters
    ----------
    points : (N, 3) float64, metres
    tolerance : float
        Largest distance between neighbours, metres.
    """
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components
    from scipy.spatial import cKDTree

    if not len(points):
        return np.empty(0, np.int32)
    pairs = cKDTree(points).query_pairs(tolerance, output_type="ndarray")
    graph = coo_matrix((np.ones(len(pairs), bool), pairs.T), shape=(len(points), len(points)))
    return connected_components(graph, directed=False)[1].astype(np.int32)
