"""What a user's script does with the public names, for the type checker: `make lint` checks it in strict mode."""

from __future__ import annotations

from pathlib import Path

import numpy as np

import spherefunc_bullet as sf


def settled_share(path: Path) -> float:
    """Return the share of spheres that settle on a file's object."""
    cloud: sf.Cloud = sf.load_cloud(path, up="auto", units="auto", report=print)
    simulator: sf.Simulator = sf.make_simulator("fast", flat_angle_deg=4.0)
    result: sf.DropResult = simulator.drop(cloud, sf.DropSettings(radius=sf.parse_length("2cm")), seed=0)
    if result.stop == sf.Stop.SPHERE_LIMIT or not result.drops:
        raise sf.InputError(f"{path}: expected an object that spheres can fill")
    return result.settled / result.drops


def best_function(clouds: list[sf.Cloud], labels: list[str], asked: sf.Cloud) -> str:
    """Return what an object is most likely for, learnt from others."""
    model = sf.CubeClassifier("fast", radii=(0.02, 0.03)).fit(clouds, labels)
    sf.save_model(model, "model.npz")
    scores: np.ndarray = sf.load_model("model.npz", backend="fast").predict_proba([asked])
    said: list[frozenset[str]] | np.ndarray = model.predict([asked])
    return model.functions_[int(scores[0].argmax())] if said[0] else "none"


def histograms(points: list[np.ndarray]) -> int:
    """Return in how many cubes spheres settled on some clouds."""
    clouds = [sf.cloud_from_points(each, name=f"cloud {i}") for i, each in enumerate(points)]
    matrix = sf.SphereHistogram(simulator="fast", radius=0.02).fit_transform(clouds)
    answer: sf.Answer = sf.classify(points[0], units="mm", up="y")
    objects: list[sf.FoundObject] = sf.find_objects(points[0])
    if answer.unsure or "cup" in answer.functions or objects[0].scores["cup"] > answer.scores["cup"]:
        print(answer.reasons, objects[0].box.size, objects[0].points.shape)
    members: dict[str, sf.Membership] = sf.load_model(sf.shipped_model()).memberships_of([])[0]
    return int(matrix.shape[1]) + len(members)
