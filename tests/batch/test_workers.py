"""A process that dies costs one task: with real crashes, in workers, batches and the console script."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import clouds
import numpy as np
import pytest
from checkout import TESTS
from mishaps import MishapSimulator, happen, surroundings

from spherefunc_bullet.errors import InputError, Unexpected
from spherefunc_bullet.processes.tasks import run_tasks
from spherefunc_bullet.settling.cached_runs import DropConfig
from spherefunc_bullet.settling.records import object_record, simulate_by_several, simulate_objects

SCRIPT = Path(sys.executable).with_name("spherefunc")
DEATHS = {
    "segfault": "SIGSEGV",
    "killed": "SIGKILL (Killed); is there enough memory?",
    "aborted": "SIGABRT",
    "left": "exit code 3",
    "left_quietly": "exit code 0",
}


def outcomes(names, **options) -> list:
    """Return what becomes of tasks of these names."""
    found = dict(run_tasks(happen, [(name,) for name in names], names, **options))
    return [found[i] for i in range(len(names))]


def processes(texts) -> set[str]:
    return {text.split()[1] for text in texts}


def is_alive(process: int) -> bool:
    """Return whether a process still runs; one that only waits for its exit code to be read does not."""
    try:
        return Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except FileNotFoundError:
        return False


@pytest.mark.parametrize("jobs", [1, 2])
def test_each_death_costs_its_own_task(jobs):
    names = [f"{each}.ply" for death in DEATHS for each in ("before", death)] + ["after.ply"]
    for name, outcome in zip(names, outcomes(names, jobs=jobs, isolate=True), strict=True):
        words = DEATHS.get(name.removesuffix(".ply"))
        if words is None:
            assert outcome.startswith(name.removesuffix(".ply"))
        else:
            assert isinstance(outcome, InputError) and words in str(outcome)
            assert str(outcome).startswith(f"{name}: ") and "\n" not in str(outcome)


def test_task_whose_process_dies_once_is_done_at_the_second_try(tmp_path):
    first, second = outcomes([tmp_path / "once.ply", "other.ply"], isolate=True)
    assert first.startswith("once") and second.startswith("other")


def test_task_that_takes_too_long_is_stopped():
    [slow] = outcomes(["sleeper.ply"], time_limit=0.3)
    assert str(slow) == "sleeper.ply: expected a result within 0.3 s; stopped twice"


@pytest.mark.slow
def test_time_limit_is_for_each_task_and_not_for_all():
    """Four seconds of sleep, in tasks that have three each and need half of one."""
    assert all(isinstance(each, str) for each in outcomes(["dozer"] * 8, time_limit=3.0))


def test_one_process_does_all_tasks_in_their_order():
    done = list(run_tasks(happen, [(f"{i}",) for i in range(20)], range(20), isolate=True))
    assert [index for index, _ in done] == list(range(20))
    assert len(processes(text for _, text in done)) == 1 and str(os.getpid()) not in processes(t for _, t in done)


def test_one_job_that_need_not_be_isolated_starts_no_process():
    assert processes(outcomes(["one", "two"], jobs=1)) == {str(os.getpid())}


def test_more_tasks_than_workers_are_all_done_once():
    done = list(run_tasks(happen, [(f"{i}",) for i in range(100)], range(100), jobs=3))
    assert sorted(index for index, _ in done) == list(range(100)) and len(processes(t for _, t in done)) <= 3
    assert all(text.split()[0] == str(index) for index, text in done)


def test_no_tasks_are_no_work():
    assert list(run_tasks(happen, [], [], jobs=2, isolate=True)) == []


@pytest.mark.parametrize("isolate", [False, True])
def test_input_errors_come_back_as_they_are(isolate):
    refused, other = outcomes(["refused.ply", "other.ply"], isolate=isolate)
    assert type(refused) is InputError and str(refused) == "refused.ply: expected something else"
    assert other.startswith("other")


@pytest.mark.parametrize("isolate", [False, True])
def test_a_bug_costs_one_task_and_says_where_it_is(isolate):
    bug, other = outcomes(["bug.ply", "other.ply"], isolate=isolate)
    assert isinstance(bug, Unexpected) and other.startswith("other")
    assert str(bug).startswith("bug.ply: expected a result, got ValueError: a bug of ours (mishaps.py, line ")


@pytest.mark.parametrize(("name", "words"), [("unpicklable", "first"), ("sys_exit", "SystemExit")])
def test_errors_that_cannot_be_sent_come_back_in_words(name, words):
    error, other = outcomes([name, "other"], isolate=True)
    assert isinstance(error, Unexpected) and words in str(error) and other.startswith("other")


def test_result_that_cannot_be_sent_is_a_bug():
    [(_, error)] = run_tasks(memoryview, [(b"bytes",)], ["bytes"], isolate=True)
    assert isinstance(error, Unexpected) and "pickle" in str(error)


def test_workers_find_what_the_caller_has_around(tmp_path, monkeypatch):
    """Also those of a second batch, whose server was started before."""
    for folder in ("a", "b"):
        (tmp_path / folder).mkdir()
        monkeypatch.chdir(tmp_path / folder)
        monkeypatch.setenv("SOME_VARIABLE", folder)
        monkeypatch.setenv("OMP_NUM_THREADS", "7")
        ((_, found),) = run_tasks(surroundings, [("SOME_VARIABLE",)], ["task"], isolate=True)
        assert found[:3] == (str(tmp_path / folder), folder, "1") and os.environ["OMP_NUM_THREADS"] == "7"


def test_abandoned_tasks_leave_no_process():
    tasks = run_tasks(happen, [("one",), ("sleeper",), ("sleeper",)], ["one", "sleeper", "sleeper"], jobs=2)
    process = int(next(tasks)[1].split()[1])
    tasks.close()
    assert not is_alive(process)


def test_jobs_that_mean_nothing_are_refused():
    with pytest.raises(InputError, match="jobs 0"):
        outcomes(["one"], jobs=0)


@pytest.fixture
def models(tmp_path, monkeypatch):
    """Return a function that writes objects of the names given, and returns their paths."""
    monkeypatch.setenv("SPHEREFUNC_CACHE", str(tmp_path / "cache"))

    def write(*names) -> list[Path]:
        paths = [tmp_path / f"{name}.npz" for name in names]
        for i, path in enumerate(paths):  # of different contents, or the cache would know what is still to happen
            np.savez(path, points=clouds.mug(height=0.08 + 0.01 * i).points)
        return paths

    return write


@pytest.mark.parametrize("jobs", [1, 2])
def test_crash_in_a_simulator_costs_one_object(models, jobs):
    paths = models("one", "segfault", "refused", "two")
    done = dict(simulate_objects(paths, DropConfig(simulator=MishapSimulator(), radii=(0.01, 0.02)), jobs=jobs))
    assert [type(done[i]).__name__ for i in range(4)] == ["ObjectRecord", "Crashed", "InputError", "ObjectRecord"]
    assert "SIGSEGV" in str(done[1]) and str(done[1]).startswith(f"{paths[1]}: ")
    assert done[3].centers(0.02).shape == (1, 3) and done[3].path == paths[3]


def test_crash_in_one_of_several_simulators_costs_that_one_the_object(models):
    paths, fast = models("one", "segfault", "two"), DropConfig(simulator="fast", radii=(0.02,))
    tasks = [(path, [fast, DropConfig(simulator=MishapSimulator(), radii=(0.02,))]) for path in paths]
    done = dict(simulate_by_several(tasks, jobs=2))
    assert [[type(one).__name__ for one in done[i]] for i in range(3)] == [
        ["ObjectRecord", "ObjectRecord"],
        ["ObjectRecord", "Crashed"],
        ["ObjectRecord", "ObjectRecord"],
    ]
    assert "SIGSEGV" in str(done[1][1]) and done[1][0].path == paths[1]


@pytest.mark.slow
def test_object_that_takes_too_long_costs_itself(models):
    slow, other = models("sleeper", "other")
    how = DropConfig(simulator=MishapSimulator(), radii=(0.02,))
    dict(simulate_objects([other], how))  # then it takes no time, however slow the machine
    done = dict(run_tasks(object_record, [(slow, how), (other, how)], [slow, other], jobs=2, time_limit=3.0))
    assert str(slow) in str(done[0]) and len(done[1].settled[0.02]) == 1


@pytest.fixture
def script(tmp_path):
    """Return a function that starts the console script where the backend `mishap` is installed."""
    about = tmp_path / "site" / "mishaps-1.dist-info"
    about.mkdir(parents=True)
    (about / "METADATA").write_text("Metadata-Version: 2.1\nName: mishaps\nVersion: 1\n")
    (about / "entry_points.txt").write_text("[spherefunc.backends]\nmishap = mishaps:MishapSimulator\n")
    folders = os.pathsep.join([str(about.parent), str(TESTS / "support")])
    environment = os.environ | {"PYTHONPATH": folders, "SPHEREFUNC_CACHE": str(tmp_path / "cache")}

    def start(*arguments, **options):
        command = [SCRIPT, *map(str, arguments)]
        streams = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
        # A test run in the background ignores SIGINT, and what it starts would as well.
        options["preexec_fn"] = lambda: signal.signal(signal.SIGINT, signal.SIG_DFL)
        return subprocess.Popen(command, env=environment, cwd=tmp_path, **streams, **options)

    return start


def test_simulate_says_which_file_crashed_and_does_the_others(models, script, tmp_path):
    models("one", "killed", "printer")
    process = script(
        "simulate", "one.npz", "killed.npz", "gone.npz", "printer.npz", "--backend", "mishap", "--json", "--out", "out"
    )
    stdout, stderr = process.communicate()
    rows = json.loads(stdout)
    assert process.returncode == 2 and [row["file"] for row in rows] == ["one.npz", "printer.npz"]
    # Several processes say these, in any order, and what is written in pieces may come apart.
    killed = re.search(r"spherefunc: killed\.npz: .*SIGKILL", stderr)
    others = ("spherefunc: gone.npz: ", "this takes long", "complained by a C library")
    assert killed and [stderr.count(text) for text in others] == [1, 1, 1] and stderr.count("spherefunc: ") == 2
    assert len(list((tmp_path / "out").glob("*.npz"))) == 2
    assert all(row["provenance"]["process"] != process.pid for row in rows)


def test_one_process_serves_all_files(models, script):
    models("one", "two", "three")
    stdout, _ = script("simulate", "one.npz", "two.npz", "three.npz", "--backend", "mishap", "--json").communicate()
    assert len({row["provenance"]["process"] for row in json.loads(stdout)}) == 1


def test_workers_load_nothing_that_lies_in_the_current_folder(models, script, tmp_path):
    """As the console script itself does not, which Python would start workers differently from."""
    models("one")
    for name in ("numpy.py", "random.py", "spherefunc_bullet.py"):
        (tmp_path / name).write_text("raise SystemExit('of the current folder')")
    process = script("simulate", "one.npz", "--backend", "mishap", "--json")
    stdout, stderr = process.communicate()
    assert process.returncode == 0, stderr
    assert [row["file"] for row in json.loads(stdout)] == ["one.npz"] and "current folder" not in stderr


def test_a_bug_in_a_backend_is_one_line_and_costs_one_object(models, script):
    models("bug", "post")
    process = script("simulate", "bug.npz", "post.npz", "--backend", "mishap", "--json")
    stdout, stderr = process.communicate()
    assert process.returncode == 2 and [row["file"] for row in json.loads(stdout)] == ["post.npz"]
    line = "spherefunc: bug.npz: backend 'mishap': expected a result, got ValueError: a bug of ours (mishaps.py, line "
    assert stderr.startswith(line) and stderr.count("\n") == 1


@pytest.mark.slow
def test_train_and_classify_survive_a_crash(models, script, tmp_path):
    files = models("cup_1", "cup_2", "cup_3", "post_1", "post_2", "segfault", "post_3")
    rows = [f"{file.name},{'cup' if 'cup' in file.name else 'none'}" for file in files]
    (tmp_path / "manifest.csv").write_text("\n".join(["file,label", *rows]))
    process = script("train", ".", "--backend", "mishap", "--radii", "2cm", "--out", "model.npz", "--json")
    stdout, stderr = process.communicate()
    assert process.returncode == 2 and json.loads(stdout)["objects"] == 6 and "segfault.npz: " in stderr, stderr
    process = script("classify", "cup_1.npz", "segfault.npz", "post_1.npz", "--model", "model.npz", "--json")
    stdout, stderr = process.communicate()
    assert process.returncode == 2 and "segfault.npz: " in stderr and len(stderr.splitlines()) == 1
    rows = json.loads(stdout)
    assert [row["file"] for row in rows] == ["cup_1.npz", "segfault.npz", "post_1.npz"]
    assert ["error" in row for row in rows] == [False, True, False]


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGKILL])
@pytest.mark.slow
def test_processes_end_with_the_script(models, script, number):
    models("sleeper")
    process = script("simulate", "sleeper.npz", "--backend", "mishap", start_new_session=True)
    assert process.stderr.readline() == "asleep\n"
    children = members(process.pid)
    os.kill(process.pid, number)
    started = time.monotonic()
    while any(is_alive(child) for child in children) and time.monotonic() - started < 50:  # a sleeper sleeps for 60
        time.sleep(0.02)
    assert process.wait() != 0 and len(children) >= 2 and not any(is_alive(child) for child in children)
    assert number != signal.SIGINT or "Traceback" not in process.stderr.read()


def members(session: int) -> list[int]:
    """Return the processes of a session other than its leader."""
    processes = [int(each.name) for each in Path("/proc").iterdir() if each.name.isdigit()]
    return [each for each in processes if each != session and session_of(each) == session]


def session_of(process: int) -> int:
    try:
        return os.getsid(process)
    except ProcessLookupError:
        return -1
