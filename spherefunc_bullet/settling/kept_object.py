"""Objects on which spheres can be dropped: a cloud in memory, or a file with results cached by content."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

import numpy as np

from ..clouds.cloud import Cloud
from ..clouds.orientation import Report
from ..errors import one_line
from ..formats.sources import as_source
from .cache import computed_once, entry_path, kept_answer
from .drops import DropsByRadius, RunLimit
from .records import Dropping, cloud_hash, kept_runs, settle_kept
from .settling import settle


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
        return settle_kept(self.own, *how) if self.cache else settle(self.cloud(), *how)

    def check(self, name: str, check: Callable[[Cloud], bool]) -> bool:
        """Return what ``check`` says of the cloud, cached under this name where results are."""
        return kept_answer(cloud_hash(self.own), name, lambda: check(self.own)) if self.cache else check(self.own)

    def count(self, name: str, count: Callable[[Cloud], int]) -> int:
        """Return what ``count`` counts in the cloud."""
        return count(self.cloud())


class KeptFile:
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
        return dropping.drops(kept_runs(self.content, self.cloud, dropping))

    def check(self, name: str, check: Callable[[Cloud], bool]) -> bool:
        """Return the result of ``check`` for the cloud, cached under this name."""
        return kept_answer(self.content, name, lambda: check(self.cloud()))

    def count(self, name: str, count: Callable[[Cloud], int]) -> int:
        """Return what ``count``, which is known by a name, counts in the cloud."""
        entry = entry_path(name, self.content)
        return int(computed_once(entry, lambda: {"count": np.array(count(self.cloud()))})["count"])
