"""Runs on an object, a cloud in memory or a file, and their cache: each run is simulated once.

A cache entry is named by the hash of everything that decides it: the bytes of the file, how it was loaded, the
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
from .settling import checked_radii, drop_settings, measured_run, settle

FORMAT = 2  # of the cache; with another number entries are computed again
Runs = dict[float, dict[str, np.ndarray]]  # radius in metres -> arrays of its run
# Runs a check on a cloud, unless its result is cached under the name.
Check = Callable[[str, Callable[[Cloud], bool]], bool]


@dataclass(frozen=True, kw_only=True)
class LoadOptions:
    """Options with which files are loaded as clouds."""

    up: str = BY_FILE
    units: str = "m"

    def for_file(self, path: Path) -> LoadOptions:
        """Return the options for one file, with the up axis of its format where that decides."""
        return replace(self, up=promised_up(path)) if self.up == BY_FILE else self

    def to_dict(self) -> dict[str, str]:
        """Return the options as a run folder saves them: for files whose format has no up axis, it is z."""
        return asdict(self.for_file(Path()))


@dataclass(frozen=True, kw_only=True)
class DropConfig:
    """How spheres are dropped on objects: everything but the object that decides where they settle."""

    simulator: str | Simulator
    radii: tuple[float, ...]  # metres
    seed: int = 0
    loading: LoadOptions = field(default_factory=LoadOptions)
    run_limit: RunLimit = LIMITED  # of runs

    def __post_init__(self):
        object.__setattr__(self, "simulator", make_simulator(self.simulator))
        object.__setattr__(self, "radii", checked_radii(self.radii))

    def cloud(self, file: Path | Source, report: Report | None = None) -> Cloud:
        """Return the cloud of a file, on which spheres are dropped; see `load_cloud` and `prepared`."""
        return self.prepared(load_cloud(file, up=self.loading.up, units=self.loading.units, report=report))

    def prepared(self, cloud: Cloud) -> Cloud:
        """Return the cloud on which spheres are dropped: prepared if the number of drops is given, else unchanged."""
        return cloud if self.run_limit.drops is None else prepare(cloud)

    def content_hash(self, file: Path | Source) -> str:
        """Return the hash of the bytes of a file and of all files that it names, and of how it is loaded.

        For a source, it is the hash of the bytes that were read, from which its cloud is made.

        Raises
        ------
        InputError
            If the file, or one that it names, cannot be read: missing, too large, a pipe.
        """
        source = as_source(file)
        digest = hashlib.sha256(f"{FORMAT} {source.kind} {asdict(self.loading.for_file(source.path))}".encode())
        for part in source.digests():
            digest.update(part)
        return digest.hexdigest()

    def cloud_hash(self, content: str) -> str:
        """Return the hash of a file's cloud, by that of its content: a `prepared` cloud is another one."""
        return content if self.run_limit.drops is None else hashlib.sha256(f"prepared {content}".encode()).hexdigest()

    def run(self, cloud: Cloud, radius: float) -> dict[str, np.ndarray]:
        """Return the arrays of the run of one radius; see `measured_run`."""
        return measured_run(cloud, self.simulator, radius, self.seed, self.run_limit)

    def drops(self, runs: Runs) -> DropsByRadius:
        """Return the drops of runs."""
        drops = {}
        for radius, run in runs.items():
            provenance = provenance_of(self.simulator, drop_settings(self.simulator, radius, self.run_limit), self.seed)
            drops[radius] = drops_from_rows(radius, run["centers"], run.get("outcomes"), provenance=provenance)
        return drops

    def settings(self, radius: float) -> dict[str, Any]:
        """Return the settings of a run of one radius, without what is not set."""
        settings = asdict(drop_settings(self.simulator, radius, self.run_limit))
        return {name: value for name, value in settings.items() if value}

    def run_hash(self, content: str, radius: float) -> str:
        """Return the hash of all that decides one run, which names its cache entry."""
        simulator = self.simulator
        parts = [content, simulator.name, simulator.version, simulator.options(), round(radius, 9), self.seed]
        parts.append(self.settings(radius))
        return hashlib.sha256(json.dumps(parts, sort_keys=True, default=str).encode()).hexdigest()


def settle_cached(
    cloud: Cloud, simulator: str | Simulator, radii: Sequence[float], seed: int = 0, run_limit: RunLimit = LIMITED
) -> DropsByRadius:
    """Return the drops as `settle` does, from the cache where it has them: the same cloud is simulated once."""
    drop_config = DropConfig(simulator=simulator, radii=radii, seed=seed, run_limit=run_limit)
    return drop_config.drops(cached_runs(cloud_hash(cloud), lambda: drop_config.prepared(cloud), drop_config))


