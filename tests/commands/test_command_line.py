"""The console script as scripts use it: JSON fields, streams and exit codes.

In processes of their own where it is the process that is tested, else by the same calls in this one.
"""

from __future__ import annotations

import csv
import json
import os
import subprocess
import sys
from itertools import pairwise
from pathlib import Path

import clouds
import numpy as np
import pytest
from typer.testing import CliRunner

from spherefunc_bullet.commands.carry import carried_file
from spherefunc_bullet.commands.command_line import application
from spherefunc_bullet.commands.simulate import drop_on_file
from spherefunc_bullet.errors import InputError
from spherefunc_bullet.formats.files import cache_home
from spherefunc_bullet.formats.units import parse_lengths
from spherefunc_bullet.learning import function_classifier
from spherefunc_bullet.simulator import DropSettings, make_simulator
from spherefunc_bullet.simulator.mechanics import CarrySettings

SCRIPT = Path(sys.executable).with_name("spherefunc")
SIMULATE_FIELDS = {
    "file",
    "backend",
    "radius",
    "seed",
    "points",
    "drops",
    "settled",
    "rolled_off",
    "rejected",
    "timed_out",
    "seconds",
    "bounding_box",
}
TREES = 20  # of a forest, which learn quickly; objects here differ in everything
FIGURES = {"f_measure", "f_measure_std", "f_measure_fair", "precision", "recall", "accuracy", "radius"}
UNSET = "is a variable unset?"


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """Return a function that runs the script with a cache of its own."""
    cache = tmp_path_factory.mktemp("cache")

    def spherefunc(*arguments, cwd=None):
        return subprocess.run(
            [SCRIPT, *map(str, arguments)],
            capture_output=True,
            text=True,
            check=False,
            cwd=cwd or cache,
            env=os.environ | {"SPHEREFUNC_CACHE": str(cache)},
        )

    return spherefunc


def invoke(*arguments) -> subprocess.CompletedProcess:
    """Do as the script does, without the seconds that a new process costs."""
    done = CliRunner().invoke(application(), [str(each) for each in arguments])
    if isinstance(done.exception, InputError):  # what `main` turns into a line and a code
        return subprocess.CompletedProcess(arguments, 2, done.stdout, f"{done.stderr}{done.exception}\n")
    assert done.exception is None or isinstance(done.exception, SystemExit), done.exception
    return subprocess.CompletedProcess(arguments, done.exit_code, done.stdout, done.stderr)


@pytest.fixture
def call(tmp_path, monkeypatch):
    """Return `invoke`, with an empty cache."""
    monkeypatch.setenv("SPHEREFUNC_CACHE", str(tmp_path / "cache"))
    monkeypatch.setattr(function_classifier, "TREES", TREES)
    monkeypatch.chdir(tmp_path)
    return invoke


@pytest.fixture(scope="module")
def data(tmp_path_factory):
    """Return a data set of sixteen small objects, four of each kind."""
    folder = tmp_path_factory.mktemp("data")
    rows = []
    for i in range(4):
        kinds = {
            "cup": clouds.mug(0.035 + 0.003 * i, 0.08 + 0.01 * i),
            "table": clouds.table(0.4 + 0.05 * i, 0.3 + 0.03 * i, 0.35 + 0.02 * i),
            "sittable": clouds.chair(0.22 + 0.01 * i, 0.22 + 0.02 * i, 0.2 + 0.02 * i),
            "none": clouds.cloud(clouds.post(0, 0, 0.3 + 0.1 * i, 0.1), name="post"),
        }
        for label, shape in kinds.items():
            np.savez(folder / f"{label}_{i}.npz", points=shape.points)
            rows.append(
                [
                    f"{label}_{i}.npz",
                    label,
                    "sittable" if (label, i) == ("table", 0) else "",
                    f"source {i % 2}",
                ]
            )
    with open(folder / "manifest.csv", "w", newline="", encoding="utf-8") as file:
        csv.writer(file).writerows([["file", "label", "also", "group"], *rows])
    return folder


