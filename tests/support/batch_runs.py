"""Batches of small objects: made, run, disturbed by kill -9, and compared row for row and array for array.

By hand: ``python tests/support/batch_runs.py --kills 200`` kills so many batches of 60 objects and prints what it
compared.
"""

from __future__ import annotations

import argparse
import csv
import os
import random
import signal
import sqlite3
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import clouds
import numpy as np

SCRIPT = Path(sys.executable).with_name("spherefunc")
SAME = "object, content, backend, settings, radius, seed, outcome, settled, drops, error, run, digest"
STARTUP = 1.5  # seconds until a batch has begun to simulate, at most; it is killed in that time as well
# What `spherefunc batch DATA --run DIR --radii 1cm,2cm --jobs 1` does, without a second for what only learning needs.
BATCH = """
import sys
from pathlib import Path
from spherefunc_bullet.batch.batch import Batch, run_batch
from spherefunc_bullet.batch.folder import RunFolder
from spherefunc_bullet.datasets.dataset import open_dataset
from spherefunc_bullet.settling.cached_runs import DropConfig
from spherefunc_bullet.settling.drops import DROPS, RunLimit

config = DropConfig(simulator="fast", radii=(0.01, 0.02), run_limit=RunLimit(drops=DROPS))
batch = Batch(dataset=open_dataset(sys.argv[1]), drop_config=config, folder=RunFolder(Path(sys.argv[2])))
list(run_batch(batch, jobs=1))
"""


def small_objects(folder: Path, count: int) -> Path:
    """Write so many mugs of different heights, and one file that is no model, with a manifest."""
    folder.mkdir(parents=True)
    names = [f"mug_{number:03d}.npz" for number in range(count - 1)]
    for number, name in enumerate(names):
        np.savez(folder / name, points=clouds.mug(height=0.06 + 0.0005 * number).points)
    (folder / "broken.ply").write_text("ply\nnot a model\n")
    with open(folder / "manifest.csv", "w", newline="") as file:
        rows = [(name, "cup" if number % 2 else "none") for number, name in enumerate([*names, "broken.ply"])]
        csv.writer(file).writerows([("file", "label"), *rows])
    return folder


def rows(run: Path) -> list[tuple]:
    """Return a ledger's rows but for what differs each time: seconds, memory, and when."""
    connection = sqlite3.connect(run / "ledger.sqlite")
    try:
        return connection.execute(f"SELECT {SAME} FROM ledger").fetchall()
    finally:
        connection.close()


def arrays(run: Path) -> dict[str, tuple]:
    """Return the settled centres and drops of every file of a run; what is not whole raises."""
    found = {}
    for path in (run / "settled").rglob("*.npz"):
        with np.load(path, allow_pickle=False) as entry:
            found[path.name] = (entry["centers"].tobytes(), entry["centers"].shape, int(entry["drops"]))
    return found


def scraps(run: Path) -> list[Path]:
    """Return the files that are neither results nor the ledger."""
    kept = {run / f"ledger.sqlite{ending}" for ending in ("", "-wal", "-shm")}
    files = {path for path in run.rglob("*") if path.is_file() and (run / "settled") not in path.parents}
    return sorted(files - kept)


def start_batch(data: Path, run: Path, cache: Path) -> subprocess.Popen:
    """Start a process that runs a batch on two radii, with a worker process of its own."""
    command, quiet = [sys.executable, "-P", "-c", BATCH, data, run], subprocess.DEVNULL
    environment = os.environ | {"SPHEREFUNC_CACHE": str(cache)}
    return subprocess.Popen(command, env=environment, stdout=quiet, stderr=quiet, start_new_session=True)


def results(run: Path) -> int:
    """Return how many files of centres there are, synced or not."""
    return sum(1 for _ in run.rglob("*.npz"))


def kill_somewhere(process: subprocess.Popen, run: Path, chance: random.Random) -> bool:
    """Kill a batch at a random moment, alone or with its workers; return False if it was done before.

    Half of the moments lie anywhere in the time that it takes to start, the others soon after the next result.
    """
    until, had = time.monotonic() + chance.uniform(0.0, STARTUP), results(run)
    if chance.random() < 0.5:
        while results(run) == had and process.poll() is None:
            time.sleep(0.01)
        until = time.monotonic() + chance.uniform(0.0, 0.2)
    while time.monotonic() < until and process.poll() is None:
        time.sleep(0.002)
    if process.poll() is not None:
        return False
    with_workers = chance.random() < 0.5
    (os.killpg if with_workers else os.kill)(process.pid, signal.SIGKILL)
    process.wait()
    return True


def disturbed(data: Path, folder: Path, cache: Path, kills: int, seed: int = 0) -> list[Path]:
    """Return finished runs that were killed so many times, all together; one that is done gives way to a new one."""
    chance, runs = random.Random(seed), [folder / "run_0"]
    while kills:
        if kill_somewhere(start_batch(data, runs[-1], cache), runs[-1], chance):
            kills -= 1
        elif kills:
            runs.append(folder / f"run_{len(runs)}")
    start_batch(data, runs[-1], cache).wait()
    return runs


def main():
    """Print how many runs that were killed equal one that was not."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kills", type=int, default=200)
    parser.add_argument("--objects", type=int, default=60)
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        data, cache = small_objects(folder / "data", given.objects), folder / "cache"
        start_batch(data, folder / "undisturbed", cache).wait()
        expected = rows(folder / "undisturbed"), arrays(folder / "undisturbed")
        runs = disturbed(data, folder, cache, given.kills, given.seed)
        equal = sum((rows(run), arrays(run)) == expected for run in runs)
        left = sum(len(scraps(run)) for run in runs)
    print(f"{given.kills} times kill -9 over {len(runs)} runs of {given.objects} objects at 2 radii:")
    each = f"{len(expected[0])} rows and {len(expected[1])} files each"
    print(f"{equal} of {len(runs)} equal the undisturbed run, {each}")
    print(f"{left} files are left over")
    sys.exit(equal != len(runs))


if __name__ == "__main__":
    main()
