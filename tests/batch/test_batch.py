"""Batches lose nothing: killed, crashed, damaged, in shards, and taken up by the other commands."""

from __future__ import annotations

import json
import os
import shutil
import signal
import sqlite3
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import batch_runs
import clouds
import numpy as np
import pytest
import trimesh
from batch_runs import SCRIPT, arrays, rows, scraps, small_objects
from ledger_speed import speed
from mishaps import MishapSimulator
from typer.testing import CliRunner

from spherefunc_bullet.batch import folder as folder_module
from spherefunc_bullet.batch import task
from spherefunc_bullet.batch.batch import Batch, ObjectLimits, run_batch
from spherefunc_bullet.batch.folder import RunFolder, is_alive, merge_runs, status
from spherefunc_bullet.batch.ledger import DONE, Ledger
from spherefunc_bullet.batch.simulated import simulate_dataset
from spherefunc_bullet.batch.task import settled_rows
from spherefunc_bullet.commands.command_line import application
from spherefunc_bullet.datasets.dataset import Dataset, DatasetObject, open_dataset, parse_shard, shard_of
from spherefunc_bullet.errors import InputError
from spherefunc_bullet.formats.npz import packed
from spherefunc_bullet.settling.cached_runs import DropConfig
from spherefunc_bullet.settling.records import simulate_objects
from spherefunc_bullet.simulator import make_simulator

pytestmark = pytest.mark.slow

BY_CUBES = ("--method", "cubes", "--radii", "1cm,2cm")
RADII = (0.01, 0.02)
OBJECTS = 8


@pytest.fixture(scope="module")
def data(tmp_path_factory):
    return small_objects(tmp_path_factory.mktemp("batch") / "data", OBJECTS)


@pytest.fixture(autouse=True)
def empty_cache(tmp_path, monkeypatch):
    monkeypatch.setenv("SPHEREFUNC_CACHE", str(tmp_path / "cache"))


@pytest.fixture(scope="module")
def undisturbed(data, tmp_path_factory):
    """Return a finished run; tests copy it before they change it."""
    run = tmp_path_factory.mktemp("run") / "run"
    assert len(finished(batch_of(data, run))) == OBJECTS
    return run


@pytest.fixture
def copy(undisturbed, tmp_path):
    return Path(shutil.copytree(undisturbed, tmp_path / "copy"))


def batch_of(data, run, **changes) -> Batch:
    batch = Batch(
        dataset=open_dataset(data), drop_config=DropConfig(simulator="fast", radii=RADII), folder=RunFolder(Path(run))
    )
    return replace(batch, drop_config=replace(batch.drop_config, **changes))


def finished(batch, **options) -> dict:
    return {each.name: each for each in run_batch(batch, jobs=1, **options)}


def counts(done) -> tuple[int, int, int]:
    """Return how many were done, failed and skipped."""
    failed = sum(bool(each.errors) for each in done.values())
    skipped = sum(each.skipped and not each.errors for each in done.values())
    return len(done) - failed - skipped, failed, skipped


def call(*arguments):
    return CliRunner().invoke(application(), [str(each) for each in arguments])


def test_every_object_at_every_radius_has_its_row_and_its_centres(data, undisturbed):
    found = rows(undisturbed)
    assert len(found) == 2 * OBJECTS and len(arrays(undisturbed)) == 2 * (OBJECTS - 1) and scraps(undisturbed) == []
    outcomes = {row[0]: row[6] for row in found}
    assert outcomes.pop("broken.ply") == "refused" and set(outcomes.values()) == {DONE}
    connection = sqlite3.connect(undisturbed / "ledger.sqlite")
    assert connection.execute("PRAGMA journal_mode").fetchone() == ("wal",)
    (seconds, memory), *_ = connection.execute("SELECT min(seconds), min(memory) FROM ledger WHERE outcome = 'done'")
    assert seconds > 0 and memory > 2**20


def test_centres_are_those_that_the_other_commands_get(data, copy):
    files = sorted(data.glob("mug*"))
    for index, record in simulate_objects(files, DropConfig(simulator="fast", radii=RADII), jobs=1):
        twin = dict(simulate_objects([files[index]], DropConfig(simulator="fast", radii=RADII), jobs=1, home=copy))[0]
        assert all(np.array_equal(record.centers(radius), twin.centers(radius)) for radius in RADII)


