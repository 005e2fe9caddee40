"""Sources left out in turn: the quantities that a model has kept say what spheres say that are dropped anew."""

from __future__ import annotations

import json
from pathlib import Path
from unittest import mock

import pytest
import typer
from catalogues import household
from commands import ended, spherefunc

from spherefunc_bullet.compare.evaluation.robustness import exam, steadiness
from spherefunc_bullet.compare.evaluation.robustness.across_sources import main
from spherefunc_bullet.datasets.catalogue import COLUMNS, write_manifest
from spherefunc_bullet.formats.files import write_bytes
from spherefunc_bullet.learning import function_classifier

LABELS = {"cup": 6, "table": 6, "none": 6}  # objects of each
FEW = 20  # trees


@pytest.fixture(scope="module")
def data(tmp_path_factory) -> Path:
    """Objects of three people, whose licence is stated."""
    folder, rows, left = tmp_path_factory.mktemp("data"), [], dict(LABELS)
    for item in household():
        if left.get(item.label, 0):
            left[item.label] -= 1
            write_bytes(folder / f"{item.name}.ply", item.mesh.export(file_type="ply", encoding="binary"))
            rows.append((f"{item.name}.ply", item.label, "", item.category, "abc"[left[item.label] % 3], "CC0"))
    write_manifest(folder, (*COLUMNS, "license"), rows)
    return folder


@pytest.fixture(scope="module")
def model(data, tmp_path_factory) -> Path:
    """A model that has learnt them, with few trees."""
    path = tmp_path_factory.mktemp("model") / "model.npz"
    with mock.patch.object(function_classifier, "TREES", FEW):
        assert spherefunc("train", data, "--out", path, "--jobs", 1).returncode == 0
    return path


def measured(main, *arguments: object):
    """Run a measurement in this process."""
    app = typer.Typer(pretty_exceptions_enable=False)
    app.command()(main)
    with mock.patch.object(function_classifier, "TREES", FEW):
        return ended(lambda: app([*map(str, arguments), "--json"], prog_name="measured"))


def across_sources(*arguments: object):
    """Leave sources out."""
    return measured(main, *arguments, "--jobs", "1")


@pytest.mark.slow
def test_what_a_model_has_kept_says_what_simulating_says(data, model):
    simulated, kept = across_sources(data), across_sources(data, "--model", model)
    assert simulated.returncode == kept.returncode == 0, simulated.stderr + kept.stderr
    assert json.loads(kept.stdout) == json.loads(simulated.stdout)
    report = json.loads(kept.stdout)
    assert report["objects"] == report["data_sets"][data.name]["objects"] == sum(LABELS.values())
    assert report["data_sets"][data.name]["f_measure"] == report["f_measure_fair"]


@pytest.mark.slow
def test_copies_that_are_only_tested_are_not_learnt(data, model, tmp_path):
    copies = tmp_path / "copies"
    assert spherefunc("dataset", "impair", data, copies, "--copied", 2, "--kinds", "toppled").returncode == 0
    alone, tested = (across_sources(data, "--model", model, *more) for more in ([], ["--tested", copies]))
    assert alone.returncode == tested.returncode == 0, alone.stderr + tested.stderr
    kinds = json.loads(tested.stdout)["kinds"]
    of_copies = {kind: kinds.pop(kind) for kind in list(kinds) if kind.endswith(", not learnt")}
    assert json.loads(tested.stdout) | {"kinds": kinds} == json.loads(alone.stdout)
    assert {kind: row["objects"] for kind, row in of_copies.items()} == {
        "whole, not learnt": 4,  # cups and tables
        "toppled, not learnt": 2,
    }


def test_a_model_of_other_objects_is_refused(data, model, tmp_path):
    manifest = (data / "manifest.csv").read_text().splitlines()[:-1]
    (tmp_path / "manifest.csv").write_text("\n".join(manifest) + "\n")
    for name in (line.split(",")[0] for line in manifest[1:]):
        (tmp_path / name).write_bytes((data / name).read_bytes())
    refused = across_sources(tmp_path, "--model", model)
    assert refused.returncode == 2 and f"that has learnt the {len(manifest) - 1} objects" in refused.stderr


def test_data_without_a_source_is_refused():
    refused = across_sources("household")
    assert refused.returncode == 2 and "household: expected objects of other people" in refused.stderr


@pytest.mark.slow
def test_an_exam_says_which_answers_of_a_ready_model_are_wrong(data, model, tmp_path):
    manifest = (data / "manifest.csv").read_text()
    for path in data.glob("*.ply"):
        (tmp_path / path.name).write_bytes(path.read_bytes())
    (tmp_path / "manifest.csv").write_text(manifest.replace(",table,", ",none,", 1))
    right, wrong = (measured(exam.main, folder, "--model", model) for folder in (data, tmp_path))
    assert right.returncode == wrong.returncode == 0, right.stderr + wrong.stderr
    assert json.loads(right.stdout)["f_measure_fair"] == {"cup": 1.0, "table": 1.0}
    mislabelled = next(line.split(",")[0] for line in manifest.splitlines() if ",table," in line)
    assert [(row["file"], row["label"], row["answer"]) for row in json.loads(wrong.stdout)["wrong"]] == [
        (mislabelled, "none", "table")
    ]


@pytest.mark.slow
def test_an_exam_goes_on_where_a_file_cannot_be_read_and_knows_its_labels(data, model, tmp_path):
    manifest = (data / "manifest.csv").read_text()
    for path in data.glob("*.ply"):
        (tmp_path / path.name).write_bytes(path.read_bytes())
    (tmp_path / "manifest.csv").write_text(manifest)
    damaged = tmp_path / manifest.splitlines()[1].split(",")[0]
    damaged.write_bytes(b"ply\nformat")
    said = measured(exam.main, tmp_path, "--model", model)
    assert said.returncode == 2 and said.stderr.count("\n") == 1 and damaged.name in said.stderr
    assert json.loads(said.stdout)["objects"] == sum(LABELS.values()) - 1
    (tmp_path / "manifest.csv").write_text(manifest.replace(",table,", ",shelf,"))
    refused = measured(exam.main, tmp_path, "--model", model)
    assert refused.returncode == 2 and "'shelf': expected some of cup, table" in refused.stderr


@pytest.mark.slow
def test_steadiness_compares_answers_about_an_object_turned_moved_and_with_other_spheres(data, model, tmp_path):
    (tmp_path / "manifest.csv").write_text((data / "manifest.csv").read_text())
    for path in data.glob("*.ply"):
        (tmp_path / path.name).write_bytes(path.read_bytes())
    damaged = next(data.glob("*.ply")).name
    (tmp_path / damaged).write_bytes(b"ply\nformat")
    said = measured(steadiness.main, tmp_path, "--model", model, "--times", "3")
    assert said.returncode == 2 and said.stderr.count("\n") == 1 and damaged in said.stderr
    report = json.loads(said.stdout)
    assert report["objects"] == len(report["rows"]) == sum(LABELS.values()) - 1
    assert report["changes"] == sum(len(row["answers"]) > 1 for row in report["rows"])
    assert report["sure_change"] <= report["changes"] and 0 < report["deviation"] < 0.2
