"""Answers after the first drops: what these say wrongly is as seldom as is stated, and else all drops are made."""

from __future__ import annotations

from copy import copy
from functools import cache

import numpy as np
import pytest
import trimesh

from spherefunc_bullet.answer import classify
from spherefunc_bullet.clouds.cloud import Cloud, cloud_from_mesh
from spherefunc_bullet.clouds.preparation import turned_cloud
from spherefunc_bullet.learning.function_classifier import FunctionClassifier
from spherefunc_bullet.learning.profiles.profile_model import depends_on_few_spheres
from spherefunc_bullet.settling.drops import Drops, RunLimit, drops_from_rows, first_drops

RADIUS = 0.02
DROPS, FIRST = 60, 20


def drops_at(height: float, random: np.random.Generator) -> dict[float, Drops]:
    """Return drops that all come to rest side by side at a height, in an order by lot."""
    x, y = (2 * RADIUS * part.ravel() for part in np.mgrid[:10, :6])
    rows = np.column_stack([x, y, x, y, np.full(DROPS, height + random.normal(0, 0.01))])
    rows = np.column_stack([rows, np.zeros(DROPS)])[random.permutation(DROPS)]
    return {RADIUS: drops_from_rows(RADIUS, rows)}


@cache
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


@pytest.mark.slow
def test_what_mostly_holds_is_not_answered_early():
    """One answer in twenty may be wrong; where one label in five is, no answer is so sure."""
    assert share_that_stopped(learnt(wrong=0.2)) < 0.1


def test_all_drops_are_made_where_there_is_no_early_answer():
    model, asked = copy(learnt(wrong=0.0)), []
    model.early_ = None
    model.read(lambda length: asked.append(length) or drops_at(0.4, np.random.default_rng(2)))
    assert asked == [RunLimit(drops=DROPS)]


@pytest.mark.parametrize(("stays", "apart", "few"), [(0, 2, False), (1, 2, True), (4, 2, True), (5, 2, False)])
def test_few_spheres_where_there_is_room_for_many_decide_nothing(stays, apart, few):
    assert depends_on_few_spheres(spread(stays, apart)) == few


def test_few_spheres_on_what_has_no_room_for_more_decide():
    assert not depends_on_few_spheres(spread(2, apart=0.5))


def spread(stays: int, apart: float) -> Drops:
    """Return 60 drops side by side, so many radii apart, of which the first few stay."""
    x, y = (apart * RADIUS * part.ravel() for part in np.mgrid[:10, :6])
    rows = np.column_stack([x, y, x, y, np.full(DROPS, 0.4), np.zeros(DROPS)])
    rows[stays:, 2:] = np.nan
    return drops_from_rows(RADIUS, rows)


@pytest.mark.slow
@pytest.mark.parametrize(("radius", "rise"), [(0.22, 0.04), (0.25, 0.04), (0.27, 0.04), (0.3, 0.06)])
def test_no_heading_turns_a_sure_answer_about_a_domed_stool(radius, rise):
    """Some 2 of the first 40 spheres stay on it: by lot they seemed to say surely that it was none."""
    stool, functions = domed_stool(radius, rise), set()
    for number in range(8):
        answer = classify(turned_cloud(stool, 0.7 * number), explain=False)
        functions |= set() if answer.unsure else {answer.functions}
    assert len(functions) <= 1


def domed_stool(radius: float, rise: float) -> Cloud:
    """Return a round stool 42 cm high, whose seat falls off to its edge by a rise, metres."""
    out = np.linspace(1e-3, radius, 30)
    profile = np.vstack([[0, 0.42], np.column_stack([out, 0.42 - rise * (out / radius) ** 2]), [radius, 0], [0, 0]])
    mesh = trimesh.creation.revolve(profile, sections=64)
    return cloud_from_mesh(mesh.vertices, mesh.faces, "stool")
