"""Poses, standing and keeping as tasks beside labels: what each backend does, and what is said of it."""

from __future__ import annotations

import json
from functools import partial
from pathlib import Path

import catalogues
import numpy as np
import pytest
from commands import spherefunc

from spherefunc_bullet.clouds.cloud import cloud_from_mesh, load_cloud
from spherefunc_bullet.commands.command_line import main
from spherefunc_bullet.compare.comparison.experiment import LABELS, as_toml, read_experiment, read_options_of
from spherefunc_bullet.compare.evaluation import readings
from spherefunc_bullet.compare.mechanics import poses, standing
from spherefunc_bullet.compare.mechanics.measures import (
    TaskReports,
    benefit_sentence,
    compare_outcomes,
    measured,
    read_tasks,
    task_reports,
)
from spherefunc_bullet.compare.mechanics.standing import TaskOptions, TaskOutcome
from spherefunc_bullet.datasets.catalogue import built_catalogue, write_catalogue
from spherefunc_bullet.datasets.dataset import open_dataset
from spherefunc_bullet.errors import InputError
from spherefunc_bullet.learning import function_classifier
from spherefunc_bullet.scenes.impairment.sawn import HEIGHTS, HOLED, copies_of
from spherefunc_bullet.scenes.impairment.specimen import Specimen
from spherefunc_bullet.simulator import make_simulator
from spherefunc_bullet.simulator.mechanics import CarrySettings


def outcome(backend: str, right: str, seconds: float = 1.0) -> TaskOutcome:
    """Return an outcome of which objects are classified correctly, 1, and wrong, 0."""
    answer = {str(number): digit == "1" for number, digit in enumerate(right)}
    value = float(np.mean(list(answer.values())))
    return TaskOutcome(backend=backend, measure="share", value=value, asked=len(answer), seconds=seconds, right=answer)


def household(name: str) -> Path:
    return built_catalogue("household").parent / f"{name}.ply"


def test_the_sign_test_by_hand():
    better, chance = compare_outcomes(outcome("fast", "0000001"), outcome("bullet", "1111110"))
    assert better and chance == pytest.approx(2 * (1 + 7) / 2**7)  # 6 of 7 or more, either way
    assert compare_outcomes(outcome("fast", "1100"), outcome("bullet", "1100"))[1] == 1.0


def test_one_sentence_says_what_fidelity_buys():
    quick, same = outcome("fast", "1" * 20), outcome("bullet", "1" * 20, seconds=3.0)
    level = benefit_sentence("poses", [quick, same], ())
    assert "bullet is as good as fast (share 1.00 against 1.00 of 20) and gains nothing measurable" in level
    worse = outcome("fast", "0" * 10 + "1" * 10)
    said = benefit_sentence("poses", [worse, same], ())
    assert "better than" in said and "3.0 times the time (3.0 s against 1.0 s each)" in said
    assert "worse than" in benefit_sentence("poses", [quick, outcome("bullet", "0" * 10 + "1" * 10)], ())
    alone = benefit_sentence("keeping", [same], ("fast",))
    assert "only bullet can do it, fast cannot (share 1.00 of 20, 3.0 s each)" in alone
    assert "nothing was measured, fast cannot do it" in benefit_sentence("keeping", [], ("fast",))


def test_tasks_are_read():
    assert read_tasks(["poses", " keeping", "poses"]) == ("poses", "keeping")
    with pytest.raises(InputError, match="swimming': expected some of poses, standing, keeping"):
        read_tasks(["swimming"])
    assert read_options_of(["labels", "standing"]) == (LABELS, "standing")
    with pytest.raises(InputError, match="spherefunc mechanics --tasks standing"):
        read_options_of(["standing"])


def test_an_experiment_repeats_its_tasks(tmp_path):
    file = tmp_path / "experiment.toml"
    file.write_text('data = "household"\nbackends = ["fast"]\ntasks = ["labels", "poses"]\ntask_objects = 7\n')
    experiment = read_experiment(file)
    assert (experiment.tasks, experiment.task_objects) == (("labels", "poses"), 7)
    file.write_text(as_toml(experiment))
    assert read_experiment(file) == experiment


def test_a_hole_is_where_it_is_said_to_be():
    cloud = load_cloud(household("mug_01"))
    specimen = Specimen(cloud, "cup")
    copies = copies_of(specimen, "mug_01", HOLED)
    assert [kind.kind for kind, _ in copies] == ["hole_at_25", "hole_at_50", "hole_at_75"]
    cup = specimen.cavity
    for height, (_, surface) in zip(HEIGHTS, copies, strict=True):
        copy = cloud_from_mesh(*surface.mesh(), "holed")
        far, _ = copy.tree.query(cloud.points)  # what is gone is far from all that is left
        gone = cloud.points[far > 0.004]
        middle = (gone.max(axis=0) + gone.min(axis=0)) / 2
        assert middle[2] == pytest.approx(cup.floor + height * (cup.brim - cup.floor), abs=0.004)
        assert np.ptp(gone[:, 2]) == pytest.approx(3 * cloud.size.max() / 16, abs=0.012)  # less the samples around it


@pytest.fixture(scope="module")
def kept() -> TaskReports:
    """Return what a mug, with and without holes, and a plate keep at the farthest angle, asked in this process."""
    simulator, farthest = carrier(), CarrySettings().angles_deg[-1:]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(poses, "CarrySettings", partial(CarrySettings, angles_deg=farthest, shake=0.0, frequency=30.0))
        patch.setattr(standing, "isolated", lambda simulator: False)
        return measured(few("mug_01", "plate_01"), {"bullet": simulator}, ["keeping"], None, TaskOptions(count=1))


