"""The features that are evaluated: the spheres as a method reads them, and every baseline, each with its classifier."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial, reduce

import numpy as np
from joblib import Parallel, delayed

from spherefunc_bullet.batch.simulated import Simulated
from spherefunc_bullet.classification import excluded, failed_uses
from spherefunc_bullet.clouds.thinning import thin
from spherefunc_bullet.console import progress
from spherefunc_bullet.datasets.dataset import DatasetObject, distinct_names, sources_of
from spherefunc_bullet.function_model import THRESHOLD
from spherefunc_bullet.learning.function_classifier import FunctionClassifier
from spherefunc_bullet.learning.method import CUBES, DROPS, METHODS, AnyMethod, Method
from spherefunc_bullet.learning.profiles.calibration import CopyGroups, group_copies
from spherefunc_bullet.settling.cached_runs import Check
from spherefunc_bullet.settling.drops import DropsByRadius, settled_in_column
from spherefunc_bullet.settling.records import ObjectRecord

from .evaluation import Evaluation, FeatureMethod, Trial, evaluation_of, pooled_trial, splits_of_protocol
from .features import SPHERES, Distances, baseline_distances, of_each, sphere_distances, voxel_centers
from .protocol import Labels, Split, Splits, labels_of
from .related.examiner import related

POINTS = "points"  # by the same quantities
ACROSS = "leave_one_group_out"
PARTS = 10  # folds in place of leave-one-out: a forest takes seconds to learn, and nine tenths are nearly all objects
WORTH_CORES = 400  # objects to learn in all, a second's work: for fewer, other processes take longer to start


@dataclass(frozen=True, kw_only=True, eq=False)
class UseChecks:
    """Checks that objects can be used: they rule out functions that the spheres indicate."""

    fallen: np.ndarray  # (N,) bool: the objects that fall over when they are put down
    uses: tuple[Check, ...]  # of each object: whether it fails a check of its use, which takes time

    def of(self, rows: np.ndarray) -> UseChecks:
        """Return the checks of some objects, in their order."""
        return UseChecks(fallen=self.fallen[rows], uses=tuple(self.uses[row] for row in rows))

    def excluded(self, rows: np.ndarray, scores: np.ndarray, functions: Sequence[str]) -> tuple[np.ndarray, np.ndarray]:
        """Return the functions ruled out by scores (T, F), (T, F) bool, and which objects fail in use, (T,) bool."""
        failed = [
            () if self.fallen[row] else failed_uses(np.array(functions)[row_scores > THRESHOLD], self.uses[row])
            for row, row_scores in zip(rows, scores, strict=True)
        ]
        without = [excluded(functions, falls, uses) for falls, uses in zip(self.fallen[rows], failed, strict=True)]
        return np.array(without).reshape(scores.shape), np.array([bool(uses) for uses in failed], bool)


@dataclass(frozen=True, kw_only=True, eq=False)
class ProfileFeatures(FeatureMethod):
    """All objects' quantities, and the classifier that learns from them."""

    method = METHODS["profile"]

    profiles: np.ndarray  # (N, R * Q) float
    labels: Labels
    classifier: FunctionClassifier
    copy_groups: CopyGroups | None = None  # of the objects, where some are copies of others
    checks: UseChecks | None = None  # of the objects themselves

    def trial(self, splits: Sequence[Split]) -> Trial:
        """Return one trial of some splits; see `trials`."""
        return self.trials([splits])[0]

    def trials(self, splits_of_trials: Sequence[Sequence[Split]]) -> list[Trial]:
        """Return several trials; see `trials_of`."""
        return trials_of([(self, splits) for splits in splits_of_trials])

    def fold_trial(self, fold: Split) -> Trial:
        """Return the trial of one split, with the radius that counts most for each function as weight."""
        rows, functions = fold.train, self.labels.functions
        members, names = self.labels.members[rows], [str(row) for row in rows]
        copy_groups = None if self.copy_groups is None else self.copy_groups.of(rows)
        learnt = self.classifier.fit_profiles(self.profiles[rows], members, functions, names, copy_groups)
        scores, failing = learnt.score_profiles(self.profiles[fold.test]), False
        if self.checks is not None:
            without, failing = self.checks.excluded(fold.test, scores, functions)
            scores[without] = 0.0
        weights, unsure = [{learnt.radius_[name]: 1.0} for name in functions], learnt.are_uncertain(scores) | failing
        return Trial(learnt=len(rows), rows=fold.test, scores=scores, weights=[weights], unsure=unsure)


def evaluations(tasks: Sequence[tuple[ProfileFeatures, Splits]]) -> list[Evaluation]:
    """Return the evaluations of features under protocols, all of them learnt in parallel."""
    splits_of_trials = [(features, splits) for features, protocol in tasks for splits in splits_of_protocol(protocol)]
    results = iter(trials_of(splits_of_trials))
    return [evaluation_of(features, protocol, results) for features, protocol in tasks]