def test_second_call_does_nothing_again(data, copy):
    before = {path: path.stat().st_mtime_ns for path in copy.rglob("*.npz")}
    done = finished(batch_of(data, copy))
    assert counts(done) == (0, 1, OBJECTS - 1) and "broken.ply" in done["broken.ply"].errors[0]
    assert before == {path: path.stat().st_mtime_ns for path in copy.rglob("*.npz")}


def test_a_file_that_could_not_be_read_is_tried_again(data, copy, tmp_path):
    fewer = Path(shutil.copytree(data, tmp_path / "data"))
    (fewer / "mug_000.npz").unlink()
    newest = []
    for _ in range(2):
        assert counts(finished(batch_of(fewer, copy)))[1] == 2
        with RunFolder(copy).ledger() as ledger:
            newest += ledger.query("SELECT object, max(finished) FROM runs")
    assert newest[0][0] == newest[1][0] == "mug_000.npz" and newest[0] < newest[1]


def test_kill_9_changes_nothing(tmp_path):
    """At random moments, of the batch alone or of all its processes: the same rows and arrays as undisturbed.

    The seed draws each of both while it starts, and soon after a result.

    Two hundred times by hand: ``python tests/support/batch_runs.py``.
    """
    data, cache = small_objects(tmp_path / "data", 20), tmp_path / "cache"
    call("batch", data, "--run", tmp_path / "undisturbed", "--radii", "1cm,2cm", "--jobs", 1)
    expected = rows(tmp_path / "undisturbed"), arrays(tmp_path / "undisturbed")
    assert len(expected[0]) == 40 and len(expected[1]) == 38
    for run in batch_runs.disturbed(data, tmp_path, cache, kills=4, seed=2):
        assert (rows(run), arrays(run)) == expected and scraps(run) == []


def test_file_without_a_row_is_believed_if_it_is_whole(data, copy):
    """As after a kill between the two: the result is read and not simulated again."""
    connection = sqlite3.connect(copy / "ledger.sqlite")
    before = connection.execute("SELECT object, radius, seconds FROM ledger WHERE outcome = 'done'").fetchall()
    connection.execute("DELETE FROM runs")
    connection.commit()
    moved = [path for number, path in enumerate(sorted((copy / "settled").rglob("*.npz"))) if number % 2]
    for path in moved:  # not yet synced when it happened
        partial = copy / "partial" / path.relative_to(copy)
        partial.parent.mkdir(parents=True, exist_ok=True)
        path.rename(partial)
    assert counts(finished(batch_of(data, copy))) == (OBJECTS - 1, 1, 0)
    assert connection.execute("SELECT object, radius, seconds FROM ledger WHERE outcome = 'done'").fetchall() == before


