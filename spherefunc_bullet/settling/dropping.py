"""How spheres are dropped on an object, a cloud in memory or a file, and what is kept of it: each run happens once.

A cache entry is named for the hash of everything that decides it: the file's bytes, how it was loaded, the
backend with its version and options, the radius, the limits and the seed.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, field, replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from ..clouds.cloud import Cloud, load_cloud
from ..clouds.orientation import Report, promised_up
from ..clouds.preparation import prepare
from ..errors import one_line
from ..formats.npz import cached_check, computed_once, entry_path
from ..formats.sources import Source, as_source
from ..formats.units import BY_FILE
from ..simulator import Simulator, make_simulator, provenance_of
from .drops import LIMITED, DropsByRadius, RunLimit, drops_from_rows
from .settling import drop_settings, measured_run, settle

FORMAT = 2  # of the cache; another number, other entries
Runs = dict[float, dict[str, np.ndarray]]  # radius in metres -> what comes of its run
Check = Callable[[str, Callable[[Cloud], bool]], bool]  # asks a cloud, unless the answer is kept under the name


@dataclass(frozen=True, kw_only=True)
class LoadOptions:
    """How files become clouds."""

    up: str = BY_FILE
    units: str = "m"

    def of(self, path: Path) -> LoadOptions:
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
    loading: LoadOptions = field(default_factory=LoadOptions)
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


def settle_cached(
    cloud: Cloud, simulator: str | Simulator, radii: Sequence[float], seed: int = 0, length: RunLimit = LIMITED
) -> DropsByRadius:
    """Return what `settle` does, from the cache where it has it: the same points, and mesh, are simulated once."""
    dropping = Dropping(simulator=simulator, radii=tuple(radii), seed=seed, length=length)
    return dropping.drops(cached_runs(cloud_hash(cloud), lambda: dropping.prepared(cloud), dropping))


def cached_runs(content: str, cloud: Callable[[], Cloud], dropping: Dropping, home: Path | None = None) -> Runs:
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


@dataclass(frozen=True, kw_only=True, eq=False)
class CloudObject:
    """A cloud, and how spheres are dropped on it."""

    own: Cloud
    dropping: Dropping
    cache: bool = False  # whether results for the same points are read from the user's cache

    def cloud(self) -> Cloud:
        """Return its points and mesh as spheres meet them."""
        return self.dropping.prepared(self.own)

    def drops(self, length: RunLimit) -> DropsByRadius:
        """Return the drops of runs with this limit."""
        how = (self.dropping.simulator, self.dropping.radii, self.dropping.seed, length)
        return settle_cached(self.own, *how) if self.cache else settle(self.cloud(), *how)

    def check(self, name: str, check: Callable[[Cloud], bool]) -> bool:
        """Return what ``check`` says of the cloud, cached under this name where results are."""
        return cached_check(cloud_hash(self.own), name, lambda: check(self.own)) if self.cache else check(self.own)

    def count(self, name: str, count: Callable[[Cloud], int]) -> int:
        """Return what ``count`` counts in the cloud."""
        return count(self.cloud())


class CachedFile:
    """A file's object and what is kept of it by content: the file is read once at most, and only for what is not kept.

    Parameters
    ----------
    report : callable, optional
        Receives what looks odd about the file, or was guessed, whether it is read again or not.
    """

    def __init__(self, path: Path, dropping: Dropping, report: Report | None = None):
        self.path, self.dropping, source = path, dropping, as_source(path)
        self.content, name, lines = dropping.content_hash(source), one_line(Path(path).name), []
        self.cloud = cache(lambda: dropping.cloud(source, lambda line: lines.append(line.removeprefix(name))))
        entry = entry_path("remarks", self.content)
        remarks = computed_once(entry, lambda: self.cloud() and {"lines": np.array(lines, str)})
        for line in remarks["lines"].tolist() if report else []:
            report(name + line)

    def drops(self, length: RunLimit) -> DropsByRadius:
        """Return the drops of runs with this limit."""
        dropping = replace(self.dropping, length=length)
        return dropping.drops(cached_runs(self.content, self.cloud, dropping))

    def check(self, name: str, check: Callable[[Cloud], bool]) -> bool:
        """Return the result of ``check`` for the cloud, cached under this name."""
        return cached_check(self.content, name, lambda: check(self.cloud()))

    def count(self, name: str, count: Callable[[Cloud], int]) -> int:
        """Return what ``count``, which is known by a name, counts in the cloud."""
        entry = entry_path(name, self.content)
        return int(computed_once(entry, lambda: {"count": np.array(count(self.cloud()))})["count"])
