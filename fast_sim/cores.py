"""One object's drops on several cores, with the same bits on any number of them.

The next few spheres are dropped at once, each as if the others were not there. Then they are taken in order: one whose
way a sphere has come near that settled before it in the same few is dropped again, all others are as they would have
been one by one. So the number of cores decides how long it takes, and nothing else.
"""

from __future__ import annotations

import os

import numpy as np
from numba import config, get_num_threads, njit, prange, set_num_threads

from .dropping import drop_one, take_in
from .nearby import MAX_LOOKS, SPHERE_REACH, Nearby

# Threads that wait give their core away: few drops are between two waits, and others may want it. Read by OpenMP as
# numba's first parallel kernel loads it.
os.environ.setdefault("OMP_WAIT_POLICY", "passive")
config.THREADING_LAYER_PRIORITY = ["omp", "tbb", "workqueue"]  # numba warns of old versions of the one it asks first

FEW, MANY = 8, 256  # spheres dropped at once, at least and at most
SELDOM, OFTEN = 0.08, 0.25  # shares of them dropped again, below and above which more and fewer are dropped at once
COLUMN_REACH = 4.0  # radii: so far from where it was last looked around a long fall can touch a sphere


@njit(cache=True, error_model="numpy", parallel=True)
def drop_at_once(points, spheres, nearbies, columns, radius, shape, low, high, ends, outcomes, touching, looks, counts):
    """Drop a sphere down each of the columns (B, 2), as if there were no other; none is entered.

    ``nearbies`` are scratch, the arrays of a `Nearby` for each core (W, …); where each sphere ended, what became of it,
    whether it touches the object, and its looks, are written into the last five.
    """
    cores = len(nearbies[0])
    for core in prange(cores):
        around, close, counted, place, normals, seen, asked = nearbies
        scratch = (normals[core], seen[core], asked[core])
        nearby = Nearby(around[core], close[core], counted[core], place[core], *scratch)
        for k in range(core, len(columns), cores):
            x, y = columns[k, 0], columns[k, 1]
            x, y, z, outcome, on_object = drop_one(points, spheres, nearby, x, y, radius, shape, low, high)
            ends[k, 0], ends[k, 1], ends[k, 2] = x, y, z
            outcomes[k], touching[k], counts[k] = outcome, on_object, nearby.counts[2]
            for i in range(min(counts[k], MAX_LOOKS)):
                for axis in range(4):
                    looks[k, i, axis] = nearby.looks[i, axis]


@njit(cache=True, error_model="numpy")
def came_near(centers, first, end, looks, count, radius):
    """Tell whether one of the spheres from ``first`` to ``end`` is where a sphere of so many looks can have felt it."""
    if count > MAX_LOOKS:
        return True
    around, column = (1.0001 * SPHERE_REACH * radius) ** 2, (COLUMN_REACH * radius) ** 2
    left, right, front, back = looks[0, 0], looks[0, 0], looks[0, 1], looks[0, 1]
    for i in range(1, count):
        left, right = min(left, looks[i, 0]), max(right, looks[i, 0])
        front, back = min(front, looks[i, 1]), max(back, looks[i, 1])
    margin = COLUMN_REACH * radius
    for s in range(first, end):
        x, y = centers[s, 0], centers[s, 1]
        if x < left - margin or x > right + margin or y < front - margin or y > back + margin:
            continue
        for i in range(count):
            dx, dy, dz = centers[s, 0] - looks[i, 0], centers[s, 1] - looks[i, 1], centers[s, 2] - looks[i, 2]
            across = dx * dx + dy * dy
            if across + dz * dz < around or (across < column and (i == 0 or looks[i, 3] > 0)):
                return True
    return False


@njit(cache=True, error_model="numpy")
def drop_spheres_at_once(
    points, spheres, nearby, nearbies, columns, radius, shape, low, high, miss_limit, limit, state, on_object, outcomes
):
    """Do as `drop_spheres`; ``nearbies`` are scratch, the arrays of a `Nearby` for each core (W, …)."""
    ends, became, touching = np.empty((MANY, 3)), np.empty(MANY, np.int64), np.empty(MANY, np.bool_)
    looks, counts = np.empty((MANY, MAX_LOOKS, 4)), np.empty(MANY, np.int64)
    begin, some = 0, 8 * FEW
    while begin < len(columns):
        batch = columns[begin : begin + some]
        drop_at_once(
            points, spheres, nearbies, batch, radius, shape, low, high, ends, became, touching, looks, counts
        )
        first, again = state[0], 0
        for k in range(len(batch)):
            if state[4] >= miss_limit or state[0] >= limit:
                return True
            x, y, z, outcome, touches = ends[k, 0], ends[k, 1], ends[k, 2], became[k], touching[k]
            if came_near(spheres.centers, first, state[0], looks[k], counts[k], radius):
                x, y = batch[k, 0], batch[k, 1]
                x, y, z, outcome, touches = drop_one(points, spheres, nearby, x, y, radius, shape, low, high)
                again += 1
            outcomes[begin + k] = outcome
            take_in(spheres, x, y, z, outcome, touches, state, on_object)
        begin += len(batch)
        if again < SELDOM * len(batch):
            some = min(MANY, 2 * some)
        elif again > OFTEN * len(batch):
            some = max(FEW, some // 2)
    return state[4] >= miss_limit or state[0] >= limit


def on_cores(cores: int, nearby: Nearby) -> tuple[np.ndarray, ...]:
    """Return scratch for so many cores, the arrays of a `Nearby` for each."""
    return tuple(np.empty((cores, *array.shape), array.dtype) for array in nearby)


class Threads:
    """So many threads of numba's, for as long as a ``with`` lasts."""

    def __init__(self, count: int):
        self.count = count

    def __enter__(self):
        self.before = get_num_threads()
        set_num_threads(self.count)

    def __exit__(self, *_):
        set_num_threads(self.before)
