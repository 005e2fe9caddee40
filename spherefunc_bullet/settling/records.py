"""What is kept of labelled objects: where spheres settled, and their shape for the baselines that look at it alone."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import cache, partial
from pathlib import Path

import numpy as np

from ..clouds.cloud import Cloud
from ..datasets.dataset import size_of
from ..errors import InputError, attempt
from ..formats.npz import cached_check, computed_once, entry_path
from ..formats.sources import Source, as_source
from ..processes.tasks import run_tasks
from ..simulator import isolated
from .dropping import Check, Dropping, cached_runs
from .drops import DropsByRadius
from .settling import falls_over

VOXEL = 0.005  # metres: the cloud's own resolution, for the baselines that look at it alone


def passed(name: str, check: Callable[[Cloud], bool]) -> bool:
    """Return that nothing fails, where there is no file to ask."""
    return False


@dataclass(frozen=True, kw_only=True)
class ObjectRecord:
    """What is kept of one object: where spheres settled, and its shape for the baselines."""

    path: Path
    size: np.ndarray  # (3,) extents of the bounding box, metres
    occupied: Callable[[], np.ndarray] = field(repr=False)  # see `voxels`: half a megabyte, of which labels need none
    settled: DropsByRadius = field(repr=False)
    seconds: dict[float, float] = field(repr=False, default_factory=dict)  # radius in metres -> wall time of the run
    drops: dict[float, int] = field(repr=False, default_factory=dict)
    memory: dict[float, int] = field(repr=False, default_factory=dict)  # bytes at most, of the runs where it is known
    falls_over: bool = False  # when it is put down as it is
    check: Check = field(repr=False, default=passed)  # asks whether it fails a check

    @property
    def voxels(self) -> np.ndarray:
        """The occupied cubes of `VOXEL` metres (V, 3) int16, read anew whenever they are asked for."""
        return self.occupied()

    def centers(self, radius: float) -> np.ndarray:
        """Return where spheres of a radius settled (S, 3), metres."""
        return self.settled[radius].rests


def simulate_objects(
    paths: Sequence[Path], dropping: Dropping, *, jobs: int = -1, time_limit: float = math.inf, home: Path | None = None
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
    tasks = [(path, dropping, home) for path in paths]
    isolate = isolated(dropping.simulator)
    yield from run_tasks(object_record, tasks, paths, jobs=jobs, isolate=isolate, time_limit=time_limit)


def simulate_by_several(
    tasks: Sequence[tuple[Path, Sequence[Dropping]]], *, jobs: int = -1, home: Path | None = None
) -> Iterator[tuple[int, Sequence[ObjectRecord | InputError]]]:
    """Yield what `simulate_objects` does of each file for several droppings, which share what is loaded.

    The largest files are begun first, so that no process is left alone with one at the end.
    """
    first = sorted(range(len(tasks)), key=lambda index: -size_of(tasks[index][0]))
    paths, asked = [tasks[index][0] for index in first], [(*tasks[index], home) for index in first]
    isolate = any(isolated(one.simulator) for _, droppings in tasks for one in droppings)
    for place, outcome in run_tasks(object_records, asked, paths, jobs=jobs, isolate=isolate):
        path, droppings = tasks[first[place]]
        if isinstance(outcome, InputError) and len(droppings) > 1:  # the process died: whose fault it was, each says
            outcome = [one for each in droppings for _, one in simulate_objects([path], each, jobs=1, home=home)]
        yield first[place], [outcome] if isinstance(outcome, InputError) else outcome


def object_records(
    path: Path, droppings: Sequence[Dropping], home: Path | None = None
) -> list[ObjectRecord | InputError]:
    """Return the record of one file by each dropping, or why there is none; the file is read and sampled once."""
    source, clouds = as_source(path), {}

    def cloud_for(dropping: Dropping) -> Cloud:
        """Return the cloud as one dropping loads it, once for all that load it alike."""
        key = dropping.loading, dropping.length.drops is None
        if key not in clouds:
            clouds[key] = dropping.cloud(source)
        return clouds[key]

    return [attempt(object_record, (source, dropping, home, cloud_for)) for dropping in droppings]


def object_record(
    file: Path | Source,
    dropping: Dropping,
    home: Path | None = None,
    cloud_for: Callable[[Dropping], Cloud] | None = None,
) -> ObjectRecord:
    """Return the record of one file, computing only what the cache, or the run directory ``home``, lacks.

    Raises
    ------
    InputError
        If the file cannot be used.
    """
    source = as_source(file)
    content = dropping.content_hash(source)
    cloud = cache(lambda: cloud_for(dropping) if cloud_for else dropping.cloud(source))
    shape = cached_shape(content, cloud, home, "size")
    runs = cached_runs(content, cloud, dropping, home)
    return ObjectRecord(
        path=source.path,
        size=shape["size"],
        occupied=partial(file_voxels, source.path, dropping, home),
        settled=dropping.drops(runs),
        seconds={radius: float(run["seconds"]) for radius, run in runs.items()},
        drops={radius: int(run["drops"]) for radius, run in runs.items()},
        memory={radius: int(run["memory"]) for radius, run in runs.items() if "memory" in run},
        falls_over=cached_check(content, "falls_over", lambda: falls_over(cloud()), home),
        check=partial(file_check, source.path, dropping, home),
    )


def cached_shape(content: str, cloud: Callable[[], Cloud], home: Path | None, *names: str) -> dict[str, np.ndarray]:
    """Return arrays of these names of the shape of the object with this hash, see `shape_of`."""
    return computed_once(entry_path("shape", content, home), lambda: shape_of(cloud()), names)


def file_voxels(path: Path, dropping: Dropping, home: Path | None = None) -> np.ndarray:
    """Return the cubes (V, 3) that a file's object occupies, see `shape_of`."""
    content = dropping.content_hash(path)
    return cached_shape(content, lambda: dropping.cloud(path), home, "voxels")["voxels"]


def file_check(path: Path, dropping: Dropping, home: Path | None, name: str, check: Callable[[Cloud], bool]) -> bool:
    """Return the result of a check of the cloud of a file, from the cache where it has it by this name."""
    return cached_check(dropping.content_hash(path), name, lambda: check(dropping.cloud(path)), home)


def shape_of(cloud: Cloud) -> dict[str, np.ndarray]:
    """Return the extents of a cloud and the cubes of `VOXEL` metres that it occupies, sorted.

    A cube's three numbers, 16 bits each, are sorted as one, six times as quick as rows; where counts are asked numpy
    sorts, thirty times as quick as the table of hashes that it uses otherwise.
    """
    cubes = np.floor(cloud.points / VOXEL).astype(np.int16).astype(np.int64) + 2**15
    numbers, _ = np.unique(cubes @ [2**32, 2**16, 1], return_counts=True)
    cubes = np.column_stack([numbers >> 32, numbers >> 16 & 0xFFFF, numbers & 0xFFFF]) - 2**15
    return {"size": cloud.size, "voxels": cubes.astype(np.int16)}
