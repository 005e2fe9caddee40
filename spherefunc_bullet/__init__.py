"""Tells what an object is for from how spheres come to rest on it (after Hinkle and Olson, IROS 2013).

import spherefunc_bullet as sf

cloud = sf.load_cloud("chair.ply")                        # metres, z up, on the ground
simulator = sf.make_simulator("fast")
result = simulator.drop(cloud, sf.DropSettings(radius=0.02), seed=0)
features = sf.SphereHistogram(simulator="fast", radius=0.02).fit_transform(clouds)
model = sf.FunctionClassifier(simulator="fast").fit(clouds, functions)
"""

from importlib import import_module

_HOMES = {
    "Cloud": "clouds.cloud",
    "CubeHistogram": "learning.histogram",
    "DropResult": "simulator",
    "DropSettings": "simulator",
    "FunctionClassifier": "learning.function_classifier",
    "InputError": "errors",
    "InverseDistanceClassifier": "learning.inverse_distance",
    "Outcome": "simulator",
    "Simulator": "simulator",
    "SphereHistogram": "learning.histogram",
    "Stop": "simulator",
    "cloud_from_mesh": "clouds.cloud",
    "cloud_from_points": "clouds.cloud",
    "load_cloud": "clouds.cloud",
    "load_model": "learning.model_file",
    "make_simulator": "simulator",
    "open_dataset": "datasets.dataset",
    "parse_length": "quantities",
    "save_model": "learning.model_file",
    "shipped_model": "learning.model_file",
}
__all__ = sorted(_HOMES)  # noqa: PLE0605


def __getattr__(name: str):
    """Import a public name when it is first used, so that the command line starts at once."""
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f".{_HOMES[name]}", __name__), name)


def __dir__():
    return __all__
