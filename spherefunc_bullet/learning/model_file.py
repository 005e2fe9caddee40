"""Trained classifiers on disk: one NPZ file of plain arrays, without code.

The file holds the backend with its version and options, radii, function names, package versions and examples. A file
that does not fit what is installed is refused with a message that says why.
"""

from __future__ import annotations

import io
import json
import os
from collections.abc import Callable, Mapping
from functools import cache, partial
from importlib.metadata import version
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import InputError, attempt, explaining
from ..formats.files import require_file, require_place, write_bytes
from ..formats.npz import Archive
from ..function_model import FunctionModel, require_bounds
from ..settling.cached_runs import DropConfig
from ..simulator import backend_names, make_simulator
from .profiles.arrays import EARLY, FileModel, LostModel, fill_early, fill_profiles, profile_parts, refusing_damage
from .profiles.forest import of_prefix
from .profiles.profile_model import PROFILE

if TYPE_CHECKING:
    from ..classification import ModelPair
    from .classifier import CloudClassifier
    from .method import AnyMethod

FORMAT = "spherefunc-model"
FORMAT_VERSION = 1
About = dict[str, Any]  # the header of a model file, JSON
Arrays = Mapping[str, np.ndarray]
Rebuilding = Callable[[About, Arrays, str | Path], FunctionModel]


def shipped_model(backend: str = "fast", *, scans: bool = False) -> Path:
    """Return the model that comes with the package for a backend (made by ``make model``).

    Parameters
    ----------
    backend : str
    scans : bool
        Return the model for objects in scans, if the backend has one: it has learnt partial views of large objects as
        well as whole models (``make scan-model``).
    """
    folder = Path(str(files(__package__) / "models"))
    path = folder / f"household-scans-{backend}.npz"
    if not scans or not path.is_file():
        path = folder / f"household-{backend}.npz"
    if not path.is_file():
        make_simulator(backend)  # raises an error that lists the backends if there is none of this name
        raise InputError(f"backend {backend!r}: no model ships for it; train one and give model=")
    return path


def save_model(model: CloudClassifier, path: str | Path):
    """Write a fitted classifier.

    Raises
    ------
    NotFittedError
        If it is not fitted.
    InputError
        If it was fitted with another estimator than forests, which cannot be saved as arrays of trees.
    """
    from .cube_classifier import CubeClassifier, cube_parts

    if not hasattr(model, "require_fitted"):
        raise InputError(f"model: expected a FunctionClassifier or CubeClassifier, got {type(model).__name__}")
    model.require_fitted()
    require_bounds(model.radii, model.run_limit.drops, path)
    simulator = make_simulator(model.simulator)
    about = {
        "format": FORMAT,
        "format_version": FORMAT_VERSION,
        "backend": simulator.name,
        "backend_version": simulator.version,
        "backend_options": simulator.options(),
        "functions": list(model.functions_),
        "radii": [float(radius) for radius in model.radii],
        "seed": model.seed,
        "random_state": model.random_state,
        "versions": {name: version(name) for name in ("spherefunc-bullet", "numpy", "scikit-learn")},
    }
    about |= {"columns": list(model.columns_)} if model.columns_ else {}
    arrays = {"members": model.members_, "names": np.array(model.names_)}
    more, parts = cube_parts(model) if isinstance(model, CubeClassifier) else profile_parts(model)
    require_place(Path(path))
    with explaining(f"{path}: expected a random_state that is a number or None, to be saved", TypeError):
        header, buffer = json.dumps(about | more, default=np.generic.item), io.BytesIO()
    np.savez_compressed(buffer, about=np.array(header), **arrays, **parts)
    write_bytes(Path(path), buffer.getvalue())


@cache
def cached_model(path: Path, backend: str | None, changed: int) -> FunctionModel:
    """Return the model of a file, read once per process and shared, so it must not be changed.

    Parameters
    ----------
    changed : int
        Time at which the file was last changed, so that a newer file is read again.

    Raises
    ------
    InputError
        See `load_model`; or if the file is newer than ``changed``.
    """
    if os.path.isfile(path) and path.stat().st_mtime_ns != changed:
        raise InputError(f"{path}: expected the model that was read when this began, it has been written since")
    model = read_model(path, backend, rebuilt_for_inference)
    if isinstance(model, FileModel):
        model.origin = (model_again, (path, backend, changed))
        if model.early_ is not None:
            model.early_.origin = (getattr, (model, "early_"))
    return model


