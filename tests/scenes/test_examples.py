"""Training examples for scans: what is proposed, which object it is, and views from near by."""

from __future__ import annotations

import numpy as np
import pytest
from room_shapes import NAMES, room

from spherefunc_bullet.datasets.dataset import open_dataset
from spherefunc_bullet.scenes.recognition.examples import best_object, proposed_examples
from spherefunc_bullet.scenes.virtual_rooms.furnishing import furnish
from spherefunc_bullet.scenes.virtual_rooms.scans import close_ups


def sure(truth: np.ndarray) -> list:
    """Return the examples of the room and the object that each is, or None; disputed ones are left out."""
    examples = [one for one in proposed_examples(room()[0], truth, "fast") if not 0.25 <= one.overlap < 0.4]
    return [(one.nearest if one.overlap >= 0.4 else None, one.cloud) for one in examples]


@pytest.fixture(scope="module")
def examples():
    return sure(room()[1])


def test_every_object_of_the_room_is_an_example(examples):
    assert {number for number, _ in examples if number is not None} == set(range(len(NAMES)))


def test_examples_stand_on_their_support(examples):
    (mug, *_) = [cloud for number, cloud in examples if number == NAMES.index("mug")]
    assert mug.bounds[0, 2] == pytest.approx(0.0, abs=0.02)
    assert mug.size.max() < 0.2
    tops = [cloud.bounds[1, 2] for number, cloud in examples if number == NAMES.index("table")]
    assert min(tops) == pytest.approx(0.72, abs=0.03)  # the table's pool; its cluster has the mug on it


@pytest.mark.slow
def test_what_is_proposed_of_no_object_is_an_example_of_none():
    truth = room()[1]
    assert {number for number, _ in sure(np.where(truth >= 0, -3, truth))} == {None}


def test_the_best_object_is_that_of_most_overlap():
    assert best_object(np.array([1, 1, 0, -1]), np.array([10, 2])) == (1, 0.5)
    assert best_object(np.array([-1, -1]), np.array([], int)) == (-1, 0.0)


@pytest.mark.slow
def test_close_ups_are_near_single_views_and_the_same_again():
    (virtual,) = furnish(open_dataset("household"), 1, seed=3, failed=lambda error: None)
    views, again = (list(close_ups(virtual, 2, 1.0, seed=5)) for _ in range(2))
    assert 1 <= len(views) <= 2
    for view, same in zip(views, again, strict=True):
        assert np.array_equal(view.points, same.points)
        (pose,) = view.poses
        near = np.linalg.norm(view.points - pose[:3, 3], axis=1).min()
        assert 0.3 < near < 2.4
        assert (view.labels >= 0).any()
