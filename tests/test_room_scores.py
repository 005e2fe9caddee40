"""How parsed rooms are scored, on labels whose scores are known by counting."""

from __future__ import annotations

import numpy as np
import pytest

from spherefunc_bullet.compare.rooms.scores import Counts, function_counts, matched, segmentation_counts
from spherefunc_bullet.compare.rooms.trials import halves, shares
from spherefunc_bullet.datasets.dataset import open_dataset

TRUTH = np.repeat([0, 1, 2, -1], [10, 10, 4, 20])


def test_the_truth_itself_is_all_right():
    answer = matched(TRUTH, TRUTH, [0, 1, 2])
    assert answer == {0: 0, 1: 1, 2: 2}
    counts = segmentation_counts(answer, [0, 1, 2])
    assert counts.precision == counts.recall == counts.f_measure == 1


def test_half_an_object_is_none():
    found = TRUTH.copy()
    found[:5] = 7  # two halves of IoU 0.5 each, which is not above it
    assert matched(TRUTH, found, [0, 1, 2]) == {0: None, 1: 1, 2: 2, 7: None}
    found[5] = 7
    assert matched(TRUTH, found, [0, 1, 2])[7] == 0  # 6 of 10


def test_two_objects_in_one_part_are_the_larger_or_none():
    together = np.where(np.isin(TRUTH, (0, 2)), 5, TRUTH)
    assert matched(TRUTH, together, [0, 1, 2]) == {5: 0, 1: 1}  # IoU 10 of 14
    both = np.where(np.isin(TRUTH, (0, 1)), 5, TRUTH)
    assert matched(TRUTH, both, [0, 1, 2])[5] is None  # 10 of 20


def test_floor_in_a_part_counts_against_it():
    found = TRUTH.copy()
    found[-10:] = 0
    assert matched(TRUTH, found, [0, 1, 2])[0] is None  # 10 of 20
    assert segmentation_counts(matched(TRUTH, found, [0, 1, 2]), [0, 1, 2]) == Counts(2, 1, 1)


def test_hidden_objects_are_neither_asked_for_nor_held_against():
    answer = matched(TRUTH, TRUTH, [0, 1])
    assert answer == {0: 0, 1: 1}
    assert segmentation_counts(answer, [0, 1]) == Counts(2, 0, 0)


def test_order_of_points_and_numbers_of_parts_do_not_matter():
    rng = np.random.default_rng(0)
    found = rng.integers(-1, 4, len(TRUTH))
    order = rng.permutation(len(TRUTH))
    one, other = matched(TRUTH, found, [0, 1, 2]), matched(TRUTH[order], found[order], [0, 1, 2])
    assert one == other
    renamed = matched(TRUTH, np.where(found >= 0, 9 - found, -1), [0, 1, 2])
    assert {9 - part: number for part, number in renamed.items()} == one


def test_functions_count_from_scan_to_label():
    answer = {0: 0, 1: 1, 5: None}
    given = {0: frozenset({"cup"}), 1: frozenset(), 5: frozenset({"cup", "table"})}
    labels = {0: frozenset({"cup"}), 1: frozenset({"table"}), 2: frozenset({"cup"})}
    assert function_counts(answer, given, labels, "cup") == Counts(1, 1, 1)  # 5 is nothing, 2 was not found
    assert function_counts(answer, given, labels, "table") == Counts(0, 1, 1)
    assert function_counts(answer, given, labels, "sittable").f_measure is None


def test_counts_add_up():
    total = Counts(3, 1, 0) + Counts(1, 0, 2)
    assert (total.precision, total.recall, total.f_measure) == pytest.approx((4 / 5, 4 / 6, 8 / 11))


def test_halves_share_every_label_and_no_object():
    one, other = halves(open_dataset("household"), 0)
    names = [{item.path for item in part.objects} for part in (one, other)]
    assert not names[0] & names[1] and len(names[0] | names[1]) == 200
    for label in ("cup", "table", "sittable"):
        counts = [sum(label in item.functions for item in part.objects) for part in (one, other)]
        assert abs(counts[0] - counts[1]) <= 1
    assert shares(12, 2) == [6, 6] and sum(shares(7, 2)) == 7
