"""Places to sit: a template of a sitter is placed on every cell at the height of a seat, in all headings."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy import ndimage

from ..processes.compilation import njit
from .place import FUNCTION, Place
from .regions import HeightMap, normal_of, plane_through, rings_of

TALL = 1.75  # metres, height of the person of the template
SEAT_HEIGHTS = 0.22, 0.60  # metres above the ground, for that person; on a higher seat the feet hang in the air
HIGH_SEAT = 0.86  # metres, for objects that are known as seats: a bar stool with a gas lift is that high
NARROW = 0.90  # metres, including the cells around it: a draughtsman's chair with its five feet is that wide
HEADINGS = 24
# Zones of the template: ahead (from, to) and aside (from, to) of the pelvis' middle, metres, of a person 1.75 m tall.
CORE, THIGHS, TRUNK, BACK, FRONT, FEET, ARMS = range(7)
ZONES = (
    (-0.11, 0.11, 0.0, 0.13),
    (0.11, 0.28, 0.0, 0.15),
    (-0.10, 0.14, 0.0, 0.17),
    (-0.34, -0.12, 0.0, 0.15),
    (0.28, 0.50, 0.0, 0.15),
    (0.42, 0.52, 0.0, 0.12),
    (-0.10, 0.25, 0.20, 0.38),
)
SOFT = 0.05  # metres by which a seat may differ from the level under the pelvis
STEEPEST_DEG = 16.0
STEEPEST = np.tan(np.radians(STEEPEST_DEG))
ROUGHEST = 0.018  # metres, standard deviation of a seat about its plane
STEP = 0.025  # metres between samples of a zone
OF_WHOLE = 0.3  # share of the score of a heading that all cells of the seat determine together
SMOOTHED = 3  # headings to either side over which a score is averaged, so that the middle of equal ones is chosen
APART = 0.55  # metres between persons
LEAST = 0.25  # least score of a place
GOOD = 0.75  # of the best score: least score of other places on the same seat
STRAIGHT = 0.015  # metres, standard deviation of a back about a line up to which it determines the heading
BACKED = 0.4  # least share of the width behind the sitter that is a back


@dataclass(frozen=True, eq=False)
class SeatScores:
    """The scores of the template at each cell and heading."""

    cells: np.ndarray  # (P, 2)
    scores: np.ndarray  # (P, HEADINGS)
    zones: np.ndarray  # (P, HEADINGS, 7): share of each zone that is supported, blocked, backed, or free
    levels: np.ndarray  # (P,) of the seat, metres


def sit_places(surface: HeightMap, person: float = TALL, sittable: float = 0.5) -> list[Place]:
    """Return places to sit, one for each person that there is room for.

    Parameters
    ----------
    surface : HeightMap
        See `regions.seat_surface`.
    person : float, metres
        Height of the person.
    sittable : float
        Score of the object as a seat, 0 to 1.
    """
    scale = person / TALL
    narrow = max(surface.heights.shape) * surface.cell < NARROW
    highest = HIGH_SEAT if sittable > 0.5 and narrow else SEAT_HEIGHTS[1]
    sittings = sittings_of(surface, scale, SEAT_HEIGHTS[0] * scale, highest * scale)
    chosen = choose(surface, sittings, APART * scale)
    places = [sit_place(surface, sittings, cell, heading, scale) for cell, heading in chosen]
    return [replace(place, score=place.score * (0.8 + 0.2 * share_facing(place, places))) for place in places]


def share_facing(place: Place, places: Sequence[Place]) -> float:
    """Return the share of places on the same object that face nearly the same way."""
    if place.heading_deg is None:
        return float(np.mean([other.heading_deg is None for other in places]))
    ways = [other.heading_deg for other in places if other.heading_deg is not None]
    return sum(abs((way - place.heading_deg + 180) % 360 - 180) <= 30 for way in ways) / len(places)


def sittings_of(surface: HeightMap, scale: float, lowest: float, highest: float) -> SeatScores:
    """Return the scores of the template at each cell at the height of a seat."""
    heights = np.where(np.isfinite(surface.heights), surface.heights, -10.0)
    smooth = ndimage.median_filter(heights, 3)
    cells = np.argwhere((smooth >= lowest) & (smooth <= highest))
    cells = cells[(cells.sum(axis=1) % 2 == 0) & (cells[:, 0] % 2 == 0)]  # every second one along both axes
    offsets, zones = template(scale, surface.cell)
    shares = np.zeros((len(cells), HEADINGS, len(ZONES)))
    levels, fits = np.zeros(len(cells)), np.zeros((len(cells), HEADINGS), np.bool_)
    counts = np.bincount(zones, minlength=len(ZONES)).astype(float)
    whole = np.ones(heights.shape, bool) if surface.whole is None else surface.whole
    lay(heights, smooth, whole, cells, offsets, zones, counts, surface.cell, scale, levels, shares, fits)
    core, thighs, trunk, back, front, feet = (shares[..., zone] for zone in range(6))
    scores = fits * core * (0.5 + 0.5 * thighs) * (1 - trunk) * (1 - 0.8 * front) * (0.55 + 0.3 * back + 0.15 * feet)
    scores = np.where(core >= 0.75, scores, 0.0)
    # In a corner two sides look like a back; the rest of the seat shows which one it is.
    seat = scores.max(axis=1) >= 0.6 * scores.max(initial=0.0)
    whole = scores[seat].sum(axis=0)
    scores = scores * (1 - OF_WHOLE + OF_WHOLE * whole / max(float(whole.max(initial=0.0)), 1e-9))
    around = sum(np.roll(scores, turn, axis=1) for turn in range(-SMOOTHED, SMOOTHED + 1)) / (2 * SMOOTHED + 1)
    return SeatScores(cells, 0.5 * scores + 0.5 * np.where(scores > 0, around, 0.0), shares, levels)


def template(scale: float, cell: float) -> tuple[np.ndarray, np.ndarray]:
    """Return offsets (HEADINGS, K, 2) in cells from the pelvis' middle, and the zone of each (K,)."""
    points, zones = [], []
    for zone, (behind, ahead, inner, outer) in enumerate(ZONES):
        along = np.arange(behind + STEP / 2, ahead, STEP)
        aside = np.arange(inner + STEP / 2, outer, STEP)
        u, v = np.meshgrid(along, np.concatenate([-aside, aside]), indexing="ij")
        points.append(np.column_stack([u.ravel(), v.ravel()]))
        zones.append(np.full(u.size, zone))
    laid = scale * np.vstack(points) / cell
    angles = 2 * np.pi * np.arange(HEADINGS) / HEADINGS
    turns = np.array([[[np.cos(a), np.sin(a)], [-np.sin(a), np.cos(a)]] for a in angles])
    return np.ascontiguousarray(laid @ turns), np.concatenate(zones)


