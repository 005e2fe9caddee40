"""What an object is for, from its English name: the table ``functions.csv``.

In an English name, the last noun before any *with*, *and* or *of* says what the object is: a table lamp is a
lamp, a desk chair a chair, a chair with cushion a chair.
"""

from __future__ import annotations

import csv
import re
from dataclasses import dataclass
from functools import cache
from importlib.resources import files

_REST = re.compile(r",|\(|\b(?:with|and|for|of|in|on|by)\b|&")


@dataclass(frozen=True)
class Purpose:
    """What an object is for, or may be."""

    label: str  # cup, table, sittable or none
    also: str = ""  # functions that are true as well, or the other reading of an ambiguous one; ';'-separated
    ambiguous: bool = False  # people would dispute it, or its height contradicts its name


@dataclass(frozen=True)
class _Rule:
    field: str
    pattern: re.Pattern
    purpose: Purpose
    max_height: float  # metres; the row is not for higher objects


@cache
def _rules() -> tuple[_Rule, ...]:
    with files(__package__).joinpath("functions.csv").open(encoding="utf-8", newline="") as stream:
        rules = []
        for row in csv.DictReader(stream):
            pattern = re.compile(rf"\b(?:{row['pattern']})(?:e?s)?\b", re.IGNORECASE)
            purpose = Purpose(row["label"], row["also"], row["ambiguous"] == "1")
            rules.append(_Rule(row["field"], pattern, purpose, float(row["max_height"] or "inf")))
        return tuple(rules)


def purpose_of(name: str, category: str = "", height: float = 0.0) -> Purpose:
    """Return the purpose of an object by its name; without a matching row it has no function.

    Parameters
    ----------
    name : str
        In English. Of all matching rows, those whose match ends last count, and of these the longest, then the first in
        the table. The part after *with* or *and* counts only if nothing before it matches.
    category : str
        In the library's catalogue; some (doors, lights, vehicles) decide alone.
    height : float
        Metres. Rows for lower objects do not count; if no row is left (a desk of 1.8 m has something on it), the
        purpose is ambiguous.

    Examples
    --------
    >>> [purpose_of(name).label for name in ("Table lamp", "Coffee table", "Chair with cushion")]
    ['none', 'table', 'sittable']
    """
    if any(rule.pattern.fullmatch(category.strip()) for rule in _rules() if rule.field == "category"):
        return Purpose("none")
    rest = _REST.search(name)
    head = rest.start() if rest else len(name)
    matches = []
    for order, rule in enumerate(_rules()):
        for match in rule.pattern.finditer(name) if rule.field == "name" else ():
            matches.append(((match.start() < head, match.end()), (match.end() - match.start(), -order), rule))
    if not matches:
        return Purpose("none")
    noun = max(place for place, _, _ in matches)
    rules = [rule for place, _, rule in sorted(matches, key=lambda match: match[:2]) if place == noun]
    fitting = [rule for rule in rules if height <= rule.max_height]
    return fitting[-1].purpose if fitting else Purpose("none", rules[-1].purpose.label, True)


def slug(name: str) -> str:
    """Return a name as a category and file name.

    Examples
    --------
    >>> slug("Coffee mug, 12 oz")
    'coffee_mug_12_oz'
    """
    return re.sub(r"[^a-z0-9]+", "_", name.lower()).strip("_")[:60] or "object"
