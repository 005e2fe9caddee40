"""Objects and their settled spheres: each simulated once per radius, and kept by content.

A cache entry is named for the hash of everything that decides it: the file's bytes, how it was loaded, the
backend with its version and options, the radius, the limits and the seed.
"""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass, field
from functools import cache
from pathlib import Path

import numpy as np

from ..clouds.cloud import Cloud, load_cloud
from ..errors import InputError, one_line
from ..formats.limits import require_file
from ..processes.tasks import run_tasks
from ..simulator import Simulator, isolated, make_simulator
from .cache import entry_path, read_entry, write_entry
from .settling import drop_settings, measured_run

FORMAT = 1  # of the cache; another number, other entries
VOXEL = 0.005  # metres: the cloud's own resolution, for the baselines that look at it alone


@dataclass(frozen=True, kw_only=True)
class Loading:
    """How files become clouds."""

    up: str = "z"
    units: str = "m"


@dataclass(frozen=True, kw_only=True)
class ObjectRecord:
    """What is kept of one object: where spheres settled, and its shape for the baselines."""

    path: Path
    size: np.ndarray  # (3,) extents of the bounding box, metres
    voxels: np.ndarray  # (V, 3) int16, the occupied cubes of VOXEL metres
    settled: dict[float, np.ndarray] = field(repr=False)  # radius in metres -> centres (S, 3) float32, metres
    seconds: dict[float, float] = field(repr=False)  # radius in metres -> wall time of the simulation
    drops: dict[float, int] = field(repr=False)
    memory: dict[float, int] = field(repr=False, default_factory=dict)  # bytes at most, of the runs where it is known


def simulate_objects(
    paths: Sequence[Path],
    simulator: str | Simulator,
    radii: Sequence[float],
    *,
    seed: int = 0,
    loading: Loading | None = None,
    jobs: int = -1,
    time_limit: float = math.inf,
    home: Path | None = None,
) -> Iterator[tuple[int, ObjectRecord | InputError]]:
    """Simulate the objects of files at every radius, in parallel and from the cache where it has them.

    Parameters
    ----------
    jobs : int
        Processes that work at once; -1: one per core. One alone is this process, unless the simulator is declared
        to be isolated (see `Simulator`) or there is a time limit.
    time_limit : float
        Seconds one object may take, all radii together.
    home : path, optional
        A run directory that is the cache (`batch`); by default the user's.

    Yields
    ------
    index, outcome : int, ObjectRecord or InputError
        In the order in which they are done. A file that cannot be used yields its error, and so does one whose
        process crashed twice or took too long; the rest goes on.
    """
    simulator, loading = make_simulator(simulator), loading or Loading()
    tasks = [(path, simulator, tuple(radii), seed, loading, home) for path in paths]
    yield from run_tasks(object_record, tasks, paths, jobs=jobs, isolate=isolated(simulator), time_limit=time_limit)


def object_record(
    path: Path, simulator: Simulator, radii: Iterable[float], seed: int, loading: Loading, home: Path | None = None
) -> ObjectRecord:
    """Return the record of one file, computing only what the cache, or the run directory ``home``, lacks.

    Raises
    ------
    InputError
        If the file cannot be used.
    """
    object_hash = content_hash(path, loading)

    @cache
    def cloud() -> Cloud:
        return load_cloud(path, up=loading.up, units=loading.units)

    shape = computed_once(entry_path("shape", object_hash, home), lambda: shape_of(cloud()))
    runs = {}
    for radius in radii:
        entry = entry_path("settled", run_hash(object_hash, simulator, radius, seed), home)
        runs[radius] = computed_once(entry, lambda radius=radius: measured_run(cloud(), simulator, radius, seed))
    return ObjectRecord(
        path=path,
        size=shape["size"],
        voxels=shape["voxels"],
        settled={radius: run["centers"] for radius, run in runs.items()},
        seconds={radius: float(run["seconds"]) for radius, run in runs.items()},
        drops={radius: int(run["drops"]) for radius, run in runs.items()},
        memory={radius: int(run["memory"]) for radius, run in runs.items() if "memory" in run},
    )


def computed_once(entry: Path, compute: Callable[[], dict[str, np.ndarray]]) -> dict[str, np.ndarray]:
    """Return the arrays of an entry; where there is none they are computed and kept."""
    arrays = read_entry(entry)
    if arrays is None:
        arrays = compute()
        write_entry(entry, arrays)
    return arrays


def shape_of(cloud: Cloud) -> dict[str, np.ndarray]:
    """Return the extents of a cloud and the cubes of `VOXEL` metres that it occupies, sorted.

    A cube's three numbers, 16 bits each, are sorted as one: six times as quick as rows.
    """
    cubes = np.floor(cloud.points / VOXEL).astype(np.int16).astype(np.int64) + 2**15
    numbers = np.unique(cubes @ [2**32, 2**16, 1])
    cubes = np.column_stack([numbers >> 32, numbers >> 16 & 0xFFFF, numbers & 0xFFFF]) - 2**15
    return {"size": cloud.size, "voxels": cubes.astype(np.int16)}


def content_hash(path: Path, loading: Loading) -> str:
    """Return the hash of a file's bytes and of how it is loaded.

    A glTF file keeps its geometry in ``.bin`` files beside it, so those count as well.

    Raises
    ------
    InputError
        If it is no file that would be read: none, too large, a pipe.
    """
    digest = hashlib.sha256(f"{FORMAT} {Path(path).suffix.lower()} {asdict(loading)}".encode())
    for part in file_parts(path):
        try:
            require_file(part, one_line(part))
            with open(part, "rb") as file:
                digest.update(hashlib.file_digest(file, "sha256").digest())
        except OSError as error:
            raise InputError(f"{one_line(part)}: expected a file that can be read; {error.strerror}") from error
    return digest.hexdigest()


def file_parts(path: Path) -> list[Path]:
    """Return the files that hold an object: the file, and with a glTF file what lies beside it."""
    path = Path(path)
    return [path, *sorted(path.parent.glob("*.bin"))] if path.suffix.lower() == ".gltf" else [path]


def run_hash(object_hash: str, simulator: Simulator, radius: float, seed: int) -> str:
    """Return the hash of one run."""
    run = [object_hash, simulator.name, simulator.version, simulator.options(), round(radius, 9), seed]
    run.append(asdict(drop_settings(simulator, radius)))
    return hashlib.sha256(json.dumps(run, sort_keys=True, default=str).encode()).hexdigest()