@pytest.mark.parametrize("damage", ["cut", "flip", "empty", "gone", "another", "garbage in partial"])
def test_damaged_centres_are_simulated_again(data, undisturbed, copy, damage):
    path, other = sorted((copy / "settled").rglob("*.npz"))[:2]
    content = path.read_bytes()
    if damage == "gone":
        path.unlink()
    elif damage == "garbage in partial":
        partial = copy / "partial" / path.relative_to(copy)
        partial.parent.mkdir(parents=True, exist_ok=True)
        partial.write_bytes(content[:100])
        path.unlink()
    else:
        flipped = bytearray(content)
        flipped[len(content) // 2] ^= 1
        wrong = {"cut": content[:-7], "flip": bytes(flipped), "empty": b"", "another": other.read_bytes()}
        path.write_bytes(wrong[damage])
    assert counts(finished(batch_of(data, copy))) == (1, 1, OBJECTS - 2)
    assert (rows(copy), arrays(copy)) == (rows(undisturbed), arrays(undisturbed)) and scraps(copy) == []


def test_copied_run_and_data_are_recognised(data, copy, tmp_path):
    moved = Path(shutil.copytree(data, tmp_path / "elsewhere", copy_function=shutil.copyfile))
    assert counts(finished(batch_of(moved, copy))) == (0, 1, OBJECTS - 1)


def test_changed_object_is_simulated_again(data, copy, tmp_path):
    moved = Path(shutil.copytree(data, tmp_path / "elsewhere"))
    np.savez(moved / "mug_003.npz", points=clouds.mug(height=0.2).points)
    (moved / "broken.ply").unlink()
    shutil.copy(moved / "mug_003.npz", moved / "broken.ply")  # still none, but another content
    assert counts(finished(batch_of(moved, copy))) == (1, 1, OBJECTS - 2)
    assert len([row for row in rows(copy) if row[0] == "mug_003.npz"]) == 2


URDF = """<robot name="can"><link name="can">
<visual><geometry><mesh filename="can.stl"/></geometry></visual></link></robot>"""


def test_files_that_an_object_names_are_looked_at_by_size_and_time(tmp_path, monkeypatch):
    can = tmp_path / "data" / "can.urdf"
    can.parent.mkdir()
    can.write_text(URDF)
    trimesh.creation.cylinder(0.04, 0.1).export(can.with_name("can.stl"))
    dataset = Dataset("one", (DatasetObject(path=can, functions=frozenset()),), can.parent)
    drop_config, folder = DropConfig(simulator="fast", radii=(0.02, 0.03)), RunFolder(tmp_path / "run")
    batch = Batch(dataset=dataset, drop_config=drop_config, folder=folder)
    assert counts(finished(batch)) == (1, 0, 0)
    with monkeypatch.context() as context:
        context.setattr(task, "as_source", lambda path: pytest.fail(f"{path} is read again"))
        assert counts(finished(batch)) == (0, 0, 1)
    with sqlite3.connect(folder.path / "ledger.sqlite") as ledger:
        ledger.execute("UPDATE runs SET source = '123 456'")  # as earlier versions wrote it
    assert counts(finished(batch)) == (0, 0, 1)
    with monkeypatch.context() as context:
        context.setattr(task, "as_source", lambda path: pytest.fail(f"{path} is read again"))
        assert counts(finished(batch)) == (0, 0, 1)
    trimesh.creation.cylinder(0.05, 0.1).export(can.with_name("can.stl"))
    assert counts(finished(batch)) == (1, 0, 0)
    can.with_name("can.stl").unlink()
    assert counts(finished(batch)) == (0, 1, 0)


@pytest.mark.parametrize("fails", [False, True])
def test_an_object_that_changes_while_it_is_simulated_is_simulated_again(tmp_path, fails):
    path, folder = tmp_path / "data" / "mug.npz", RunFolder(tmp_path / "run")
    path.parent.mkdir()
    np.savez(path, points=clouds.mug().points)

    def work(tasks):
        outcome = InputError("it could not be read") if fails else settled_rows(tasks[0], folder)
        np.savez(path, points=clouds.mug(height=0.2).points)
        yield 0, outcome

    dataset = Dataset("one", (DatasetObject(path=path, functions=frozenset()),), path.parent)
    batch = Batch(dataset=dataset, drop_config=DropConfig(simulator="fast", radii=(0.02,)), folder=folder)
    assert counts(finished(batch, work=work)) == ((0, 1, 0) if fails else (1, 0, 0))
    assert counts(finished(batch)) == (1, 0, 0)
    assert [row[1] for row in rows(folder.path)] == [batch.drop_config.content_hash(path)]
    assert counts(finished(batch)) == (0, 0, 1)


def test_another_setting_is_another_row(data, copy):
    before = rows(copy)
    assert counts(finished(batch_of(data, copy, seed=1)))[0] == OBJECTS - 1
    assert counts(finished(batch_of(data, copy, radii=(0.03,))))[0] == OBJECTS - 1
    assert counts(finished(batch_of(data, copy, simulator=make_simulator("fast", flat_angle_deg=2.0))))[0] > 0
    assert set(before) < set(rows(copy)) and len(rows(copy)) == len(before) * 5 // 2 + len(before)


@pytest.fixture
def mishaps(tmp_path):
    """Return a function that makes a batch of objects to which something happens."""

    def batch(*names) -> Batch:
        objects = []
        for number, name in enumerate(names):
            path = tmp_path / f"{name}.npz"
            np.savez(path, points=clouds.mug(height=0.08 + 0.01 * number).points)
            objects.append(DatasetObject(path=path, functions=frozenset()))
        dataset = Dataset("mishaps", tuple(objects), tmp_path)
        folder = RunFolder(tmp_path / "run")
        return Batch(dataset=dataset, drop_config=DropConfig(simulator=MishapSimulator(), radii=(0.02,)), folder=folder)

    return batch


def test_crash_hang_hunger_and_bugs_cost_one_object_each(mishaps):
    names = ("one", "segfault", "killed", "left", "hungry", "bug", "sys_exit", "refused", "two")
    assert counts(finished(mishaps(*names), limits=ObjectLimits(memory=2**30))) == (2, 7, 0)
    batch = mishaps(*names, "sleeper")  # the only one that is left to do, however slow the machine
    assert counts(finished(batch, limits=ObjectLimits(seconds=0.3))) == (0, 8, 2)
    outcomes = {Path(row[0]).stem: (row[6], row[9]) for row in rows(batch.folder.path)}
    expected = {
        "segfault": ("crashed", "SIGSEGV"),
        "killed": ("out of memory", "SIGKILL"),
        "left": ("crashed", "exit code 3"),
        "sleeper": ("timed out", "within 0.3 s; stopped twice"),
        "hungry": ("out of memory", "1024 MiB that a worker may have"),
        "bug": ("error", "ValueError: a bug of ours (mishaps.py"),
        "sys_exit": ("error", "SystemExit: 4 (mishaps.py"),
        "refused": ("refused", "expected something else"),
    }
    for name, (outcome, words) in expected.items():
        assert outcomes[name][0] == outcome and words in outcomes[name][1], outcomes[name]
        assert outcomes[name][1].startswith(f"{name}.npz: ") and "\n" not in outcomes[name][1]
    assert outcomes["one"] == outcomes["two"] == ("done", None)


@pytest.mark.skipif(sys.platform != "linux", reason="other systems refuse such names of files")
def test_a_name_that_is_not_utf8_is_written_out(tmp_path):
    names = [os.fsdecode(name) for name in (b"caf\xe9.npy", b"broken\xe9.ply")]
    (tmp_path / "data" / "none").mkdir(parents=True)
    np.save(tmp_path / "data" / "none" / names[0], clouds.plate().points)
    (tmp_path / "data" / "none" / names[1]).write_text("x")
    batch = Batch(
        dataset=open_dataset(tmp_path / "data"),
        drop_config=DropConfig(simulator="fast", radii=(0.02,)),
        folder=RunFolder(tmp_path / "run"),
    )
    assert counts(finished(batch)) == (1, 1, 0) and counts(finished(batch)) == (0, 1, 1)
    assert {row[0] for row in rows(tmp_path / "run")} == {r"none/caf\udce9.npy", r"none/broken\udce9.ply"}


def test_a_ledger_that_cannot_be_opened_is_not_called_damaged(tmp_path):
    (tmp_path / "ledger.sqlite").mkdir()
    with pytest.raises(InputError, match="unable to open database file$"):
        RunFolder(tmp_path).ledger(make=True)


def test_failures_stay_until_they_are_to_be_tried_again(mishaps, tmp_path):
    batch = mishaps("one", "once", "left")
    cloud = tmp_path / "once.seen"
    os.chdir(tmp_path)
    assert counts(finished(batch)) == (2, 1, 0) and Path("once.seen").exists() and cloud.exists()
    assert counts(finished(batch)) == (0, 1, 2)
    again = finished(batch, retry_failed=True)
    assert counts(again) == (0, 1, 2) and not again["left.npz"].skipped


def test_radii_that_were_done_before_the_crash_are_kept(tmp_path):
    np.savez(tmp_path / "mug.npz", points=clouds.mug().points)
    dataset = Dataset("one", (DatasetObject(path=tmp_path / "mug.npz", functions=frozenset()),), tmp_path)
    batch = Batch(
        dataset=dataset,
        drop_config=DropConfig(simulator=CrashesAt3cm(), radii=(0.02, 0.03)),
        folder=RunFolder(tmp_path / "run"),
    )
    assert counts(finished(batch)) == (0, 1, 0)
    assert [(row[4], row[6]) for row in rows(tmp_path / "run")] == [(0.02, "done"), (0.03, "crashed")]


class CrashesAt3cm(MishapSimulator):
    """Dies with spheres of 3 cm."""

    def drop(self, cloud, settings, seed=0):
        if settings.radius == 0.03:
            os.abort()
        return super().drop(cloud, settings, seed)


def test_a_file_that_another_batch_keeps_at_the_same_time(tmp_path, monkeypatch):
    this, other, run, sync = RunFolder(tmp_path), RunFolder(tmp_path), "ab" * 32, folder_module.sync
    this.put(run, packed({"centers": np.zeros((2, 3), np.float32)}))

    def sync_late(path):
        monkeypatch.setattr(folder_module, "sync", sync)
        other.keep(run)
        sync(path)

    monkeypatch.setattr(folder_module, "sync", sync_late)
    assert this.keep(run)["bytes"] > 0 and len(this.find(run)["centers"]) == 2


def test_full_disk_ends_the_run_in_one_line(data, tmp_path, monkeypatch):
    run = tmp_path / "run"
    run.mkdir()
    (run / "settled").write_text("in the way")
    done = call("batch", data, "--run", run, "--radii", "2cm")
    assert isinstance(done.exception, InputError) and "settled" in str(done.exception)
    assert {row[6] for row in rows(run)} <= {"waiting", "refused"}


def test_shards_are_disjoint_and_their_merged_ledger_is_the_whole(data, undisturbed, tmp_path):
    for part in ("1/3", "2/3", "3/3"):
        run = tmp_path / part.replace("/", "_")
        done = call("batch", data, "--run", run, *BY_CUBES, "--shard", part, "--jobs", 1, "--json")
        assert json.loads(done.stdout)["done"] >= 2
    for _ in range(2):  # the second time there is nothing left to join
        done = call("batch", "merge", *tmp_path.glob("*_3"), "--run", tmp_path / "whole", "--json")
        assert done.exit_code == 0, done.stderr
    assert json.loads(done.stdout) == {"runs": 3, "merged": 0, "kept": 2 * OBJECTS}
    whole = tmp_path / "whole"
    assert (rows(whole), arrays(whole)) == (rows(undisturbed), arrays(undisturbed)) and scraps(whole) == []
    assert counts(finished(batch_of(data, whole))) == (0, 1, OBJECTS - 1)


def test_merging_takes_the_better_row_and_says_what_disagrees(data, undisturbed, copy, tmp_path):
    connection = sqlite3.connect(copy / "ledger.sqlite")
    connection.execute("UPDATE runs SET outcome = 'crashed', error = 'x' WHERE object = 'mug_001.npz'")
    connection.execute("UPDATE runs SET digest = 'other' WHERE object = 'mug_002.npz'")
    connection.commit()
    said = []
    merge_runs([RunFolder(copy), RunFolder(undisturbed)], RunFolder(tmp_path / "whole"), failed=said.append)
    assert len(said) == 2 and all("mug_002.npz" in str(error) and "damaged" in str(error) for error in said)
    assert rows(tmp_path / "whole") == rows(undisturbed)
    connection = sqlite3.connect(tmp_path / "whole" / "ledger.sqlite")
    connection.execute("UPDATE runs SET digest = 'other' WHERE object = 'mug_002.npz'")
    connection.commit()
    merge_runs([RunFolder(undisturbed)], RunFolder(tmp_path / "whole"), failed=said.append)
    assert len(said) == 4 and "same spheres" in str(said[-1])


@pytest.mark.parametrize("text", ["0/3", "4/3", "1", "a/b", "1/0", "-1/3", "1/3/4"])
def test_shards_that_are_none_are_refused(text):
    with pytest.raises(InputError, match="--shard"):
        parse_shard(text)


def test_every_object_is_in_one_shard(data):
    dataset = open_dataset(data)
    parts = [shard_of(dataset, (number, 3)).objects for number in (1, 2, 3)]
    assert sorted(str(each.path) for part in parts for each in part) == sorted(str(e.path) for e in dataset.objects)
    with pytest.raises(InputError, match="at most 8 shards"):
        shard_of(dataset, (9, 9))


def test_command_prints_the_contract_and_its_status(data, tmp_path):
    run = tmp_path / "run"
    done = call("batch", data, "--backend", "fast", "--radii", "2cm", "--run", run, "--json")
    about = json.loads(done.stdout)
    assert done.exit_code == 2 and about.pop("seconds") > 0
    assert about == {"done": OBJECTS - 1, "failed": 1, "skipped": 0} and "broken.ply" in done.stderr
    answer = json.loads(call("batch", "--run", run, "--status", "--json").stdout)
    assert (answer["objects"], answer["done"], answer["failed"], answer["waiting"]) == (OBJECTS, OBJECTS - 1, 1, 0)
    assert answer["seconds_left"] == 0 and answer["rate"] > 0 and answer["failures"][0]["object"] == "broken.ply"
    text = call("batch", "--run", run, "--status").stdout
    assert f"{OBJECTS - 1} of {OBJECTS} objects done, 1 failed, 0 waiting" in text and "refused" in text


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--run", "nowhere", "--status"], "expected a run directory"),
        (["--run", "nowhere", "--status", "--radii", "3cm"], "--radii: expected without --status"),
        (["--run", "run"], "expected DATA"),
        (["nothing", "--run", "run"], "found nothing of that name"),
        (["DATA", "--run", "DATA/manifest.csv"], "expected a folder that can be written"),
        (["DATA", "--run", "run", "--time-limit", "soon"], "expected a duration"),
        (["DATA", "--run", "run", "--memory-limit", "0"], "expected an amount of memory"),
        (["DATA", "--run", "run", "--shard", "9/8"], "--shard 9/8"),
        (["DATA", "--run", "run", "--jobs", "0"], "jobs 0"),
        (["merge", "nowhere", "--run", "run"], "expected a run directory"),
    ],
)
def test_mistakes_are_one_line(data, tmp_path, monkeypatch, arguments, words):
    monkeypatch.chdir(tmp_path)
    done = call("batch", *[each.replace("DATA", str(data)) for each in arguments])
    assert isinstance(done.exception, InputError) and words in str(done.exception)
    assert "\n" not in str(done.exception)


