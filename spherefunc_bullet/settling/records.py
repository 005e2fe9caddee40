"""Objects and their settled spheres: each simulated once per radius, and kept by content.

A cache entry is named for the hash of everything that decides it: the file's bytes, how it was loaded, the
backend with its version and options, the radius, the limits and the seed.
"""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass, field, replace
from functools import cache, partial
from pathlib import Path
from typing import Any

import numpy as np

from ..clouds.cloud import Cloud, load_cloud
from ..clouds.orientation import Report, promised_up
from ..errors import InputError, attempt
from ..formats.sources import Source, as_source
from ..formats.units import BY_FILE
from ..processes.tasks import run_tasks
from ..simulator import Simulator, isolated, make_simulator, provenance_of
from .cache import computed_once, entry_path, kept_answer
from .drops import LIMITED, DropsByRadius, RunLimit, drops_from_rows
from .settling import drop_settings, loses_water, measured_run

FORMAT = 2  # of the cache; another number, other entries
Runs = dict[float, dict[str, np.ndarray]]  # radius in metres -> what comes of its run
VOXEL = 0.005  # metres: the cloud's own resolution, for the baselines that look at it alone


@dataclass(frozen=True, kw_only=True)
class Loading:
    """How files become clouds."""

    up: str = BY_FILE
    units: str = "m"

    def of(self, path: Path) -> Loading:
        """Return how one file is loaded, with the axis that its format promises where that decides."""
        return replace(self, up=promised_up(path)) if self.up == BY_FILE else self

    def kept(self) -> dict[str, str]:
        """Return what a run's folder keeps of it: files whose format promises nothing are as they were with z."""
        return asdict(self.of(Path()))


@dataclass(frozen=True, kw_only=True)
class Dropping:
    """How spheres are dropped on objects: all that decides where they settle but the object."""

    simulator: str | Simulator
    radii: tuple[float, ...]  # metres
    seed: int = 0
    loading: Loading = field(default_factory=Loading)
    length: RunLimit = LIMITED  # of runs

    def __post_init__(self):
        object.__setattr__(self, "simulator", make_simulator(self.simulator))
        object.__setattr__(self, "radii", tuple(self.radii))

    def cloud(self, file: Path | Source, report: Report | None = None) -> Cloud:
        """Return a file's cloud as spheres meet it; see `load_cloud` and `prepared`."""
        return self.prepared(load_cloud(file, up=self.loading.up, units=self.loading.units, report=report))

    def prepared(self, cloud: Cloud) -> Cloud:
        """Return a cloud as spheres meet it: as it is in runs to the end, and prepared where few drops are to tell."""
        if self.length.drops is None:
            return cloud
        from .preparation import prepare  # not where all that is read was kept

        return prepare(cloud)

    def content_hash(self, file: Path | Source) -> str:
        """Return the hash of the bytes of a file, and of all files that it names, and of how it is loaded.

        Of a source whose cloud is made afterwards, it is the hash of the very bytes that were read.

        Raises
        ------
        InputError
            If it is no file that would be read: none, too large, a pipe; or if one that it names is not.
        """
        source = as_source(file)
        digest = hashlib.sha256(f"{FORMAT} {source.kind} {asdict(self.loading.of(source.path))}".encode())
        for part in source.digests():
            digest.update(part)
        return digest.hexdigest()

    def run(self, cloud: Cloud, radius: float) -> dict[str, np.ndarray]:
        """Return what comes of the run of one radius; see `measured_run`."""
        return measured_run(cloud, self.simulator, radius, self.seed, self.length)

    def drops(self, runs: Runs) -> DropsByRadius:
        """Return the drops of runs."""
        drops = {}
        for radius, run in runs.items():
            made_by = provenance_of(self.simulator, drop_settings(self.simulator, radius, self.length), self.seed)
            drops[radius] = drops_from_rows(radius, run["centers"], run.get("outcomes"), provenance=made_by)
        return drops

    def settings(self, radius: float) -> dict[str, Any]:
        """Return the settings of the runs of one radius, without limits that are not set."""
        settings = asdict(drop_settings(self.simulator, radius, self.length))
        return {name: value for name, value in settings.items() if value is not None}

    def run_hash(self, content: str, radius: float) -> str:
        """Return the hash of all that decides one run, which names its results."""
        simulator = self.simulator
        run = [content, simulator.name, simulator.version, simulator.options(), round(radius, 9), self.seed]
        run.append(self.settings(radius))
        return hashlib.sha256(json.dumps(run, sort_keys=True, default=str).encode()).hexdigest()


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
    leaks: Callable[[], bool] = field(repr=False, default=bool)  # whether water runs out of it

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
    from ..simulator.statics.falling_over import falls_over

    source = as_source(file)
    content = dropping.content_hash(source)
    cloud = cache(lambda: cloud_for(dropping) if cloud_for else dropping.cloud(source))
    shape = kept_shape(content, cloud, home, "size")
    runs = kept_runs(content, cloud, dropping, home)
    return ObjectRecord(
        path=source.path,
        size=shape["size"],
        occupied=partial(file_voxels, source.path, dropping, home),
        settled=dropping.drops(runs),
        seconds={radius: float(run["seconds"]) for radius, run in runs.items()},
        drops={radius: int(run["drops"]) for radius, run in runs.items()},
        memory={radius: int(run["memory"]) for radius, run in runs.items() if "memory" in run},
        falls_over=kept_answer(content, "falls_over", lambda: falls_over(cloud()), home),
        leaks=partial(file_leaks, source.path, dropping, home),
    )


