"""Labels as people and scikit-learn write them."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.sparse import csr_matrix

from spherefunc_bullet.errors import InputError
from spherefunc_bullet.learning.labels import (
    columns_of_indicator,
    in_columns,
    labels_of_indicator,
    memberships,
    more_members,
    sets_of,
)

ROWS = [[1, 0, 1], [0, 0, 0]]


@pytest.mark.parametrize(
    "rows", [ROWS, np.array(ROWS), np.array(ROWS, bool), csr_matrix(ROWS), tuple(map(tuple, ROWS))]
)
def test_columns_are_called_by_their_numbers_or_as_they_were(rows):
    assert columns_of_indicator(rows) == ("0", "1", "2") == columns_of_indicator(rows, ("cup", "table"))
    assert columns_of_indicator(rows, ("cup", "seat", "table")) == ("cup", "seat", "table")
    assert labels_of_indicator(rows, ("cup", "seat", "table")) == [{"cup", "table"}, set()]


def test_a_data_frame_says_what_its_columns_are():
    assert columns_of_indicator(SimpleNamespace(columns=["seat", 7]), ("cup", "table")) == ("seat", "7")


@pytest.mark.parametrize(
    "labels", [["cup", "none"], [{"cup"}, set()], [[], ["cup"]], np.array(["cup"]), np.zeros(3), []]
)
def test_what_is_no_table_of_numbers_is_no_indicator(labels):
    assert columns_of_indicator(labels) is None


@pytest.mark.parametrize("rows", [[[0, 2]], [[0.5, 1]], [[0, 1, 1]], np.zeros((2, 2, 2))])
def test_an_indicator_of_something_else_is_refused(rows):
    with pytest.raises(InputError, match="expected an indicator"):
        labels_of_indicator(rows, ("cup", "table"))


def test_a_text_alone_and_numbers_are_no_labels():
    with pytest.raises(InputError, match="one for each object"):
        sets_of("cup")
    with pytest.raises(InputError, match="got 3"):
        sets_of([["cup", 3]])


def test_scores_go_to_their_columns_and_none_to_those_of_nobody():
    scores = np.array([[0.1, 0.9]])
    assert in_columns(scores, ("cup", "table"), ("cup", "table")) is scores
    assert in_columns(scores, ("cup", "table"), ("table", "seat", "cup")).tolist() == [[0.9, 0, 0.1]]


def test_who_comes_later_brings_functions_that_nobody_had():
    known = memberships([frozenset({"table"}), frozenset()], ("table",))
    functions, members = more_members(("table",), known, [frozenset({"cup"}), frozenset({"table", "cup"})])
    assert functions == ("cup", "table")
    assert members.tolist() == [[False, True], [False, False], [True, False], [True, True]]
