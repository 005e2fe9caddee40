"""Places on partly seen objects: where spheres rest in a hollow, and the middle of a level.

A sitter's template and flooding with water need whole surfaces, but a view may show half of a mug, or a seat under a
table.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy import ndimage

from spherefunc_bullet.clouds.cloud import Cloud
from spherefunc_bullet.clouds.water import SPILLED_AT
from spherefunc_bullet.places.place import FUNCTION, Place, Similarity
from spherefunc_bullet.places.pouring import ABOVE, pour_places
from spherefunc_bullet.places.putting import DISC, put_places
from spherefunc_bullet.places.regions import HeightMap, rings_of, seat_surface, surface_of
from spherefunc_bullet.places.shelves import GAP
from spherefunc_bullet.places.sitting import HIGH_SEAT, NARROW, SEAT_HEIGHTS, sit_places
from spherefunc_bullet.simulator import Simulator

from ..pools.tops import Top
from ..pools.vessels import VesselPool, vessel_pools
from ..scans.cells import cells
from ..scans.depth_image import filled
from ..scans.scan import Scan
from ..settings import POOL, RECOGNITION, SCAN, SEGMENTATION
from .completion import complete
from .room import InferredObject, Room, SceneObject
from .surroundings import level_of

_NOTE = "seen in part"
_UNSEEN = "to be pulled out from under its table"


def level_place(item: SceneObject, kind: str, around: np.ndarray) -> Place | None:
    """Return the place in the middle of an object's level, to sit or to put; None without room for a disc.

    Parameters
    ----------
    kind : {"sit", "put"}
    around : (N, 3) float64, metres, level frame
        The scene: places to put are only where nothing is above the level; places to sit are also under a table.
    """
    voxels = cells(item.points, SEGMENTATION.leaf_size).means
    if kind == "sit":
        highest = HIGH_SEAT if item.box.size[0] < NARROW else SEAT_HEIGHTS[1]
        above = voxels[:, 2] - item.support
        voxels = voxels[(above > SEAT_HEIGHTS[0]) & (above < highest)]
    if len(voxels) < POOL.min_points:
        return None
    height = level_of(voxels, SEGMENTATION.leaf_size).height
    squares = cells(voxels[np.abs(voxels[:, 2] - height) <= POOL.slab] * [1, 1, 0], SCAN.cell).indices[:, :2]
    corner = squares.min(axis=0) - 2
    mask = np.zeros(squares.max(axis=0) - corner + 3, bool)
    mask[tuple((squares - corner).T)] = True
    surface = HeightMap(corner * SCAN.cell, SCAN.cell, np.where(mask, height, -np.inf), 0.0)
    mask = surface.closed(mask)
    if kind == "put":
        mask &= ~covered(surface, around, height)
    room = SCAN.cell * (ndimage.distance_transform_edt(mask) - 0.5)
    if room.max() < DISC:
        return None
    middle = surface.middles(np.array(np.unravel_index(room.argmax(), room.shape)))
    return Place(
        kind=kind,
        function=FUNCTION[kind],
        position=np.array([*middle, height]),
        region=rings_of(surface, mask, np.array([0.0, 0.0, height])),
        area=float(mask.sum()) * SCAN.cell**2,
        height=height,
        score=RECOGNITION.trust,
        radius=float(room.max()),
        inferred=True,
        note=_NOTE,
    )


def covered(surface: HeightMap, points: np.ndarray, height: float) -> np.ndarray:
    """Return the squares (X, Y) bool of a surface with points (N, 3) above them within a hand's reach."""
    over = points[(points[:, 2] > height + POOL.slab) & (points[:, 2] < height + GAP)]
    places = np.floor((over[:, :2] - surface.origin) / surface.cell).astype(int)
    hidden = np.zeros(surface.heights.shape, bool)
    hidden[tuple(places[((places >= 0) & (places < hidden.shape)).all(axis=1)].T)] = True
    return hidden


def hollow_places(item: SceneObject, simulator: str | Simulator) -> list[Place]:
    """Return the place to pour where small spheres rest in an object with a wall around them in most directions.

    Spheres are dropped on the seen points; if none rest there, on the completed object.
    """
    for points in (item.points, complete(item.points, support=item.support)):
        standing = Top(plane=np.array([0.0, 0.0, item.support]), points=points, indices=np.arange(len(points)))
        pools = vessel_pools(standing, simulator)
        if pools:
            return [hollow_place(pools[0])]
    return []


def hollow_place(pool: VesselPool) -> Place:
    """Return a pool as a place to pour; its capacity is that of a cylinder as wide as its walls."""
    angles = np.linspace(0, 2 * np.pi, 24, endpoint=False)
    ring = pool.center[:2] + pool.reach * np.column_stack([np.cos(angles), np.sin(angles)])
    area = float(np.pi * pool.reach**2)
    depth = float(pool.rim - pool.center[2])
    return Place(
        kind="pour",
        function=FUNCTION["pour"],
        position=np.array([*pool.center[:2], pool.rim + ABOVE]),
        region=(np.column_stack([ring, np.full(len(ring), pool.rim)]),),
        area=area,
        height=float(pool.rim),
        score=float(np.clip(2 * depth / np.sqrt(area), 0, 1)) * RECOGNITION.trust,
        radius=pool.reach,
        capacity_ml=area * depth * 1e6,
        filled_ml=SPILLED_AT * area * depth * 1e6,
        depth=depth,
        inside=(np.array([*ring.min(axis=0), pool.center[2]]), np.array([*ring.max(axis=0), pool.rim])),
        inferred=True,
        note=_NOTE,
    )


