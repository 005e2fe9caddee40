"""Training examples of virtual rooms: how proposals are labelled, and that cached ones equal computed ones."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from objects_to_scan import write_objects
from sklearn.base import clone

from spherefunc_bullet.compare.rooms.scan_model import learn, room_sets
from spherefunc_bullet.compare.rooms.training_examples import (
    ScanSetup,
    TrainingExample,
    balanced_rows,
    cached_examples,
    label_by_overlap,
)
from spherefunc_bullet.datasets.dataset import open_dataset
from spherefunc_bullet.errors import InputError
from spherefunc_bullet.learning.function_classifier import FunctionClassifier
from spherefunc_bullet.scenes.recognition.surroundings import NAMES
from spherefunc_bullet.scenes.virtual_rooms.furnishing import furnish

SETUP = ScanSetup(views=1, noise=0.5, close=0)


@pytest.fixture(scope="module")
def model():
    return FunctionClassifier("fast", radii=(0.01, 0.03), drops=30, early_drops=0)


@pytest.fixture(scope="module")
def data(tmp_path_factory):
    return open_dataset(write_objects(tmp_path_factory.mktemp("objects"), ("desk", "bench", "chest", "mug", "tin")))


@pytest.fixture(scope="module")
def rooms(data):
    return list(furnish(data, 2, seed=1, failed=pytest.fail))


@pytest.fixture(scope="module")
def kept(rooms, model, tmp_path_factory):
    folder = tmp_path_factory.mktemp("kept")
    return folder, [cached_examples(room, SETUP, model, 0, folder) for room in rooms]


def example(**how) -> TrainingExample:
    about = {"name": "one", "source": "sofa", "functions": frozenset({"sittable"})}
    return TrainingExample(**about, settled={}, surroundings=np.zeros(len(NAMES)), **how)


@pytest.mark.parametrize(
    ("how", "expected"),
    [
        ({"overlap": 0.9}, ({"sittable"}, set())),
        ({"overlap": 0.9, "visible": 0.1}, (set(), {"sittable"})),  # the back alone
        ({"overlap": 0.3}, (set(), {"sittable"})),  # disputed
        ({"overlap": 0.15}, (set(), set())),  # mostly something else, or a piece
    ],
)
def test_what_counts_and_as_what(how, expected):
    (one,) = label_by_overlap([example(**how)])
    assert (set(one.functions), set(one.unlabelled)) == expected


@pytest.mark.parametrize("overlap", [0.1, 0.3, 0.9])
def test_useless_things_need_no_surface(overlap):
    (one,) = label_by_overlap([replace(example(overlap=overlap, visible=0.0), functions=frozenset())])
    assert not one.functions and not one.unlabelled


@pytest.mark.slow
def test_rooms_teach_what_stands_in_them(kept):
    examples = [one for room in kept[1] for one in label_by_overlap(room)]
    assert {"table", "sittable"} <= {name for one in examples for name in one.functions}
    assert any(not one.functions for one in examples)
    assert all(0 <= one.visible <= 1 and 0 <= one.overlap <= 1 for one in examples)


@pytest.mark.slow
def test_what_is_kept_is_what_was_computed(rooms, model, kept):
    folder, (first, _) = kept
    for one, other in zip(cached_examples(rooms[0], SETUP, model, 0, None), first, strict=True):
        fields = ("name", "source", "functions", "overlap", "visible")
        assert [getattr(one, name) for name in fields] == [getattr(other, name) for name in fields]
        assert np.array_equal(one.surroundings, other.surroundings)
        for radius, drops in one.settled.items():
            assert np.array_equal(drops.rows(), other.settled[radius].rows(), equal_nan=True)
    assert len(list(folder.glob("*.joblib"))) == 2


@pytest.mark.slow
def test_another_seed_or_setup_is_another_room(rooms, model, kept, monkeypatch):
    folder, _ = kept
    monkeypatch.setattr("spherefunc_bullet.compare.rooms.training_examples.room_examples", lambda *how: [])
    assert cached_examples(rooms[0], SETUP, model, 1, folder) == []
    assert cached_examples(rooms[0], replace(SETUP, views=2), model, 0, folder) == []
    assert cached_examples(rooms[0], SETUP, model, 0, folder)


def test_rooms_are_shared_out_to_all_kinds(data):
    sets = room_sets([data, data, data], 23, 7)
    assert sum(room_set.rooms for room_set in sets) == 23
    assert {room_set.rooms for room_set in sets} == {2, 3}
    assert len({room_set.seed for room_set in sets}) == len(sets)


@pytest.mark.slow
def test_a_thing_never_tells_of_itself(kept, model):
    examples = [one for room in kept[1] for one in label_by_overlap(room)]
    learnt = learn(examples, model)
    items = dict(zip([one.name for one in examples], [one.source for one in examples], strict=True))
    groups = [(items[name], group) for name, group in zip(learnt.names_, learnt.copy_groups_.groups, strict=True)]
    groups = [(item, group) for item, group in groups if item]
    assert len(set(groups)) == len({item for item, _ in groups}) < len(groups)


def test_useful_examples_are_kept_and_as_many_others():
    useful = np.arange(100) % 10 == 0
    rows = balanced_rows(useful)
    assert useful[rows].sum() == 10 and (~useful[rows]).sum() == 10
    assert len(set(rows.tolist())) == 20 and (np.diff(rows) > 0).all()


def test_a_damaged_file_is_named(rooms, model, tmp_path, monkeypatch):
    monkeypatch.setattr("spherefunc_bullet.compare.rooms.training_examples.room_examples", lambda *how: [])
    cached_examples(rooms[0], SETUP, model, 0, tmp_path)
    [file] = tmp_path.iterdir()
    file.write_bytes(b"nothing")
    with pytest.raises(InputError, match=rf"{file.name}: expected training examples"):
        cached_examples(rooms[0], SETUP, model, 0, tmp_path)


def test_what_says_nothing_of_a_function_changes_nothing_of_it(model):
    rng = np.random.default_rng(0)
    profiles = rng.normal(size=(60, len(model.quantity_names())))
    members = np.column_stack([profiles[:, 0] > 0, profiles[:, 1] > 0])
    labelled = np.ones_like(members)
    labelled[40:, 1] = False
    whole, some = clone(model), clone(model)
    whole.fit_profiles(profiles, members, ("cup", "table"), [str(row) for row in range(60)], labelled=labelled)
    some.fit_profiles(profiles[:40], members[:40], ("cup", "table"), [str(row) for row in range(40)])
    cup, table = (whole.score_profiles(profiles) - some.score_profiles(profiles)).T
    assert not table.any() and cup.any()
    assert np.isfinite(list(whole.held_out_f_measures().values())).all()