@pytest.fixture(scope="module")
def subset(data, tmp_path_factory):
    """Return twelve of the objects as a folder of label folders."""
    folder = tmp_path_factory.mktemp("subset")
    for path in sorted(data.glob("*.npz")):
        label, number = path.stem.split("_")
        if number != "3":
            (folder / label).mkdir(exist_ok=True)
            (folder / label / path.name).write_bytes(path.read_bytes())
    return folder


@pytest.fixture(scope="module")
def trained(subset, tmp_path_factory):
    """Return a model's path and what its training printed."""
    path = tmp_path_factory.mktemp("model") / "model.npz"
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("SPHEREFUNC_CACHE", str(path.with_name("cache")))
        patch.setattr(function_classifier, "TREES", TREES)
        done = invoke("train", subset, "--out", path, "--radii", "2cm,1cm", "--jobs", 1, "--json")
    assert done.returncode == 0, done.stderr
    return path, json.loads(done.stdout)


@pytest.mark.parametrize("line", [["classify", ""], ["simulate", "cup.ply", "--out", ""], ["train", "data", "--out="]])
def test_an_unset_variable_of_the_shell_is_not_the_current_folder(run, line):
    done = run(*line)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr == f"spherefunc: {line[-1]!r} after {line[-2]}: expected a value, got an empty one; {UNSET}\n"


@pytest.mark.slow
def test_several_data_sets_are_learnt_as_one(call, subset, tmp_path):
    few = ("--radii", "5cm", "--jobs", 1, "--json", "--out", tmp_path / "model.npz")
    one, both = (json.loads(call("train", *given, *few).stdout) for given in ((subset,), (subset, subset)))
    assert both["objects"] == 2 * one["objects"]
    assert both["functions"] == {name: 2 * count for name, count in one["functions"].items()}


def said(done) -> list[str]:
    """Return the lines on stderr, without that kernels are compiled: who does so first on a machine says it."""
    return [line for line in done.stderr.splitlines() if not line.startswith("compiling ")]


def check_refused(done, *words):
    """Check that a run was the user's mistake, said in one line."""
    assert done.returncode == 2, done.stderr
    lines = said(done)
    assert len(lines) == 1, done.stderr
    assert "Traceback" not in lines[0] and all(word in lines[0] for word in words)


def test_simulate_prints_the_contract(run, data):
    files = [data / "cup_0.npz", data / "table_0.npz"]
    done = run("simulate", *files, "--radius", "2cm", "--seed", 5, "--json")
    rows = json.loads(done.stdout)
    assert done.returncode == 0 and not said(done)
    assert [row["file"] for row in rows] == [str(file) for file in files]
    for row in rows:
        assert SIMULATE_FIELDS <= set(row)
        assert (row["backend"], row["radius"], row["seed"]) == ("fast", 0.02, 5)
        assert row["drops"] == row["settled"] + row["rolled_off"] + row["rejected"] + row["timed_out"]
        low, high = np.array(row["bounding_box"])
        assert low[2] == 0 and np.allclose(low[:2], -high[:2])
    assert rows[0]["points"] == len(clouds.mug(0.035, 0.08))


@pytest.mark.parametrize("radius", ["20mm", "0.02"])
def test_lengths_take_a_unit(call, data, radius):
    row = json.loads(call("simulate", data / "cup_0.npz", "--radius", radius, "--json").stdout)[0]
    assert row["radius"] == 0.02


def test_simulate_writes_centres_named_for_the_file(call, data, tmp_path):
    done = call("simulate", data / "cup_0.npz", "--radius", "1cm,2cm", "--out", tmp_path / "new" / "folder", "--json")
    rows = json.loads(done.stdout)
    files = sorted((tmp_path / "new" / "folder").iterdir())
    assert len(rows) == len(files) == 2
    assert all(file.suffix == ".npz" and file.name.startswith("cup_0") for file in files)
    for row, file in zip(rows, files, strict=True):
        with np.load(file, allow_pickle=False) as arrays:
            assert arrays["centers"].shape == (row["settled"], 3) and row["settled"] > 0
            assert json.loads(str(arrays["provenance"]))["settings"]["radius"] == row["radius"]


