"""How parsed rooms are scored, on labels whose scores are known by counting."""

from __future__ import annotations

import re
from dataclasses import fields

import numpy as np
import pytest
from checkout import ROOT

from spherefunc_bullet.compare.rooms.matching import MatchCounts, function_counts, match_parts, segmentation_counts
from spherefunc_bullet.compare.rooms.sensitivity import numbers_of, print_list, spread_of
from spherefunc_bullet.compare.rooms.trials import shares, split_in_halves
from spherefunc_bullet.datasets.dataset import open_dataset
from spherefunc_bullet.scenes.settings import SEGMENTATION, STAGES

TRUTH = np.repeat([0, 1, 2, -1], [10, 10, 4, 20])


def test_the_truth_itself_is_all_right():
    matches = match_parts(TRUTH, TRUTH, [0, 1, 2])
    assert matches == {0: 0, 1: 1, 2: 2}
    counts = segmentation_counts(matches, [0, 1, 2])
    assert counts.precision == counts.recall == counts.f_measure == 1


def test_half_an_object_is_none():
    parts = TRUTH.copy()
    parts[:5] = 7  # two halves of IoU 0.5 each, which is not above it
    assert match_parts(TRUTH, parts, [0, 1, 2]) == {0: None, 1: 1, 2: 2, 7: None}
    parts[5] = 7
    assert match_parts(TRUTH, parts, [0, 1, 2])[7] == 0  # 6 of 10


def test_two_objects_in_one_part_are_the_larger_or_none():
    together = np.where(np.isin(TRUTH, (0, 2)), 5, TRUTH)
    assert match_parts(TRUTH, together, [0, 1, 2]) == {5: 0, 1: 1}  # IoU 10 of 14
    both = np.where(np.isin(TRUTH, (0, 1)), 5, TRUTH)
    assert match_parts(TRUTH, both, [0, 1, 2])[5] is None  # 10 of 20


def test_floor_in_a_part_counts_against_it():
    parts = TRUTH.copy()
    parts[-10:] = 0
    assert match_parts(TRUTH, parts, [0, 1, 2])[0] is None  # 10 of 20
    assert segmentation_counts(match_parts(TRUTH, parts, [0, 1, 2]), [0, 1, 2]) == MatchCounts(2, 1, 1)


def test_hidden_objects_are_neither_asked_for_nor_held_against():
    matches = match_parts(TRUTH, TRUTH, [0, 1])
    assert matches == {0: 0, 1: 1}
    assert segmentation_counts(matches, [0, 1]) == MatchCounts(2, 0, 0)


def test_order_of_points_and_numbers_of_parts_do_not_matter():
    rng = np.random.default_rng(0)
    parts = rng.integers(-1, 4, len(TRUTH))
    order = rng.permutation(len(TRUTH))
    one, other = match_parts(TRUTH, parts, [0, 1, 2]), match_parts(TRUTH[order], parts[order], [0, 1, 2])
    assert one == other
    renamed = match_parts(TRUTH, np.where(parts >= 0, 9 - parts, -1), [0, 1, 2])
    assert {9 - part: number for part, number in renamed.items()} == one


def test_functions_count_from_scan_to_label():
    matches = {0: 0, 1: 1, 5: None}
    given = {0: frozenset({"cup"}), 1: frozenset(), 5: frozenset({"cup", "table"})}
    labels = {0: frozenset({"cup"}), 1: frozenset({"table"}), 2: frozenset({"cup"})}
    assert function_counts(matches, given, labels, "cup") == MatchCounts(1, 1, 1)  # 5 is nothing, 2 was not found
    assert function_counts(matches, given, labels, "table") == MatchCounts(0, 1, 1)
    assert function_counts(matches, given, labels, "sittable").f_measure is None


def test_counts_add_up():
    total = MatchCounts(3, 1, 0) + MatchCounts(1, 0, 2)
    assert (total.precision, total.recall, total.f_measure) == pytest.approx((4 / 5, 4 / 6, 8 / 11))


def test_halves_share_every_label_and_no_object():
    one, other = split_in_halves(open_dataset("household"), 0)
    names = [{item.path for item in part.objects} for part in (one, other)]
    assert not names[0] & names[1] and len(names[0] | names[1]) == 200
    for label in ("cup", "table", "sittable"):
        counts = [sum(label in item.functions for item in part.objects) for part in (one, other)]
        assert abs(counts[0] - counts[1]) <= 1
    assert shares(12, 2) == [6, 6] and sum(shares(7, 2)) == 7


# The sensitivity of numbers


def test_a_number_is_another_for_a_while_where_it_is_read():
    thickness = next(one for one in numbers_of("segmentation") if one.title == "segmentation.wall_thickness")
    with thickness.times(0.5):
        assert SEGMENTATION.wall_thickness == 0.025
    assert SEGMENTATION.wall_thickness == 0.05


def test_the_spread_leaves_out_what_changes_little_and_what_breaks():
    rows = [["a", "1", "9", "2", "4", "8", "9", "9"], ["b", "2", "11", "4", "3", "10", "3", "2"]]
    rows += [["c", "3", "-", "-", "ValueError", "10", "6", "5"]]
    said = spread_of(rows, MatchCounts(10, 3, 2))
    assert said == "3 variations change some answers: 10.0 ± 1.0 found, 4.0 ± 2.0 false"
    assert spread_of(rows[:1], MatchCounts(10, 3, 2)).startswith("too few")


@pytest.mark.slow
def test_every_number_is_read():
    code = "".join(path.read_text() for path in (ROOT / "scenes").rglob("*.py"))
    names = [f"{stage.upper()}.{one.name}" for stage in STAGES for one in fields(STAGES[stage])]
    assert [name for name in names if not re.search(rf"\b{name}\b", code)] == ["SCAN.aligned_deg"]  # `SCAN.aligned`


def test_every_number_says_what_it_stands_for():
    assert all(one.metadata["meaning"] for stage in STAGES.values() for one in fields(stage))


def test_the_document_says_how_many_are_left(capsys):
    print_list()
    count = capsys.readouterr().out.splitlines()[-1]
    assert count in " ".join((ROOT / "docs" / "rooms.md").read_text().split())
