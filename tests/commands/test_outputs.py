"""What a command writes never destroys what it reads, and what it cannot do is refused before hours are spent.

Results of a library do not hold its clouds.
"""

from __future__ import annotations

import clouds
import numpy as np
import pytest
from commands import spherefunc

from spherefunc_bullet.commands.options import run_on_files
from spherefunc_bullet.commands.stand import stood_file
from spherefunc_bullet.console import Failures
from spherefunc_bullet.simulator import make_simulator
from spherefunc_bullet.simulator.mechanics import StandSettings


@pytest.fixture
def files(tmp_path):
    """Return a cloud and a mesh."""
    np.savetxt(tmp_path / "table.xyz", clouds.table().points)
    (tmp_path / "sheet.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 2 4\nf 1 3 4\nf 2 3 4\n")
    return tmp_path / "table.xyz", tmp_path / "sheet.obj"


def refused(*line) -> str:
    done = spherefunc(*line)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.startswith("spherefunc: ") and done.stderr.count("\n") == 1
    return done.stderr


@pytest.mark.parametrize(
    "line",
    [
        ["classify", "--csv"],
        ["shapes", "--csv"],
        ["poses", "--page"],
        ["places", "--page"],
        ["places", "--put", "INPUT", "--page"],
        ["together", "--page"],
    ],
    ids=" ".join,
)
def test_an_input_is_not_overwritten(files, line):
    command, *options = line
    for file in files:
        before = file.read_bytes()
        same = file.parent / "." / file.name
        words = [same if word == "INPUT" else word for word in options]
        assert "got an input" in refused(command, *files, *words, same)
        assert file.read_bytes() == before


@pytest.mark.parametrize(
    "line",
    [
        ["poses", "--page"],
        ["stand", "--picture"],
        ["carry", "--picture"],
        ["places", "--picture"],
        ["together", "--page"],
        ["shapes", "--csv"],
        ["shapes", "--report"],
    ],
    ids=" ".join,
)
def test_what_cannot_be_written_is_refused_at_once(files, line):
    command, option = line
    unread = ["missing.ply", "missing.ply"]  # nothing is said of them, since they are not read yet
    assert "that can be written" in refused(command, *unread, option, files[0] / "drawn.png")


@pytest.mark.parametrize("line", ["--port 80", "--live --out demo", "--live --backend fast", "--live --jobs 1"])
def test_options_of_the_demo_that_would_change_nothing(line):
    assert refused("demo", *line.split()).startswith(f"spherefunc: {line.removeprefix('--live ').split()[0]}: expected")


@pytest.mark.parametrize("line", ["--shared-path", "--jobs 2 --scheduler tcp://127.0.0.1:1"])
def test_options_of_a_batch_that_would_change_nothing(files, line):
    asked = refused("batch", files[0].parent, "--run", files[0].parent / "run", *line.split())
    assert asked.startswith(f"spherefunc: {line.split()[0]}: expected") and not (files[0].parent / "run").exists()


def test_a_demo_is_not_begun_where_it_cannot_be_written(files):
    assert "expected a folder that can be written" in refused("demo", "--out", files[0])


@pytest.mark.parametrize("command", ["poses", "places", "together"])
def test_a_page_does_not_replace_a_picture(files, tmp_path, command):
    drawn = tmp_path / "drawn.png"
    assert "expected another file than --picture" in refused(command, *files, "--picture", drawn, "--page", drawn)


def test_objects_that_are_too_far_apart_to_cover_with_spheres(files):
    places = f"{files[0]}@0,0", f"{files[1]}@2000,0"
    assert "expected objects within 1000 m, got 200" in refused("together", *places)
    assert "x: expected at least -1e+06 and at most 1e+06" in refused("together", files[0], f"{files[1]}@1e300,0")


@pytest.mark.parametrize("option", [["--csv", "answers.csv"], ["--explain"]])
def test_options_that_do_not_go_with_any_pose(files, option):
    assert "--any-pose: expected without --csv and --explain" in refused("classify", files[0], "--any-pose", *option)


def test_a_mesh_has_no_collision_geometry_to_compare(files):
    assert "sheet.obj: expected a file with collision geometry" in refused("shapes", files[1], "--only-collision")


@pytest.mark.parametrize("line", ["dataset select DATA DATA", "dataset impair DATA DATA", "train DATA --out LABELS"])
def test_the_labels_of_a_data_set_are_not_overwritten(files, tmp_path, line):
    manifest = tmp_path / "manifest.csv"
    manifest.write_text("file,label\ntable.xyz,table\nsheet.obj,none\n")
    names = {"DATA": tmp_path, "LABELS": manifest}
    assert "would be lost" in refused(*[names.get(word, word) for word in line.split()])
    assert manifest.read_text().startswith("file,label")


@pytest.mark.parametrize("option", ["--miss-limit", "--max-spheres"])
def test_a_limit_that_no_kernel_can_count_to(files, option):
    limit = option[2:].replace("-", "_")
    assert f"{limit}: expected at least 1 and at most 1e+18, got {10**20}" in refused(
        "simulate", files[0], option, 10**20
    )


def test_an_option_of_another_backend(files):
    assert "backend 'fast': expected options of cores" in refused("simulate", files[0], "--shape", "voxel")


def test_the_files_of_a_room_are_not_written_over_what_is_read(tmp_path):
    image, camera = tmp_path / "room.png", tmp_path / "room.json"
    for file in (image, camera):
        file.write_text("read")
    assert "room.png: expected another file" in refused("scene", image, "--out", tmp_path)
    assert "room.json: expected another file" in refused("scene", "room.ply", "--intrinsics", camera, "--out", tmp_path)
    for images in (tmp_path, tmp_path / "depth"):
        images.mkdir(exist_ok=True)
        assert "expected another folder" in refused("scene", "--frames", tmp_path, "--out", images)
    assert (image.read_text(), camera.read_text()) == ("read", "read")


