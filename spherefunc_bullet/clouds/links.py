"""Links between neighbouring cells of space with no surface between them, and floods along these links."""

from __future__ import annotations

import numpy as np

from ..processes.compilation import lean_njit


@lean_njit(cache=True, error_model="numpy")
def cut_links(triangles, cuts):
    """Mark the links between the centres of neighbours that triangles (T, 3, 3), in cells, cross: bits of x, y and z.

    The bit of an axis is stored in the lower of the two cells.
    """
    sizes = cuts.shape
    for t in range(len(triangles)):
        for axis in range(3):
            b, c = (axis + 1) % 3, (axis + 2) % 3
            p, q, r = triangles[t, 0], triangles[t, 1], triangles[t, 2]
            area = (q[b] - p[b]) * (r[c] - p[c]) - (q[c] - p[c]) * (r[b] - p[b])
            if abs(area) < 1e-12:
                continue
            first_b = max(0, int(np.ceil(min(p[b], q[b], r[b]) - 0.5 - 1e-7)))
            last_b = min(sizes[b] - 1, int(np.floor(max(p[b], q[b], r[b]) - 0.5 + 1e-7)))
            first_c = max(0, int(np.ceil(min(p[c], q[c], r[c]) - 0.5 - 1e-7)))
            last_c = min(sizes[c] - 1, int(np.floor(max(p[c], q[c], r[c]) - 0.5 + 1e-7)))
            for i in range(first_b, last_b + 1):
                y = i + 0.5
                for j in range(first_c, last_c + 1):
                    z = j + 0.5
                    u = ((y - p[b]) * (r[c] - p[c]) - (z - p[c]) * (r[b] - p[b])) / area
                    v = ((q[b] - p[b]) * (z - p[c]) - (q[c] - p[c]) * (y - p[b])) / area
                    if u < -1e-6 or v < -1e-6 or u + v > 1 + 1e-6:
                        continue
                    along = p[axis] + u * (q[axis] - p[axis]) + v * (r[axis] - p[axis])
                    k = int(np.floor(along - 0.5))
                    if k < 0 or k >= sizes[axis]:
                        continue
                    if axis == 0:
                        cuts[k, i, j] |= 1
                    elif axis == 1:
                        cuts[j, k, i] |= 2
                    else:
                        cuts[i, j, k] |= 4


@lean_njit(cache=True, error_model="numpy")
def beyond(cuts, i, j, k, side):
    """Return the neighbour of a cell on one of its six sides, and whether the link to it is free."""
    axis, forward = side // 2, side % 2 == 1
    a, b, c = i, j, k
    step = 1 if forward else -1
    if axis == 0:
        a += step
    elif axis == 1:
        b += step
    else:
        c += step
    if a < 0 or b < 0 or c < 0 or a >= cuts.shape[0] or b >= cuts.shape[1] or c >= cuts.shape[2]:
        return a, b, c, False
    keeper = cuts[i, j, k] if forward else cuts[a, b, c]
    return a, b, c, (keeper >> axis) & 1 == 0


@lean_njit(cache=True, error_model="numpy")
def flood_links(cuts, solid, levels, links, heads):
    """Write the lowest height, in layers, over which each free cell can be reached from the first one; -1 if it cannot.

    The outermost cells must be free, so that the first one represents all of them.

    Parameters
    ----------
    cuts : (X, Y, Z) uint8
        Links between cells that a surface crosses, see `cut_links`.
    solid : (X, Y, Z) bool
    levels : (X, Y, Z) int32
        All -1; receives the heights.
    links : (X * Y * Z,) int64
        Scratch, all -1: the next waiting cell at the same height.
    heads : (Z,) int64
        Scratch, all -1: the first waiting cell at each height.
    """
    nx, ny, nz = cuts.shape
    levels[0, 0, 0], heads[0] = 0, 0
    for level in range(nz):
        while heads[level] >= 0:
            cell = heads[level]
            heads[level] = links[cell]
            i, j, k = cell // (ny * nz), cell // nz % ny, cell % nz
            for side in range(6):
                a, b, c, free = beyond(cuts, i, j, k, side)
                if not free or solid[a, b, c] or levels[a, b, c] >= 0:
                    continue
                height = max(level, c)
                levels[a, b, c] = height
                neighbor = (a * ny + b) * nz + c
                links[neighbor], heads[height] = heads[height], neighbor


@lean_njit(cache=True, error_model="numpy")
def label_links(cuts, wet, labels, stack):
    """Number the bodies of linked wet cells, from 1; return their number."""
    nx, ny, nz = cuts.shape
    count = 0
    for start in range(wet.size):
        i, j, k = start // (ny * nz), start // nz % ny, start % nz
        if not wet[i, j, k] or labels[i, j, k] > 0:
            continue
        count += 1
        labels[i, j, k] = count
        stack[0], top = start, 1
        while top > 0:
            top -= 1
            cell = stack[top]
            i, j, k = cell // (ny * nz), cell // nz % ny, cell % nz
            for side in range(6):
                a, b, c, free = beyond(cuts, i, j, k, side)
                if free and wet[a, b, c] and labels[a, b, c] == 0:
                    labels[a, b, c] = count
                    stack[top] = (a * ny + b) * nz + c
                    top += 1
    return count
