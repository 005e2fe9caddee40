"""Measured tables: blocks of documents, the commands behind them, their saved results, and what has changed since.

A measurement names the code that it measures by patterns; layout, comments and docstrings do not count.
"""

from __future__ import annotations

import ast
import hashlib
import json
import os
import re
import subprocess
import sys
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
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


BLOCK = re.compile(r"(?P<begin><!-- table: (?P<name>[\w-]+) -->\n)(?P<text>.*?)(?P<end><!-- end -->)", re.DOTALL)
MARK = re.compile(r"<!-- (?:table: [^>]*|end) -->")


def blocks_of(document: str, name: str) -> dict[str, str]:
    """Return the text of each block of a document by the block's name.

    Raises
    ------
    InputError
        If a marker has no partner, or a name occurs twice.
    """
    found = [(match["name"], match["text"]) for match in BLOCK.finditer(document)]
    marks = MARK.findall(document)
    if len(marks) != 2 * len(found) or len(dict(found)) != len(found):
        raise InputError(f"{name}: expected `<!-- table: NAME -->` and `<!-- end -->` by turns, each name once")
    return dict(found)


def with_blocks(document: str, texts: Mapping[str, str]) -> str:
    """Return a document with other texts in some of its blocks."""

    def filled(match: re.Match) -> str:
        return f"{match['begin']}{texts.get(match['name'], match['text'])}{match['end']}"

    return BLOCK.sub(filled, document)


OLDER = "*Older than the code:"  # the beginning of a line that each kept table has to show
Lines = list[str]


@dataclass(frozen=True, kw_only=True)
class DocumentTable:
    """One block of a document."""

    name: str
    document: str  # from the repository's root
    measurements: tuple[Measurement, ...]
    render: Callable[..., Lines]  # is called with the results of the measurements

    def text(self, root: Path) -> str:
        """Return the text that the document should have in this block: the measured one, or the kept one."""
        if not self.is_measured(root):
            return self.kept(root).read_text(encoding="utf-8")
        results = [measurement.saved(root)["result"] for measurement in self.measurements]
        lines = [*self.render(*results), "", f"Measured by {commands_of(self.measurements, root)}."]
        return "".join(f"{line}\n" for line in lines)

    def is_measured(self, root: Path) -> bool:
        """Return whether the saved results are used: if they are up to date, or there is no kept text."""
        return not self.kept(root).is_file() or not any(measurement.changed(root) for measurement in self.measurements)

    def kept(self, root: Path) -> Path:
        """Return the file of the block's kept text, which is older than the code and says so."""
        return root / RESULTS / "kept" / f"{self.name}.md"

    def keep(self, root: Path, why: str):
        """Keep the block of the document, with a visible line that it is older than the code, and why."""
        lines = read_blocks(root, self.document)[self.name].rstrip().splitlines()
        text = "\n".join(line for line in lines if not line.startswith(OLDER)).rstrip()
        commands = quoted([measurement.command for measurement in self.measurements])
        why += "" if "\nMeasured by " in text else f"{'' if why.endswith('.') else '.'} The command is {commands}."
        self.kept(root).parent.mkdir(parents=True, exist_ok=True)
        self.kept(root).write_text(f"{text}\n\n{OLDER} {why}*\n", encoding="utf-8")


def read_blocks(root: Path, document: str) -> dict[str, str]:
    """Return the text of each block of a document of the repository."""
    return blocks_of((root / document).read_text(encoding="utf-8"), document)


def complaints(root: Path, tables: Iterable[DocumentTable]) -> Lines:
    """Return a line for each block that is older than its code, or differs from its saved results."""
    by_document: dict[str, dict[str, DocumentTable]] = {}
    for table in tables:
        by_document.setdefault(table.document, {})[table.name] = table
    found = []
    for document, known in by_document.items():
        blocks = read_blocks(root, document)
        wrong = {name: "expected an entry in the registry" for name in blocks.keys() - known.keys()}
        for name, table in known.items():
            wrong[name] = complaint_of(root, table, blocks[name]) if name in blocks else "expected its markers"
        found += [f"{document}: table {name}: {line}" for name, line in wrong.items() if line]
    return found


def complaint_of(root: Path, table: DocumentTable, block: str) -> str | None:
    """Return the complaint about one block, None if it is up to date."""
    changed = [file for measurement in table.measurements for file in measurement.changed(root)]
    if changed and table.is_measured(root):
        more = f" and {len(changed) - 2} more" if len(changed) > 2 else ""
        return f"older than {', '.join(changed[:2])}{more}; `make tables ONLY={table.name}` measures it again"
    if block != table.text(root):
        return "expected what the saved results say; `make tables` writes it"
    if changed and not block.splitlines()[-1].startswith(OLDER):
        return f"expected a last line that begins with {OLDER!r}"
    return None


FUNCTIONS = ("cup", "sittable", "table")


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> list[str]:
    """Return the lines of a table."""
    return [row_line(head), "|" + "---|" * len(head), *(row_line(row) for row in rows)]


def row_line(cells: Sequence[str]) -> str:
    """Return one row of a table."""
    return f"| {' | '.join(cells)} |".replace("|  |", "| |").replace("|  |", "| |")


def figures(value: Mapping[str, Any], key: str = "f_measure", between: str = " / ") -> str:
    """Return one figure of each function, in the order of `FUNCTIONS`."""
    return between.join(f"{value[name][key]:.3f}" for name in FUNCTIONS)
