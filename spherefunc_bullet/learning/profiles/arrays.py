"""A fitted model by resting profiles as the arrays of its file."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from ...errors import InputError
from ...formats import FormatError
from ...formats.npz import DAMAGE
from .calibration import UNSURE, CopyGroups
from .forest import Forest, kept_forests, rebuilt_forests, rebuilt_scenes, scenes_kept
from .profile_model import PROFILE, ProfileModel
from .quantities import NAMES

EARLY = "early_"  # begins the names of what was learnt from the first drops alone


def profiles_kept(model: ProfileModel) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
    """Return what is kept of a classifier by resting profiles beside what is kept of all."""
    about, arrays = learnt_kept(model)
    if model.early_ is not None:
        early, parts = learnt_kept(model.early_)
        about["early"] = early
        arrays |= {EARLY + name: values for name, values in parts.items()}
    if model.in_scenes_ is not None:
        scenes, parts = scenes_kept(model.in_scenes_)
        about, arrays = about | scenes, arrays | parts
    return about, arrays


def learnt_kept(model: ProfileModel) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
    """Return what is kept of what was learnt from runs of one length."""
    arrays = {"profiles": model.profiles_.astype(np.float32), "lines": np.array(model.lines_, float)}
    arrays |= {"weights": model.copy_groups_.weights, "groups": model.copy_groups_.groups}
    for one in model.forests_:
        if one is not None and not isinstance(one, Forest):
            raise InputError(f"expected forests, which can be kept as arrays, got {type(one).__name__}")
    arrays |= kept_forests([one and one.to_float32() for one in model.forests_])
    about = {"name": PROFILE, "drops": model.drops, "quantities": list(model.quantities)}
    radii = [model.radius_[name] for name in model.functions_]
    kept = {"method": about, "familiar": model.familiar_, "radius": radii}
    return kept | {"unsure": [list(model.band(name)) for name in model.functions_]}, arrays


class KeptModel(ProfileModel):
    """A model of a file for asking alone: trees and training objects are unpacked when they are first needed.

    Most answers need those of the first drops, ``early_``, alone. Where it is known how to read it again, that is what
    goes to another process, so that a worker unpacks a model once and not for each object.
    """

    origin: tuple[Callable[..., KeptModel], tuple] | None = None  # what returns this model, and its arguments

    def __init__(self, arrays: Mapping[str, np.ndarray], path: str | Path, **how: Any):
        super().__init__(**how)
        self._arrays, self._path = arrays, path

    @cached_property
    def profiles_(self) -> np.ndarray:
        """The training objects' quantities (N, R * Q)."""
        return self._unpacked(profiles_in)

    @cached_property
    def copy_groups_(self) -> CopyGroups:
        """Which training objects are copies."""
        return self._unpacked(copy_groups_in)

    @cached_property
    def forests_(self) -> list[Forest | None]:
        """A forest for each function."""
        return self._unpacked(forests_in)

    def __reduce_ex__(self, protocol: int) -> Any:
        return self.origin or super().__reduce_ex__(protocol)

    def only(self, name: str) -> KeptModel:
        """Return a copy for one function alone."""
        alone = super().only(name)
        alone.origin = self.origin and (KeptModel.only, (self, name))
        return alone

    def __copy__(self) -> KeptModel:
        other = object.__new__(type(self))
        vars(other).update(vars(self) | {"origin": None})
        return other

    def _unpacked(self, part: Callable[[ProfileModel, Mapping[str, np.ndarray]], Any]) -> Any:
        with fitting_together(self._path):
            return part(self, self._arrays)


@contextmanager
def fitting_together(path: str | Path) -> Iterator[None]:
    """Raise InputError where what a model file holds is damaged, or does not fit together."""
    try:
        yield
    except InputError:
        raise
    except FormatError as error:  # larger than a model may be
        raise InputError(f"{path}: {error}") from error
    except (*DAMAGE, AttributeError, IndexError) as error:
        wanted = "expected a model as `spherefunc train` writes it"
        raise InputError(f"{path}: {wanted}; it is damaged, or its contents do not fit together") from error


def profiles_in(model: ProfileModel, arrays: Mapping[str, np.ndarray]) -> np.ndarray:
    """Return the quantities (N, R * Q) of a model's training objects that its file holds."""
    profiles = np.asarray(arrays["profiles"], float)
    if profiles.shape != (len(model.names_), len(model.radii) * len(model.quantities)):
        raise ValueError("quantities and names differ in number")
    return profiles


def copy_groups_in(model: ProfileModel, arrays: Mapping[str, np.ndarray]) -> CopyGroups:
    """Return which of them are copies."""
    copies = CopyGroups(weights=np.asarray(arrays["weights"], float), groups=arrays["groups"].astype(int))
    if {len(copies.weights), len(copies.groups)} != {len(model.names_)}:
        raise ValueError("weights and names differ in number")
    return copies


def forests_in(model: ProfileModel, arrays: Mapping[str, np.ndarray]) -> list[Forest | None]:
    """Return a model's forests that its file holds."""
    forests = rebuilt_forests(arrays, len(model.functions_))
    for one in forests:
        if one is not None:
            one.require_whole(len(model.radii) * len(model.quantities))
    return forests


def fill_profiles(model: ProfileModel, about: dict[str, Any], arrays: Mapping[str, np.ndarray]):
    """Give a model by resting profiles what its file holds, but what a `KeptModel` unpacks when it is needed."""
    names = about["functions"]
    model.quantities = tuple(about["method"]["quantities"])
    if not set(model.quantities) <= set(NAMES):
        raise ValueError("other quantities than this version reads")
    model.familiar_ = float(about["familiar"])
    model.lines_ = [(float(slope), float(offset)) for slope, offset in arrays["lines"].reshape(len(names), 2)]
    model.radius_ = {name: float(radius) for name, radius in zip(names, about["radius"], strict=True)}
    bands = about.get("unsure") or [UNSURE] * len(names)
    model.bands_ = {name: (float(low), float(high)) for name, (low, high) in zip(names, bands, strict=True)}
    if about.get("surroundings"):
        model.in_scenes_ = rebuilt_scenes(about, arrays, len(model.radii) * len(model.quantities))
    if not isinstance(model, KeptModel):
        model.profiles_, model.copy_groups_ = profiles_in(model, arrays), copy_groups_in(model, arrays)
        model.forests_ = forests_in(model, arrays)


def fill_early(model: ProfileModel, early: ProfileModel, about: dict[str, Any], arrays: Mapping[str, np.ndarray]):
    """Give a model what its file holds of the first drops (arrays named without `EARLY`), in another one, empty yet."""
    early.functions_, early.members_, early.names_ = model.functions_, model.members_, model.names_
    fill_profiles(early, about | about["early"] | {"surroundings": ()}, arrays)
    model.early_ = early