def settle_prepared(
    cloud: Cloud,
    simulator: str | Simulator,
    radii: Sequence[float],
    seed: int = 0,
    run_limit: RunLimit = LIMITED,
    *,
    cache: bool,
) -> DropsByRadius:
    """Return the drops on a cloud, which is prepared first, see `DropConfig.prepared`; with or without the cache."""
    if cache:
        return settle_cached(cloud, simulator, radii, seed, run_limit)
    how = DropConfig(simulator=simulator, radii=radii, seed=seed, run_limit=run_limit)
    return settle(how.prepared(cloud), how.simulator, how.radii, seed, run_limit)


def cached_runs(content: str, cloud: Callable[[], Cloud], drop_config: DropConfig, home: Path | None = None) -> Runs:
    """Return the runs on an object with this hash, from the cache or a run folder where it has them."""
    runs = {}
    for radius in drop_config.radii:
        entry = entry_path("settled", drop_config.run_hash(content, radius), home)
        runs[radius] = computed_once(entry, lambda radius=radius: drop_config.run(cloud(), radius))
    return runs


def cloud_hash(cloud: Cloud) -> str:
    """Return the hash of the points and the mesh of a cloud, without its name."""
    digest = hashlib.sha256(f"cloud {FORMAT} {cloud.points.shape}".encode() + cloud.points.tobytes())
    if cloud.mesh is not None:
        for part in (cloud.mesh.vertices, cloud.mesh.faces):
            digest.update(f"{part.dtype} {part.shape}".encode() + np.ascontiguousarray(part).tobytes())
    return digest.hexdigest()


@dataclass(frozen=True, kw_only=True, eq=False)
class CloudObject:
    """A cloud in memory, and how spheres are dropped on it."""

    raw_cloud: Cloud  # as loaded, not yet prepared
    drop_config: DropConfig
    cache: bool = False  # whether results for the same cloud are cached

    def cloud(self) -> Cloud:
        """Return the cloud on which spheres are dropped."""
        return self.drop_config.prepared(self.raw_cloud)

    def drops(self, run_limit: RunLimit) -> DropsByRadius:
        """Return the drops of runs with this limit."""
        how = self.drop_config
        return settle_prepared(self.raw_cloud, how.simulator, how.radii, how.seed, run_limit, cache=self.cache)

    def check(self, name: str, check: Callable[[Cloud], bool]) -> bool:
        """Return the result of ``check`` for the cloud, cached under this name if results are cached."""
        if not self.cache:
            return check(self.cloud())
        return cached_check(self.drop_config.cloud_hash(cloud_hash(self.raw_cloud)), name, lambda: check(self.cloud()))

    def count(self, name: str, count: Callable[[Cloud], int]) -> int:
        """Return the result of ``count`` for the cloud."""
        return count(self.cloud())


class CachedFile:
    """The object of a file, with its results cached by content: the file is loaded at most once, and only if needed.

    Parameters
    ----------
    report : callable, optional
        Receives remarks on what looks odd in the file or was guessed, also from the cache.
    """

    def __init__(self, path: Path, drop_config: DropConfig, report: Report | None = None):
        self.path, self.drop_config, source = path, drop_config, as_source(path)
        self.content, name, lines = drop_config.content_hash(source), one_line(Path(path).name), []
        self.cloud = cache(lambda: drop_config.cloud(source, lambda line: lines.append(line.removeprefix(name))))
        entry = entry_path("remarks", self.content)
        remarks = computed_once(entry, lambda: self.cloud() and {"lines": np.array(lines, str)})
        for line in remarks["lines"].tolist() if report else []:
            report(name + line)

    def drops(self, run_limit: RunLimit) -> DropsByRadius:
        """Return the drops of runs with this limit."""
        drop_config = replace(self.drop_config, run_limit=run_limit)
        return drop_config.drops(cached_runs(self.content, self.cloud, drop_config))

    def check(self, name: str, check: Callable[[Cloud], bool]) -> bool:
        """Return the result of ``check`` for the cloud, cached under this name."""
        return cached_check(self.drop_config.cloud_hash(self.content), name, lambda: check(self.cloud()))

    def count(self, name: str, count: Callable[[Cloud], int]) -> int:
        """Return the result of ``count`` for the cloud, cached under this name."""
        entry = entry_path(name, self.drop_config.cloud_hash(self.content))
        return int(computed_once(entry, lambda: {"count": np.array(count(self.cloud()))})["count"])
