"""Answers after the first drops: what these say wrongly is as seldom as is stated, and else all drops are made."""

from __future__ import annotations

import numpy as np
import pytest

from spherefunc_bullet.learning.function_classifier import FunctionClassifier
from spherefunc_bullet.settling.drops import Drops, RunLimit, drops_from_rows, first_drops

RADIUS = 0.02
DROPS, FIRST = 60, 20


def drops_at(height: float, random: np.random.Generator) -> dict[float, Drops]:
    """Return drops that all come to rest side by side at a height, in an order by lot."""
    x, y = (2 * RADIUS * part.ravel() for part in np.mgrid[:10, :6])
    rows = np.column_stack([x, y, x, y, np.full(DROPS, height + random.normal(0, 0.01))])
    rows = np.column_stack([rows, np.zeros(DROPS)])[random.permutation(DROPS)]
    return {RADIUS: drops_from_rows(RADIUS, rows)}


def learnt(wrong: float, count: int = 200) -> FunctionClassifier:
    """Return a classifier of what is high among low objects, of whose labels a share is wrong."""
    random = np.random.default_rng(0)
    objects = [drops_at(0.4 + 0.4 * (k % 2), random) for k in range(count)]
    labels = ["high" if (k % 2) ^ (random.uniform() < wrong) else "none" for k in range(count)]
    model = FunctionClassifier(radii=(RADIUS,), drops=DROPS, early_drops=FIRST)
    return model.fit_settled(objects, labels, [str(k) for k in range(count)])


def share_that_stopped(model: FunctionClassifier, count: int = 60) -> float:
    """Return of how many new objects no more than the first drops were made."""
    random, made = np.random.default_rng(1), []
    for k in range(count):
        settled = drops_at(0.4 + 0.4 * (k % 2), random)
        answered = model.read(lambda length, settled=settled: first_drops(settled, length.drops)).drops
        made.append(len(answered[RADIUS]))
    assert set(made) <= {FIRST, DROPS}
    return np.mean(np.array(made) == FIRST)


def test_what_always_holds_is_answered_early():
    assert share_that_stopped(learnt(wrong=0.0)) > 0.9


@pytest.mark.parametrize("wrong", [0.2, 0.3])
def test_what_mostly_holds_is_not_answered_early(wrong):
    """One answer in twenty may be wrong; where one label in five is, no answer is so sure."""
    assert share_that_stopped(learnt(wrong)) < 0.1


def test_all_drops_are_made_where_there_is_no_early_answer():
    model, asked = learnt(wrong=0.0), []
    model.early_ = None
    model.read(lambda length: asked.append(length) or drops_at(0.4, np.random.default_rng(2)))
    assert asked == [RunLimit(drops=DROPS)]
