"""The ledger of a batch: one row for every object and run configuration, in SQLite.

A row is waiting, done, or failed with a reason. Rows are written in transactions, so that a reader, also after a crash,
sees a complete row or none. Readers and the writer do not wait for each other (write-ahead log).
"""

from __future__ import annotations

import sqlite3
import time
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import astuple, dataclass, fields
from pathlib import Path
from typing import Any

from ..errors import InputError

VERSION = 1
SCHEMA = f"""
PRAGMA user_version = {VERSION};
CREATE TABLE IF NOT EXISTS ways (      -- to simulate an object
    way INTEGER PRIMARY KEY,
    backend TEXT NOT NULL,
    settings TEXT NOT NULL,            -- JSON: the backend's version and options, the limits, how files are loaded
    radius REAL NOT NULL,              -- metres
    seed INTEGER NOT NULL,
    UNIQUE (backend, settings, radius, seed));
CREATE TABLE IF NOT EXISTS runs (
    object TEXT NOT NULL,              -- the file's path below the data set's folder
    way INTEGER NOT NULL REFERENCES ways,
    outcome TEXT NOT NULL DEFAULT 'waiting',
    content TEXT,                      -- hash of the file's bytes and of how it is loaded
    run TEXT,                          -- hash of all that decides the result; names the file of the centres
    digest TEXT,                       -- hash of the settled centres
    settled INTEGER, drops INTEGER,
    seconds REAL, memory INTEGER,      -- of the simulation alone; bytes of its process at most
    bytes INTEGER, kept INTEGER,       -- size of the file of the centres, and when it was written (ns)
    source TEXT,                       -- size and time of the object's file: another, and it is looked at again
    error TEXT, finished REAL,
    PRIMARY KEY (object, way)) WITHOUT ROWID;
CREATE INDEX IF NOT EXISTS outcomes ON runs (outcome, finished, way, seconds, bytes);
CREATE TABLE IF NOT EXISTS calls (started REAL, ended REAL, jobs INTEGER, host TEXT, process INTEGER, data TEXT);
CREATE VIEW IF NOT EXISTS ledger AS
    SELECT object, content, backend, settings, radius, seed, outcome, settled, drops, seconds, memory, error, run,
        digest, datetime(finished, 'unixepoch') AS finished
    FROM runs JOIN ways USING (way) ORDER BY object, backend, settings, radius, seed;
"""
WAITING, DONE = "waiting", "done"


@dataclass(frozen=True, kw_only=True)
class RunConfig:
    """How an object is simulated: all that determines the result but the object. Its number is the column ``way``."""

    backend: str
    settings: str  # JSON
    radius: float  # metres
    seed: int


@dataclass(frozen=True, kw_only=True)
class LedgerRow:
    """The result of one run, or the reason why it failed."""

    object: str
    way: int
    outcome: str = WAITING
    content: str | None = None
    run: str | None = None
    digest: str | None = None
    settled: int | None = None
    drops: int | None = None
    seconds: float | None = None
    memory: int | None = None
    bytes: int | None = None
    kept: int | None = None
    source: str | None = None
    error: str | None = None
    finished: float | None = None


WAY_NAMES, NAMES = (tuple(column.name for column in fields(kind)) for kind in (RunConfig, LedgerRow))
WAY_COLUMNS, COLUMNS = ", ".join(WAY_NAMES), ", ".join(NAMES)
VALUES = ", ".join(f":{name}" for name in NAMES)