def test_files_of_one_stem_get_two_names(call, data, tmp_path):
    (tmp_path / "cup_0.npz").write_bytes((data / "cup_1.npz").read_bytes())
    call("simulate", data / "cup_0.npz", tmp_path / "cup_0.npz", "--radius", "2cm", "--out", tmp_path / "out")
    assert len(list((tmp_path / "out").glob("cup_0*.npz"))) == 2


def test_seed_reproduces_in_another_process(run, call, data, tmp_path):
    for name, spherefunc in (("a", run), ("b", call)):
        spherefunc("simulate", data / "cup_0.npz", "--radius", "1cm", "--seed", 3, "--out", tmp_path / name)
    a, b = (np.load(next((tmp_path / name).iterdir()))["centers"] for name in "ab")
    assert a.tobytes() == b.tobytes()


def test_without_json_there_is_a_table(call, data):
    done = call("simulate", data / "cup_0.npz", "--radius", "2cm")
    assert done.returncode == 0 and not said(done) and "cup_0.npz" in done.stdout


def test_other_files_of_the_call_are_still_done(call, data, tmp_path):
    (tmp_path / "broken.ply").write_bytes(b"ply\nformat ascii 1.0\nelement vertex 3\n")
    done = call("simulate", tmp_path / "broken.ply", data / "cup_0.npz", "--radius", "2cm", "--json")
    check_refused(done, "broken.ply")
    assert [row["file"] for row in json.loads(done.stdout)] == [str(data / "cup_0.npz")]


def test_sphere_limit_is_an_outcome(call, data):
    done = call("simulate", data / "table_0.npz", "--radius", "1cm", "--max-spheres", 9, "--json")
    row = json.loads(done.stdout)[0]
    assert done.returncode == 0 and (row["settled"], row["stop"]) == (9, "sphere_limit")


def test_mistake_is_one_line_and_code_two(run, data):
    done = run("simulate", data / "cup_0.npz", "--radius", "0")
    check_refused(done, "spherefunc: length '0': expected more than zero")
    assert done.stdout == ""


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["gone.ply"], ["gone.ply"]),
        (["{cup}", "--radius", "-1cm"], ["-1cm", "more than zero"]),
        (["{cup}", "--radius", "2m"], ["cup_0", "units"]),
        (["{cup}", "--backend", "magic"], ["magic", "fast"]),
        (["{cup}", "--shape", "voxel"], ["fast", "shape"]),
        (["{cup}", "--units", "parsec"], ["parsec", "expected"]),
        (["{cup}", "--out", "{cup}"], ["cup_0.npz", "expected a folder"]),
    ],
)
def test_mistakes_in_simulate_are_one_line(call, data, arguments, words):
    cup = str(data / "cup_0.npz")
    done = call("simulate", *(each.format(cup=cup) for each in arguments))
    check_refused(done, *words)
    assert done.stdout == ""


@pytest.mark.parametrize("text", ["0", "-1cm", "nan", "inf", "1e999", "2 apples", "cm", "", ",", "1cm,x", "1,5cm,0"])
def test_text_that_is_no_length_is_refused(text):
    with pytest.raises(InputError, match="expected") as caught:
        parse_lengths(text)
    assert "\n" not in str(caught.value)


def test_train_prints_the_contract(trained):
    path, printed = trained
    assert printed["backend"] == "fast" and printed["objects"] == 12
    assert set(printed["radii"]) == set(printed["functions"]) == {"cup", "sittable", "table"}
    assert set(printed["radii"].values()) <= {0.01, 0.02}
    assert set(printed["functions"].values()) == {3}
    assert path.is_file()


