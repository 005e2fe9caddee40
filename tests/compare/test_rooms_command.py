"""``spherefunc rooms``: from a data set to figures and a plot, and one line for every mistake."""

from __future__ import annotations

import json

import numpy as np
import pytest
from objects_to_scan import write_objects
from typer.testing import CliRunner

from spherefunc_bullet.batch.simulated import simulate_dataset
from spherefunc_bullet.commands.command_line import application
from spherefunc_bullet.compare.commands.rooms import conditions
from spherefunc_bullet.compare.rooms.benchmark import curve_rows, write_report
from spherefunc_bullet.compare.rooms.folds import TrainingOptions, trained_classifier, whole_fold
from spherefunc_bullet.compare.rooms.scan_model import TIDY, RoomSet, examples_of_sets
from spherefunc_bullet.compare.rooms.training_examples import ScanSetup
from spherefunc_bullet.compare.rooms.trials import Condition
from spherefunc_bullet.console import Failures
from spherefunc_bullet.datasets.dataset import open_dataset
from spherefunc_bullet.errors import InputError
from spherefunc_bullet.learning.function_classifier import FunctionClassifier
from spherefunc_bullet.learning.model_file import shipped_model
from spherefunc_bullet.settling.cached_runs import DropConfig


@pytest.fixture
def run():
    return lambda *arguments: CliRunner().invoke(application(), ["rooms", *(str(argument) for argument in arguments)])


@pytest.mark.slow
def test_a_room_is_furnished_scanned_and_told(run, tmp_path):
    data = write_objects(tmp_path, ("desk", "seat", "mug"))
    few = ("--rooms", 1, "--views", 1, "--jobs", 1)
    done = run(data, "--model", shipped_model(), *few, "--json", "--report", tmp_path)
    about = json.loads(done.stdout)
    (measured,) = about["conditions"]
    assert measured["views"] == "1 view" and measured["rooms"] == 1
    parts, seen = measured["segmentation"], measured["objects"]
    assert parts["hits"] + parts["misses"] == seen and seen + measured["hidden"] >= 8
    for name in ("cup", "sittable", "table"):
        row = measured["functions"][name]
        assert row["hits"] + row["misses"] <= seen and row["f_measure_cut_out"] is None
    assert json.loads((tmp_path / "rooms.json").read_text()) == about
    assert {path.suffix for path in tmp_path.glob("rooms.*")} == {".json", ".png", ".svg", ".csv"}


def test_every_number_of_views_meets_every_noise_and_whole_surfaces_none():
    assert conditions("whole,1,3", "0,2") == (
        Condition(views=None, noise=0),
        Condition(views=1, noise=0),
        Condition(views=1, noise=2),
        Condition(views=3, noise=0),
        Condition(views=3, noise=2),
    )


@pytest.mark.slow
def test_rooms_side_by_side_give_the_same(run, tmp_path):
    data = write_objects(tmp_path, ("desk", "mug"))
    few = ("--rooms", 2, "--views", "1", "--model", shipped_model(scans=True), "--cut-out", "--json")
    one, two = (json.loads(run(data, *few, "--jobs", jobs).stdout)["conditions"] for jobs in (1, 2))
    for measured in (*one, *two):
        assert measured.pop("seconds").keys() >= {"floor", "clusters", "spheres"}
    assert one == two and one[0]["rooms"] == 2


@pytest.mark.slow
def test_any_number_of_processes_teaches_the_same(tmp_path):
    model = FunctionClassifier("fast", radii=(0.01, 0.03), drops=30, early_drops=0)
    setup, few = ScanSetup(views=1, noise=0.5, close=0), open_dataset(write_objects(tmp_path, ("desk", "mug")))
    sets = [RoomSet(dataset=few, lived_in=TIDY, setups=(setup,), rooms=1, seed=seed) for seed in (1, 2)]
    alone = list(examples_of_sets(sets, model, None, 1, Failures()))
    both = list(examples_of_sets(sets, model, tmp_path / "cached", 2, Failures()))
    assert len({one.source for one in sum(alone, []) if one.source}) == 2  # desks and mugs
    assert [[one.name for one in room] for room in alone] == [[one.name for one in room] for room in both]
    for one, other in zip(sum(alone, []), sum(both, []), strict=True):
        for radius, drops in one.settled.items():
            assert np.array_equal(drops.rows(), other.settled[radius].rows(), equal_nan=True)


@pytest.mark.slow
def test_what_is_learnt_of_partial_views(tmp_path):
    dataset = open_dataset(write_objects(tmp_path, ("desk", "seat", "mug")))
    how = DropConfig(simulator="fast", radii=(0.05,))
    simulated = simulate_dataset(dataset, how, jobs=1, failed=pytest.fail)
    names = list(trained_classifier(dataset, simulated, TrainingOptions(drop_config=how), pytest.fail).names_)
    seen = [name for name in names if " in room_" in name]
    assert len(names) - len(seen) == len(dataset) and seen
    assert not any(name.startswith("mug") for name in seen)  # small ones look like what they are not


def test_a_model_that_knows_the_objects_is_said(capsys):
    whole_fold(open_dataset("household"), shipped_model())
    assert "has learnt 200 objects" in capsys.readouterr().err


def test_the_plot_draws_what_it_is_given(tmp_path):
    cup, table = ({"f_measure": f, "f_measure_whole": whole} for f, whole in ((0.5, 0.9), (None, None)))
    functions = {"cup": cup, "table": table}
    measured = [
        {"views": views, "noise": noise, "segmentation": {"recall": 0.8}, "functions": functions}
        for views, noise in [("whole", 0.0), ("1 view", 1.0), ("3 views", 1.0), ("3 views", 2.0)]
    ]
    rows = curve_rows(measured)
    assert [row["value"] for row in rows if row["curve"] == "cup"] == [0.5] * 4
    about = {"data": "objects", "backend": "fast"}
    write_report(tmp_path, about, measured)
    assert (tmp_path / "rooms.csv").read_text().count("\n") == 1 + 3 * 4
    assert (tmp_path / "rooms.svg").read_text().startswith("<?xml")


@pytest.mark.parametrize(
    "wrong",
    [
        ["--views", "some"],
        ["--noise=-1"],
        ["--completion", "magic"],
        ["--model", "none.npz"],
        ["--radii", "5m", "--model", shipped_model()],
    ],
)
def test_mistakes_are_one_line(run, tmp_path, wrong):
    done = run(write_objects(tmp_path, ("mug",)), *wrong)
    assert isinstance(done.exception, InputError)
    assert "\n" not in str(done.exception) and "expected" in str(done.exception)
