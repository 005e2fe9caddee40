"""Records of labelled objects: their drops, and their shape for baselines that use no spheres."""

from __future__ import annotations

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
from .cached_runs import Check, DropConfig, cached_runs
from .drops import DropsByRadius
from .settling import falls_over

VOXEL = 0.005  # metres, side of the cubes for baselines: the resolution of clouds


def passed(name: str, check: Callable[[Cloud], bool]) -> bool:
    """Return False: without a file, no check fails."""
    return False


@dataclass(frozen=True, kw_only=True)
class ObjectRecord:
    """The record of one object: its drops, and its shape for the baselines."""

    path: Path
    size: np.ndarray  # (3,) extents of the bounding box, metres
    occupied: Callable[[], np.ndarray] = field(repr=False)  # see `voxels`; half a megabyte that most uses do not need
    settled: DropsByRadius = field(repr=False)
    seconds: dict[float, float] = field(repr=False, default_factory=dict)  # radius in metres -> wall time of the run
    drops: dict[float, int] = field(repr=False, default_factory=dict)
    memory: dict[float, int] = field(repr=False, default_factory=dict)  # peak in bytes, of the runs where it is known
    falls_over: bool = False  # when it is put down in this orientation
    check: Check = field(repr=False, default=passed)  # returns whether it fails a check

    @property
    def voxels(self) -> np.ndarray:
        """The occupied cubes of `VOXEL` metres (V, 3) int16, read again at every access."""
        return self.occupied()

    def centers(self, radius: float) -> np.ndarray:
        """Return where spheres of a radius settled (S, 3), metres."""
        return self.settled[radius].rests


def simulate_objects(
    paths: Sequence[Path],
    drop_config: DropConfig,
    *,
    jobs: int = -1,
    home: Path | None = None,
) -> Iterator[tuple[int, ObjectRecord | InputError]]:
    """Simulate the objects of files at every radius, in parallel and from the cache where it has them.

    Parameters
    ----------
    jobs : int
        Number of parallel processes; -1: one per core. With 1, this process does the work, unless the simulator
        declares that it is isolated (see `Simulator`).
    home : path, optional
        A run folder that serves as the cache (`batch`); by default the cache of the user.

    Yields
    ------
    index, outcome : int, ObjectRecord or InputError
        In the order in which they finish. A file that cannot be used yields its error, and so does one whose process
        crashed twice; the others continue.
    """
    tasks = [(path, drop_config, home) for path in paths]
    yield from run_tasks(object_record, tasks, paths, jobs=jobs, isolate=isolated(drop_config.simulator))


def simulate_by_several(
    tasks: Sequence[tuple[Path, Sequence[DropConfig]]], *, jobs: int = -1, home: Path | None = None
) -> Iterator[tuple[int, Sequence[ObjectRecord | InputError]]]:
    """Yield the results of `simulate_objects` for each file and several drop configs, which share what is loaded.

    The largest files start first, so that no process is left alone with one at the end.
    """
    order = sorted(range(len(tasks)), key=lambda index: -size_of(tasks[index][0]))
    paths, arguments = [tasks[index][0] for index in order], [(*tasks[index], home) for index in order]
    isolate = any(isolated(config.simulator) for _, drop_configs in tasks for config in drop_configs)
    for place, outcome in run_tasks(object_records, arguments, paths, jobs=jobs, isolate=isolate):
        path, drop_configs = tasks[order[place]]
        if not isinstance(outcome, InputError):
            yield order[place], outcome
        elif len(drop_configs) == 1:
            yield order[place], [outcome]
        else:  # the process died: run each config alone to see which one fails
            alone = (simulate_objects([path], each, jobs=1, home=home) for each in drop_configs)
            yield order[place], [result for results in alone for _, result in results]


def object_records(
    path: Path, drop_configs: Sequence[DropConfig], home: Path | None = None
) -> list[ObjectRecord | InputError]:
    """Return the record of one file for each drop config, or its error; the file is read and sampled once."""
    source, clouds = as_source(path), {}

    def cloud_for(drop_config: DropConfig) -> Cloud:
        """Return the cloud as a drop config loads it; configs that load it alike share one."""
        key = drop_config.loading, drop_config.run_limit.drops is None
        if key not in clouds:
            clouds[key] = drop_config.cloud(source)
        return clouds[key]

    return [attempt(object_record, (source, drop_config, home, cloud_for)) for drop_config in drop_configs]


def object_record(
    file: Path | Source,
    drop_config: DropConfig,
    home: Path | None = None,
    cloud_for: Callable[[DropConfig], Cloud] | None = None,
) -> ObjectRecord:
    """Return the record of one file, computing only what the cache or the run folder ``home`` lacks.

    Raises
    ------
    InputError
        If the file cannot be used.
    """
    source = as_source(file)
    content = drop_config.content_hash(source)
    cloud = cache(lambda: cloud_for(drop_config) if cloud_for else drop_config.cloud(source))
    of_cloud = drop_config.cloud_hash(content)
    shape = cached_shape(of_cloud, cloud, home, "size")
    runs = cached_runs(content, cloud, drop_config, home)
    return ObjectRecord(
        path=source.path,
        size=shape["size"],
        occupied=partial(file_voxels, source.path, drop_config, home),
        settled=drop_config.drops(runs),
        seconds={radius: float(run["seconds"]) for radius, run in runs.items()},
        drops={radius: int(run["drops"]) for radius, run in runs.items()},
        memory={radius: int(run["memory"]) for radius, run in runs.items() if "memory" in run},
        falls_over=cached_check(of_cloud, "falls_over", lambda: falls_over(cloud()), home),
        check=partial(file_check, source.path, drop_config, home),
    )


def cached_shape(content: str, cloud: Callable[[], Cloud], home: Path | None, *names: str) -> dict[str, np.ndarray]:
    """Return arrays by these names of the shape of the object with this hash, see `shape_of`."""
    return computed_once(entry_path("shape", content, home), lambda: shape_of(cloud()), names)


def file_voxels(path: Path, drop_config: DropConfig, home: Path | None = None) -> np.ndarray:
    """Return the cubes (V, 3) that the object of a file occupies, see `shape_of`."""
    of_cloud = drop_config.cloud_hash(drop_config.content_hash(path))
    return cached_shape(of_cloud, lambda: drop_config.cloud(path), home, "voxels")["voxels"]


def file_check(
    path: Path, drop_config: DropConfig, home: Path | None, name: str, check: Callable[[Cloud], bool]
) -> bool:
    """Return the result of a check of the cloud of a file, cached under this name."""
    of_cloud = drop_config.cloud_hash(drop_config.content_hash(path))
    return cached_check(of_cloud, name, lambda: check(drop_config.cloud(path)), home)


def shape_of(cloud: Cloud) -> dict[str, np.ndarray]:
    """Return the extents of a cloud and the cubes of `VOXEL` metres that it occupies, sorted.

    The three indices of a cube, 16 bits each, are sorted as one number, six times as fast as rows; with
    ``return_counts`` numpy sorts, thirty times as fast as the hash table that it uses otherwise.
    """
    cubes = np.floor(cloud.points / VOXEL).astype(np.int16).astype(np.int64) + 2**15
    numbers, _ = np.unique(cubes @ [2**32, 2**16, 1], return_counts=True)
    cubes = np.column_stack([numbers >> 32, numbers >> 16 & 0xFFFF, numbers & 0xFFFF]) - 2**15
    return {"size": cloud.size, "voxels": cubes.astype(np.int16)}