def kept_shape(
    content: str, cloud: Callable[[], Cloud], home: Path | None, *names: str
) -> dict[str, np.ndarray]:
    """Return arrays of these names of the shape of the object with this hash, see `shape_of`."""
    return computed_once(entry_path("shape", content, home), lambda: shape_of(cloud()), names)


def file_voxels(path: Path, dropping: Dropping, home: Path | None = None) -> np.ndarray:
    """Return the cubes (V, 3) that a file's object occupies, see `shape_of`."""
    content = dropping.content_hash(path)
    return kept_shape(content, lambda: dropping.cloud(path), home, "voxels")["voxels"]


def file_leaks(path: Path, dropping: Dropping, home: Path | None = None) -> bool:
    """Return whether water runs out of a file's object, see `loses_water`."""
    return kept_answer(dropping.content_hash(path), "leaks", lambda: loses_water(dropping.cloud(path)), home)


def settle_kept(
    cloud: Cloud, simulator: str | Simulator, radii: Sequence[float], seed: int = 0, length: RunLimit = LIMITED
) -> DropsByRadius:
    """Return what `settle` does, from the cache where it has it: the same points, and mesh, are simulated once."""
    dropping = Dropping(simulator=simulator, radii=tuple(radii), seed=seed, length=length)
    return dropping.drops(kept_runs(cloud_hash(cloud), lambda: dropping.prepared(cloud), dropping))


def kept_runs(content: str, cloud: Callable[[], Cloud], dropping: Dropping, home: Path | None = None) -> Runs:
    """Return the runs on an object with this hash, from the cache, or a run directory, where it has them."""
    runs = {}
    for radius in dropping.radii:
        entry = entry_path("settled", dropping.run_hash(content, radius), home)
        runs[radius] = computed_once(entry, lambda radius=radius: dropping.run(cloud(), radius))
    return runs


def cloud_hash(cloud: Cloud) -> str:
    """Return the hash of all of a cloud that spheres meet; its name does not matter."""
    digest = hashlib.sha256(f"cloud {FORMAT} {cloud.points.shape}".encode() + cloud.points.tobytes())
    if cloud.mesh is not None:
        for part in (cloud.mesh.vertices, cloud.mesh.faces):
            digest.update(f"{part.dtype} {part.shape}".encode() + np.ascontiguousarray(part).tobytes())
    return digest.hexdigest()


def size_of(path: Path) -> int:
    """Return a file's size in bytes, 0 where there is none."""
    try:
        return path.stat().st_size
    except (OSError, ValueError):
        return 0


def shape_of(cloud: Cloud) -> dict[str, np.ndarray]:
    """Return the extents of a cloud and the cubes of `VOXEL` metres that it occupies, sorted.

    A cube's three numbers, 16 bits each, are sorted as one, six times as quick as rows; where counts are asked numpy
    sorts, thirty times as quick as the table of hashes that it uses otherwise.
    """
    cubes = np.floor(cloud.points / VOXEL).astype(np.int16).astype(np.int64) + 2**15
    numbers, _ = np.unique(cubes @ [2**32, 2**16, 1], return_counts=True)
    cubes = np.column_stack([numbers >> 32, numbers >> 16 & 0xFFFF, numbers & 0xFFFF]) - 2**15
    return {"size": cloud.size, "voxels": cubes.astype(np.int16)}