def test_a_room_that_cannot_be_written_is_refused_at_once(files):
    assert "expected a folder that can be written" in refused("scene", "missing.ply", "--out", files[0])


@pytest.mark.parametrize(
    "line",
    [
        ["table.xyz", "--depth-scale", "1000"],
        ["depth.png", "--units", "mm"],
        ["scan.bag", "--units", "mm"],
        ["scan.bag", "--time", "nan"],
        ["scan.bag", "--time", "-5"],
        ["table.xyz", "--method", "paper", "--model", "any.npz", "--complete", "none"],
        ["table.xyz", "--method", "paper", "--model", "any.npz", "--proposals", "pools"],
        ["--frames", "FOLDER", "--units", "mm"],
    ],
    ids=" ".join,
)
def test_options_of_scene_that_would_change_nothing(files, line):
    words = [files[0].parent if word == "FOLDER" else word for word in line]
    options = [word for word in line if word.startswith("--")]
    assert refused("scene", *words).startswith(f"spherefunc: {options[-1]}")


def test_a_depth_scale_is_above_zero_and_of_whole_numbers(tmp_path):
    np.save(tmp_path / "depth.npy", np.ones((12, 16)))
    asked = "scene", tmp_path / "depth.npy", "--depth-scale"
    assert "--depth-scale: expected more than 0, got 0.0" in refused(*asked, 0)
    assert "--depth-scale: expected more than 0, got nan" in refused(*asked, "nan")
    assert "--depth-scale: expected with a depth image of whole numbers, got metres in depth.npy" in refused(*asked, 5)


def test_an_object_to_put_down_is_read_before_the_room(files):
    assert "missing.ply: expected a file" in refused("scene", "no_room.ply", "--put", "missing.ply")


def test_an_object_that_cannot_be_put_down_is_one_failure_of_several_files(files):
    assert "--put missing.ply: expected a file" in refused("places", files[0], files[0], "--put", "missing.ply")


@pytest.mark.parametrize("command", ["places", "scene"])
def test_an_object_to_put_down_in_millimetres_is_not_asked_for_the_others_unit(files, tmp_path, command):
    np.savetxt(tmp_path / "stool_mm.xyz", 1000 * clouds.table().points)
    said = refused(command, files[0], "--units", "mm", "--put", tmp_path / "stool_mm.xyz")
    assert "in millimetres? it is read in metres" in said and "--units" not in said


@pytest.mark.parametrize("command", ["classify", "simulate", "places"])
def test_a_folder_of_packages_that_is_none(files, command):
    wrong = files[0].parent / "packages"
    for path in (wrong, files[0]):
        assert f"--package-path {path}: expected a folder" in refused(command, files[0], "--package-path", path)


@pytest.mark.parametrize("run", [".", "run", "cup/run"])
def test_a_run_is_no_label_of_the_data_set(files, tmp_path, run):
    data = tmp_path / "data"
    (data / "cup").mkdir(parents=True)
    files[0].rename(data / "cup" / "cup.xyz")
    assert "in which folders are labels" in refused("batch", data, "--run", data / run)


@pytest.mark.parametrize("command", ["select", "impair"])
@pytest.mark.parametrize("folder", ["cup", "copies"])
def test_copies_are_no_further_objects_of_the_data_set(files, tmp_path, command, folder):
    """Copies of tables among the cups would be cups."""
    data = tmp_path / "data"
    (data / "cup").mkdir(parents=True)
    files[0].rename(data / "cup" / "cup.xyz")
    assert "in which folders are labels" in refused("dataset", command, data, data / folder)
    assert [path.name for path in data.rglob("*.*")] == ["cup.xyz"]


@pytest.mark.parametrize(
    ("line", "says"),
    [
        ("evaluate DATA --impaired --picture DATA/table.xyz/drawn.png", "that can be written"),
        ("evaluate DATA --copied 3", "--copied: expected with --impaired or --corruptions"),
        ("evaluate DATA --test DATA --trials 3", "--trials: expected without --test"),
        ("evaluate DATA --test DATA --train-sizes 5", "--train-sizes: expected without --test"),
        ("evaluate DATA --task-objects 3", "--task-objects: expected with --tasks other than labels"),
        ("evaluate DATA --test DATA --groups", "--groups: expected without --test"),
        ("evaluate DATA --test DATA --leave-one-out", "--leave-one-out: expected without --test"),
        ("rooms DATA --noise nan", "expected numbers from 0"),
        ("dataset rooms DATA DATA", "would be lost"),
        ("dataset rooms DATA DATA/table.xyz", "that can be written"),
    ],
)
def test_an_evaluation_or_a_room_is_not_begun_for_nothing(files, tmp_path, line, says):
    (tmp_path / "manifest.csv").write_text("file,label\ntable.xyz,table\nsheet.obj,none\n")
    assert says in refused(*line.replace("DATA", str(tmp_path)).split())


@pytest.mark.parametrize("drawn", [False, True])
def test_results_hold_their_clouds_only_for_a_drawing(tmp_path, drawn):
    np.savez(tmp_path / "mug.npz", points=clouds.mug().points)
    how, failures = (StandSettings(), None, 0, "z", "m"), Failures()
    files, simulator = [tmp_path / "mug.npz"], make_simulator("fast")
    [(file, (cloud, result))] = run_on_files(stood_file, files, simulator, how, "standing", failures, drawn)
    assert file == files[0] and (cloud is not None) == drawn and len(result.places)
