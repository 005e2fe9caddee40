"""Blocks of a document between markers, which a program writes and nobody else."""

from __future__ import annotations

import re
from collections.abc import Mapping

from spherefunc_bullet.errors import InputError

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


def outside_blocks(document: str) -> str:
    """Return what people write of a document."""
    return BLOCK.sub("", document)
