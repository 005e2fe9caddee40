"""Blocks that are what programs printed."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from .markdown import fenced

Printed = Sequence[str]  # the lines that a program printed


def whole(*printed: Printed) -> list[str]:
    """Return all that programs printed, an empty line between two."""
    blocks = ["\n".join(lines).strip("\n") for lines in printed]
    return fenced("\n\n".join(blocks).split("\n"))


def part(first: str, before: str = "") -> Callable[[Printed], list[str]]:
    """Return what shows the lines from one that begins with some words to before one that begins with others."""

    def lines(printed: Printed) -> list[str]:
        start = next(k for k, line in enumerate(printed) if line.startswith(first))
        end = next((k for k, line in enumerate(printed) if k > start and before and line.startswith(before)), None)
        return whole(printed[start:end])

    return lines