def trials_of(tasks: Sequence[tuple[ProfileFeatures, Sequence[Split]]]) -> list[Trial]:
    """Return a trial for each, on all cores; see `folds_of`."""
    folds = [[(features, fold) for fold in folds_of(splits)] for features, splits in tasks]
    work = [delayed(features.fold_trial)(fold) for own_folds in folds for features, fold in own_folds]
    rows = sum(len(fold.train) for own_folds in folds for _, fold in own_folds)
    learning = Parallel(n_jobs=-1 if rows >= WORTH_CORES else 1, return_as="generator")
    results = iter(list(progress(learning(work), len(work), "learning and testing")))
    parts = [[next(results) for _ in own_folds] for own_folds in folds]
    return [Trial.joined(trials, splits) for trials, (_, splits) in zip(parts, tasks, strict=True)]


def folds_of(splits: Sequence[Split]) -> list[Split]:
    """Return splits that are learnt at once: where many leave out one object each, a tenth of them at a time."""
    if len(splits) <= PARTS:
        return list(splits)
    parts = [[splits[k] for k in part] for part in np.array_split(np.arange(len(splits)), PARTS)]
    trains = [reduce(np.intersect1d, [split.train for split in part]) for part in parts]
    tests = [np.concatenate([split.test for split in part]) for part in parts]
    return list(map(Split, trains, tests))


def profiled(
    objects: Sequence[DropsByRadius], labels: Labels, classifier: FunctionClassifier, **more: object
) -> ProfileFeatures:
    """Return the quantities of objects, each given by its drops at every radius."""
    return ProfileFeatures(profiles=classifier.profiles(objects), labels=labels, classifier=classifier, **more)


def spheres_profiled(simulated: Simulated, labels: Labels, radii: tuple[float, ...]) -> ProfileFeatures:
    """Return the quantities of the spheres that fell on objects, with the checks of the objects' use."""
    fallen = np.array([record.falls_over for record in simulated.records], bool)
    checks = UseChecks(fallen=fallen, uses=tuple(record.check for record in simulated.records))
    groups = copy_groups_in(simulated.objects)
    return profiled(simulated.settled, labels, FunctionClassifier(radii=radii), copy_groups=groups, checks=checks)


def copy_groups_in(objects: Sequence[DatasetObject]) -> CopyGroups | None:
    """Return which objects are copies of others, as their manifests say; None where none is."""
    names, originals = distinct_names(objects)
    return group_copies(names, originals) if any(originals) else None


def calibrated_across_sources(read: ProfileFeatures, objects: Sequence[DatasetObject]) -> ProfileFeatures:
    """Return features whose classifier is calibrated on the objects of each source with that source left out."""
    names, originals = distinct_names(objects)
    return replace(read, copy_groups=group_copies(names, originals, sources_of(objects)))


def points_as_drops(record: ObjectRecord, radii: Sequence[float], seed: int = 0) -> DropsByRadius:
    """Return an object's own points in place of settled spheres: as far apart as spheres, in random order."""
    points = voxel_centers(record)
    mixed = np.random.default_rng(seed).permutation(points)
    return {radius: settled_in_column(thin(mixed, 2 * radius)[:DROPS], points, radius) for radius in radii}


@dataclass(frozen=True, kw_only=True, eq=False)
class NeighbourFeatures(FeatureMethod):
    """Nearest neighbours by distances between all objects."""

    distances: Distances
    labels: Labels
    method: Method

    def trials(self, splits_of_trials: Sequence[Sequence[Split]]) -> list[Trial]:
        """Return several trials; see `pooled_trial`."""
        each = progress(splits_of_trials, len(splits_of_trials), "learning and testing")
        return [pooled_trial(self.distances, self.labels, splits, self.method) for splits in each]


def readings(simulated: Simulated, radii: tuple[float, ...], method: AnyMethod) -> dict[str, FeatureMethod]:
    """Return the spheres as a method reads them, and all baselines: the objects' points, shapes and related work."""
    return {SPHERES: spheres_read(simulated, radii, method)} | baselines_read(simulated, radii, method)


def spheres_read(simulated: Simulated, radii: tuple[float, ...], method: AnyMethod) -> FeatureMethod:
    """Return the spheres as a method reads them."""
    labels = labels_of(simulated)
    if isinstance(method, Method):
        return NeighbourFeatures(distances=sphere_distances(simulated, radii, method), labels=labels, method=method)
    return spheres_profiled(simulated, labels, radii)


def baselines_read(simulated: Simulated, radii: tuple[float, ...], method: AnyMethod) -> dict[str, FeatureMethod]:
    """Return all baselines: the objects' own points, shapes and related work."""
    points = of_each(partial(points_as_drops, radii=radii), simulated.records)
    groups, classifier = copy_groups_in(simulated.objects), FunctionClassifier(radii=radii)
    read = profiled(points, labels_of(simulated), classifier, copy_groups=groups)  # by the same quantities
    return {POINTS: read} | shapes_read(simulated, radii, method)


def shapes_read(simulated: Simulated, radii: tuple[float, ...], method: AnyMethod) -> dict[str, FeatureMethod]:
    """Return the baselines that take little time: shapes, and related work.

    Shapes are scored with the neighbours, votes and choice of radius of the method, if it has these.
    """
    labels, neighbours = labels_of(simulated), method if isinstance(method, Method) else CUBES
    by_shape = baseline_distances(simulated.records, radii)
    features = partial(NeighbourFeatures, labels=labels, method=neighbours)
    return {name: features(distances=each) for name, each in by_shape.items()} | related(simulated.records, labels)