def test_what_was_learnt_is_recognised(call, trained, data):
    files = [data / f"{label}_3.npz" for label in ("cup", "table", "sittable", "none")]
    done = call("classify", *files, "--model", trained[0], "--json")
    assert done.returncode == 0 and not said(done)
    rows = json.loads(done.stdout)
    members = []
    for row, file in zip(rows, files, strict=True):
        assert {"file", "functions", "seconds"} <= set(row) and row["file"] == str(file)
        for each in row["functions"].values():
            assert {"member", "score", "radius"} <= set(each) and 0 <= each["score"] <= 1
            assert each["member"] == (each["score"] > 0.5)
        members.append({name for name, each in row["functions"].items() if each["member"]})
    assert members == [{"cup"}, {"table"}, {"sittable"}, set()]


def test_explain_says_it_in_words(call, trained, data):
    explain = ("classify", data / "cup_3.npz", "--model", trained[0], "--explain")
    row = json.loads(call(*explain, "--json").stdout)[0]
    assert row["nearest"][0]["name"].startswith("cup_") and row["nearest"][0]["functions"] == ["cup"]
    assert any(reason.startswith("cup ") and "above the ground" in reason for reason in row["reasons"])
    decided = row["quantities"]["cup"]
    assert decided and all(abs(one["share"]) >= abs(two["share"]) for one, two in pairwise(decided))
    printed = call(*explain).stdout
    assert row["reasons"][0][:40] in printed and "nearest training objects: cup_" in printed


def test_explain_names_the_neighbours_of_cubes(call, subset, data, tmp_path):
    quick = ("--method", "cubes", "--radii", "2cm", "--jobs", 1)
    assert call("train", data, "--out", tmp_path / "cubes.npz", *quick).returncode == 0
    done = call("classify", data / "cup_3.npz", "--model", tmp_path / "cubes.npz", "--explain", "--json")
    nearest = json.loads(done.stdout)[0]["neighbors"]["cup"][0]
    assert nearest["member"] and nearest["name"].startswith("cup_")


def test_what_hardly_holds_a_sphere_is_unsure(call, trained, tmp_path):
    needle = np.column_stack([np.zeros(200), np.zeros(200), np.linspace(0, 0.3, 200)])
    np.savetxt(tmp_path / "needle.xyz", needle + np.random.default_rng(0).normal(0, 5e-4, needle.shape))
    row = json.loads(call("classify", tmp_path / "needle.xyz", "--model", trained[0], "--json").stdout)[0]
    assert row["unsure"] is True and len(row["reasons"]) > 1


def test_classify_refuses_what_it_cannot_use(call, trained, data):
    cup = data / "cup_3.npz"
    check_refused(call("classify", cup, "--model", trained[0], "--backend", "bullet"), "fast", "bullet")
    done = call("classify", "gone.ply", cup, "--model", trained[0], "--json")
    check_refused(done, "gone.ply")
    failed, answer = json.loads(done.stdout)
    assert failed.keys() == {"file", "error"} and "gone.ply" in failed["error"] and answer["functions"]


@pytest.mark.slow
def test_classify_takes_folders_and_names_on_stdin(call, trained, data, tmp_path):
    (tmp_path / "objects" / "deep").mkdir(parents=True)
    for name in ("cup_3", "table_3"):
        (tmp_path / "objects" / "deep" / f"{name}.npz").write_bytes((data / f"{name}.npz").read_bytes())
    (tmp_path / "objects" / "notes.txt").write_text("no model")
    (tmp_path / "objects" / "broken.ply").write_text("junk")
    table = tmp_path / "classified.csv"
    done = call("classify", tmp_path / "objects", "--model", trained[0], "--csv", table, "--jobs", 2)
    assert done.returncode == 2 and "1 of 3 files" in done.stderr and "cup_3.npz" in done.stdout
    with open(table, encoding="utf-8") as file:
        rows = {Path(row["file"]).name: row for row in csv.DictReader(file)}
    assert rows["cup_3.npz"]["functions"] == "cup" and float(rows["cup_3.npz"]["cup"]) > 0.5
    assert "PLY" in rows["broken.ply"]["error"] and rows["broken.ply"]["functions"] == ""
    names = f"{data / 'cup_3.npz'}\n\n{data / 'table_3.npz'}\n"
    listed = CliRunner().invoke(application(), ["classify", "-", "--model", str(trained[0]), "--json"], input=names)
    assert [row["file"] for row in json.loads(listed.stdout)] == names.split()
    check_refused(call("classify", tmp_path, "--model", tmp_path / "none.npz"), "none.npz")


