"""Measurements: the command as the documents print it, what it depends on, and its saved result."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from datetime import date
from pathlib import Path
from typing import Any, TypedDict

from spherefunc_bullet.errors import InputError

from ..machine import processor, versions
from .fingerprint import Fingerprint, fingerprint

RESULTS = Path("docs/results")
BULLET = " --backend bullet"


class Saved(TypedDict):
    """The file of a measurement."""

    command: str
    date: str  # ISO
    seconds: float  # that the command took, whatever else the machine did
    processor: str
    versions: dict[str, str]
    code: Fingerprint  # of what it depends on, as it was
    result: Any  # the JSON that the command printed, or its lines


@dataclass(frozen=True, kw_only=True)
class Measurement:
    """What is measured by one command."""

    name: str  # of the file that keeps its result
    command: str  # as the documents print it
    modules: tuple[str, ...]  # that it measures, from the repository's root; what they import counts too
    without: tuple[str, ...] = ()  # what they import that cannot change a figure; see `fingerprint`
    files: tuple[str, ...] = ()  # other than code
    json: bool = True  # whether it is asked for JSON; else its lines are kept
    timed: bool = False  # whether it measures time, so that the processor is said

    def path(self, root: Path) -> Path:
        """Return the file that keeps its result."""
        return root / RESULTS / f"{self.name}.json"

    def fingerprint(self, root: Path) -> Fingerprint:
        """Return the hashes of all that it depends on, as it is now; of data outside the repository, what there is."""
        there = [name for name in self.manifests if (root / name).is_file()]
        return fingerprint(root, self.modules, self.without, (*self.files, *there))

    @property
    def manifests(self) -> list[str]:
        """Return the manifests of the data that the command names, from the repository's root."""
        return [f"{word}/manifest.csv" for word in self.command.split() if word.startswith("../")]

    def saved(self, root: Path) -> Saved:
        """Return its result; InputError where there is none."""
        path = self.path(root)
        if not path.is_file():
            raise InputError(f"{path}: expected a saved result, got none; `make tables ONLY={self.name}` makes it")
        return json.loads(path.read_text(encoding="utf-8"))

    def changed(self, root: Path) -> list[str]:
        """Return which files, or its command, are not as they were when it was measured; all where it never was."""
        if not self.path(root).is_file():
            return [str(RESULTS / self.path(root).name)]
        saved, now = self.saved(root), self.fingerprint(root)
        absent = {name: saved["code"].get(name) for name in self.manifests if name not in now}
        now |= {name: known for name, known in absent.items() if known is not None}  # nobody can tell
        files = [name for name in sorted(saved["code"].keys() | now.keys()) if saved["code"].get(name) != now.get(name)]
        return [*files, *(["its command"] if saved["command"] != self.command else [])]

    def measure(self, root: Path):
        """Run the command in the repository and save its result."""
        code, start = self.fingerprint(root), time.perf_counter()
        printed = standard_output(self.command + (" --json" if self.json else ""), root)
        saved = Saved(
            command=self.command,
            date=date.today().isoformat(),
            seconds=round(time.perf_counter() - start, 1),
            processor=f"{processor()}, {os.cpu_count()} cores",
            versions=versions(),
            code=code,
            result=json.loads(printed) if self.json else [line.rstrip() for line in printed.splitlines()],
        )
        self.path(root).parent.mkdir(parents=True, exist_ok=True)
        self.path(root).write_text(json.dumps(saved, indent=1) + "\n", encoding="utf-8")


def standard_output(command: str, root: Path) -> str:
    """Return what a command prints that is run by the shell in a folder, with our programs first on the path.

    Raises
    ------
    InputError
        If it fails.
    """
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ.get('PATH', '')}"
    done = subprocess.run(
        ["bash", "-c", command],
        cwd=root,
        env=os.environ | {"PATH": path},
        stdout=subprocess.PIPE,
        text=True,
        check=False,
    )
    if done.returncode:
        raise InputError(f"{command}: expected exit code 0, got {done.returncode}")
    return done.stdout


def commands_of(measurements: Iterable[Measurement], root: Path) -> str:
    """Return the words that name the commands behind a table, and when they ran."""
    days: dict[str, list[str]] = {}
    for measurement in measurements:
        saved = measurement.saved(root)
        where = f" on {saved['processor']}" if measurement.timed else ""
        days.setdefault(f"{saved['date']}{where}", []).append(measurement.command)
    return "; ".join(f"{quoted(commands)} ({day})" for day, commands in days.items())


def quoted(commands: Sequence[str]) -> str:
    """Return commands as a document names them, those that differ by the backend alone at once."""
    pairs = {command: f"`{command}`" for command in commands if command.removesuffix(BULLET) == command}
    for command in commands:
        if command not in pairs:
            plain = command.removesuffix(BULLET)
            pairs[plain if plain in pairs else command] = (
                f"`{plain}` and with `{BULLET.strip()}`" if plain in pairs else f"`{command}`"
            )
    return ", ".join(pairs.values())
