"""Lines of Markdown."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

FUNCTIONS = ("cup", "sittable", "table")


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> list[str]:
    """Return the lines of a table."""
    return [row_line(head), "|" + "---|" * len(head), *(row_line(row) for row in rows)]


def row_line(cells: Sequence[str]) -> str:
    """Return one row of a table."""
    return f"| {' | '.join(cells)} |".replace("|  |", "| |").replace("|  |", "| |")


def fenced(lines: Iterable[str]) -> list[str]:
    """Return what a program printed."""
    return ["```", *lines, "```"]


def figures(value: Mapping[str, Any], key: str = "f_measure", between: str = " / ") -> str:
    """Return one figure of each function, in the order of `FUNCTIONS`."""
    return between.join(f"{value[name][key]:.3f}" for name in FUNCTIONS)