def test_classify_simulates_a_file_once(call, trained, data, tmp_path):
    ask = ("classify", data / "cup_3.npz", "--model", trained[0], "--json")
    first = json.loads(call(*ask).stdout)[0]
    kept = sorted((tmp_path / "cache" / "settled").rglob("*.npz"))
    again = json.loads(call(*ask).stdout)[0]
    assert kept == sorted((tmp_path / "cache" / "settled").rglob("*.npz"))
    assert len(kept) == 2 * 2  # at either radius the first drops, and all: who has learnt six objects is never sure
    assert first["functions"] == again["functions"] and first["reasons"] == again["reasons"]


def test_what_is_odd_is_said_each_time(call, trained, tmp_path):
    np.savez(tmp_path / "large.npz", points=300 * clouds.mug().points)
    lines = [call("classify", tmp_path / "large.npz", "--model", trained[0]).stderr for _ in range(2)]
    assert lines[0] == lines[1] and "30 m wide" in lines[0]


def test_one_function_alone_runs_its_radius_alone(call, subset, data, tmp_path):
    model = tmp_path / "paper.npz"
    learn = ("train", subset, "--out", model, "--method", "paper", "--radii", "2cm,5cm", "--jobs", 1)
    radii = json.loads(call(*learn, "--json").stdout)["radii"]
    before = len(list((tmp_path / "cache" / "settled").rglob("*.npz")))
    row = json.loads(call("classify", data / "cup_3.npz", "--model", model, "--function", "cup", "--json").stdout)[0]
    assert list(row["functions"]) == ["cup"] and row["functions"]["cup"]["radius"] == radii["cup"]
    assert len(list((tmp_path / "cache" / "settled").rglob("*.npz"))) == before + 1
    check_refused(call("classify", data / "cup_3.npz", "--model", model, "--function", "shelf"), "shelf", "cup")


@pytest.mark.parametrize(("count", "width"), [(2, 70), (3, 40), (9, 70), (30, 70)])
def test_a_narrow_terminal_gets_whole_scores(monkeypatch, capsys, count, width):
    from spherefunc_bullet.commands import classify

    monkeypatch.setattr(classify, "terminal_width", lambda: width)
    names = [f"function_{i:02}" for i in range(count)]
    scores = {name: 0.9 if i == 1 else 0.01 * i for i, name in enumerate(names)}
    answer = {name: {"member": score > 0.5, "score": score, "radius": 0.01} for name, score in scores.items()}
    classify.print_functions([{"file": "a/object.ply", "functions": answer, "unsure": False}], names, False)
    printed = capsys.readouterr().out
    assert "function_01" in printed and "0.90" in printed and "…" not in printed
    assert max(map(len, printed.splitlines()[1:])) <= max(width, 75)


@pytest.mark.parametrize("command", ["simulate", "classify", "view", "scene"])
def test_an_axis_that_points_down_is_taken_everywhere(call, command, tmp_path):
    order, sign = (0, 2, 1), (1, -1, 1)
    points = np.vstack([clouds.level(0.5, 0.5, 0), clouds.mug().points + [0, 0, 0.004]])
    np.savez(tmp_path / "down.npz", points=points[:, order] * sign)
    done = call(command, tmp_path / "down.npz", "--up", "-y", "--units", "m", "--json")
    assert done.returncode == 0, done.stderr