@pytest.mark.slow
def test_the_lower_the_hole_the_less_is_kept(kept):
    score = kept.keeping["bullet"]
    low, middle, high, whole = (curve[-1] for curve in (*(one.kept for one in score.holed), score.vessels))
    # The hole is three sixteenths of the mug's extent across, so its lower edge is some 0.12 of the depth under its
    # middle: what it holds without spilling is that much less than a quarter, a half and three quarters.
    assert low < middle - 0.1 < high - 0.2 < whole - 0.3 and whole > 0.95


def carrier():
    try:
        return make_simulator("bullet")
    except InputError as error:
        pytest.skip(str(error))


def few(*names: str):
    """Return objects of the catalogue."""
    return [item for item in open_dataset("household").objects if item.path.stem in names]


def test_what_a_backend_cannot_do_is_said_and_left_out():
    objects = few("mug_01", "plate_01", "cafe_table_01")
    fast = {"fast": make_simulator("fast")}
    found = task_reports(measured(objects, fast, ["standing", "keeping"], None, TaskOptions(count=3)))
    assert found["keeping"]["unable"] == ["fast"] and found["keeping"]["rows"] == []
    assert found["standing"]["rows"][0]["asked"] >= 2 and found["standing"]["agreement"] is None
    json.dumps(found)  # ready for it


@pytest.mark.slow
def test_a_mug_is_told_from_a_plate_by_what_it_keeps(kept):
    score = kept.keeping["bullet"]
    assert score.score.f_measure == 1.0 and score.vessels[-1] > 0.5 > score.others[-1]
    assert [(one.kind, one.asked) for one in score.holed] == [("hole_at_25", 1), ("hole_at_50", 1), ("hole_at_75", 1)]
    [row] = task_reports(kept)["keeping"]["rows"]
    assert row["asked"] == len(row["right"]) == 2 and all(row["right"].values())
    assert set(json.loads(json.dumps(task_reports(kept)["keeping"]))["backends"]) == {"bullet"}


@pytest.mark.slow
def test_a_person_can_sit_on_seats_and_spheres_alone_believe_more():
    simulators = {"fast": make_simulator("fast"), "bullet": carrier()}
    found = measured(few("stool_01"), simulators, ["places"], None, TaskOptions(count=1))
    proposed, proven = (found.places[name].verdicts for name in simulators)
    assert [(one.name, one.kind) for one in proposed] == [(one.name, one.kind) for one in proven]
    assert all(one.positive for one in (*proposed, *proven) if one.kind == "whole")
    useless = [(one.positive, other.positive) for one, other in zip(proposed, proven, strict=True) if not one.true]
    assert useless and all(may or not holds for may, holds in useless)
    assert not any(holds for _, holds in useless)
    [first, last] = task_reports(found)["places"]["rows"]
    assert first["asked"] == last["asked"] == len(proven) and last["value"] >= first["value"]


def test_data_without_furniture_have_nothing_that_stands():
    found = measured(few("mug_01"), {"fast": make_simulator("fast")}, ["standing"], None, TaskOptions(count=3))
    assert "the data have nothing to ask about" in task_reports(found)["standing"]["says"]


@pytest.mark.slow
def test_a_file_that_cannot_be_used_is_said_once_and_counts(tmp_path):
    chosen = [item for item in catalogues.household() if item.name in ("stool_01", "mug_01", "plate_01")]
    folder = write_catalogue(chosen, tmp_path / "objects", "three").parent
    (folder / "stool_01.ply").write_bytes(b"")
    done = spherefunc("mechanics", folder, "--backend", "fast", "--tasks", "poses,standing,places", "--json")
    assert done.returncode == 2 and json.loads(done.stdout)["poses"]["rows"][0]["asked"] == 1
    [line] = done.stderr.splitlines()
    assert line.startswith("spherefunc: ") and "stool_01.ply" in line and line.endswith("(left out)")


@pytest.mark.slow
def test_compare_and_evaluate_take_tasks(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(function_classifier, "TREES", 8)  # what forests say is not looked at
    monkeypatch.setattr(readings, "WORTH_CORES", 10**6)
    kinds = ("mug_01", "mug_02", "dining_chair_01", "dining_chair_02", "cafe_table_01", "vase_01")
    write_catalogue([item for item in catalogues.household() if item.name in kinds], tmp_path / "objects", "six")
    options = ["--tasks", "labels,standing", "--task-objects", "2", "--trials", "1", "--radii", "3cm", "--jobs", "1"]

    def said(command: str, *arguments: str) -> dict:
        monkeypatch.setattr(
            "sys.argv", ["spherefunc", command, str(tmp_path / "objects"), *arguments, *options, "--json"]
        )
        with pytest.raises(SystemExit) as ended:
            main()
        out, err = capsys.readouterr()
        assert not ended.value.code, err
        return json.loads(out)

    compared = said("compare", "--backends", "fast", "--copied", "0", "--report", str(tmp_path / "out"))
    [row] = compared["tasks"]["standing"]["rows"]
    assert row["backend"] == "fast" and row["asked"] == len(row["right"]) >= 4
    assert compared["tasks"]["standing"]["says"][1:] in compared["answer"]
    page = (tmp_path / "out" / "report.html").read_text()
    assert "What else rigid bodies tell" in page and "F of sound furniture" in page
    assert 'tasks = ["labels", "standing"]' in (tmp_path / "out" / "experiment.toml").read_text()
    evaluated = said("evaluate", "--train-sizes", "half")
    assert evaluated["tasks"]["standing"]["rows"][0]["right"] == row["right"]