@njit(cache=True, error_model="numpy")
def lay(heights, smooth, whole, cells, offsets, zones, counts, side, scale, levels, shares, fits):
    """Lay the template on each cell for each heading; a gap between slats is as high as what is around it."""
    nx, ny = heights.shape
    for p in range(len(cells)):
        x, y = cells[p, 0], cells[p, 1]
        total, near = 0.0, 0
        for i in range(max(0, x - 3), min(nx, x + 4)):
            for j in range(max(0, y - 3), min(ny, y + 4)):
                if abs(heights[i, j] - smooth[x, y]) < SOFT:
                    total += heights[i, j]
                    near += 1
        level = total / max(1, near)
        levels[p] = level
        held, tested = 0, 0
        for k in range(len(zones)):
            if zones[k] == CORE:
                i, j = int(x + 0.5 + offsets[0, k, 0]), int(y + 0.5 + offsets[0, k, 1])
                tested += 1
                if 0 <= i < nx and 0 <= j < ny and whole[i, j] and abs(heights[i, j] - level) <= SOFT:
                    held += 1
        if held < 0.6 * tested:
            continue
        for h in range(len(offsets)):
            n, su, sv, sz, suu, svv, suv, suz, svz, szz = 0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
            for k in range(len(zones)):
                du, dv = offsets[h, k, 0], offsets[h, k, 1]
                i, j = int(np.floor(x + 0.5 + du)), int(np.floor(y + 0.5 + dv))
                within = 0 <= i < nx and 0 <= j < ny
                z = heights[i, j] if within else -10.0
                rise = z - level
                zone = zones[k]
                if zone <= THIGHS:
                    if within and whole[i, j] and abs(rise) <= SOFT:
                        shares[p, h, zone] += 1.0 / counts[zone]
                    if abs(rise) <= 0.11:
                        a, b = du * side, dv * side
                        n += 1
                        su, sv, sz = su + a, sv + b, sz + rise
                        suu, svv, suv = suu + a * a, svv + b * b, suv + a * b
                        suz, svz, szz = suz + a * rise, svz + b * rise, szz + rise * rise
                if zone == TRUNK and rise > 0.10 * scale:
                    shares[p, h, TRUNK] += 1.0 / counts[TRUNK]
                elif zone == BACK and rise > 0.14 * scale:
                    # A back counts by its height, and by the width that it covers: its cells are few.
                    shares[p, h, BACK] += min(1.0, rise / (0.4 * scale)) * 4.0 / counts[BACK]
                elif zone == FRONT and rise > 0.07 * scale:
                    shares[p, h, FRONT] += 1.0 / counts[FRONT]
                elif zone == FEET and rise < -0.2 * scale:
                    shares[p, h, FEET] += 1.0 / counts[FEET]
                elif zone == ARMS and 0.08 * scale < rise < 0.4 * scale:
                    shares[p, h, ARMS] += 1.0 / counts[ARMS]
            shares[p, h, BACK] = min(1.0, shares[p, h, BACK])
            if n < 20:
                continue
            uu, vv, uv = suu - su * su / n, svv - sv * sv / n, suv - su * sv / n
            uz, vz, zz = suz - su * sz / n, svz - sv * sz / n, szz - sz * sz / n
            det = uu * vv - uv * uv
            if det <= 1e-12:
                continue
            gu, gv = (uz * vv - vz * uv) / det, (vz * uu - uz * uv) / det
            left = max(0.0, zz - gu * uz - gv * vz) / n
            fits[p, h] = np.sqrt(gu * gu + gv * gv) <= STEEPEST and np.sqrt(left) <= ROUGHEST


