"""A measured table: a block of a document, and whether it is up to date with the code."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from spherefunc_bullet.errors import InputError

from .saved import RESULTS, Measurement, commands_of, quoted

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
        return self.measured_text(root) if self.is_measured(root) else self.kept(root).read_text(encoding="utf-8")

    def measured_text(self, root: Path) -> str:
        """Return the text of the saved results."""
        results: Sequence[Any] = [measurement.saved(root)["result"] for measurement in self.measurements]
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
    stale: dict[str, dict[str, DocumentTable]] = {}
    for table in tables:
        stale.setdefault(table.document, {})[table.name] = table
    return [line for name, some in stale.items() for line in complaints_of(root, name, some)]


def complaints_of(root: Path, document: str, tables: Mapping[str, DocumentTable]) -> Lines:
    """Return the complaints about the blocks of one document."""
    blocks = read_blocks(root, document)
    found = [f"{document}: table {name}: expected an entry in the registry" for name in blocks.keys() - tables.keys()]
    for name, table in tables.items():
        if name not in blocks:
            found.append(f"{document}: table {name}: expected its markers")
        elif line := complaint_of(root, table, blocks[name]):
            found.append(f"{document}: table {name}: {line}")
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


def fenced(lines: Iterable[str]) -> list[str]:
    """Return the output of a program as a block of code."""
    return ["```", *lines, "```"]


def figures(value: Mapping[str, Any], key: str = "f_measure", between: str = " / ") -> str:
    """Return one figure of each function, in the order of `FUNCTIONS`."""
    return between.join(f"{value[name][key]:.3f}" for name in FUNCTIONS)