class Ledger:
    """An open ledger, for one thread; closed at the end of a ``with``.

    Raises
    ------
    InputError
        From every method, if the file is no ledger, damaged, or cannot be written.
    """

    def __init__(self, path: Path, *, make: bool = False):
        self.path = path
        with self.refusing():
            if not make and not path.is_file():
                raise InputError(f"{path.parent}: expected a run directory of `spherefunc batch`, found no {path.name}")
            self.connection = sqlite3.connect(path, timeout=60.0, isolation_level=None)
            self.prepare()

    def prepare(self):
        """Make what is missing; refuse what is damaged or of another version."""
        with self.refusing():
            version = self.connection.execute("PRAGMA user_version").fetchone()[0]
            if version not in (0, VERSION):
                wanted = f"expected a ledger of version {VERSION}, got {version}"
                raise InputError(f"{self.path}: {wanted}; use another --run")
            self.connection.execute("PRAGMA synchronous = FULL")
            if version == 0:
                self.connection.execute("PRAGMA journal_mode = WAL")
                self.connection.executescript(f"BEGIN IMMEDIATE; {SCHEMA} COMMIT;")

    def check(self):
        """Raise InputError if the ledger has damaged pages, before a long run relies on it."""
        with self.refusing():
            verdict = self.connection.execute("PRAGMA quick_check(1)").fetchone()[0]
        if verdict != "ok":
            raise InputError(f"{self.path}: {DAMAGED.format(' '.join(verdict.split()))}")

    @contextmanager
    def refusing(self) -> Iterator[None]:
        """Raise InputError for errors of SQLite and of the file."""
        try:
            yield
        except (sqlite3.Error, OSError) as error:
            place = isinstance(error, sqlite3.OperationalError | OSError)  # a full disk, a folder of somebody else
            raise InputError(f"{self.path}: {(WANTED if place else DAMAGED).format(error)}") from error

    @contextmanager
    def writing(self) -> Iterator[sqlite3.Connection]:
        """Make all changes within one transaction."""
        with self.refusing():
            self.connection.execute("BEGIN IMMEDIATE")
            try:
                yield self.connection
                self.connection.execute("COMMIT")
            except BaseException:
                if self.connection.in_transaction:
                    self.connection.execute("ROLLBACK")
                raise

    def query(self, sql: str, values: Sequence = ()) -> list[tuple]:
        """Return the rows of a query."""
        with self.refusing():
            return self.connection.execute(sql, values).fetchall()

    def number(self, config: RunConfig) -> int:
        """Return the number of a run configuration, which is added if it is new."""
        with self.writing() as connection:
            connection.execute(f"INSERT OR IGNORE INTO ways ({WAY_COLUMNS}) VALUES (?, ?, ?, ?)", astuple(config))
        (number,) = self.numbers([config])
        return number

    def numbers(self, configs: Iterable[RunConfig]) -> list[int]:
        """Return the numbers of the run configurations that have one."""
        sql = f"SELECT way FROM ways WHERE ({WAY_COLUMNS}) = (?, ?, ?, ?)"
        return [number for config in configs for (number,) in self.query(sql, astuple(config))]

    def run_configs(self) -> dict[int, RunConfig]:
        """Return all run configurations by their numbers."""
        rows = self.query(f"SELECT way, {WAY_COLUMNS} FROM ways ORDER BY way")
        return {number: RunConfig(**dict(zip(WAY_NAMES, values, strict=True))) for number, *values in rows}

    def forget_waiting(self):
        """Delete the waiting rows of earlier calls, whose objects and radii the next call may not have."""
        with self.writing() as connection:
            connection.execute("DELETE FROM runs WHERE outcome = ?", (WAITING,))

    def expect(self, objects: Iterable[str], ways: Sequence[int]):
        """Add a waiting row for every object and run configuration that has none."""
        with self.writing() as connection:
            rows = ((name, way) for name in objects for way in ways)
            connection.executemany("INSERT OR IGNORE INTO runs (object, way) VALUES (?, ?)", rows)

    def rows(self, ways: Sequence[int]) -> Iterator[LedgerRow]:
        """Return the rows of these run configurations, ordered by object."""
        marks = ", ".join("?" * len(ways))
        for values in self.query(f"SELECT {COLUMNS} FROM runs WHERE way IN ({marks}) ORDER BY object, way", ways):
            yield LedgerRow(**dict(zip(NAMES, values, strict=True)))

    def failures(self, configs: Iterable[RunConfig]) -> list[LedgerRow]:
        """Return the rows of these run configurations that failed."""
        return [row for row in self.rows(self.numbers(configs)) if row.outcome not in (WAITING, DONE)]

    def write(self, rows: Iterable[LedgerRow]):
        """Write all of the rows or none, replacing those of the same objects and run configurations."""
        with self.writing() as connection:
            connection.executemany(f"INSERT OR REPLACE INTO runs ({COLUMNS}) VALUES ({VALUES})", map(vars, rows))

    def begin_call(self, about: dict[str, Any]):
        """Record that a batch begins to work on this ledger."""
        sql = f"INSERT INTO calls (started, {', '.join(about)}) VALUES (?, ?, ?, ?, ?)"
        with self.writing() as connection:
            self.call = connection.execute(sql, (time.time(), *about.values())).lastrowid

    def end_call(self):
        """Record that this call has ended."""
        with self.writing() as connection:
            connection.execute("UPDATE calls SET ended = ? WHERE rowid = ?", (time.time(), self.call))

    def __enter__(self) -> Ledger:
        return self

    def __exit__(self, *_):
        self.connection.close()


WANTED = "expected a ledger that can be read and written, {}"
DAMAGED = WANTED + "; if it is damaged, move it away: what is settled is found again"
