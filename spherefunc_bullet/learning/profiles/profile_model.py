"""A fitted model by resting profiles: the part of `FunctionClassifier` that inference needs."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from copy import copy
from typing import TYPE_CHECKING, Self

import numpy as np

from ...clouds.cloud import Cloud
from ...function_model import FunctionModel, Membership, Reading
from ...settling.drops import FEW, Drops, DropsByRadius, RunLimit, settled_count
from ...simulator import Simulator
from .calibration import DEFAULT_UNSURE_RANGE, Calibration, CopyGroups, ScoreRange, calibrated, uncertainty
from .forest import Forest, SceneForests
from .quantities import NAMES, Ranks, profiles_over

if TYPE_CHECKING:
    from sklearn.base import ClassifierMixin

FAMILIAR = 0.99  # quantile of the distances from training objects to the nearest other one
PROFILE = "profile"  # name of the method
EVERY_NTH_COPY = 5  # copies that objects are compared with: with all, comparing takes longer than dropping spheres
ROOMY = 2  # multiple of FEW spheres for which there has to be room
SURE = 0.05  # distance of every score from 0 or 1 up to which the first drops suffice


def as_stored(profiles: np.ndarray) -> np.ndarray:
    """Return quantities rounded to float32, as trees compare them and files store them."""
    return profiles.astype(np.float32).astype(float)


def depends_on_few_spheres(drops: Drops) -> bool:
    """Return whether few spheres of a radius settled where there is room for many, as on a dome.

    The quantities then depend on single spheres, and these on the heading and the seed.
    """
    return 0 < np.count_nonzero(drops.settled) < FEW and drops.room >= ROOMY * FEW


class ProfileModel(FunctionModel):
    """Classify objects from their quantities, with one forest for each function.

    Parameters
    ----------
    simulator : str or Simulator
    radii : sequence of float
        Of the spheres, metres.
    drops : int
        Spheres dropped on an object at each radius.
    seed : int
        Of the drops.

    Attributes
    ----------
    functions_, forests_, calibrations_, radius_, profiles_, members_, names_, copy_groups_, familiar_distance_
        See `FunctionClassifier`.
    early_ : ProfileModel or None
        The model of the first drops on the same objects; it answers where it is sure.
    scene_forests_ : SceneForests or None
        Forests over quantities and surroundings of objects in scans; they answer where the surroundings are known.
    """

    drops: int
    quantities: tuple[str, ...] = NAMES  # at each radius; a model of an earlier version may have fewer
    forests_: list[Forest | ClassifierMixin | None]
    calibrations_: list[Calibration]
    profiles_: np.ndarray  # (N, R * Q) float
    copy_groups_: CopyGroups
    familiar_distance_: float
    unsure_ranges_: dict[str, ScoreRange] | None = None  # range of scores in which each function is unsure
    early_: ProfileModel | None = None
    scene_forests_: SceneForests | None = None
    checks_stability = True
    _ranks: tuple[np.ndarray, CopyGroups, Ranks] | None = None  # for searching, built when it is first needed

    def __init__(self, simulator: str | Simulator, *, radii: Sequence[float], drops: int, seed: int):
        self.simulator = simulator
        self.radii = radii
        self.drops = drops
        self.seed = seed

    @property
    def run_limit(self) -> RunLimit:
        """The limit of its runs."""
        return RunLimit(drops=self.drops)

    def profiles(self, settled: Sequence[DropsByRadius]) -> np.ndarray:
        """Return the quantities (N, R * Q) of objects, radius by radius; all 0 where no sphere was dropped."""
        return profiles_over(settled, self.radii, self.quantities)

    def quantity_names(self) -> list[str]:
        """Return the name of each column of `profiles`, such as ``level_height at 2 cm``."""
        return [f"{name} at {radius * 100:g} cm" for radius in self.radii for name in self.quantities]

    def score_settled(self, settled: Sequence[DropsByRadius], *, any_heading: bool = False) -> np.ndarray:
        """Return the scores (N, F) of objects: probabilities if the training objects are representative.

        ``any_heading`` changes nothing, since quantities do not depend on the heading of an object.
        """
        scores = np.zeros((len(settled), len(self.functions_)))
        readers = [self.reader_of(drops) for drops in settled]
        for reader in {id(reader): reader for reader in readers}.values():
            rows = [row for row, other in enumerate(readers) if other is reader]
            scores[rows] = reader.score_profiles(reader.profiles([settled[row] for row in rows]))
        return scores

    def scene_memberships(
        self, settled: Sequence[DropsByRadius], surroundings: np.ndarray
    ) -> list[dict[str, Membership]]:
        """Return the memberships of objects of a scan, also from their surroundings (N, S); see `scene_forests_`."""
        return self.memberships_by(self.scene_forests_.scores(self.profiles(settled), surroundings))

    def read(self, drop: Callable[[RunLimit], DropsByRadius]) -> Reading:
        """Return the reading of the first drops where it is sure, else of all drops; see `FunctionModel`."""
        if self.early_ is not None:
            first = self.early_.reading_of(drop(self.early_.run_limit))
            if self.early_.is_sure(first):
                return first
        return self.reading_of(drop(self.run_limit))

    def reading_of(self, drops: DropsByRadius) -> Reading:
        """Return the reading of the drops of one object, by the model that was fitted to runs of this limit."""
        reader = self.reader_of(drops)
        profile = reader.profiles([drops])
        return Reading(drops=drops, profile=profile[0], scores=reader.score_profiles(profile)[0], model=reader)

    def is_sure(self, reading: Reading) -> bool:
        """Return whether every score of an object is close to 0 or 1 and there is no doubt."""
        scores = reading.scores
        if any(depends_on_few_spheres(drops) for drops in reading.drops.values()):
            return False
        return bool((np.minimum(scores, 1 - scores) < SURE).all()) and not self.doubts(reading)

    @property
    def references(self) -> np.ndarray:
        """Indices (C,) of the training objects that others are compared with: originals, and every fifth copy."""
        copies = self.copy_groups_.weights < 1
        return np.flatnonzero(~copies | (np.cumsum(copies) % EVERY_NTH_COPY == 1))

    def distances(self, profiles: np.ndarray) -> np.ndarray:
        """Return the distances (A, C) of objects (A, R * Q) to `references`: mean differences of ranks."""
        if self._ranks is None or self._ranks[0] is not self.profiles_ or self._ranks[1] is not self.copy_groups_:
            self._ranks = self.profiles_, self.copy_groups_, Ranks(as_stored(self.profiles_[self.references]))
        return self._ranks[2].distances(as_stored(profiles))

    def sentences(self, reading: Reading) -> list[str]:
        """Return a sentence for each function that an object has; if it has none, for that with the highest score."""
        from .words import sentences

        return sentences(reading)

    def objects_on_table(self, cloud: Cloud, reading: Reading) -> int:
        """Return how many objects stand on the level that carries most of the spheres."""
        from .columns import objects_on_table

        return objects_on_table(cloud, reading.drops)

    def doubts(self, reading: Reading) -> list[str]:
        """Return why the answer is unsure, each a sentence; none where it is sure."""
        found = [
            uncertainty(name, score, between)
            for name, score in zip(self.functions_, reading.rounded, strict=True)
            for between in [self.unsure_range(name)]
            if between[0] < score < between[1]
        ]
        stayed = sum(settled_count(reading.drops, radius) for radius in self.radii)
        dropped = sum(len(reading.drops.get(radius, ())) for radius in self.radii)
        if stayed < FEW:
            return [*found, f"almost no sphere settled: {stayed} of {dropped}"]
        away = float(self.distances(reading.profile[None]).min())
        if away > self.familiar_distance_:
            found.append(
                f"unlike all {len(self.names_)} training objects: {away:.2f} from the nearest, where "
                f"{self.familiar_distance_:.2f} is far for one of them"
            )
        return found

    def unsure_range(self, name: str) -> ScoreRange:
        """Return the range of scores in which a function is uncertain."""
        return (self.unsure_ranges_ or {}).get(name, DEFAULT_UNSURE_RANGE)

    def are_uncertain(self, scores: np.ndarray) -> np.ndarray:
        """Return which answers (N,) bool, given as scores (N, F), are uncertain about some function."""
        low, high = np.array([self.unsure_range(name) for name in self.functions_]).T
        return ((scores > low) & (scores < high)).any(axis=1)

    def reader_of(self, settled: DropsByRadius) -> ProfileModel:
        """Return the model that reads the drops of an object: this one, or `early_` if there are only first drops."""
        longest = max(map(len, settled.values()), default=0)
        return self if self.early_ is None or longest > self.early_.drops else self.early_

    def score_profiles(self, profiles: np.ndarray) -> np.ndarray:
        """Return the scores (N, F) of objects given as quantities (N, R * Q)."""
        scores = np.zeros((len(profiles), len(self.functions_)))
        if not len(profiles):
            return scores
        for column, (votes, calibration) in enumerate(zip(self.votes(profiles), self.calibrations_, strict=True)):
            scores[:, column] = self.members_[:, column].all() if votes is None else calibrated(votes, calibration)
        return scores

    def votes(self, profiles: np.ndarray) -> list[np.ndarray | None]:
        """Return the votes of the forest of each function for objects given as quantities; None where there is none."""
        return [
            forest.votes(profiles) if isinstance(forest, Forest) else forest and forest.predict_proba(profiles)[:, 1]
            for forest in self.forests_
        ]

    def chosen_radii(self) -> list[float]:
        """Return the radii, ascending, metres; all of them are used."""
        return sorted(self.radii)

    def only(self, name: str) -> Self:
        """Return a fitted copy for one function only."""
        alone, column = copy(self), self.column_of(name)
        alone.functions_, alone.members_ = (name,), self.members_[:, [column]]
        alone.forests_, alone.calibrations_ = [self.forests_[column]], [self.calibrations_[column]]
        alone.radius_ = {name: self.radius_[name]}
        alone.early_ = self.early_ and self.early_.only(name)
        alone.scene_forests_ = self.scene_forests_ and self.scene_forests_.only(column)
        return alone

    def keep(self, rows: np.ndarray) -> Self:
        """Keep only the training objects in these rows (K,) for comparison, so that the model file is small.

        Forests stay as they are. Quantities are rounded as trees compare them, which changes no answer.
        """
        self.profiles_ = as_stored(self.profiles_[rows])
        self.members_, self.copy_groups_ = self.members_[rows], self.copy_groups_.of(rows)
        self.names_ = [self.names_[row] for row in rows]
        return self._set_familiar_distance()

    def _set_familiar_distance(self) -> Self:
        """Set the distance up to which an object counts as familiar, from those between training objects."""
        distances = self.distances(self.profiles_[self.references])
        np.fill_diagonal(distances, np.inf)
        nearest = distances.min(axis=1)
        self.familiar_distance_ = float(np.quantile(nearest, FAMILIAR)) if len(nearest) > 1 else np.inf
        return self
