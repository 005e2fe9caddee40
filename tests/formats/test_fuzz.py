"""One fuzz target per reader, a few files each; `make fuzz` takes more."""

from __future__ import annotations

import math

import pytest
from cloud_files import require_reader
from fuzzing import HERE, KINDS, MEMORY, SECONDS, damaged, fuzz, good, load

from spherefunc_bullet.formats.sources import READERS


def test_every_reader_is_a_target():
    assert {f".{kind.split()[0]}" for kind in KINDS} == set(READERS)


@pytest.mark.parametrize("kind", KINDS)
def test_files_that_are_whole_load_and_damage_repeats(kind, tmp_path):
    require_reader(kind)
    assert load(tmp_path / f"model.{kind.split()[0]}", good(kind)) == "loaded"
    assert damaged(kind, 7) == damaged(kind, 7) and len({damaged(kind, number) for number in range(40)}) > 25


@pytest.mark.slow
def test_damage_is_refused_or_loads_within_its_limits():
    found = list(fuzz([(kind, 0, 25, math.inf) for kind in HERE]))
    assert [each["kind"] for each in found] == list(HERE)
    for each in found:
        assert set(each["found"]) <= {"refused", "loaded"}, each
        assert each["found"]["refused"] > 3 and each["slowest"][0] < SECONDS and each["peak"] < MEMORY, each
