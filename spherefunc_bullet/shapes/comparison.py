"""Comparison of an object with the collision shapes that an engine could use for it: one row per shape."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from scipy.spatial import cKDTree

from ..answer import classify
from ..clouds.cloud import Cloud, cloud_from_mesh
from ..errors import InputError
from . import spaces
from .solid import Solid, dense_points, surface
from .spheres import ObjectRests, moved, settle_spheres

SPHERE = 1 / 28  # of the extent: radius of the spheres, within the limits below
SMALLEST, LARGEST = 0.002, 0.04  # metres
VESSEL = 0.05  # of the bounding box: an object with a smaller capacity is not a vessel
OPEN = 1e-6  # m3: the same, absolute
GRAIN = 0.6  # of the radius of the spheres: finer grains may run out of a shape that is made for spheres
LEAKS = "its gaps hold spheres, and let water out"
SAME_COST = 0.05  # of the cost of the mesh: smaller differences are within the accuracy of timing
LARGER = 1.5  # ratio of sizes from which on a shape is in another unit, or of another object
NOTHING = 0.02  # of the capacity: a shape with no more holds nothing
Functions = dict[str, tuple[bool, float]]  # by name: membership and score


@dataclass(frozen=True, kw_only=True)
class KeepCriteria:
    """What a shape has to keep of an object."""

    share: float = 0.9  # of capacity, carrying level and settled spheres
    moved: float | None = None  # metres that resting places may move; None: any distance


@dataclass(frozen=True, kw_only=True)
class ShapeRow:
    """What one shape keeps, and its cost."""

    name: str
    pieces: int
    faces: int
    bytes: int
    build_seconds: float
    capacity_ml: float  # of the object's own, as much as the shape holds; never water inside its walls
    capacity_kept: float | None  # None: the object is not a vessel
    filled: bool = False  # whether spheres no longer reach most of the volume of the water in the object
    level_kept: float
    level_higher_mm: float
    openings_closed: int
    step_us: float = float("nan")
    settled: int = 0
    settled_kept: float | None = None  # None: no spheres were dropped, since the shape had already lost something
    moved_mm: float = 0.0
    deeper: int = 0
    functions: Functions = field(default_factory=dict)
    lost: tuple[str, ...] = ()  # sentences, the most important loss first
    keeps: bool = True
    verdict: str = ""
    notes: tuple[str, ...] = ()

    @property
    def measured(self) -> bool:
        """Whether spheres were dropped, so that all values are known."""
        return self.settled_kept is not None


@dataclass(frozen=True, eq=False)
class Subject:
    """An object and the quantities of it that are measured once."""

    cloud: Cloud

    @property
    def low(self) -> np.ndarray:
        return self.mesh.vertices.min(axis=0)

    @property
    def high(self) -> np.ndarray:
        return self.mesh.vertices.max(axis=0)

    @cached_property
    def mesh(self) -> Solid:
        """Its surface; InputError if the cloud has no mesh."""
        if self.cloud.mesh is None:
            raise InputError(f"{self.cloud.name}: expected a mesh, got points, which have no shape to compare with")
        return surface("mesh", self.cloud.mesh.vertices, self.cloud.mesh.faces)

    @property
    def extent(self) -> float:
        return float((self.high - self.low).max())

    @property
    def radius(self) -> float:
        """Radius of the spheres, metres."""
        return float(np.clip(SPHERE * self.extent, SMALLEST, LARGEST))

    @cached_property
    def space(self) -> spaces.FreeSpace:
        return spaces.grid_around(self.low, self.high).free_space(self.mesh)

    @cached_property
    def reached(self) -> np.ndarray:
        return self.space.reached(spaces.WIDE)

    @cached_property
    def heights(self) -> np.ndarray:
        return spaces.height_map(self.mesh, self.low, self.high)

    @cached_property
    def level(self) -> spaces.CarryingLevel:
        return spaces.carrying_level(self.heights, self.low, self.high)

    @cached_property
    def seen(self) -> ObjectRests:
        rests = tuple(settle_spheres(self.mesh, self.cloud, self.radius, seed, timed=not seed) for seed in (0, 1))
        return ObjectRests(rests=rests, surface=self.tree(self.mesh), radius=self.radius)

    def tree(self, solid: Solid) -> cKDTree:
        """Return dense points on a shape, as a tree that is made in half the time of a balanced one."""
        points = dense_points(solid, self.radius / 6)
        return cKDTree(points, balanced_tree=False, compact_nodes=False)

    @property
    def capacity(self) -> float:
        """Volume of the water that it holds to the brim, m3."""
        return self.space.capacity

    @property
    def is_vessel(self) -> bool:
        """Whether it holds enough water to count as a vessel."""
        return self.capacity > max(OPEN, VESSEL * float((self.high - self.low).prod()))

    @cached_property
    def functions(self) -> Functions:
        return functions_of(self.cloud)


def functions_of(cloud: Cloud, checks: bool = True) -> Functions:
    """Return the functions of a cloud, as the shipped model classifies it.

    Parameters
    ----------
    checks : bool
        Whether an object that leaks is not a cup. Voxel shapes have gaps, so for shapes the capacity is measured
        separately, with grains.
    """
    decision = classify(cloud, explain=False).decision
    memberships = (decision if checks else replace(decision, failed_uses=())).memberships
    return {name: (one.member, round(one.score, 4)) for name, one in memberships.items()}


def row_of(subject: Subject, solid: Solid, criteria: KeepCriteria, early: bool = False) -> ShapeRow:
    """Return the row of one shape; if ``early``, without spheres and functions if it already loses something else."""
    row = with_verdict(free_row(subject, solid), subject, criteria)
    return row if early and row.lost else with_verdict(used_row(subject, solid, row), subject, criteria)


def free_row(subject: Subject, solid: Solid) -> ShapeRow:
    """Return the row of a shape with the values that follow from the free space."""
    require_size(subject, solid)
    space = subject.space.grid.free_space(solid)
    heights = spaces.height_map(solid, subject.low, subject.high)
    share, higher = spaces.level_kept(subject.level, subject.heights, heights, subject.extent)
    held, leaks = spaces.held_share(subject.space, space, GRAIN * subject.radius / space.grid.cell)
    reached = space.reached(spaces.NARROW)
    return ShapeRow(
        name=solid.name,
        pieces=solid.count,
        faces=len(solid.faces),
        bytes=solid.bytes,
        build_seconds=solid.build_seconds,
        capacity_ml=1e6 * held * subject.capacity,
        capacity_kept=held if subject.is_vessel else None,
        filled=subject.is_vessel
        and spaces.is_filled(subject.space.basin, subject.space.reached(spaces.NARROW), reached),
        level_kept=share,
        level_higher_mm=1e3 * higher,
        openings_closed=spaces.closed_openings(subject.reached, reached),
        notes=(LEAKS,) if leaks and subject.is_vessel else (),
    )


def used_row(subject: Subject, solid: Solid, row: ShapeRow) -> ShapeRow:
    """Return a row with the values that need spheres, and the functions."""
    rest = settle_spheres(solid, subject.cloud, subject.radius, 0)
    return replace(
        row,
        step_us=rest.step_us,
        settled=len(rest.centers),
        settled_kept=subject.seen.kept(rest),
        moved_mm=1e3 * moved(subject.seen, rest, subject.tree(solid)),
        deeper=subject.seen.deeper(rest),
        functions=functions_of(cloud_from_mesh(solid.vertices, solid.faces, solid.name), checks=False),
    )


def relative_size(subject: Subject, solid: Solid) -> float:
    """Return how many times as large as its object a shape is."""
    return float(np.ptp(solid.vertices, axis=0).max()) / subject.extent


def require_size(subject: Subject, solid: Solid):
    """Raise InputError for a shape whose size differs so much from its object's that the unit must be wrong."""
    times = relative_size(subject, solid)
    if not 1 / LARGER <= times <= LARGER:
        factor = f"{float(f'{max(times, 1 / times):.3g}'):,.12g}"  # 1,000 rather than 1e+03
        difference = f"{factor} times as {'large' if times > 1 else 'small'}"
        question = "are the units or the scale right?"
        raise InputError(f"{subject.cloud.name}: collision is {difference} as what is seen; {question}")


