"""A row of the table of shapes, what it has to keep, and what it says in words."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field, replace

NOTHING = 0.02  # of the capacity: what holds no more holds nothing
SAME_COST = 0.05  # of the mesh's: a difference that timing does not tell
Functions = dict[str, tuple[bool, float]]  # by name: whether it has it, and the score


@dataclass(frozen=True, kw_only=True)
class Kept:
    """What has to be kept of an object for a shape to keep it all."""

    share: float = 0.9  # of capacity, carrying level and settled spheres
    moved: float | None = None  # metres that places may move; None: any


@dataclass(frozen=True, kw_only=True)
class Row:
    """What one shape keeps, and what it costs."""

    name: str
    pieces: int
    faces: int
    bytes: int
    build_seconds: float
    capacity_ml: float
    capacity_kept: float | None  # None: the object is no vessel
    filled: bool = False  # of a shape that holds nothing: a sphere no longer goes where water stood
    level_kept: float
    level_higher_mm: float
    openings_closed: int
    step_us: float = float("nan")
    settled: int = 0
    settled_kept: float | None = None  # None: no spheres were dropped, since it has lost something without them
    moved_mm: float = 0.0
    deeper: int = 0
    functions: Functions = field(default_factory=dict)
    lost: tuple[str, ...] = ()  # in words, the gravest first
    keeps: bool = True
    verdict: str = ""
    notes: tuple[str, ...] = ()

    @property
    def measured(self) -> bool:
        """Whether all of it is known."""
        return self.settled_kept is not None


@dataclass(frozen=True, kw_only=True)
class Truth:
    """What there is of an object to be kept."""

    capacity_ml: float
    level_mm: float  # height of the carrying level
    functions: Functions
    step_us: float  # of the mesh itself


def judged(row: Row, truth: Truth, kept: Kept) -> Row:
    """Return a row with its verdict."""
    lost = tuple(losses(row, truth, kept))
    return replace(row, lost=lost, keeps=not lost, verdict="; ".join(lost) if lost else price(row, truth))


def losses(row: Row, truth: Truth, kept: Kept) -> Iterator[str]:
    """Yield what a shape does not keep."""
    if row.capacity_kept is not None and row.capacity_kept < kept.share:
        held = f"holds {part_of(row.capacity_kept, truth.capacity_ml)}"
        why = "solid for the engine" if row.filled else "it runs out through gaps"
        yield f"{held}: {why}" if row.capacity_kept < NOTHING else held
    if row.level_kept < kept.share:
        side = "higher" if row.level_higher_mm > 0 else "lower"
        by = abs(row.level_higher_mm)
        moved = f", it is {by:.3g} mm {side}" if by > 1 else ""
        yield f"keeps {row.level_kept:.0%} of the level at {truth.level_mm:.0f} mm{moved}"
    if row.settled_kept is not None and row.settled_kept < kept.share:
        yield f"keeps {row.settled_kept:.0%} of the spheres in their places"
    if row.openings_closed:
        yield "fills space that spheres went through" + (
            f", in {row.openings_closed} places" if row.openings_closed > 1 else ""
        )
    if kept.moved is not None and row.moved_mm > 1e3 * kept.moved:
        yield f"resting places moved by {row.moved_mm:.2g} mm"
    for name, (member, _) in truth.functions.items():
        if member and name in row.functions and not row.functions[name][0]:
            yield f"is no longer classified as {name}"


def price(row: Row, truth: Truth) -> str:
    """Return at which cost everything is kept."""
    mesh = truth.step_us
    if not (math.isfinite(mesh) and math.isfinite(row.step_us)) or row.name == "mesh":
        return "keeps everything"
    times = row.step_us / mesh
    if abs(times - 1) < SAME_COST:
        return "keeps everything at the cost of the mesh"
    return f"keeps everything at {times:.1f} times the cost of the mesh"


def part_of(share: float, millilitres: float) -> str:
    """Return a share of a volume, and the volume, as people write them.

    Examples
    --------
    >>> part_of(0.5, 310.4), part_of(0.9, 19018.0)
    ('155 of 310 ml', '17.1 of 19.0 l')
    """
    if millilitres < 1000:
        return f"{share * millilitres:.0f} of {millilitres:.0f} ml"
    return f"{share * millilitres / 1000:.1f} of {millilitres / 1000:.1f} l"
