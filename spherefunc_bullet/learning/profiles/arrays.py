"""A fitted model by resting profiles as the arrays of its file, and back."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from operator import methodcaller
from pathlib import Path
from typing import Any

import numpy as np

from ...errors import InputError
from ...formats import FormatError
from ...formats.npz import DAMAGE
from .calibration import DEFAULT_UNSURE_RANGE, CopyGroups
from .forest import Forest, calibrations_in, forest_arrays, rebuilt_forests, rebuilt_scene_forests, scene_forest_parts
from .profile_model import PROFILE, ProfileModel
from .quantities import NAMES

EARLY = "early_"  # prefix of the arrays of the model that was fitted to the first drops alone


def profile_parts(model: ProfileModel) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
    """Return header entries and arrays that the file of a model by resting profiles has besides those of all models."""
    about, arrays = fitted_parts(model)
    if model.early_ is not None:
        early, parts = fitted_parts(model.early_)
        about["early"] = early
        arrays |= {EARLY + name: values for name, values in parts.items()}
    if model.scene_forests_ is not None:
        scenes, parts = scene_forest_parts(model.scene_forests_)
        about, arrays = about | scenes, arrays | parts
    return about, arrays


def fitted_parts(model: ProfileModel) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
    """Return header entries and arrays of what was fitted to runs of one limit."""
    arrays = {"profiles": model.profiles_.astype(np.float32), "lines": np.array(model.calibrations_, float)}
    arrays |= {"weights": model.copy_groups_.weights, "groups": model.copy_groups_.groups}
    for forest in model.forests_:
        if forest is not None and not isinstance(forest, Forest):
            raise InputError(f"expected forests, which can be saved as arrays, got {type(forest).__name__}")
    arrays |= forest_arrays([forest and forest.to_float32() for forest in model.forests_])
    about = {"name": PROFILE, "drops": model.drops, "quantities": list(model.quantities)}
    radii = [model.radius_[name] for name in model.functions_]
    header = {"method": about, "familiar": model.familiar_distance_, "radius": radii}
    return header | {"unsure": [list(model.unsure_range(name)) for name in model.functions_]}, arrays


class FileModel(ProfileModel):
    """A model of a file for inference only: trees and training objects are unpacked when they are first needed.

    Most answers need only those of the first drops, ``early_``. A model that can be read from its file again is pickled
    as its ``origin`` alone, so that a worker unpacks it once and not for each object.
    """

    origin: tuple[Callable[..., FileModel], tuple] | None = None  # a function that returns this model, its arguments

    def __init__(self, arrays: Mapping[str, np.ndarray], path: str | Path, **how: Any):
        super().__init__(**how)
        self._arrays, self._path = arrays, path

    def __getattr__(self, name: str) -> Any:
        if name not in UNPACKED:
            raise AttributeError(f"{type(self).__name__} has no attribute {name!r}")
        with refusing_damage(self._path):
            setattr(self, name, UNPACKED[name](self, self._arrays))
        return vars(self)[name]

    def __reduce_ex__(self, protocol: int) -> Any:
        return self.origin or super().__reduce_ex__(protocol)

    def only(self, name: str) -> FileModel:
        """Return a copy for one function only."""
        alone = super().only(name)
        alone.origin = self.origin and (methodcaller("only", name), (self,))
        return alone

    def __copy__(self) -> FileModel:
        other = object.__new__(type(self))
        vars(other).update(vars(self) | {"origin": None})
        return other


class LostModel:
    """Stands for the model of a pickled answer that cannot be read any more: what needs it raises the error."""

    def __init__(self, error: InputError):
        self._error, self.early_ = error, self

    def only(self, name: str) -> LostModel:
        """Return the same."""
        return self

    def __getattr__(self, name: str) -> Any:
        raise AttributeError(name) if name.startswith("_") else self._error


@contextmanager
def refusing_damage(path: str | Path) -> Iterator[None]:
    """Raise InputError where the contents of a model file are damaged or inconsistent."""
    try:
        yield
    except InputError:
        raise
    except FormatError as error:  # larger than a model may be, or trees that are none
        raise InputError(f"{path}: {error}") from error
    except (*DAMAGE, AttributeError, IndexError) as error:
        expected = "expected a model as `spherefunc train` writes it"
        raise InputError(f"{path}: {expected}; it is damaged or inconsistent") from error


def profiles_in(model: ProfileModel, arrays: Mapping[str, np.ndarray]) -> np.ndarray:
    """Return the quantities (N, R * Q) of the training objects from the arrays of a model file."""
    profiles = np.asarray(arrays["profiles"], float)
    if profiles.shape != (len(model.names_), len(model.radii) * len(model.quantities)):
        raise ValueError("quantities and names differ in number")
    return profiles


def copy_groups_in(model: ProfileModel, arrays: Mapping[str, np.ndarray]) -> CopyGroups:
    """Return which training objects are copies from the arrays of a model file."""
    copies = CopyGroups(weights=np.asarray(arrays["weights"], float), groups=arrays["groups"].astype(int))
    if {len(copies.weights), len(copies.groups)} != {len(model.names_)}:
        raise ValueError("weights and names differ in number")
    return copies


def forests_in(model: ProfileModel, arrays: Mapping[str, np.ndarray]) -> list[Forest | None]:
    """Return the forests of a model from the arrays of its file."""
    forests = rebuilt_forests(arrays, len(model.functions_))
    for forest in forests:
        if forest is not None:
            forest.require_whole(len(model.radii) * len(model.quantities))
    return forests


# The largest attributes of a model, and the functions that return them from the arrays of its file.
UNPACKED = {"profiles_": profiles_in, "copy_groups_": copy_groups_in, "forests_": forests_in}


def fill_profiles(model: ProfileModel, about: dict[str, Any], arrays: Mapping[str, np.ndarray]):
    """Set the attributes of a model from its file; a `FileModel` unpacks the largest ones when they are needed."""
    names = about["functions"]
    model.quantities = tuple(about["method"]["quantities"])
    if not set(model.quantities) <= set(NAMES):
        raise ValueError("other quantities than this version reads")
    model.familiar_distance_ = float(about["familiar"])
    model.calibrations_ = calibrations_in(arrays["lines"], len(names))
    model.radius_ = {name: float(radius) for name, radius in zip(names, about["radius"], strict=True)}
    ranges = about.get("unsure") or [DEFAULT_UNSURE_RANGE] * len(names)
    model.unsure_ranges_ = {name: (float(low), float(high)) for name, (low, high) in zip(names, ranges, strict=True)}
    fitted = [model.familiar_distance_, *model.radius_.values(), *np.ravel(list(model.unsure_ranges_.values()))]
    if np.isnan(fitted).any():
        raise ValueError("limits that are no numbers")
    if about.get("surroundings"):
        model.scene_forests_ = rebuilt_scene_forests(about, arrays, len(model.radii) * len(model.quantities))
    if not isinstance(model, FileModel):
        for name, unpack in UNPACKED.items():
            setattr(model, name, unpack(model, arrays))


def fill_early(model: ProfileModel, early: ProfileModel, about: dict[str, Any], arrays: Mapping[str, np.ndarray]):
    """Set ``early_`` of a model to ``early``, filled from the arrays of its file, named without the prefix `EARLY`."""
    early.functions_, early.members_, early.names_ = model.functions_, model.members_, model.names_
    fill_profiles(early, about | about["early"] | {"surroundings": ()}, arrays)
    model.early_ = early