def with_verdict(row: ShapeRow, subject: Subject, criteria: KeepCriteria) -> ShapeRow:
    """Return a row with its verdict."""
    lost = tuple(losses(row, subject, criteria))
    return replace(row, lost=lost, keeps=not lost, verdict="; ".join(lost) if lost else price(row, subject))


def losses(row: ShapeRow, subject: Subject, criteria: KeepCriteria) -> Iterator[str]:
    """Yield sentences on what a shape does not keep."""
    if row.capacity_kept is not None and row.capacity_kept < criteria.share:
        held = f"holds {part_of(row.capacity_kept, 1e6 * subject.capacity)}"
        why = "solid for the engine" if row.filled else "it runs out through gaps"
        yield f"{held}: {why}" if row.capacity_kept < NOTHING else held
    if row.level_kept < criteria.share:
        side = "higher" if row.level_higher_mm > 0 else "lower"
        by = abs(row.level_higher_mm)
        moved = f", it is {by:.3g} mm {side}" if by > 1 else ""
        yield f"keeps {row.level_kept:.0%} of the level at {1e3 * subject.level.height:.0f} mm{moved}"
    if row.settled_kept is not None and row.settled_kept < criteria.share:
        yield f"keeps {row.settled_kept:.0%} of the spheres in their places"
    if row.openings_closed:
        places = f", in {row.openings_closed} places" if row.openings_closed > 1 else ""
        yield f"fills space that spheres went through{places}"
    if criteria.moved is not None and row.moved_mm > 1e3 * criteria.moved:
        yield f"resting places moved by {row.moved_mm:.2g} mm"
    for name, (member, _) in subject.functions.items():
        if member and name in row.functions and not row.functions[name][0]:
            yield f"is no longer classified as {name}"


def price(row: ShapeRow, subject: Subject) -> str:
    """Return a sentence on the cost of a shape that keeps everything."""
    mesh = subject.seen.rests[0].step_us
    if not (math.isfinite(mesh) and math.isfinite(row.step_us)) or row.name == "mesh":
        return "keeps everything"
    times = row.step_us / mesh
    if abs(times - 1) < SAME_COST:
        return "keeps everything at the cost of the mesh"
    return f"keeps everything at {times:.1f} times the cost of the mesh"


def part_of(share: float, millilitres: float) -> str:
    """Return a share of a volume and the volume as text.

    Examples
    --------
    >>> part_of(0.5, 310.4), part_of(0.9, 19018.0)
    ('155 of 310 ml', '17.1 of 19.0 l')
    """
    if millilitres < 1000:
        return f"{share * millilitres:.0f} of {millilitres:.0f} ml"
    return f"{share * millilitres / 1000:.1f} of {millilitres / 1000:.1f} l"
