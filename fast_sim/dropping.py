"""Dropping: one sphere after another, until 50 in a row were not placed (paper, §III-A)."""

from __future__ import annotations

from .falling import fall
from .grid import insert
from .kernels import entry_jit, inline_jit
from .nearby import is_in_strip
from .rolling import ASTRAY, SETTLED, roll


@inline_jit
def drop_one(points, spheres, nearby, x, y, radius, shape, low, high):
    """Drop a sphere down a column; return x, y, z, the outcome and whether it rests on the object itself."""
    if not is_in_strip(nearby, x, y):
        return x, y, 0.0, ASTRAY, False
    # Above everything: the centre of a sphere on top of the object is one radius above it, and a sphere on that one is
    # two radii higher.
    z, _ = fall(points, spheres, x, y, high[2] + 4 * radius, radius)
    return roll(points, spheres, nearby, x, y, z, radius, shape, low, high)


@inline_jit
def record_outcome(spheres, x, y, z, outcome, touching, state, on_object):
    """Record the outcome of a drop: in the counts, and in the grid if the sphere has settled."""
    state[outcome] += 1
    if outcome != SETTLED:
        state[4] += 1
        return
    i = state[0] - 1
    spheres.centers[i, 0], spheres.centers[i, 1], spheres.centers[i, 2] = x, y, z
    spheres.used[0] += insert(spheres, x, y, z, spheres.used[0])
    on_object[i] = touching
    state[4] = 0


@entry_jit
def drop_spheres(
    points, spheres, nearby, columns, radius, shape, low, high, miss_limit, limit, state, on_object, outcomes
):
    """Drop a sphere down each of the columns until one of the limits is reached.

    Parameters
    ----------
    points, spheres : PointGrid, SphereGrid
        ``spheres`` receives those that settle.
    nearby : Nearby
        Scratch.
    columns : (M, 2) float64
        Where to drop, metres.
    low, high : (3,) float64
        The object's bounding box.
    miss_limit, limit : int
        Consecutive misses, and settled spheres, that end the run.
    state : (5,) int64
        Settled, rolled off, rejected, timed out, and consecutive misses so far; updated.
    on_object : (capacity,) bool
        Receives whether each settled sphere touches the object.
    outcomes : (M,) int8
        Receives the outcome of the sphere of each column.

    Returns
    -------
    bool
        Whether the run has ended.
    """
    for k in range(len(columns)):
        if state[4] >= miss_limit or state[0] >= limit:
            return True
        x, y = columns[k, 0], columns[k, 1]
        x, y, z, outcome, touching = drop_one(points, spheres, nearby, x, y, radius, shape, low, high)
        outcomes[k] = outcome
        record_outcome(spheres, x, y, z, outcome, touching, state, on_object)
    return state[4] >= miss_limit or state[0] >= limit
