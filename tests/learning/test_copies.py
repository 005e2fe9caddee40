"""Changed copies of training objects: ten weigh as one original, and none says anything of how sure to be of it."""

from __future__ import annotations

import numpy as np
import pytest
from sklearn.base import BaseEstimator, ClassifierMixin
from sklearn.neighbors import KNeighborsClassifier
from sklearn.tree import DecisionTreeClassifier

from spherefunc_bullet.learning.function_classifier import FunctionClassifier
from spherefunc_bullet.learning.profiles.calibration import (
    UNCALIBRATED,
    CopyGroups,
    fit_weighted,
    group_copies,
    held_out_votes,
)
from spherefunc_bullet.learning.profiles.quantities import NAMES


def test_ten_copies_weigh_as_much_as_their_original():
    """Where one working object and ten impaired copies look the same, a tree's vote is undecided."""
    names = ["works", "another that works", "useless", *(f"copy {k}" for k in range(10))]
    originals = ["", "", "", *["works"] * 10]
    places = np.array([0.0, 1.0, 2.0, *[0.0] * 10])[:, None]  # the copies are where their original is
    members = np.array([True, True, *[False] * 11])  # either side weighs two originals, so nothing is balanced
    tree = fit_weighted(DecisionTreeClassifier(random_state=0), places, members, group_copies(names, originals))
    assert tree.predict_proba([[0.0]])[0].tolist() == pytest.approx([0.5, 0.5])


@pytest.mark.parametrize("copied", [False, True])
def test_members_weigh_as_much_as_all_others(copied):
    """One member among nine others, where all look the same: undecided, copies or none."""
    count = 10 + 5 * copied
    names, originals = [str(k) for k in range(count)], ["" if k < 10 else "0" for k in range(count)]
    tree = fit_weighted(
        DecisionTreeClassifier(), np.zeros((count, 1)), np.arange(count) % 10 == 0, group_copies(names, originals)
    )
    assert tree.predict_proba([[0.0]])[0].tolist() == pytest.approx([0.5, 0.5])


def test_who_is_asked_has_not_seen_a_copy():
    """Labels by lot are learnt by heart by who may see a copy of what is asked; who may not is right by chance."""
    random = np.random.default_rng(0)
    places, members = random.uniform(size=(300, 1)), random.uniform(size=300) < 0.5
    names = [str(k) for k in range(300)]
    copy_groups = group_copies([*names, *(f"{name}, copied" for name in names)], [""] * 300 + names)
    both = np.vstack([places, places]), np.append(members, members)
    votes = held_out_votes(KNeighborsClassifier(1), *both, copy_groups, 0)
    right = np.mean((votes > 0.5) == both[1])
    assert abs(right - 0.5) < 4 * 0.5 / np.sqrt(300)  # four standard deviations of 300 coins


class Seer(ClassifierMixin, BaseEstimator):
    """A classifier that learns nothing: its votes are an object's first quantity, whatever else there is."""

    def fit(self, X, y):
        self.classes_ = np.array([False, True])
        return self

    def predict_proba(self, X):
        return np.column_stack([1 - X[:, 0], X[:, 0]])


@pytest.mark.parametrize("contrary", [False, True])
def test_copies_do_not_decide_what_a_vote_means(contrary):
    """The same votes of the same originals mean the same, however many copies agree or disagree."""
    random = np.random.default_rng(1)
    profiles = np.zeros((80, len(NAMES)))
    profiles[:, 0] = random.uniform(size=80)
    members = (random.uniform(size=80) < profiles[:, 0])[:, None]
    names, model = [str(k) for k in range(80)], FunctionClassifier(radii=(0.02,), estimator=Seer())
    alone = model.fit_profiles(profiles, members, ["cup"], names)
    lines, measured = alone.calibrations_, alone.held_out_f_measures()
    copies = [f"{name}, copied" for name in names]
    both = model.fit_profiles(
        np.vstack([profiles, profiles]),
        np.vstack([members, members ^ contrary]),
        ["cup"],
        names + copies,
        group_copies(names + copies, [""] * 80 + names),
    )
    assert both.calibrations_ == lines and both.held_out_f_measures() == measured
    assert 0.6 < measured["cup"] < 0.9  # of votes that are probabilities, and so not always right


def test_where_all_that_is_left_to_learn_from_agrees_that_is_the_vote():
    """Without the first group's four objects and the one beside them, only a member is left."""
    members, groups = np.array([True, True, False, False, False, True]), np.array([1, 1, 1, 1, 3, 2])
    copy_groups = CopyGroups(weights=np.ones(6), groups=groups)
    votes = held_out_votes(DecisionTreeClassifier(random_state=0), np.arange(6.0)[:, None], members, copy_groups, 0)
    assert np.isin(votes, (0, 1)).all() and votes[:5].tolist() == [1] * 5


def test_one_example_of_a_function_is_too_few_to_say_how_sure_to_be():
    profiles = np.zeros((3, len(NAMES)))
    profiles[:, 0] = [0.9, 0.2, 0.1]
    for members in ([True, False, False], [True, True, False]):
        model = FunctionClassifier(radii=(0.02,), estimator=Seer())
        model.fit_profiles(profiles, np.array(members)[:, None], ["cup"], ["a", "b", "c"])
        assert model.held_out_f_measures() == {"cup": None} and model.calibrations_ == [UNCALIBRATED]
