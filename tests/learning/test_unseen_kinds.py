"""What has learnt impaired copies is also asked about each kind when it has learnt those of all other kinds alone."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from spherefunc_bullet.batch.simulated import Simulated
from spherefunc_bullet.compare.evaluation.impaired import (
    ImpairedSet,
    held_out,
    scores_for_unseen_kinds,
    with_copies_learnt,
)
from spherefunc_bullet.compare.evaluation.protocol import Labels
from spherefunc_bullet.compare.evaluation.readings import ProfileFeatures
from spherefunc_bullet.datasets.dataset import DatasetObject
from spherefunc_bullet.learning.function_classifier import FunctionClassifier
from spherefunc_bullet.learning.profiles.quantities import QUANTITIES
from spherefunc_bullet.scenes.impairment.folder import CopyRow

SHOWS = {"whole": None, "hole": 3, "lid": 4}  # which quantity tells a kind of copy from what is whole; none does else
EACH = 20  # cups, and as many other objects


@pytest.fixture(scope="module")
def impaired() -> ImpairedSet:
    """Return cups of two sources and other objects, and copies of three kinds of every cup."""
    cups = [item(f"cup{k}", {"cup"}, k) for k in range(EACH)]
    whole = cups + [item(f"block{k}", set(), k) for k in range(EACH)]
    copies = [copy(cup, kind) for kind in SHOWS for cup in cups]
    objects = [*whole, *(one.item for one in copies)]
    members = np.array([[bool(one.functions)] for one in objects])
    groups = np.array([one.group for one in objects])
    return ImpairedSet(
        simulated=Simulated("made up", tuple(objects), ()),
        labels=Labels(("cup",), members, np.zeros_like(members), groups),
        copies=copies,
        originals=np.tile(np.arange(EACH), len(SHOWS)),
    )


def item(name: str, functions: set[str], number: int) -> DatasetObject:
    return DatasetObject(path=Path(f"{name}.ply"), functions=frozenset(functions), group=f"source {number % 2}")


def copy(cup: DatasetObject, kind: str) -> CopyRow:
    works = kind == "whole"
    made = item(f"{cup.path.stem}_{kind}", {"cup"} if works else set(), int(cup.group[-1]))
    return CopyRow(item=made, of=cup.path.name, kind=kind, works=works)


@pytest.fixture(scope="module")
def read(impaired) -> ProfileFeatures:
    """Return quantities by which blocks differ from cups, and each useless kind by one quantity of its own."""
    profiles = np.random.default_rng(0).normal(0, 0.01, (len(impaired.labels), len(QUANTITIES)))
    profiles[: impaired.whole, 0] += ~impaired.labels.members[: impaired.whole, 0]
    for row, one in enumerate(impaired.copies):
        if SHOWS[one.kind] is not None:
            profiles[impaired.whole + row, SHOWS[one.kind]] += 1
    return ProfileFeatures(profiles=profiles, labels=impaired.labels, classifier=FunctionClassifier(radii=(0.01,)))


def shares(impaired: ImpairedSet, splits, said) -> dict[str, float]:
    """Return the share of each kind that is still called a cup."""
    kinds = np.array([impaired.copies[row - impaired.whole].kind for split in splits for row in split.test])
    called = np.concatenate(said)[:, 0]
    return {kind: called[kinds == kind].mean() for kind in SHOWS}


def test_a_kind_that_is_left_out_is_not_learnt(impaired):
    (split, _) = held_out(impaired, 0)
    learnt = impaired.with_copies(split, unseen="hole").train
    kinds = {impaired.copies[row - impaired.whole].kind for row in learnt if row >= impaired.whole}
    assert kinds == {"whole", "lid"}
    assert len(impaired.with_copies(split).train) - len(learnt) == EACH // 2


def test_what_only_its_own_kind_teaches_is_lost_without_it(impaired, read):
    splits, learnt = held_out(impaired, 0), with_copies_learnt(impaired, read)
    seen = [trial.predicted for trial in learnt.trials([[impaired.with_copies(split)] for split in splits])]
    known = shares(impaired, splits, seen)
    unseen = shares(impaired, splits, scores_for_unseen_kinds(impaired, learnt, splits))
    for kind in ("hole", "lid"):  # trees cut at random places, so not 0 and 1
        assert known[kind] <= 0.3 and unseen[kind] >= 0.7
