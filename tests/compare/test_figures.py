"""The paper's figures: the numbers are those of `evaluate`, every file is there, and bad data is refused in a line."""

from __future__ import annotations

import csv
import json
import subprocess
from pathlib import Path

import clouds
import numpy as np
import pytest
from commands import spherefunc
from PIL import Image
from typer.testing import CliRunner

from spherefunc_bullet.batch.simulated import Simulated
from spherefunc_bullet.commands.command_line import application
from spherefunc_bullet.compare.evaluation.evaluation import Evaluation, Trial, count_confusion
from spherefunc_bullet.compare.evaluation.protocol import Labels, Protocol, fitting_sizes
from spherefunc_bullet.compare.figures import typical_objects
from spherefunc_bullet.compare.figures.evaluated_data import EvaluatedData, ladder
from spherefunc_bullet.compare.figures.histogram_slice import cut_slice
from spherefunc_bullet.compare.pages.plates import look
from spherefunc_bullet.datasets.dataset import open_dataset
from spherefunc_bullet.errors import InputError
from spherefunc_bullet.learning import function_classifier
from spherefunc_bullet.learning.method import find_method
from spherefunc_bullet.settling.cached_runs import DropConfig
from spherefunc_bullet.settling.drops import resting_drops
from spherefunc_bullet.settling.records import ObjectRecord
from spherefunc_bullet.viewer.pictures import CameraView

STEMS = {
    "fig1_settled", "fig2_histogram", "fig3a_learning_curve", "fig3b_functions", "fig4_confusion", "fig5_membership",
}  # fmt: skip
RADII = ("--radii", "1cm,2cm", "--jobs", "1")


@pytest.fixture(scope="module")
def call(tmp_path_factory):
    """Return a function that does as the script does, with a cache of its own."""
    cache = tmp_path_factory.mktemp("cache")

    def spherefunc(*arguments):
        runner = CliRunner(env={"SPHEREFUNC_CACHE": str(cache)})
        done = runner.invoke(application(), [str(each) for each in arguments])
        if isinstance(done.exception, InputError):  # what `main` turns into a line and a code
            return subprocess.CompletedProcess(arguments, 2, done.stdout, f"{done.stderr}{done.exception}\n")
        assert done.exception is None or isinstance(done.exception, SystemExit), done.exception
        return subprocess.CompletedProcess(arguments, done.exit_code, done.stdout, done.stderr)

    return spherefunc


def write_data(folder: Path, shapes: dict[str, list]) -> Path:
    """Write clouds as a folder of label folders."""
    for label, several in shapes.items():
        (folder / label).mkdir(parents=True)
        for number, shape in enumerate(several):
            np.savez(folder / label / f"{label}_{number}.npz", points=shape.points)
    return folder


@pytest.fixture(scope="module")
def data(tmp_path_factory):
    """Return a data set of twelve small objects with labels of its own, and a file that cannot be read."""
    shapes = {
        "shelf": [clouds.plate(0.12 + 0.01 * k, 0.12, 0.1 + 0.01 * k) for k in range(4)],
        "mug": [clouds.mug(0.04 + 0.002 * k, 0.08 + 0.005 * k) for k in range(4)],
        "none": [clouds.bin_(0.1 + 0.01 * k, 0.1, 0.02 + 0.01 * k) for k in range(4)],
    }
    folder = write_data(tmp_path_factory.mktemp("data") / "kitchen", shapes)
    (folder / "none" / "broken.ply").write_text("no geometry")
    return folder


@pytest.fixture(scope="module")
def drawn(call, data, tmp_path_factory):
    """Return the folder of figures and what the command printed."""
    out = tmp_path_factory.mktemp("out") / "figures"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(typical_objects, "VIEW", CameraView(size=(140, 118)))  # a sixteenth of the rays
        protocol = ("--train-sizes", "4,45", "--trials", 3, "--seed", 5)
        done = call("figures", data, "--out", out, *protocol, "--json", *RADII)
    return out, done


