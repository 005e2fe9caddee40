"""A fitted model by resting profiles as the arrays of its file."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...errors import InputError
from .calibration import UNSURE, CopyGroups
from .forest import Forest, kept_forests, rebuilt_forests
from .in_scenes import rebuilt_scenes, scenes_kept
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
    arrays = {"profiles": model.profiles_, "lines": np.array(model.lines_, float)}
    arrays |= {"weights": model.copy_groups_.weights, "groups": model.copy_groups_.groups}
    for one in model.forests_:
        if one is not None and not isinstance(one, Forest):
            raise InputError(f"expected forests, which can be kept as arrays, got {type(one).__name__}")
    arrays |= kept_forests([one and one.to_float32() for one in model.forests_])
    about = {"name": PROFILE, "drops": model.drops, "quantities": list(model.quantities)}
    radii = [model.radius_[name] for name in model.functions_]
    kept = {"method": about, "familiar": model.familiar_, "radius": radii}
    return kept | {"unsure": [list(model.band(name)) for name in model.functions_]}, arrays


def fill_profiles(model: ProfileModel, about: dict[str, Any], arrays: dict[str, np.ndarray]):
    """Give a model by resting profiles what its file holds."""
    names = about["functions"]
    model.quantities = tuple(about["method"]["quantities"])
    if not set(model.quantities) <= set(NAMES):
        raise ValueError("other quantities than this version reads")
    model.profiles_ = arrays["profiles"].astype(float)
    model.familiar_ = float(about["familiar"])
    model.lines_ = [(float(slope), float(offset)) for slope, offset in arrays["lines"].reshape(len(names), 2)]
    model.radius_ = {name: float(radius) for name, radius in zip(names, about["radius"], strict=True)}
    bands = about.get("unsure") or [UNSURE] * len(names)
    model.bands_ = {name: (float(low), float(high)) for name, (low, high) in zip(names, bands, strict=True)}
    model.copy_groups_ = CopyGroups(weights=arrays["weights"].astype(float), groups=arrays["groups"].astype(int))
    if {len(model.copy_groups_.weights), len(model.copy_groups_.groups)} != {len(model.profiles_)}:
        raise ValueError("weights and names differ in number")
    if model.profiles_.shape != (len(arrays["names"]), len(model.radii) * len(model.quantities)):
        raise ValueError("quantities and names differ in number")
    model.forests_ = rebuilt_forests(arrays, len(names))
    for one in model.forests_:
        if one is not None:
            one.require_whole(model.profiles_.shape[1])
    if about.get("surroundings"):
        model.in_scenes_ = rebuilt_scenes(about, arrays, model.profiles_.shape[1])


def fill_early(model: ProfileModel, early: ProfileModel, about: dict[str, Any], arrays: dict[str, np.ndarray]):
    """Give a model what its file holds of the first drops, to be read by another one that is empty."""
    early.functions_, early.members_, early.names_ = model.functions_, model.members_, model.names_
    parts = {name.removeprefix(EARLY): values for name, values in arrays.items() if name.startswith(EARLY)}
    fill_profiles(early, about | about["early"] | {"surroundings": ()}, parts | {"names": arrays["names"]})
    model.early_ = early
