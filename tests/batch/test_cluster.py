"""The same batch on executors and on a Dask cluster of real processes: the same rows and arrays, bit for bit."""

from __future__ import annotations

import json
import os
import signal
import socket
import subprocess
import sys
import threading
import time
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from multiprocessing import get_context
from pathlib import Path

import clouds
import numpy as np
import pytest
from batch_runs import SCRIPT, arrays, results, rows, scraps, small_objects
from mishaps import MishapSimulator

from spherefunc_bullet.batch.batch import Batch, ObjectLimits, run_batch
from spherefunc_bullet.batch.cluster import DaskExecutor, on_executor, on_scheduler, within
from spherefunc_bullet.batch.folder import RunFolder
from spherefunc_bullet.datasets.dataset import Dataset, DatasetObject, open_dataset
from spherefunc_bullet.errors import InputError
from spherefunc_bullet.settling.cached_runs import DropConfig

pytestmark = pytest.mark.slow

RADII = (0.01, 0.02)
OBJECTS = 16
DASK = Path(sys.executable).with_name("dask")


@pytest.fixture(scope="module")
def data(tmp_path_factory):
    return small_objects(tmp_path_factory.mktemp("cluster") / "data", OBJECTS)


@pytest.fixture(scope="module")
def expected(data, tmp_path_factory):
    """Return the rows and arrays of a run in processes of this machine."""
    run = tmp_path_factory.mktemp("here") / "run"
    list(run_batch(batch_of(data, run), jobs=2))
    return rows(run), arrays(run)


def batch_of(data, run) -> Batch:
    return Batch(
        dataset=open_dataset(data), drop_config=DropConfig(simulator="fast", radii=RADII), folder=RunFolder(run)
    )


def processes(workers):
    return ProcessPoolExecutor(workers, mp_context=get_context("spawn"))


@pytest.mark.parametrize("shared_path", [False, True])
@pytest.mark.parametrize("kind", [ThreadPoolExecutor, processes])
def test_any_executor_gives_the_same_bit_for_bit(data, expected, tmp_path, kind, shared_path):
    batch = batch_of(data, tmp_path / "run")
    with kind(2) as executor:
        done = list(run_batch(batch, work=on_executor(executor, batch.folder, shared_path=shared_path)))
    assert len(done) == OBJECTS and sum(bool(each.errors) for each in done) == 1
    assert (rows(tmp_path / "run"), arrays(tmp_path / "run")) == expected and scraps(tmp_path / "run") == []


def test_crash_on_an_executor_costs_one_object(tmp_path):
    names = ("one", "segfault", "sleeper", "two")
    for number, name in enumerate(names):
        np.savez(tmp_path / f"{name}.npz", points=clouds.mug(height=0.08 + 0.01 * number).points)
    objects = tuple(DatasetObject(path=tmp_path / f"{name}.npz", functions=frozenset()) for name in names)
    folder = RunFolder(tmp_path / "run")
    dataset = Dataset("mishaps", objects, tmp_path)
    batch = Batch(dataset=dataset, drop_config=DropConfig(simulator=MishapSimulator(), radii=(0.02,)), folder=folder)
    with ThreadPoolExecutor(2) as executor:
        list(run_batch(batch, work=on_executor(executor, folder, ObjectLimits(seconds=2.0))))
    assert [(Path(row[0]).stem, row[6]) for row in rows(tmp_path / "run")] == [
        ("one", "done"),
        ("segfault", "crashed"),
        ("sleeper", "timed out"),
        ("two", "done"),
    ]


class Cluster:
    """A scheduler and workers on this machine, as docs/batch.md starts them."""

    def __init__(self, folder: Path):
        with socket.socket() as probe:
            probe.bind(("127.0.0.1", 0))
            self.address = f"tcp://127.0.0.1:{probe.getsockname()[1]}"
        self.folder, self.processes = folder, []
        self.start("scheduler", "--host", self.address, "--dashboard-address", ":0")

    def start(self, *arguments) -> subprocess.Popen:
        command = [DASK, *map(str, arguments)]
        quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL, "cwd": self.folder}
        self.processes.append(subprocess.Popen(command, start_new_session=True, **quiet))
        return self.processes[-1]

    def add_worker(self) -> subprocess.Popen:
        return self.start("worker", self.address, "--nthreads", "1", "--no-dashboard", "--local-directory", self.folder)

    def end(self):
        for process in self.processes:
            if process.poll() is None:
                os.killpg(process.pid, signal.SIGKILL)
            process.wait()


@pytest.fixture
def cluster(tmp_path):
    pytest.importorskip("distributed", reason="dask.distributed is not installed: pip install -e '.[cluster]'")
    started = Cluster(tmp_path)
    yield started
    started.end()


def test_dask_gives_the_same_bit_for_bit_with_workers_that_come_and_go(data, expected, cluster, tmp_path):
    first, run = cluster.add_worker(), tmp_path / "run"
    how = ["--method", "cubes", "--radii", "1cm,2cm", "--json", "--scheduler", cluster.address]
    command = [SCRIPT, "batch", data, "--run", run, *how]
    batch = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    while results(run) < 4 and batch.poll() is None:
        time.sleep(0.01)
    os.killpg(first.pid, signal.SIGKILL)  # in the midst of an object
    cluster.add_worker()
    stdout, stderr = batch.communicate()
    assert stdout, stderr
    about = json.loads(stdout)
    assert (about["done"], about["failed"]) == (OBJECTS - 1, 1) and len(stderr.splitlines()) == 1, stderr
    assert (rows(run), arrays(run)) == expected and scraps(run) == []


class Gathered:
    """A client and its one future, of a task whose worker is lost once the result has been fetched."""

    status = "finished"

    def submit(self, function, *arguments, pure):
        self.value = function(*arguments)
        return self

    def add_done_callback(self, call):
        call(self)

    def result(self):
        self.status = "lost"
        return self.value


def test_what_was_fetched_counts_although_its_worker_is_lost_then():
    assert DaskExecutor(client=Gathered()).submit(abs, -2).result(timeout=0) == 2


def test_no_scheduler_is_one_line(tmp_path, monkeypatch):
    pytest.importorskip("distributed", reason="dask.distributed is not installed: pip install -e '.[cluster]'")
    monkeypatch.setattr("spherefunc_bullet.batch.cluster.PATIENCE", 1.0)
    with pytest.raises(InputError, match="expected a Dask scheduler that answers"):
        with on_scheduler("tcp://127.0.0.1:9", RunFolder(tmp_path), ObjectLimits()):
            pass


def test_a_server_that_is_no_scheduler_is_not_waited_for(tmp_path, monkeypatch):
    pytest.importorskip("distributed")
    monkeypatch.setattr("spherefunc_bullet.batch.cluster.PATIENCE", 0.5)
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = server.getsockname()[1]
        with pytest.raises(InputError, match=f"{port}: expected a Dask scheduler that answers"):
            with on_scheduler(f"tcp://127.0.0.1:{port}", RunFolder(tmp_path), ObjectLimits()):
                pass


def test_what_does_not_return_is_given_up():
    never = threading.Event()
    with pytest.raises(TimeoutError, match="no answer within 0.1 s"):
        within(0.1, never.wait)
    never.set()
    assert within(5.0, lambda: 3) == 3