def model_again(path: Path, backend: str | None, changed: int) -> FunctionModel | LostModel:
    """Return the model that a pickle names by its path; if the file is gone or newer, one that cannot be used."""
    found = attempt(cached_model, (path, backend, changed))
    return LostModel(found) if isinstance(found, InputError) else found


def inference_model(model: str | Path | FunctionModel | None, backend: str | None) -> FunctionModel:
    """Return a model for inference only: a given one, that of a file, or the one that ships; files are read once.

    A model by resting profiles is returned as a `ProfileModel`, which does not need scikit-learn.

    Raises
    ------
    InputError
        See `load_model`.
    """
    if isinstance(model, FunctionModel):
        if not hasattr(model, "functions_"):
            raise InputError(f"model: expected a fitted classifier, got {type(model).__name__}; call fit first")
        return model
    with explaining(f"model: expected a path or a classifier, got {type(model).__name__}", TypeError):
        path = shipped_model(backend or "fast") if model is None else Path(model)
    return cached_model(path, backend, path.stat().st_mtime_ns if os.path.isfile(path) else 0)


def models_for(model: str | Path | FunctionModel | None, backend: str | None, function: str | None) -> list[ModelPair]:
    """Return the model of each backend named, with a function that returns its model for single views.

    Parameters
    ----------
    backend : str, optional
        One, or several separated by commas, of which the first answers; see `classification.classify_by_all`.
    function : str, optional
        The only function that is classified.

    Raises
    ------
    InputError
        See `load_model`; or if several backends are named with a model, which belongs to one backend.
    """
    names = [None] if backend is None else backend_names(backend)
    if model is not None and len(names) > 1:
        raise InputError(f"backend {backend!r}: expected one backend, since a model belongs to one")
    models = [inference_model(model, name) for name in names]
    chosen = models if function is None else [each.only(function) for each in models]
    return [(each, partial(model_for_views, each, given=model is not None)) for each in chosen]


def model_for_views(model: FunctionModel, *, given: bool) -> FunctionModel:
    """Return the model for single views: the same one if the user gave it, else the one that ships for scans.

    A model for one function only is replaced by one for that function only.
    """
    if given:
        return model
    backend = make_simulator(model.simulator).name
    shipped = inference_model(shipped_model(backend, scans=True), backend)
    return shipped.only(model.functions_[0]) if len(model.functions_) == 1 else shipped


def load_model(path: str | Path | None = None, backend: str | None = None) -> CloudClassifier:
    """Read a classifier from a file, ready to classify and to learn more.

    Parameters
    ----------
    path : path, optional
        A model file; without one, the model that ships with the package for the backend, by default ``fast``.
    backend : str, optional
        The backend with which it will be used.

    Raises
    ------
    InputError
        If the file is not a model, is damaged, or is of another version or backend.
    """
    return read_model(shipped_model(backend or "fast") if path is None else path, backend, rebuilt_for_training)


def read_model(path: str | Path, backend: str | None, rebuilt: Rebuilding) -> FunctionModel:
    """Return the model of a file, rebuilt for inference or for training; see `load_model`."""
    require_file(Path(path))
    with refusing_damage(path):
        arrays = Archive(Path(path).read_bytes())
        about = json.loads(str(arrays["about"]))
        check_about(about, path, backend)
        return rebuilt(about, arrays, path)


