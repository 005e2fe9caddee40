"""A row of the table of shapes, what it has to keep, and what it says in words."""

from __future__ import annotations

from dataclasses import dataclass, field

NOTHING = 0.02  # of the capacity: what holds no more holds nothing
Functions = dict[str, tuple[bool, float]]  # by name: whether it has it, and the score


@dataclass(frozen=True, kw_only=True)
class KeepCriteria:
    """What has to be kept of an object for a shape to keep it all."""

    share: float = 0.9  # of capacity, carrying level and settled spheres
    moved: float | None = None  # metres that places may move; None: any


@dataclass(frozen=True, kw_only=True)
class ShapeRow:
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
