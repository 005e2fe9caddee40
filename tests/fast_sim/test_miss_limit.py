"""The miss limit of §III-A is an option: so many consecutive spheres that are not placed end a run, 50 by default."""

from __future__ import annotations

import json
from pathlib import Path

import clouds
import numpy as np
import pytest
from commands import spherefunc

from spherefunc_bullet.clouds.cloud import load_cloud
from spherefunc_bullet.compare.comparison.experiment import Experiment, as_toml, candidates, read_experiment
from spherefunc_bullet.errors import InputError
from spherefunc_bullet.learning.method import METHODS
from spherefunc_bullet.settling.cached_runs import DropConfig
from spherefunc_bullet.settling.drops import LIMITED, TO_THE_END
from spherefunc_bullet.settling.settling import drop_settings
from spherefunc_bullet.simulator import DropSettings, make_simulator


@pytest.fixture
def folder(tmp_path, monkeypatch) -> Path:
    """Return a data set of two mugs and two plates."""
    monkeypatch.setenv("SPHEREFUNC_CACHE", str(tmp_path / "cache"))
    folder, rows = tmp_path / "data", ["file,label"]
    folder.mkdir()
    for name, cloud in (("mug", clouds.mug()), ("plate", clouds.plate())):
        for number in range(2):
            np.savetxt(folder / f"{name}{number}.xyz", cloud.points * (1 + 0.1 * number))
            rows.append(f"{name}{number}.xyz,{'cup' if name == 'mug' else 'none'}")
    (folder / "manifest.csv").write_text("\n".join(rows) + "\n")
    return folder


def simulated(file: Path, *options) -> dict:
    """Return what `simulate` prints of a file."""
    done = spherefunc("simulate", file, "--radius", "2cm", "--json", *options)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)[0]


def test_simulate_ends_after_so_many_misses_in_a_row(folder):
    usual, short = simulated(folder / "plate0.xyz"), simulated(folder / "plate0.xyz", "--miss-limit", 2)
    assert usual == simulated(folder / "plate0.xyz", "--miss-limit", 50) | {"seconds": usual["seconds"]}
    assert short["drops"] < usual["drops"] and short["settled"] < usual["settled"] and short["stop"] == "misses"


def test_the_run_is_that_of_the_settings(folder):
    plate, settings = load_cloud(folder / "plate0.xyz"), DropSettings(radius=0.02, miss_limit=3)
    result, row = make_simulator("fast").drop(plate, settings, 0), simulated(folder / "plate0.xyz", "--miss-limit", 3)
    assert (row["settled"], row["drops"]) == (result.settled, result.drops)


@pytest.mark.parametrize("length", [LIMITED, TO_THE_END])
def test_runs_for_features_take_it_and_are_kept_apart(length):
    simulator = make_simulator("fast")
    assert drop_settings(simulator, 0.02, length).miss_limit == 50
    assert drop_settings(simulator, 0.02, length.ending(7)).miss_limit == 7
    names = {
        DropConfig(simulator="fast", radii=(0.02,), run_limit=length.ending(n)).run_hash("", 0.02)
        for n in (None, 50, 7)
    }
    assert len(names) == 2


@pytest.mark.parametrize("command", ["evaluate", "batch"])
@pytest.mark.slow
def test_commands_take_it(folder, tmp_path, command):
    arguments = [command, folder, "--method", "cubes", "--radii", "3cm", "--miss-limit", 4, "--json"]
    done = spherefunc(*arguments, *(["--run", tmp_path / "run"] if command == "batch" else ["--trials", 1]))
    assert done.returncode == 0, done.stderr


def test_an_experiment_keeps_it(tmp_path):
    experiment = Experiment(data="household", backends=("fast",), methods=("cubes",), miss_limit=5)
    assert [one.run_limit.miss_limit for one in candidates(experiment)] == [5]
    (tmp_path / "experiment.toml").write_text(as_toml(experiment))
    assert read_experiment(tmp_path / "experiment.toml") == experiment


def test_where_runs_are_so_many_drops_it_is_refused(folder):
    with pytest.raises(InputError, match="miss limit 9: expected with method cubes or paper"):
        METHODS["profile"].run_limit.ending(9)
    done = spherefunc("evaluate", folder, "--miss-limit", 9)
    assert done.returncode == 2 and len(done.stderr.splitlines()) == 1