def rows_of(folder: Path, stem: str) -> list[dict]:
    """Return a figure's numbers."""
    with open(folder / f"{stem}.csv", newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


@pytest.mark.slow
def test_every_figure_is_written_in_every_form(drawn):
    out, done = drawn
    written = {Path(path) for path in json.loads(done.stdout)}
    assert written == set(out.iterdir())
    for ending in (".png", ".svg", ".csv"):
        assert {path.stem for path in written if path.suffix == ending} == STEMS
    for path in written:
        assert path.stat().st_size > 0


@pytest.mark.slow
@pytest.mark.parametrize("stem", sorted(STEMS))
def test_figures_are_not_blank_and_as_wide_as_a_column(drawn, stem):
    image = Image.open(drawn[0] / f"{stem}.png")
    assert round(image.info["dpi"][0]) == 300
    inches = image.width / 300
    assert min(abs(inches - width) for width in (3.5, 5.4, 7.16)) < 0.01
    grey = np.asarray(image.convert("L"))
    assert (grey < 128).mean() > 0.002  # ink: less than that is an empty frame
    words = (drawn[0] / f"{stem}.svg").read_text(encoding="utf-8")
    assert "<text" in words  # searchable, and a journal may set it in its own face


@pytest.mark.slow
def test_a_broken_file_is_said_and_left_out(drawn):
    out, done = drawn
    assert done.returncode == 2 and "broken.ply" in done.stderr
    about = json.loads((out / "figures.json").read_text(encoding="utf-8"))
    assert about["objects"] == 12 and about["files_left_out"] == 1 and about["seed"] == 5


@pytest.mark.slow
def test_a_size_that_does_not_fit_is_said_and_replaced(drawn):
    out, done = drawn
    assert "45 training examples are more than half of the 12 objects; drawn with 6 instead" in done.stderr
    assert {row["train_size"] for row in rows_of(out, "fig4_confusion")} == {"4", "6"}


@pytest.mark.slow
def test_numbers_are_those_of_evaluate(call, data, drawn, monkeypatch):
    monkeypatch.setattr(function_classifier, "TREES", 8)  # forests stand beside, and are not looked at
    protocol = ("--train-sizes", "4,6", "--trials", 3, "--seed", 5, "--leave-one-out")
    done = call("evaluate", data, "--method", "cubes", *protocol, "--json", *RADII)
    results = json.loads(done.stdout)["results"]
    curve = {(row["train_size"], row["function"]): row for row in rows_of(drawn[0], "fig3a_learning_curve")}
    for each in results[:2]:
        for name, expected in each["functions"].items():
            row = curve[str(each["train_size"]), name]
            assert {key: float(row[key]) for key in expected} == expected
    quality = {row["function"]: row for row in rows_of(drawn[0], "fig3b_functions")}
    for name, expected in results[1]["functions"].items():
        assert {key: float(quality[name][key]) for key in expected} == expected
        assert sum(int(quality[name][f"trials_choosing_{radius}"]) for radius in ("1cm", "2cm")) == 3
    check_membership(rows_of(drawn[0], "fig5_membership"), results[2]["functions"])


def check_membership(rows: list[dict], expected: dict):
    """Check that every object is there, once for each function, and that their sum is evaluate's accuracy."""
    for name, figures in expected.items():
        own = [row for row in rows if row["function"] == name]
        assert len(own) == len({row["file"] for row in own}) == 12
        right = [row["said"] == row["labelled"] for row in own]
        assert np.mean(right) == pytest.approx(figures["accuracy"], abs=1e-4)  # rounded there


@pytest.mark.slow
def test_a_function_that_is_not_the_papers_has_no_number_of_it(drawn):
    assert {row["paper_f_measure"] for row in rows_of(drawn[0], "fig3b_functions")} == {""}


@pytest.mark.parametrize(
    ("shapes", "words"),
    [
        ({"table": [clouds.plate()] * 6}, "at least two labels"),
        ({"table": [clouds.plate()], "none": [clouds.plate()] * 2}, "at least 4 objects"),
    ],
)
def test_data_that_cannot_be_split_is_refused_before_anything_is_written(call, tmp_path, shapes, words):
    done = call("figures", write_data(tmp_path / "data", shapes), "--out", tmp_path / "out", *RADII)
    assert done.returncode == 2 and words in done.stderr and len(done.stderr.splitlines()) == 1
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("labels", "options", "words"),
    [
        (("table", "table"), (), "at least two labels"),
        (("table", "none"), ("--groups",), "--groups: expected a manifest"),
        (("table", "none"), ("--train-sizes", "9"), "--train-sizes 9: expected from 2 to 4"),
        (("table", "none"), ("--test", "missing"), "missing"),
    ],
)
def test_what_evaluate_cannot_split_is_refused_before_spheres_fall(call, tmp_path, monkeypatch, labels, options, words):
    monkeypatch.setattr("spherefunc_bullet.batch.simulated.simulate_dataset", lambda *_, **__: pytest.fail("it fell"))
    data = write_data(tmp_path, {"first": [clouds.plate()] * 4, "second": [clouds.plate()] * 4})
    rows = [f"{path.relative_to(data)},{labels[path.parent.name == 'second']}" for path in sorted(data.rglob("*.npz"))]
    (data / "manifest.csv").write_text("\n".join(["file,label", *rows]) + "\n")
    done = call("evaluate", data, *options, *RADII)
    assert done.returncode == 2 and words in done.stderr and len(done.stderr.splitlines()) == 1


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--backend", "mujoco"), "mujoco"),
        (("--train-sizes", "few"), "expected numbers and half"),
        (("--train-sizes", "1"), "expected numbers from 2"),
    ],
)
def test_options_that_mean_nothing_are_refused(call, data, tmp_path, options, words):
    done = call("figures", data, "--out", tmp_path / "out", *options, *RADII)
    assert done.returncode == 2 and words in done.stderr and len(done.stderr.splitlines()) == 1


