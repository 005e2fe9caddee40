"""A fitted classifier by cubes as the arrays of its file."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

import numpy as np
from scipy import sparse

from .cube_classifier import CubeClassifier
from .method import CUBES, Method, find_cube_method


def cubes_kept(model: CubeClassifier) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
    """Return what is kept of a classifier by cubes beside what is kept of all."""
    arrays = {}
    for i, radius in enumerate(model.radii):
        matrix = model.examples_[radius]
        arrays[f"keys_{i}"] = model.histograms_[radius].keys_
        arrays[f"data_{i}"], arrays[f"indices_{i}"], arrays[f"indptr_{i}"] = matrix.data, matrix.indices, matrix.indptr
    weights = {name: list(weights.items()) for name, weights in model.weights_.items()}
    return {"method": asdict(find_cube_method(model.method)), "weights": weights}, arrays


def rebuilt_method(about: dict[str, Any]) -> Method:
    """Return the method that a model file describes; of what earlier versions could vary, only the default is left."""
    fixed = {"anchor": "centre", "heading": "as_given", "counts": "raw"}
    about = about | {"neighbors": tuple(about["neighbors"])}
    if any(about.pop(name, value) != value for name, value in fixed.items()):
        raise ValueError("a method of an earlier version")
    if about["name"] == "default":  # what earlier versions called it
        about["name"] = CUBES.name
    return Method(**about)


def fill_cubes(model: CubeClassifier, about: dict[str, Any], arrays: dict[str, np.ndarray]):
    """Give a classifier by cubes what its file holds."""
    model.weights_ = {
        name: {radius: weight for radius, weight in about["weights"][name]} for name in about["functions"]
    }
    if not all(weights and set(weights) <= set(model.radii) for weights in model.weights_.values()):
        raise ValueError("a function's radius is none of the model's")
    model.histograms_, model.examples_ = {}, {}
    for i, radius in enumerate(model.radii):
        histogram = model.method.histogram(radius)
        histogram.keys_ = arrays[f"keys_{i}"].astype(np.int64)
        parts = arrays[f"data_{i}"], arrays[f"indices_{i}"], arrays[f"indptr_{i}"]
        matrix = sparse.csr_matrix(parts, shape=(len(arrays["names"]), len(histogram.keys_) + 1))
        matrix.check_format(full_check=True)
        model.histograms_[radius], model.examples_[radius] = histogram, matrix