def write_labels(folder, data, *rows):
    """Write a manifest over copies of the data's files."""
    for file, _ in rows:
        (folder / file).write_bytes((data / file).read_bytes())
    lines = "".join(f'{file},"{label}"\n' for file, label in rows)
    (folder / "manifest.csv").write_text(f"file,label\n{lines}")
    return folder


@pytest.mark.parametrize(
    ("rows", "words"),
    [
        ([("cup_0.npz", "cup"), ("cup_0.npz", "none")], ["cup_0.npz", "listed twice", "cup and none"]),
        ([("cup_0.npz", "container,shelf"), ("table_0.npz", "none")], ["container,shelf", "separated by ;", "line 2"]),
        ([("cup_0.npz", "cup"), ("cup_1.npz", "cup")], ["all 2 objects are cup"]),
        ([("cup_0.npz", "none"), ("cup_1.npz", "none")], ["all are labelled none"]),
    ],
)
def test_train_refuses_labels_that_teach_nothing(call, data, tmp_path, rows, words):
    folder = write_labels(tmp_path, data, *rows)
    check_refused(call("train", folder, "--out", tmp_path / "model.npz", "--radii", "2cm", "--jobs", 1), *words)
    assert not (tmp_path / "model.npz").exists()


def test_train_refuses_the_same_content_under_two_labels(call, data, tmp_path):
    folder = write_labels(tmp_path, data, ("cup_0.npz", "cup"), ("cup_1.npz", "none"))
    (folder / "cup_1.npz").write_bytes((folder / "cup_0.npz").read_bytes())
    done = call("train", folder, "--out", tmp_path / "model.npz", "--radii", "2cm", "--jobs", 1)
    check_refused(done, "cup_1.npz holds the same", "cup and none")


def test_train_refuses_spheres_of_no_sense(call, subset, data, tmp_path):
    to = ("--out", tmp_path / "model.npz", "--jobs", 1)
    check_refused(call("train", subset, *to, "--radii", "2"), "0.5 mm to 20 cm, got 2 m", "2cm")
    cups = write_labels(tmp_path, data, *((f"cup_{i}.npz", "cup") for i in range(3)), ("cup_3.npz", "none"))
    check_refused(call("train", cups, *to, "--radii", "18cm"), "smaller than the objects", "18 cm")


@pytest.mark.slow
def test_train_says_how_well_it_learnt(call, data, tmp_path):
    kinds = {"cup": "cup", "table": "table", "none": "none"}
    rows = [(f"{kind}_{i}.npz", label) for kind, label in kinds.items() for i in range(4)]
    folder = write_labels(tmp_path, data, *rows, ("sittable_0.npz", "sitable"))
    learn = ("train", folder, "--out", tmp_path / "model.npz", "--radii", "2cm,1cm", "--jobs", 1)
    done = call(*learn)
    assert done.returncode == 0 and "sitable has 1 example" in done.stderr and "misspelt" in done.stderr
    assert "held out" in done.stdout and "too few" in done.stdout
    cup = next(line.split() for line in done.stdout.splitlines() if line.startswith("cup"))
    assert cup[1:3] == ["4", "9"]
    for method in ("profile", "cubes"):
        printed = json.loads(call(*learn, "--method", method, "--json").stdout)
        assert printed["f_measure_held_out"]["sitable"] is None and len(printed["remarks"]) == 1
        # Cups and tables differ in everything, whoever is held out.
        assert printed["f_measure_held_out"]["cup"] > 0.5 and printed["functions"]["cup"] == 4


def test_train_refuses_what_it_cannot_use(call, subset, tmp_path):
    check_refused(call("train", "no-such-set", "--out", tmp_path / "m"), "no-such-set", "household")
    check_refused(call("train", subset, "--out", tmp_path, "--radii", "2cm", "--jobs", 1), "can be written")