def check_about(about: About, path: str | Path, backend: str | None):
    """Raise InputError unless a header is that of a model of this version and backend."""
    if not isinstance(about, dict) or about.get("format") != FORMAT:
        raise InputError(f"{path}: expected a model as `spherefunc train` writes it, got another NPZ file")
    if (found := about.get("format_version")) != FORMAT_VERSION:
        raise InputError(f"{path}: expected model format {FORMAT_VERSION}, got {found}; train it again")
    if backend is not None and about["backend"] != backend:
        raise InputError(f"{path}: a model of the backend {about['backend']}, not to be used with {backend}'s features")
    for method in (about["method"], about.get("early", about)["method"]):
        require_bounds(about["radii"], int(method["drops"]) if "drops" in method else None, path)
    try:
        simulator = make_simulator(about["backend"], **about["backend_options"])
    except InputError as error:
        raise InputError(f"{path}: {error}") from error
    if simulator.version != about["backend_version"]:
        raise InputError(
            f"{path}: learnt with version {about['backend_version']} of the backend {about['backend']}, "
            f"installed is {simulator.version}; train it again"
        )


def rebuilt_for_inference(about: About, arrays: Arrays, path: str | Path) -> FunctionModel:
    """Return the model that a file describes, for inference only if it is one by resting profiles."""
    if about["method"]["name"] != PROFILE:
        return rebuilt_for_training(about, arrays, path)
    simulator = make_simulator(about["backend"], **about["backend_options"])
    how = {"simulator": simulator, "radii": tuple(about["radii"]), "seed": about["seed"]}
    model = FileModel(arrays, path, **how, drops=int(about["method"]["drops"]))
    fill_examples(model, about, arrays)
    fill_profiles(model, about, arrays)
    if "early" in about:
        parts, drops = of_prefix(arrays, EARLY), int(about["early"]["method"]["drops"])
        fill_early(model, FileModel(parts, path, **how, drops=drops), about, parts)
    return model


def rebuilt_for_training(about: About, arrays: Arrays, path: str | Path) -> CloudClassifier:
    """Return the classifier that a model file describes."""
    simulator = make_simulator(about["backend"], **about["backend_options"])
    options = {"radii": tuple(about["radii"]), "seed": about["seed"], "random_state": about["random_state"]}
    if about["method"]["name"] != PROFILE:
        from .cube_classifier import CubeClassifier, fill_cubes, rebuilt_method

        model = CubeClassifier(simulator, method=rebuilt_method(about["method"]), **options)
        fill_training(model, about, arrays)
        fill_cubes(model, about, arrays)
        return model
    from .function_classifier import FunctionClassifier

    early = int(about["early"]["method"]["drops"]) if "early" in about else 0
    model = FunctionClassifier(simulator, drops=int(about["method"]["drops"]), early_drops=early, **options)
    fill_training(model, about, arrays)
    fill_profiles(model, about, arrays)
    if early:
        fill_early(model, model.of_drops(early), about, of_prefix(arrays, EARLY))
    return model


def fill_training(model: CloudClassifier, about: About, arrays: Arrays):
    """Set what `fill_examples` does, and the names of the columns of the indicator that a classifier learnt, if any."""
    fill_examples(model, about, arrays)
    model.radii_ = model.radii
    model.columns_ = tuple(about["columns"]) if "columns" in about else None


def fill_examples(model: FunctionModel, about: About, arrays: Arrays):
    """Set the functions and the training objects of a model from its file."""
    model.functions_ = tuple(about["functions"])
    model.members_ = arrays["members"].astype(bool)
    model.names_ = np.asarray(arrays["names"], str).tolist()
    if model.members_.shape != (len(model.names_), len(model.functions_)):
        raise ValueError("members, names and functions differ in number")
    if len({*model.functions_} & {*map(str, model.functions_)}) < len(model.functions_):
        raise ValueError("functions that are no distinct names")


def new_classifier(how: DropConfig, method: str | AnyMethod) -> CloudClassifier:
    """Return an unfitted classifier of a method, for spheres dropped as configured."""
    from .cube_classifier import CubeClassifier
    from .function_classifier import FunctionClassifier
    from .method import Method, find_method

    chosen = find_method(method)
    if isinstance(chosen, Method):
        return CubeClassifier(how.simulator, radii=how.radii, method=chosen, seed=how.seed)
    return FunctionClassifier(how.simulator, radii=how.radii, drops=how.run_limit.drops, seed=how.seed)