def choose(surface: HeightMap, sittings: SeatScores, apart: float) -> list[tuple[int, int]]:
    """Return pairs of a row of the cells and a heading: persons side by side, then those with another heading."""
    if not len(sittings.cells):
        return []
    best, scores = sittings.scores.argmax(axis=1), sittings.scores.max(axis=1)
    threshold, left = max(LEAST, GOOD * float(scores.max())), np.ones(len(scores), bool)
    middles, chosen = surface.middles(sittings.cells), []
    while (scores * left).max() >= threshold:
        first = int((scores * left).argmax())
        heading = int(best[first])
        for row in side_by_side(sittings, middles, left, first, heading, threshold, apart):
            chosen.append((row, heading))
            left &= np.linalg.norm(middles - middles[row], axis=1) >= 0.95 * apart
    return chosen


def side_by_side(
    sittings: SeatScores,
    middles: np.ndarray,
    left: np.ndarray,
    first: int,
    heading: int,
    threshold: float,
    apart: float,
) -> list[int]:
    """Return the rows of cells at which persons sit side by side with the first, evenly spaced."""
    angle = 2 * np.pi * heading / HEADINGS
    ahead, aside = np.array([np.cos(angle), np.sin(angle)]), np.array([-np.sin(angle), np.cos(angle)])
    scores = sittings.scores[:, heading]
    row = left & (scores >= threshold) & (np.abs((middles - middles[first]) @ ahead) < 0.12)
    row &= np.abs(sittings.levels - sittings.levels[first]) < SOFT
    across = (middles - middles[first]) @ aside
    low, high = connected_range(np.sort(across[row]), apart / 4)
    count = 1 + int((high - low + 1e-9) // apart)
    targets = low + (high - low) * ((np.arange(count) + 0.5) / count if count == 1 else np.arange(count) / (count - 1))
    rows = np.flatnonzero(row)
    return [int(rows[(scores[rows] - 2 * np.abs(across[rows] - target)).argmax()]) for target in targets]


def connected_range(places: np.ndarray, gap: float) -> tuple[float, float]:
    """Return the ends of the run of sorted places around 0 that has no larger gap."""
    cuts = np.flatnonzero(np.diff(places) > gap)
    starts, ends = np.append(0, cuts + 1), np.append(cuts, len(places) - 1)
    run = int(np.argmax((places[starts] <= 1e-9) & (places[ends] >= -1e-9)))
    return float(places[starts[run]]), float(places[ends[run]])


def sit_place(surface: HeightMap, sittings: SeatScores, row: int, heading: int, scale: float) -> Place:
    """Return the place of one person."""
    cell, level = sittings.cells[row], float(sittings.levels[row])
    zones, scores = sittings.zones[row, heading], sittings.scores[row]
    seat = seat_cells(surface, cell, level)
    plane, backed = plane_through(surface, seat), bool(zones[BACK] >= BACKED)
    faces = backed or scores.min() < 0.6 * scores.max()  # whether it matters which way a person faces
    angle, middle = 360.0 * heading / HEADINGS, surface.middles(cell)
    angle = along_back(surface, middle, level, angle, scale) if backed else angle
    ways = [np.radians(angle)] if faces else 2 * np.pi * np.arange(HEADINGS) / HEADINGS  # from any side: the shortest
    top = seat_top(surface, middle, level, scale)
    return Place(
        kind="sit",
        function=FUNCTION["sit"],
        position=np.array([*middle, top]),
        normal=normal_of(plane),
        heading_deg=angle if faces else None,
        region=rings_of(surface, seat, plane),
        area=float(seat.sum()) * surface.cell**2,
        height=top,
        score=float(min(1.0, scores[heading])),
        depth=min(depth_of(surface, seat, middle, way) for way in ways),
        back=backed,
        arms=bool(zones[ARMS] >= 0.12),
        knees=bool(zones[FRONT] < 0.2 and zones[FEET] > 0.5),
    )


def along_back(surface: HeightMap, middle: np.ndarray, level: float, heading: float, scale: float) -> float:
    """Return the heading, in degrees, at right angles to the back behind a sitter with about this heading."""
    where = surface.middles(np.argwhere(surface.heights > level + 0.14 * scale)) - middle
    for _ in range(2):
        angle = np.radians(heading)
        ahead, aside = where @ [np.cos(angle), np.sin(angle)], where @ [-np.sin(angle), np.cos(angle)]
        behind = (ahead < -0.05 * scale) & (ahead > -0.45 * scale) & (np.abs(aside) < 0.18 * scale)
        columns = np.round(aside[behind] / surface.cell).astype(int)
        nearest = {column: ahead[behind][columns == column].max() for column in np.unique(columns)}
        if len(nearest) < 5:
            return heading
        across, back = surface.cell * np.array(list(nearest)), np.array(list(nearest.values()))
        slope, middle_of_back = np.polyfit(across, back, 1)
        if np.std(back - slope * across - middle_of_back) > STRAIGHT:
            return heading
        heading = (heading - np.degrees(np.clip(np.arctan(slope), -0.6, 0.6))) % 360
    return float(heading)


def seat_top(surface: HeightMap, middle: np.ndarray, level: float, scale: float) -> float:
    """Return the height of the seat where a sitter is let down: that of its higher parts under the pelvis."""
    where = np.argwhere(np.abs(surface.heights - level) <= SOFT)
    under = np.linalg.norm(surface.middles(where) - middle, axis=1) <= 0.15 * scale
    return float(np.percentile(surface.heights[tuple(where[under].T)], 80)) if under.any() else level


def seat_cells(surface: HeightMap, cell: np.ndarray, level: float) -> np.ndarray:
    """Return the cells (X, Y) bool of the seat around a cell, with gaps between slats filled."""
    near = surface.closed(np.abs(surface.heights - level) <= SOFT) & np.isfinite(surface.heights)
    labels, _ = ndimage.label(near)
    return labels == labels[tuple(cell)] if labels[tuple(cell)] else near


def depth_of(surface: HeightMap, seat: np.ndarray, middle: np.ndarray, angle: float) -> float:
    """Return the depth of a seat through a place, along a direction, metres."""
    where = surface.middles(np.argwhere(seat)) - middle
    aside = np.abs(where @ [-np.sin(angle), np.cos(angle)])
    along = where[aside <= surface.cell] @ [np.cos(angle), np.sin(angle)]
    return float(np.ptp(along) + surface.cell) if len(along) else 0.0
