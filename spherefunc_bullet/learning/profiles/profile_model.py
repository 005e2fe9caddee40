"""A fitted model by resting profiles: what is asked of `FunctionClassifier`, which learns it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from copy import copy
from typing import TYPE_CHECKING, Self

import numpy as np

from ...clouds.cloud import Cloud
from ...function_model import FunctionModel, Membership, Reading
from ...settling.drops import FEW, Drops, DropsByRadius, RunLimit, settled_count
from ...simulator import Simulator
from .calibration import UNSURE, Band, CopyGroups, Line, calibrated
from .forest import Forest, ForestBatch, SceneForests, forest_batch
from .quantities import NAMES, Ranks, profiles_over

if TYPE_CHECKING:
    from sklearn.base import ClassifierMixin

FAMILIAR = 0.99  # of the training objects are no farther from the nearest other one
PROFILE = "profile"  # the method's name
COMPARED_COPIES = 5  # one in so many copies is compared with: thousands would take longer than to drop spheres
ROOMY = 2  # times as many as are few: for so many there has to be room
SURE = 0.05  # how far from 0 or 1 each score may be after the first drops to be the answer: the error that is stated


def as_kept(profiles: np.ndarray) -> np.ndarray:
    """Return quantities as precisely as trees read them and files keep them."""
    return profiles.astype(np.float32).astype(float)


def hangs_on_few(drops: Drops) -> bool:
    """Return whether few spheres of a radius settled where there is room for many, as on a dome.

    How large a level is hangs on each of them then, and they on the heading and the seed.
    """
    return 0 < np.count_nonzero(drops.settled) < FEW and drops.room >= ROOMY * FEW


class ProfileModel(FunctionModel):
    """Tell what objects are for from their quantities, with one forest for each function.

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
    functions_, forests_, lines_, radius_, profiles_, members_, names_, copy_groups_, familiar_
        What was learnt, see `FunctionClassifier`.
    early_ : ProfileModel or None
        What was learnt from the first drops on the same objects; it answers where it is sure.
    in_scenes_ : SceneForests or None
        What was learnt from the quantities and what surrounds objects in scans; it answers where that is known.
    """

    drops: int
    quantities: tuple[str, ...] = NAMES  # at each radius; a model of an earlier version may read fewer
    forests_: list[Forest | ClassifierMixin | None]
    lines_: list[Line]
    profiles_: np.ndarray  # (N, R * Q) float
    copy_groups_: CopyGroups
    familiar_: float
    bands_: dict[str, Band] | None = None  # scores between which a function is unsure
    early_: ProfileModel | None = None
    in_scenes_: SceneForests | None = None
    checks_stability = True
    # What was learnt in the order in which it is searched, made when it is first needed.
    _ranks: tuple[np.ndarray, CopyGroups, Ranks] | None = None
    _forest_batch: tuple[list[Forest], ForestBatch] | None = None

    def __init__(self, simulator: str | Simulator, *, radii: Sequence[float], drops: int, seed: int):
        self.simulator = simulator
        self.radii = radii
        self.drops = drops
        self.seed = seed

    @property
    def length(self) -> RunLimit:
        """How long its runs are."""
        return RunLimit(drops=self.drops)

    def profiles(self, settled: Sequence[DropsByRadius]) -> np.ndarray:
        """Return the quantities (N, R * Q) of objects, radius by radius; all 0 where no sphere was dropped."""
        return profiles_over(settled, self.radii, self.quantities)

    def quantity_names(self) -> list[str]:
        """Return the name of each column of `profiles`, such as ``level_height at 2 cm``."""
        return [f"{name} at {radius * 100:g} cm" for radius in self.radii for name in self.quantities]

    def score_settled(self, settled: Sequence[DropsByRadius], *, any_heading: bool = False) -> np.ndarray:
        """Return the scores (N, F) of objects, probabilities where training objects stand for what will be asked.

        ``any_heading`` changes nothing, as quantities do not depend on which way an object faces.
        """
        scores = np.zeros((len(settled), len(self.functions_)))
        readers = [self.reader_of(one) for one in settled]
        for reader in {id(reader): reader for reader in readers}.values():
            rows = [row for row, own in enumerate(readers) if own is reader]
            scores[rows] = reader.score_profiles(reader.profiles([settled[row] for row in rows]))
        return scores

    def memberships_in_scene(self, settled: Sequence[DropsByRadius], beside: np.ndarray) -> list[dict[str, Membership]]:
        """Return what objects of a scan are for by what surrounds them (N, S) as well, see `in_scenes_`."""
        return self.memberships_by(self.in_scenes_.scores(self.profiles(settled), beside))

    def read(self, drop: Callable[[RunLimit], DropsByRadius]) -> Reading:
        """Return the first drops where these make sure what the object is for, else all; see `FunctionModel`."""
        if self.early_ is not None:
            first = self.early_.reading_of(drop(self.early_.length))
            if self.early_.sure_of(first):
                return first
        return self.reading_of(drop(self.length))

    def reading_of(self, drops: DropsByRadius) -> Reading:
        """Return one object's drops, read by what has learnt runs of such a length."""
        reader = self.reader_of(drops)
        profile = reader.profiles([drops])
        return Reading(drops=drops, profile=profile[0], scores=reader.score_profiles(profile)[0], model=reader)

    def sure_of(self, reading: Reading) -> bool:
        """Return whether every score of an object is next to 0 or 1, and nothing about it doubtful."""
        scores = reading.scores
        if any(hangs_on_few(drops) for drops in reading.drops.values()):
            return False
        return bool((np.minimum(scores, 1 - scores) < SURE).all()) and not self.doubts(reading)

    @property
    def compared(self) -> np.ndarray:
        """The training objects (C,) that others are compared with: all that are no copies, and every fifth copy."""
        copies = self.copy_groups_.weights < 1
        return np.flatnonzero(~copies | (np.cumsum(copies) % COMPARED_COPIES == 1))

    def distances(self, profiles: np.ndarray) -> np.ndarray:
        """Return how far objects (A, R * Q) are from those in `compared`, (A, C): the mean difference of ranks."""
        if self._ranks is None or self._ranks[0] is not self.profiles_ or self._ranks[1] is not self.copy_groups_:
            self._ranks = self.profiles_, self.copy_groups_, Ranks(as_kept(self.profiles_[self.compared]))
        return self._ranks[2].distances(as_kept(profiles))

    def sentences(self, reading: Reading) -> list[str]:
        """Return a sentence for each function that an object has, or for the likeliest where it has none."""
        from .words import sentences

        return sentences(reading)

    def objects_on_table(self, cloud: Cloud, reading: Reading) -> int:
        """Return how many objects stand on the level that carries most of the spheres."""
        from .columns import objects_on_table

        return objects_on_table(cloud, reading.drops)

    def doubts(self, reading: Reading) -> list[str]:
        """Return why the answer is unsure, each a sentence; none where it is sure."""
        found = [
            f"{name} is uncertain: its score {score:.2f} is between {low:.2f} and {high:.2f}"
            for name, score in zip(self.functions_, reading.rounded, strict=True)
            for low, high in [self.band(name)]
            if low < score < high
        ]
        stayed = sum(settled_count(reading.drops, radius) for radius in self.radii)
        dropped = sum(len(reading.drops.get(radius, ())) for radius in self.radii)
        if stayed < FEW:
            return [*found, f"almost no sphere settled: {stayed} of {dropped}"]
        away = float(self.distances(reading.profile[None]).min())
        if away > self.familiar_:
            found.append(
                f"unlike all {len(self.names_)} training objects: {away:.2f} from the nearest, where "
                f"{self.familiar_:.2f} is far for one of them"
            )
        return found

    def band(self, name: str) -> Band:
        """Return the two scores between which a function is uncertain."""
        return (self.bands_ or {}).get(name, UNSURE)

    def are_doubtful(self, scores: np.ndarray) -> np.ndarray:
        """Return which answers, by their scores (N, F), are uncertain about some function, (N,) bool."""
        low, high = np.array([self.band(name) for name in self.functions_]).T
        return ((scores > low) & (scores < high)).any(axis=1)

    def reader_of(self, settled: DropsByRadius) -> ProfileModel:
        """Return what reads an object's drops: this, or what has learnt the first ones where there are no more."""
        longest = max(map(len, settled.values()), default=0)
        return self if self.early_ is None or longest > self.early_.drops else self.early_

    def score_profiles(self, profiles: np.ndarray) -> np.ndarray:
        """Return the scores (N, F) of objects given as quantities (N, R * Q)."""
        scores = np.zeros((len(profiles), len(self.functions_)))
        if not len(profiles):
            return scores
        for column, (votes, line) in enumerate(zip(self.votes(profiles), self.lines_, strict=True)):
            scores[:, column] = self.members_[:, column].all() if votes is None else calibrated(votes, line)
        return scores

    def votes(self, profiles: np.ndarray) -> list[np.ndarray | None]:
        """Return what each function's forest says of objects given as quantities, None where there is none to ask."""
        forests = [one for one in self.forests_ if isinstance(one, Forest)]
        if forests and (self._forest_batch is None or self._forest_batch[0] != forests):
            self._forest_batch = forests, forest_batch(forests)
        own = iter(self._forest_batch[1].votes(profiles) if forests else ())
        return [
            next(own) if isinstance(one, Forest) else one and one.predict_proba(profiles)[:, 1] for one in self.forests_
        ]

    def chosen_radii(self) -> list[float]:
        """Return the radii, ascending, metres; all of them count."""
        return sorted(self.radii)

    def only(self, name: str) -> Self:
        """Return a fitted copy that is asked for one function alone, by its forest."""
        alone, column = copy(self), self.column_of(name)
        alone.functions_, alone.members_ = (name,), self.members_[:, [column]]
        alone.forests_, alone.lines_ = [self.forests_[column]], [self.lines_[column]]
        alone.radius_ = {name: self.radius_[name]}
        alone.early_ = self.early_ and self.early_.only(name)
        alone.in_scenes_ = self.in_scenes_ and self.in_scenes_.only(column)
        return alone

    def keep(self, rows: np.ndarray) -> Self:
        """Keep some of the training objects (K,) to be compared with, and all that was learnt; for many small files.

        Quantities are kept as precisely as trees read them, which changes no answer.
        """
        self.profiles_ = as_kept(self.profiles_[rows])
        self.members_, self.copy_groups_ = self.members_[rows], self.copy_groups_.of(rows)
        self.names_ = [self.names_[row] for row in rows]
        return self._know()

    def _know(self) -> Self:
        """See how far training objects are from one another."""
        distances = self.distances(self.profiles_[self.compared])
        np.fill_diagonal(distances, np.inf)
        nearest = distances.min(axis=1)
        self.familiar_ = float(np.quantile(nearest, FAMILIAR)) if len(nearest) > 1 else np.inf
        return self