@pytest.mark.parametrize("damage", ["garbage", "cut", "page"])
def test_damaged_ledger_is_one_line_and_costs_no_simulation(data, undisturbed, copy, damage):
    path = copy / "ledger.sqlite"
    content = path.read_bytes()
    middle = content[:4096] + b"\xff" * 4096 + content[8192:]
    path.write_bytes({"garbage": b"no ledger " * 500, "cut": content[: len(content) // 2], "page": middle}[damage])
    with pytest.raises(InputError, match="move it away"):
        finished(batch_of(data, copy))
    path.unlink()
    before = {path: path.stat().st_mtime_ns for path in (copy / "settled").rglob("*.npz")}
    finished(batch_of(data, copy))
    assert rows(copy) == rows(undisturbed)
    assert before == {path: path.stat().st_mtime_ns for path in (copy / "settled").rglob("*.npz")}


def test_commands_take_a_run_as_their_cache(data, copy, tmp_path, monkeypatch):
    """With a simulator that cannot run: whatever is asked of it would be said."""
    before = {path: path.stat().st_mtime_ns for path in (copy / "settled").rglob("*.npz")}
    for command in (
        ["train", data, "--out", tmp_path / "model.npz", *BY_CUBES, "--jobs", 1, "--json"],
        ["evaluate", data, *BY_CUBES, "--trials", 1, "--jobs", 1, "--json"],
        ["compare", data, "--backends", "fast", *BY_CUBES, "--trials", 1, "--jobs", 1, "--json"],
    ):
        done = call(*command, "--run", copy)
        assert done.exit_code == 2 and json.loads(done.stdout)["objects"] == OBJECTS - 1, done.stderr
        assert len(done.stderr.splitlines()) == 1 and "--retry-failed" in done.stderr  # the broken one, from the ledger
    assert before == {path: path.stat().st_mtime_ns for path in (copy / "settled").rglob("*.npz")}
    assert not (tmp_path / "cache" / "settled").exists()
    done = call("train", data, "--out", tmp_path / "model.npz", "--run", tmp_path / "no-run")
    assert isinstance(done.exception, InputError) and "expected a run directory" in str(done.exception)


def test_what_hung_in_a_batch_is_not_tried_by_others(mishaps):
    batch = mishaps("one", "sleeper")
    finished(batch, limits=ObjectLimits(seconds=0.5))
    failed = []
    simulated = simulate_dataset(batch.dataset, batch.drop_config, run=batch.folder.path, failed=failed.append)
    assert len(simulated.objects) == 1 and "within 0.5 s" in str(failed[0])


@pytest.fixture(scope="module")
def many(tmp_path_factory):
    """Return a data set of which a batch is not done before somebody notices that it runs."""
    return small_objects(tmp_path_factory.mktemp("many") / "data", 150)


def recorded(run: Path) -> int:
    """Return the number of objects that a batch has recorded as done so far."""
    if not (run / "ledger.sqlite").is_file():
        return 0
    try:
        return len({row[0] for row in rows(run) if row[6] == DONE})
    except sqlite3.OperationalError:  # its tables are being made
        return 0


def test_ctrl_c_stops_at_once_and_keeps_what_is_done(many, tmp_path):
    command = [SCRIPT, "batch", many, "--run", tmp_path / "run", "--radii", "1cm,2cm", "--jobs", "1", "--json"]
    process = subprocess.Popen(
        command,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )
    while recorded(tmp_path / "run") < 1 and process.poll() is None:  # results of a worker may wait to be recorded
        time.sleep(0.01)
    process.send_signal(signal.SIGINT)
    stdout, stderr = process.communicate()
    assert process.returncode == 130 and "the same command continues" in stderr and "Traceback" not in stderr
    assert json.loads(stdout)["done"] >= 1
    with RunFolder(tmp_path / "run").ledger() as ledger:
        assert 1 <= status(ledger)["done"] < 150


def test_status_of_a_killed_run_says_that_nothing_runs(many, tmp_path):
    process = batch_runs.start_batch(many, tmp_path / "run", tmp_path / "cache")
    while batch_runs.results(tmp_path / "run") < 5 and process.poll() is None:
        time.sleep(0.01)
    with RunFolder(tmp_path / "run").ledger() as ledger:
        assert status(ledger)["running"] is True
    process.kill()
    process.wait()
    answer = json.loads(call("batch", "--run", tmp_path / "run", "--status", "--json").stdout)
    assert answer["waiting"] > 0 and answer["running"] is False and answer["seconds_left"] is None
    text = call("batch", "--run", tmp_path / "run", "--status").stdout
    assert "nothing runs" in text and "run the same command to go on" in text
    assert call("batch", many, "--shard", "1/30", "--radii", "3cm", "--run", tmp_path / "run").exit_code == 0
    answer = json.loads(call("batch", "--run", tmp_path / "run", "--status", "--json").stdout)
    assert answer["waiting"] == 0 and answer["objects"] == answer["done"] >= 5


def test_status_counts_an_object_as_waiting_that_is_simulated_again(data, copy, tmp_path):
    changed = Path(shutil.copytree(data, tmp_path / "data"))
    shutil.copyfile(changed / "mug_001.npz", changed / "mug_000.npz")
    calls = run_batch(batch_of(changed, copy), jobs=1)
    assert next(calls).skipped
    with RunFolder(copy).ledger() as ledger:
        assert status(ledger)["waiting"] == 1
    assert counts({each.name: each for each in calls})[0] == 1


def test_ledger_and_status_of_100_000_rows_stay_fast(tmp_path):
    """In seconds of the processor, which other work on the machine does not lengthen; docs/batch.md has the others."""
    measured = speed(tmp_path, 100_000, time.process_time)
    assert measured["status"] < 5 and measured["read all rows, to go on"] < 20
    assert measured["write an object's rows, synced"] < 5
    with Ledger(tmp_path / "ledger.sqlite") as ledger:
        about = status(ledger)
    assert (about["objects"], about["done"], about["waiting"]) == (20_000, 10_000, 10_000)
    assert about["runs"] == {"done": 50_000, "waiting": 50_000}


def test_a_process_that_has_ended_is_not_alive_though_nobody_has_noticed():
    process = subprocess.Popen([sys.executable, "-c", ""], stdout=subprocess.PIPE)
    process.stdout.read()  # until it ends
    for _ in range(500):
        if not is_alive(process.pid):
            break
        time.sleep(0.01)
    assert process.returncode is None and not is_alive(process.pid)
    process.wait()
    assert is_alive(os.getpid())
