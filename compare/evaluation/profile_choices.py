"""How the resting profile was chosen: what each quantity adds, and what other classifiers make of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from sklearn.base import ClassifierMixin
from sklearn.ensemble import ExtraTreesClassifier, HistGradientBoostingClassifier, RandomForestClassifier
from sklearn.neighbors import KNeighborsClassifier
from sklearn.pipeline import make_pipeline
from sklearn.preprocessing import QuantileTransformer
from sklearn.svm import SVC

from spherefunc_bullet.batch.simulated import Simulated
from spherefunc_bullet.console import print_json, print_table
from spherefunc_bullet.learning.function_classifier import FunctionClassifier, forest
from spherefunc_bullet.learning.profiles.quantities import NAMES

from .alternatives import f_measures, print_beside
from .evaluation import Evaluation, Trial
from .profiled import ACROSS, Profiled, profiled
from .protocol import Labels, Splits, labels_of

SURE = 0.003  # a probability beyond this counts as this much, so that one object cannot decide a mean
TREES = 100  # of the forests that rank quantities


def scaled(classifier: ClassifierMixin) -> ClassifierMixin:
    """Return a classifier of quantities in normal ranks, so that metres and shares can be compared."""
    ranks = QuantileTransformer(n_quantiles=20, output_distribution="normal", random_state=0)
    return make_pipeline(ranks, classifier)


CLASSIFIERS = {
    "extremely random trees": forest(),
    "random forest": RandomForestClassifier(300, random_state=0),
    "boosted trees": HistGradientBoostingClassifier(random_state=0),
    "support vectors": scaled(SVC(C=3, probability=True, random_state=0)),
    "nearest neighbours": scaled(KNeighborsClassifier(3, weights="distance")),
}


def print_classifiers(simulated: Simulated, radii: tuple[float, ...], splits: Splits, json: bool):
    """Print what each classifier makes of the quantities, calibrated alike: across sources and on random halves."""
    labels = labels_of(simulated)
    read = profiled(simulated.settled, labels, FunctionClassifier(radii=radii))
    rows = {}
    for name, estimator in CLASSIFIERS.items():
        classifier = FunctionClassifier(radii=radii, estimator=estimator)
        rows[name] = summary(replace(read, classifier=classifier).evaluation(splits))
    title = f"{simulated.name}: F-measure of {', '.join(labels.functions)}, and the log loss across sources"
    print_beside("classifier", rows, title, json)


def summary(evaluation: Evaluation) -> dict[str, dict[str, float] | float]:
    """Return F-measures across sources and on random halves, and the log loss across sources."""
    halves = {f"{size} train": f_measures(evaluation.quality(size)) for size in sorted(evaluation.trials)[::-1]}
    across = f_measures(evaluation.left_out_quality(ACROSS))
    return {"across sources": across, "log loss": log_loss(evaluation.left_out[ACROSS], evaluation.labels)} | halves


def log_loss(trial: Trial, labels: Labels) -> float:
    """Return the mean over functions and objects of minus the logarithm of what was said of the truth, nats."""
    members, scores = labels.members[trial.rows], np.clip(trial.scores, SURE, 1 - SURE)
    return round(float(-np.log(np.where(members, scores, 1 - scores)).mean()), 5)


def print_ranking(simulated: Simulated, radii: tuple[float, ...], splits: Splits, json: bool):
    """Print how much worse a forest does across sources without each quantity, at all radii, the most needed first.

    The log loss, because an F-measure moves only when an object crosses 0.5. Differences of less than its change
    with another seed, which is printed too, say nothing.
    """
    labels, names = labels_of(simulated), list(NAMES)
    everything = profiled(simulated.settled, labels, ranking_classifier(radii))
    full = loss_without(everything, splits)
    noise = [loss_without(everything, splits, seed=seed) for seed in range(1, 6)]
    added = {name: loss_without(everything, splits, [name]) - full for name in names}
    ranked = {name: round(added[name], 5) for name in sorted(names, key=added.get, reverse=True)}
    spread = round(float(np.std([full, *noise])), 5)
    if json:
        print_json({"log_loss": full, "spread_of_seeds": spread, "added_without": ranked})
        return
    title = f"{simulated.name}: log loss across sources {full:.4f}, {spread:.4f} from seed to seed"
    print_table(title, ["quantity", "more without it"], [[name, f"{value:+.5f}"] for name, value in ranked.items()])


def ranking_classifier(radii: Sequence[float], seed: int = 0) -> FunctionClassifier:
    """Return a quicker classifier, to be learnt some hundred times."""
    trees = ExtraTreesClassifier(TREES, random_state=seed)
    return FunctionClassifier(radii=radii, estimator=trees, random_state=seed)


def loss_without(read: Profiled, splits: Splits, left: Sequence[str] = (), seed: int = 0) -> float:
    """Return the log loss across sources when quantities are left out at every radius."""
    radii = read.classifier.radii
    kept = np.tile([name not in left for name in NAMES], len(radii))
    some = replace(read, profiles=read.profiles[:, kept], classifier=ranking_classifier(radii, seed))
    return log_loss(some.trial(splits.left_out[ACROSS]), read.labels)