@pytest.mark.slow
def test_evaluate_prints_the_contract(call, data):
    arguments = ("--trials", 2, "--train-sizes", "4,half", "--radii", "1cm,2cm", "--jobs", 1)
    done = call("evaluate", data, *arguments, "--method", "paper", "--leave-one-out", "--groups", "--json")
    assert done.returncode == 0 and not said(done)
    report = json.loads(done.stdout)
    assert (report["backend"], report["method"]) == ("fast", "paper")
    assert [row["train_size"] for row in report["results"]] == [4, 8, 15, 8]
    for row in report["results"]:
        assert set(row["functions"]) == {"cup", "sittable", "table"}
        for figures in row["functions"].values():
            assert FIGURES <= set(figures) and 0 <= figures["f_measure"] <= 1
            assert figures["radius"] in (0.01, 0.02)
    assert {"bounding_box", "occupancy", "height_map", "rules", "examiner"} <= set(report["baselines"])
    for functions in report["baselines"].values():
        for figures in functions.values():
            assert {"f_measure", "f_measure_fair"} <= set(figures)


@pytest.mark.slow
def test_evaluate_says_who_was_taken_for_what(call, data):
    arguments = ("evaluate", data, "--trials", 2, "--train-sizes", "half", "--radii", "2cm", "--jobs", 1)
    (result,) = json.loads(call(*arguments, "--json").stdout)["results"]
    said = result["said"]
    assert said["tested"] == sum(said["memberships"].values()) == 16  # eight in either trial
    assert said["memberships"]["none"] == sum(row["none"] for row in said["confusion"].values())
    assert said["radii"] == {name: {"0.02": 2} for name in ("cup", "sittable", "table")}
    assert "predicted none" not in call(*arguments).stdout
    printed = call(*arguments, "--confusion").stdout
    assert "8 tested" in printed and f"{said['memberships']['none'] / 2:.1f} none" in printed
    assert "radii chosen: cup 2 cm 2x" in printed


@pytest.mark.slow
def test_the_papers_method_is_evaluated_to_the_end(call, data, monkeypatch):
    monkeypatch.setattr("spherefunc_bullet.simulator.SPHERE_LIMIT", 3)

    def most(*options) -> int:
        done = call("evaluate", data, "--trials", 1, "--train-sizes", 4, "--radii", "2cm", "--jobs", 1, *options)
        assert done.returncode == 0
        return max(len(np.load(entry)["centers"]) for entry in (cache_home() / "settled").rglob("*.npz"))

    assert most("--method", "cubes") == 3 < most("--method", "paper")


@pytest.mark.slow
def test_a_batch_to_the_end_is_what_the_papers_method_reads(call, data, tmp_path):
    quick = ("--radii", "2cm", "--jobs", 1)
    assert call("batch", data, "--run", tmp_path / "run", "--method", "paper", *quick).returncode == 0

    def runs(method: str) -> int:
        arguments = ("--run", tmp_path / "run", "--trials", 1, "--train-sizes", 4, "--method", method)
        assert call("evaluate", data, *arguments, *quick).returncode == 0
        return len(list((tmp_path / "run" / "settled").rglob("*.npz")))

    assert runs("paper") == 16 and runs("cubes") == 32


@pytest.mark.slow
def test_evaluate_on_other_data(call, subset, data, tmp_path):
    (tmp_path / "manifest.csv").write_text("file,label\n" + "".join(f"{k}_3.npz,{k}\n" for k in ("cup", "table")))
    for kind in ("cup", "table"):
        (tmp_path / f"{kind}_3.npz").write_bytes((data / f"{kind}_3.npz").read_bytes())
    done = call("evaluate", subset, "--test", tmp_path, "--radii", "1cm,2cm", "--jobs", 1, "--json")
    (result,) = json.loads(done.stdout)["results"]
    assert result["train_size"] == 12
    # One cup and one table, much like those learnt; no chair is there to be found.
    found = {name: each["f_measure"] for name, each in result["functions"].items()}
    assert found == {"cup": 1, "table": 1, "sittable": 0}


