"""What virtual rooms teach: which proposals are lessons, and that what is kept is what was computed."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from things import write_things

from spherefunc_bullet.compare.rooms.baselines import learnt_objects
from spherefunc_bullet.compare.rooms.lesson_files import kept_lessons, lesson_paths, read_lessons
from spherefunc_bullet.compare.rooms.lessons import Lesson, Sight, counted
from spherefunc_bullet.compare.rooms.scan_model import Visit, learn, lessons_of_rooms
from spherefunc_bullet.datasets.dataset import open_dataset
from spherefunc_bullet.errors import InputError
from spherefunc_bullet.learning.function_classifier import FunctionClassifier
from spherefunc_bullet.scenes.virtual_rooms.furnishing import furnish
from spherefunc_bullet.settling.records import ObjectRecord

SIGHT = Sight(views=1, noise=0.5, close=0)


@pytest.fixture(scope="module")
def model():
    return FunctionClassifier("fast", radii=(0.01, 0.03), drops=30, early_drops=0)


@pytest.fixture(scope="module")
def rooms(tmp_path_factory):
    data = open_dataset(write_things(tmp_path_factory.mktemp("things"), ("desk", "bench", "chest", "mug", "tin")))
    return list(furnish(data, 2, seed=1, failed=pytest.fail))


@pytest.fixture(scope="module")
def kept(rooms, model, tmp_path_factory):
    folder = tmp_path_factory.mktemp("kept")
    return folder, [kept_lessons(room, SIGHT, model, 0, folder) for room in rooms]


def lesson(**how) -> Lesson:
    record = ObjectRecord(path=Path(), size=np.ones(3), voxels=np.ones((1, 3)), settled={}, seconds={}, drops={})
    return Lesson(name="one", thing="sofa", functions=frozenset({"sittable"}), record=record, **how)


@pytest.mark.parametrize(
    ("how", "expected"),
    [
        ({"overlap": 0.9}, [{"sittable"}]),
        ({"overlap": 0.9, "shown": 0.1}, []),  # the back alone
        ({"overlap": 0.3, "inside": 0.3}, []),  # disputed
        ({"overlap": 0.15, "inside": 0.9}, []),  # the seat without the rest
        ({"overlap": 0.15, "inside": 0.3}, [set()]),  # mostly something else
        ({"overlap": 0.02, "inside": 1.0}, [set()]),  # a scrap
    ],
)
def test_what_counts_and_as_what(how, expected):
    assert [set(one.functions) for one in counted([lesson(**how)])] == expected


def test_useless_things_need_no_surface():
    (one,) = counted([replace(lesson(overlap=0.9, shown=0.0), functions=frozenset())])
    assert not one.functions


def test_rooms_teach_what_stands_in_them(kept):
    lessons = [one for room in kept[1] for one in counted(room)]
    assert {"table", "sittable"} <= {name for one in lessons for name in one.functions}
    assert any(not one.functions for one in lessons)
    assert all(0 <= one.shown <= 1 and 0 <= one.inside <= 1 for one in lessons)


def test_what_is_kept_is_what_was_computed(rooms, model, kept):
    folder, (first, _) = kept
    for one, other in zip(kept_lessons(rooms[0], SIGHT, model, 0, None), first, strict=True):
        told = ("name", "thing", "functions", "overlap", "inside", "shown")
        assert [getattr(one, name) for name in told] == [getattr(other, name) for name in told]
        assert np.array_equal(one.record.voxels, other.record.voxels)
        for radius, drops in one.record.settled.items():
            assert np.array_equal(drops, other.record.settled[radius], equal_nan=True)
    assert len(lesson_paths(folder)) == 2


def test_another_seed_or_sight_is_another_room(rooms, model, kept, monkeypatch):
    folder, _ = kept
    monkeypatch.setattr("spherefunc_bullet.compare.rooms.lesson_files.room_lessons", lambda *how: [])
    assert kept_lessons(rooms[0], SIGHT, model, 1, folder) == []
    assert kept_lessons(rooms[0], replace(SIGHT, views=2), model, 0, folder) == []
    assert kept_lessons(rooms[0], SIGHT, model, 0, folder)


def test_any_number_of_processes_teaches_the_same(rooms, model, kept):
    visits = [Visit(room=room, sight=SIGHT, seed=0) for room in rooms]
    found = list(lessons_of_rooms(visits, model, None, 2))
    assert [[one.name for one in room] for room in found] == [[one.name for one in room] for room in kept[1]]
    for one, other in zip(sum(found, []), sum(kept[1], []), strict=True):
        for radius, drops in one.record.settled.items():
            assert np.array_equal(drops, other.record.settled[radius], equal_nan=True)


def test_a_thing_never_tells_of_itself(kept, model):
    lessons = [one for room in kept[1] for one in counted(room)]
    learnt = learn(lessons, model)
    groups = [(one.thing, group) for one, group in zip(lessons, learnt.kin_.groups, strict=True) if one.thing]
    assert len(set(groups)) == len({thing for thing, _ in groups}) < len(groups)


def test_baselines_learn_lessons_too(kept):
    folder, lessons = kept
    learnt = learnt_objects([str(folder)], pytest.fail)
    assert sorted(learnt.names) == sorted(one.name for room in lessons for one in counted(room))


def test_a_damaged_file_is_named(tmp_path):
    (tmp_path / "room.npz").write_bytes(b"nothing")
    with pytest.raises(InputError, match=r"room\.npz: expected lessons"):
        read_lessons(tmp_path / "room.npz")
