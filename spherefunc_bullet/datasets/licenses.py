"""Which licences let a model that ships learn quantities of an object: those that ask for no more than a name."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence

from .dataset import DatasetObject

ALLOWED = ("CC0", "CC-BY", "BSD", "Apache-2.0", "MIT", "Zlib")
FORBIDDEN = ("GPL", "-NC", "-ND", "-SA", "research")


def is_permissive(text: str) -> bool:
    """Return whether a licence, as a manifest says it, lets others learn from and pass on.

    Examples
    --------
    >>> is_permissive("CC-BY-3.0"), is_permissive("GPL-2+ (Debian package)"), is_permissive("CC-BY-NC-4.0")
    (True, False, False)
    """
    return any(name in text for name in ALLOWED) and not any(name in text for name in FORBIDDEN)


def sources_of(objects: Sequence[DatasetObject]) -> list[str]:
    """Return who made each object, where its licence is stated: then it is another's, and else of a catalogue."""
    return [item.group if item.license else "" for item in objects]


def learnt_sources(objects: Iterable[DatasetObject]) -> dict[str, int]:
    """Return of how many objects each source is, by its name and licence; only sources that state a licence."""
    return dict(
        sorted(Counter(f"{item.source or item.group} ({item.license})" for item in objects if item.license).items())
    )