@pytest.mark.slow
def test_evaluate_learns_several_data_sets_and_tests_on_another(call, subset, data):
    done = call("evaluate", subset, data, "--test", data, "--radii", "1cm,2cm", "--jobs", 1, "--json")
    (result,) = json.loads(done.stdout)["results"]
    assert result["train_size"] == 12 + 16
    check_refused(call("evaluate", subset, data), "expected one data set", "--test")


@pytest.mark.slow
def test_evaluate_goes_on_without_a_missing_file(call, data, tmp_path):
    for path in data.iterdir():
        (tmp_path / path.name).write_bytes(path.read_bytes())
    (tmp_path / "cup_3.npz").unlink()
    arguments = ("--trials", 2, "--train-sizes", "half", "--radii", "2cm", "--jobs", 1)
    done = call("evaluate", tmp_path, *arguments, "--json")
    check_refused(done, "cup_3.npz")
    assert json.loads(done.stdout)["results"][0]["train_size"] == 7


def test_evaluate_refuses_what_it_cannot_do(call, data, subset):
    quick = ("--radii", "2cm", "--jobs", 1)
    check_refused(call("evaluate", data, "--train-sizes", "20", *quick), "20", "half of the 16 objects")
    check_refused(call("evaluate", subset, "--train-sizes", "half", "--groups", *quick), "group")


def test_backends_are_listed(call):
    rows = json.loads(call("backends", "--json").stdout)
    fast = next(row for row in rows if row["name"] == "fast")
    assert fast["available"] and fast["version"] and fast["options"]
    assert "fast" in call("backends").stdout


@pytest.mark.slow
def test_catalogue_is_built(call, tmp_path):
    done = call("dataset", "build", "household", tmp_path / "set", "--json")
    assert done.returncode == 0 and json.loads(done.stdout)["objects"] == 200
    with open(tmp_path / "set" / "manifest.csv", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 200 and all((tmp_path / "set" / row["file"]).is_file() for row in rows)


def test_help_answers_at_once(run):
    """What takes seconds to load is not loaded to say how a command is used."""
    heavy = {"numpy", "scipy", "sklearn", "open3d", "trimesh", "numba", "pybullet", "joblib", "matplotlib", "PIL"}
    asked = "sys.argv = ['spherefunc', '--help']; runpy.run_module('spherefunc_bullet', run_name='__main__')"
    said = f"atexit.register(lambda: print({heavy!r} & set(sys.modules), file=sys.stderr))"
    answer = f"import atexit, runpy, sys; {said}; {asked}"
    done = subprocess.run([sys.executable, "-c", answer], capture_output=True, text=True, check=True)
    assert done.stderr.strip() == "set()"
    assert all(name in done.stdout for name in ("simulate", "train", "classify", "evaluate", "dataset", "backends"))
    assert run("--help").stdout == done.stdout


def test_wrong_usage_is_no_traceback(call):
    for arguments in (["simulate"], ["no-such-command"], ["simulate", "a.ply", "--no-such-option"]):
        done = call(*arguments)
        assert done.returncode == 2 and done.stdout == "" and "Traceback" not in done.stderr


@pytest.mark.parametrize(("radius", "named"), [(0.001, True), (0.005, False)])
def test_spheres_that_fall_between_points_are_named(tmp_path, capsys, radius, named):
    pytest.importorskip("pybullet")
    file = tmp_path / "plate.npy"
    np.save(file, clouds.plate(0.2, 0.2, 0.1).points)
    warning = "plate.npy: spheres of radius 1 mm may fall through points 4 mm apart; use at least 2.4 mm"
    drop_on_file(file, make_simulator("fast"), [DropSettings(radius=radius)], 0, "z", "m")
    assert (warning in capsys.readouterr().err) is named
    carried_file(file, make_simulator("bullet"), CarrySettings(radius=radius), 0, "z", "m")
    assert (warning in capsys.readouterr().err) is named
