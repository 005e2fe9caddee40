"""An object beside the shapes that an engine could be given for it: one row for each."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.spatial import cKDTree

from ..answer import classify
from ..clouds.cloud import Cloud, cloud_from_mesh
from ..errors import InputError
from .rows import NOTHING, Functions, KeepCriteria, ShapeRow
from .solid import Solid, dense_points, surface
from .spaces import (
    NARROW,
    WIDE,
    CarryingLevel,
    FreeSpace,
    carrying_level,
    closed,
    grid_around,
    height_map,
    held_share,
    is_filled,
    level_kept,
    space_of,
)
from .spheres import ObjectRests, at_rest, moved

SPHERE = 1 / 28  # of the extent: the radius of the spheres, within the limits of what is dropped
SMALLEST, LARGEST = 0.002, 0.04  # metres
VESSEL = 0.05  # of the box: what holds less is no vessel by what it holds
OPEN = 1e-6  # m3: nor is what holds less than a millilitre
GRAIN = 0.6  # of the spheres' radius: what is finer may run out of a shape that is made for spheres
LEAKS = "its gaps hold spheres, and let water out"
SAME_COST = 0.05  # of the mesh's: a difference that timing does not tell
LARGER = 1.5  # times as large as the object: another unit, or another object


@dataclass(frozen=True, eq=False)
class Subject:
    """An object, with what is measured of it once."""

    cloud: Cloud

    @property
    def low(self) -> np.ndarray:
        return self.mesh.vertices.min(axis=0)

    @property
    def high(self) -> np.ndarray:
        return self.mesh.vertices.max(axis=0)

    @cached_property
    def mesh(self) -> Solid:
        """Its surface."""
        if self.cloud.mesh is None:
            raise InputError(f"{self.cloud.name}: expected a mesh, got points, which have no shape to compare with")
        return surface("mesh", self.cloud.mesh.vertices, self.cloud.mesh.faces)

    @property
    def extent(self) -> float:
        return float((self.high - self.low).max())

    @property
    def radius(self) -> float:
        """Of the spheres that are dropped, metres."""
        return float(np.clip(SPHERE * self.extent, SMALLEST, LARGEST))

    @cached_property
    def space(self) -> FreeSpace:
        return space_of(grid_around(self.low, self.high), self.mesh)

    @cached_property
    def reached(self) -> np.ndarray:
        return self.space.reached(WIDE)

    @cached_property
    def heights(self) -> np.ndarray:
        return height_map(self.mesh, self.low, self.high)

    @cached_property
    def level(self) -> CarryingLevel:
        return carrying_level(self.heights, self.low, self.high)

    @cached_property
    def seen(self) -> ObjectRests:
        rests = tuple(at_rest(self.mesh, self.cloud, self.radius, seed) for seed in (0, 1))
        return ObjectRests(rests=rests, surface=self.tree(self.mesh), radius=self.radius)

    def tree(self, solid: Solid) -> cKDTree:
        """Return dense points on a shape."""
        return cKDTree(dense_points(solid.vertices, solid.faces, self.radius / 6))

    @cached_property
    def capacity(self) -> float:
        """What it holds to the brim, m3."""
        return self.space.capacity

    @property
    def is_vessel(self) -> bool:
        """Whether what it holds is worth keeping."""
        return self.capacity > max(OPEN, VESSEL * float((self.high - self.low).prod()))

    @cached_property
    def functions(self) -> Functions:
        return functions_of(self.cloud)


def functions_of(cloud: Cloud, checks: bool = True) -> Functions:
    """Return what a cloud is for, by the model that ships.

    Parameters
    ----------
    checks : bool
        Whether what water runs out of is no cup. A shape of voxels has gaps: whether it still holds what its object
        does is measured for itself, with grains, and says more.
    """
    decision = classify(cloud, explain=False).decision
    memberships = (decision if checks else replace(decision, failed_uses=())).memberships
    return {name: (one.member, round(one.score, 4)) for name, one in memberships.items()}


def row_of(subject: Subject, solid: Solid, criteria: KeepCriteria, early: bool = False) -> ShapeRow:
    """Return the row of one shape; if ``early``, without spheres and functions where something is lost before."""
    row = with_verdict(free_row(subject, solid), subject, criteria)
    return row if early and row.lost else with_verdict(used_row(subject, solid, row), subject, criteria)


def free_row(subject: Subject, solid: Solid) -> ShapeRow:
    """Return what follows from the free space alone."""
    require_size(subject, solid)
    space = space_of(subject.space.grid, solid)
    heights = height_map(solid, subject.low, subject.high)
    share, higher = level_kept(subject.level, subject.heights, heights, subject.extent)
    held, leaks = held_share(subject.space, space, GRAIN * subject.radius / space.grid.cell)
    reached = space.reached(NARROW)
    return ShapeRow(
        name=solid.name,
        pieces=solid.count,
        faces=len(solid.faces),
        bytes=solid.bytes,
        build_seconds=solid.build_seconds,
        capacity_ml=space.capacity * 1e6,
        capacity_kept=held if subject.is_vessel else None,
        filled=subject.is_vessel and is_filled(subject.space.basin, subject.space.reached(NARROW), reached),
        level_kept=share,
        level_higher_mm=1e3 * higher,
        openings_closed=closed(subject.reached, reached),
        notes=(LEAKS,) if leaks and subject.is_vessel else (),
    )


def used_row(subject: Subject, solid: Solid, row: ShapeRow) -> ShapeRow:
    """Return a row with what spheres tell."""
    rest = at_rest(solid, subject.cloud, subject.radius, 0)
    return replace(
        row,
        step_us=rest.step_us,
        settled=len(rest.centers),
        settled_kept=subject.seen.kept(rest),
        moved_mm=1e3 * moved(subject.seen, rest, subject.tree(solid)),
        deeper=subject.seen.deeper(rest),
        functions=functions_of(cloud_from_mesh(solid.vertices, solid.faces, solid.name), checks=False),
    )


def require_size(subject: Subject, solid: Solid):
    """Raise InputError for a shape of another size than its object, which another unit would explain."""
    size = float(np.ptp(solid.vertices, axis=0).max())
    times = size / subject.extent
    if not 1 / LARGER <= times <= LARGER:
        difference = f"{times:.3g} times as large" if times > 1 else f"{1 / times:.3g} times as small"
        question = "are the units or the scale right?"
        raise InputError(f"{subject.cloud.name}: collision is {difference} as what is seen; {question}")


def with_verdict(row: ShapeRow, subject: Subject, criteria: KeepCriteria) -> ShapeRow:
    """Return a row with its verdict."""
    lost = tuple(losses(row, subject, criteria))
    return replace(row, lost=lost, keeps=not lost, verdict="; ".join(lost) if lost else price(row, subject))


def losses(row: ShapeRow, subject: Subject, criteria: KeepCriteria) -> Iterator[str]:
    """Yield what a shape does not keep."""
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
        yield "fills space that spheres went through" + (
            f", in {row.openings_closed} places" if row.openings_closed > 1 else ""
        )
    if criteria.moved is not None and row.moved_mm > 1e3 * criteria.moved:
        yield f"resting places moved by {row.moved_mm:.2g} mm"
    for name, (member, _) in subject.functions.items():
        if member and name in row.functions and not row.functions[name][0]:
            yield f"is no longer classified as {name}"


def price(row: ShapeRow, subject: Subject) -> str:
    """Return at which cost everything is kept."""
    mesh = subject.seen.rests[0].step_us
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