SIMULATOR = "fast"  # whose spheres find the hollows of partly seen vessels


def room_places(
    scan: Scan, room: Room, put: Cloud | None = None, person: float = 1.75
) -> dict[int | None, list[Place]]:
    """Return the places of each object by its id, in the scan's frame; places to put on no object are under None."""
    cloud = Cloud(filled(room.levelling.to_level(scan.points), SEGMENTATION.leaf_size), scan.name)
    found: dict[int | None, list[Place]] = {item.id: object_places(cloud, item, person) for item in room.objects}
    lowest = -POOL.slab if room.levelling.source == "table top" else POOL.lowest
    for place in put_places(surface_of(cloud), put, lowest):
        found.setdefault(owner_of(place, room), []).append(place)
    for item in room.objects:
        if "table" in item.members and not any(place.kind == "put" for place in found[item.id]):
            found[item.id] += filter(None, [level_place(item, "put", cloud.points)])
    if room.inferred:
        low = cloud.points[(cloud.points[:, 2] > SEAT_HEIGHTS[0]) & (cloud.points[:, 2] < SEAT_HEIGHTS[1])]
        found.setdefault(None, []).extend(seat_below(seat, room, low) for seat in room.inferred)
    R = room.levelling.T_level_scan[:3, :3].T
    back = Similarity(R, 1.0, -R @ room.levelling.T_level_scan[:3, 3])
    return {owner: [place.moved(back) for place in places] for owner, places in found.items() if places}


def seat_below(seat: InferredObject, room: Room, points: np.ndarray) -> Place:
    """Return the place to sit on a chair of which only the back is seen at a table; it faces the table.

    Its height is that of the visible part of the seat under the table, or the usual height of seats.

    Parameters
    ----------
    points : (N, 3) float64, metres, level frame
        Of the scene, at the heights of seats.
    """
    table = next(item for item in room.objects if item.id == seat.table)
    across = seat.box.axes[1, :2]
    ahead = across if across @ (table.box.center[:2] - seat.box.center[:2]) > 0 else -across
    width, depth, _ = seat.box.size
    top = level_of(table.points, SEGMENTATION.leaf_size).height
    near = (np.abs(seat.box.to_own(points)[:, :2]) <= [width / 2, depth / 2]).all(axis=1)
    near &= (points[:, :2] - seat.box.center[:2]) @ ahead > RECOGNITION.back_thickness - depth / 2
    level = points[near & (points[:, 2] < top - RECOGNITION.thighs)]
    enough = len(level) >= POOL.min_points
    height = level_of(level, SEGMENTATION.leaf_size).height if enough else float(np.mean(SEAT_HEIGHTS))
    corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * [width / 2, depth / 2] @ seat.box.axes[:2, :2]
    return Place(
        kind="sit",
        function=FUNCTION["sit"],
        position=np.array([*seat.box.center[:2], height]),
        heading_deg=float(np.degrees(np.arctan2(ahead[1], ahead[0])) % 360),
        region=(np.column_stack([seat.box.center[:2] + corners, np.full(4, height)]),),
        area=float(width * depth),
        height=height,
        clearance=float(top - height),
        score=RECOGNITION.trust * table.functions[FUNCTION["put"]].score,
        depth=float(depth),
        back=True,
        knees=False,
        inferred=True,
        note=f"{_UNSEEN}: {seat.reason}",
    )


def object_places(room_cloud: Cloud, item: SceneObject, person: float) -> list[Place]:
    """Return the places to sit on and to pour into an object, in the level frame."""
    found = []
    if "sittable" in item.members:
        near = around(room_cloud.points, item)
        lifted = Cloud(near - [0, 0, item.support], room_cloud.name)
        seats = sit_places(seat_surface(lifted), person, 1.0)
        raised = Similarity(np.eye(3), 1.0, np.array([0.0, 0.0, item.support]))
        inside = [place.moved(raised) for place in seats if within(place.position, item)]
        found += inside or filter(None, [level_place(item, "sit", room_cloud.points)])
    if "cup" in item.members and len(item.points) >= 10:
        found += pour_places(Cloud(item.points, room_cloud.name)) or hollow_places(item, SIMULATOR)
    return [replace(place, score=float(np.sqrt(place.score * item.functions[place.function].score))) for place in found]


def around(points: np.ndarray, item: SceneObject) -> np.ndarray:
    """Return the points (N, 3) on and around an object."""
    low, high = item.points.min(axis=0) - RECOGNITION.around, item.points.max(axis=0) + RECOGNITION.around
    low[2] = item.support - 0.05
    return points[((points >= low) & (points <= high)).all(axis=1)]


def within(position: np.ndarray, item: SceneObject) -> bool:
    """Return whether a position is above an object's box."""
    aside = (position[:2] - item.box.center[:2]) @ item.box.axes[:2, :2].T
    return bool((np.abs(aside) <= item.box.size[:2] / 2 + 0.05).all())


def owner_of(place: Place, room: Room) -> int | None:
    """Return the id of the smallest object on which a place is; None if it is on none."""
    on = [
        item
        for item in room.objects
        if within(place.position, item) and item.support - 0.05 <= place.height <= item.points[:, 2].max() + 0.05
    ]
    return min(on, key=lambda item: float(item.box.size[0] * item.box.size[1])).id if on else None
