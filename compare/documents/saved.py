"""Measurements: the command as printed in the documents, its dependencies, and its saved result.

A measurement names the code that it measures by patterns; layout, comments and docstrings do not count.
"""

from __future__ import annotations

import ast
import hashlib
import json
import os
import subprocess
import sys
import time
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from datetime import date
from functools import cache
from pathlib import Path
from typing import Any

from spherefunc_bullet.errors import InputError

from ..machine import processor, versions

RESULTS = Path("docs/results")
BULLET = " --backend bullet"


@cache
def code_hash(path: Path) -> str:
    """Return the hash of a module without layout, comments and docstrings."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    for node in ast.walk(tree):
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef) and ast.get_docstring(node) is not None:
            node.body = node.body[1:]
    return digest(ast.unparse(tree).encode())


def digest(content: bytes) -> str:
    """Return the first digits of a hash."""
    return hashlib.sha256(content).hexdigest()[:12]


@dataclass(frozen=True, kw_only=True)
class Measurement:
    """One command and its saved result."""

    name: str  # of the file with its result
    command: str  # as printed in the documents
    modules: tuple[str, ...]  # measured by it, as patterns from the repository's root
    files: tuple[str, ...] = ()  # other dependencies
    json: bool = True  # whether its result is JSON, otherwise lines of text
    timed: bool = False  # whether it measures time, so that documents name the processor

    def path(self, root: Path) -> Path:
        """Return the file of its result."""
        return root / RESULTS / f"{self.name}.json"

    def fingerprint(self, root: Path) -> dict[str, str]:
        """Return the current hash of each file on which it depends; missing files of data elsewhere are left out."""
        code = sorted({path for pattern in self.modules for path in root.glob(pattern)})
        files = [*self.files, *(name for name in self.manifests if (root / name).is_file())]
        hashes = {path.relative_to(root).as_posix(): code_hash(path) for path in code}
        return hashes | {name: digest((root / name).read_bytes()) for name in sorted(files)}

    @property
    def manifests(self) -> list[str]:
        """Return the manifests of the data that the command names, from the repository's root."""
        return [f"{word}/manifest.csv" for word in self.command.split() if word.startswith("../")]

    def saved(self, root: Path) -> dict[str, Any]:
        """Return the content of its file: the result with date, machine and code; InputError without a file."""
        path = self.path(root)
        if not path.is_file():
            raise InputError(f"{path}: expected a saved result, got none; `make tables ONLY={self.name}` makes it")
        return json.loads(path.read_text(encoding="utf-8"))

    def changed(self, root: Path) -> list[str]:
        """Return the files that have changed since it was measured, and its command if that has changed."""
        if not self.path(root).is_file():
            return [str(RESULTS / self.path(root).name)]
        saved, now = self.saved(root), self.fingerprint(root)
        absent = {name: saved["code"].get(name) for name in self.manifests if name not in now}
        now |= {name: known for name, known in absent.items() if known is not None}  # taken as unchanged
        files = [name for name in sorted(saved["code"].keys() | now.keys()) if saved["code"].get(name) != now.get(name)]
        return [*files, *(["its command"] if saved["command"] != self.command else [])]

    def measure(self, root: Path):
        """Run the command in the repository and save its result."""
        code, start = self.fingerprint(root), time.perf_counter()
        printed = standard_output(self.command + (" --json" if self.json else ""), root)
        saved = {
            "command": self.command,
            "date": date.today().isoformat(),
            "seconds": round(time.perf_counter() - start, 1),  # whatever else the machine did
            "processor": f"{processor()}, {os.cpu_count()} cores",
            "versions": versions(),
            "code": code,
            "result": json.loads(printed) if self.json else [line.rstrip() for line in printed.splitlines()],
        }
        self.path(root).parent.mkdir(parents=True, exist_ok=True)
        self.path(root).write_text(json.dumps(saved, indent=1) + "\n", encoding="utf-8")


def standard_output(command: str, root: Path) -> str:
    """Return the output of a shell command that is run in a folder, with this environment's programs first on the path.

    Raises
    ------
    InputError
        If it fails.
    """
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ.get('PATH', '')}"
    how = {"cwd": root, "env": os.environ | {"PATH": path}, "stdout": subprocess.PIPE, "text": True}
    done = subprocess.run(["bash", "-c", command], check=False, **how)
    if done.returncode:
        raise InputError(f"{command}: expected exit code 0, got {done.returncode}")
    return done.stdout


def commands_of(measurements: Iterable[Measurement], root: Path) -> str:
    """Return the commands behind a table in words, with their dates."""
    days: dict[str, list[str]] = {}
    for measurement in measurements:
        saved = measurement.saved(root)
        where = f" on {saved['processor']}" if measurement.timed else ""
        days.setdefault(f"{saved['date']}{where}", []).append(measurement.command)
    return "; ".join(f"{quoted(commands)} ({day})" for day, commands in days.items())


def quoted(commands: Sequence[str]) -> str:
    """Return commands as a document prints them; commands that differ only by the backend are joined."""
    words = []
    for command in commands:
        plain = command.removesuffix(BULLET)
        if plain == command and command + BULLET in commands:
            words.append(f"`{command}` and with `{BULLET.strip()}`")
        elif plain == command or plain not in commands:
            words.append(f"`{command}`")
    return ", ".join(words)