def test_a_folder_that_cannot_be_made_is_refused(call, data, tmp_path):
    (tmp_path / "file").write_text("in the way")
    done = call("figures", data, "--out", tmp_path / "file", *RADII)
    assert done.returncode == 2 and "expected a folder" in done.stderr


def test_sizes_that_do_not_fit_become_half():
    assert fitting_sizes("20,45,85", 200) == ((20, 45, 85), [])
    assert fitting_sizes("20,45,85", 100) == ((20, 45, 50), [85])
    assert fitting_sizes("20,half", 30) == ((15,), [20])


def test_the_ladder_ends_at_half_and_holds_the_papers_sizes():
    steps = ladder(200, (20, 45, 85))
    assert steps[-1] == 100 and {20, 45, 85} <= set(steps) and steps == sorted(steps)


def test_an_object_said_to_have_two_functions_counts_in_each():
    labels = Labels(("cup", "table"), np.array([[1, 0], [0, 0]], bool), np.zeros((2, 2), bool), np.array(["", ""]))
    both, neither = (
        Trial(learnt=1, rows=np.array([row]), scores=np.array([scores]), weights=[])
        for row, scores in enumerate(([0.9, 0.8], [0.1, 0.2]))
    )
    confusion = count_confusion(labels, both, neither, neither)
    assert confusion.labels == ("cup", "table", "none")
    assert confusion.counts.tolist() == [[1, 1, 0], [0, 0, 0], [0, 0, 2]]
    assert confusion.objects.tolist() == [1, 0, 2]


def test_no_two_functions_look_alike():
    assert len({json.dumps(look(index)) for index in range(28)}) == 28


def test_the_slice_counts_the_cubes_of_the_middle_layer(data):
    # Cubes of 7 cm: three spheres in the middle one on the floor, one above it, one to the right, one out of the layer.
    centers = np.array([[0, 0, 0.01], [0.01, 0, 0.01], [0, 0.03, 0.06], [0, 0, 0.08], [0.05, 0, 0.01], [0, 0.05, 0.01]])
    record = ObjectRecord(
        path=Path("x"),
        size=np.full(3, 0.5),
        occupied=lambda: np.empty((0, 3)),
        settled={0.01: resting_drops(0.01, centers)},
        seconds={},
        drops={},
    )
    labels = Labels((), np.empty((1, 0), bool), np.empty((1, 0), bool), np.array([""]))
    evaluated = EvaluatedData(
        simulated=Simulated("one", open_dataset(data).objects[:1], (record,)),
        drop_config=DropConfig(simulator="fast", radii=(0.01,)),
        protocol=Protocol(train_sizes=(2,)),
        evaluation=Evaluation(labels=labels, method=find_method("cubes"), trials={}, left_out={}),
    )
    cut = cut_slice(evaluated, 0, axis=0)
    counted = {tuple(cube): count for cube, count in zip(cut.cubes.tolist(), cut.counts.tolist(), strict=True)}
    assert counted == {(0, 0): 3, (0, 1): 1, (1, 0): 1}


def test_objects_on_both_sides_of_a_split_are_named(tmp_path, monkeypatch):
    monkeypatch.setenv("SPHEREFUNC_CACHE", str(tmp_path / "cache"))
    folder, rows = tmp_path / "data", ["file,label,group"]
    folder.mkdir()
    for i in range(3):
        for shape, label in ((clouds.mug(radius=0.035 + 0.003 * i), "cup"), (clouds.plate(0.2 + 0.02 * i), "table")):
            np.save(folder / f"{shape.name}_{i}.npy", shape.points)
            rows.append(f"{shape.name}_{i}.npy,{label},{i}")
    (folder / "manifest.csv").write_text("\n".join(rows))
    how = "--radii", "2cm", "--jobs", 1
    split = *how, "--train-sizes", "half", "--trials", 1
    assert "geometry" not in spherefunc("evaluate", folder, *split).stderr
    np.savez(folder / "again.npz", points=clouds.mug(radius=0.038).points)
    (folder / "manifest.csv").write_text("\n".join([*rows, "again.npz,cup,0"]))
    again = f"{folder / 'mug_1.npy'} and {folder / 'again.npz'}"
    said = spherefunc("evaluate", folder, *split).stderr
    assert f"data: 1 of 7 objects have the geometry of others, such as {again};" in said and "by --groups" in said
    said = spherefunc("evaluate", folder, "--test", folder, *how).stderr
    assert "7 of 7 objects have the geometry of others" in said and "leave them out of one" in said
