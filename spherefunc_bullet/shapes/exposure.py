"""The exposed surface of an object, which a sphere can reach, and how exactly a shape has to follow it."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial import cKDTree

from ..clouds.raycasting import raycasting_scene, rays_from
from .fitting import ExposedSurface, cut, joined
from .solid import Solid, capped, of_pieces
from .spaces import NARROW

if TYPE_CHECKING:
    from .comparison import Subject

UPWARD = 0.5  # vertical component of the normal of surfaces on which objects rest: slopes of up to 60 degrees
RESTED, HELD, OTHER = 0.003, 0.008, 0.012  # of the extent: tolerances where objects rest, in a vessel, elsewhere
EDGE = 1.0  # radii down the edge of a surface on which objects rest
UNDER = 3.0  # radii around the centre of a sphere at rest
GRAZED = 0.004  # of the extent: distance of pieces from the free space, so that thin pieces do not bridge it
FINEST = 0.0005  # metres
BLUNT = 1e-3  # of the extent: corners of a piece that stand out less are not worth their cost
OFF = 0.01  # of the way out: offset of the start of a ray from the surface
FACES = 3_000  # that are cut; simplifying finer meshes costs a fraction of a millimetre and saves a minute
SEEN, ROOM = 16_000, 6_000  # approximate number of samples of the surface, and of the free space around it
FEWER = 4  # one in so many samples is used where nothing rests and nothing is held


def exposed_surface(subject: Subject, scale: float) -> ExposedSurface:
    """Return the exposed places of an object's surface, with scaled tolerances."""
    places, normals = samples(subject.mesh, SEEN)
    places, outward = np.vstack([places, places]), np.vstack([normals, -normals])
    reached, basin = subject.space.reached(NARROW), subject.space.basin
    grid = subject.space.grid
    way = NARROW * subject.extent + 1.5 * grid.cell
    free = values_at(reached, (places + way * outward - grid.low) / grid.cell)
    held = values_at(basin, (places + 2 * grid.cell * outward - grid.low) / grid.cell)
    shown = (free | held) & has_clear_way(subject.mesh, places, outward, way)
    places, outward, held = places[shown], outward[shown], held[shown]
    share = np.where(held, HELD, OTHER)
    level = (outward[:, 2] > UPWARD) & rested_on(subject, places)
    rims = level & subject.is_vessel  # a sphere on a rim leans on both sides of it
    share[level | edge_of(places, rims, EDGE * subject.radius)] = RESTED
    chosen = (share < OTHER) | (np.arange(len(share)) % FEWER == 0)
    places, outward, share, level = places[chosen], outward[chosen], share[chosen], level[chosen]
    room, grazed = free_places(subject), GRAZED * subject.extent
    scales = np.where(share == RESTED, min(scale, 1.0), scale)  # on a different slope a sphere would roll
    followed = np.maximum(FINEST, scales * share * subject.extent)
    return ExposedSurface(
        places=np.vstack([places, room]),
        outward=np.vstack([outward, np.zeros_like(room)]),
        tolerance=np.append(followed, np.full(len(room), grazed)),
        clear=np.append(np.where(level, way, 0.0), np.zeros(len(room))),
        reach=np.append(np.zeros(len(places)), np.full(len(room), 2 * grazed)),
    )


def rested_on(subject: Subject, places: np.ndarray) -> np.ndarray:
    """Return whether each place (S, 3) lies under a sphere at rest, (S,) bool."""
    centers = np.concatenate([rest.touching for rest in subject.seen.rests])
    if not len(centers):
        return np.zeros(len(places), bool)
    return cKDTree(centers).query(places)[0] < UNDER * subject.radius


def edge_of(places: np.ndarray, level: np.ndarray, reach: float) -> np.ndarray:
    """Return whether each place (S, 3) lies near the places of a level (S,) bool, and not above them, (S,) bool."""
    if not level.any():
        return level
    gaps, nearest = cKDTree(places[level]).query(places, distance_upper_bound=reach)
    found = np.isfinite(gaps)
    found[found] = places[found, 2] <= places[level][nearest[found], 2]
    return found


def free_places(subject: Subject) -> np.ndarray:
    """Return random places (R, 3) in the free space within an object's bounding box, which no piece may bridge."""
    grid = subject.space.grid
    places = grid.low + (np.argwhere(subject.space.reached(NARROW)) + 0.5) * grid.cell
    places = places[((places > subject.low) & (places < subject.high)).all(axis=1)]
    return np.random.default_rng(0).permutation(places)[:ROOM]


def samples(solid: Solid, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Return ``count`` places (S, 3) spread over a surface, and its normals there (S, 3)."""
    corners = solid.vertices[solid.faces]
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    twice = np.linalg.norm(across, axis=1)
    chosen = np.searchsorted(np.cumsum(twice) / twice.sum(), (np.arange(count) + 0.5) / count)
    chosen = np.minimum(chosen, len(corners) - 1)
    a, b = np.random.default_rng(0).random((2, count, 1))
    over = a + b > 1
    a, b = np.where(over, 1 - a, a), np.where(over, 1 - b, b)
    first, second, third = np.moveaxis(corners[chosen], 1, 0)
    return first + a * (second - first) + b * (third - first), across[chosen] / twice[chosen, None]


def has_clear_way(solid: Solid, places: np.ndarray, outward: np.ndarray, way: float) -> np.ndarray:
    """Return whether a ray of length ``way``, metres, from each place (S, 3) hits no wall of a surface, (S,) bool."""
    scene = raycasting_scene((solid.vertices, solid.faces))
    return scene.cast_rays(rays_from(places + OFF * way * outward, outward))["t_hit"].numpy() > way


def values_at(cells: np.ndarray, places: np.ndarray) -> np.ndarray:
    """Return the values of cells (X, Y, Z) at places (S, 3), in cells."""
    index = np.clip(places.astype(int), 0, np.array(cells.shape) - 1)
    return cells[tuple(index.T)]


class Fitting:
    """Makes convex pieces that follow the exposed surface of an object; finer ones continue the cuts of coarser."""

    def __init__(self, subject: Subject, enough: Callable[[], bool] = lambda: False):
        self.subject, self.enough = subject, enough
        self.parts: list[np.ndarray] = []

    def pieces(self, scale: float) -> Solid:
        """Return pieces within scaled tolerances, or coarser ones if ``enough`` returns True before."""
        exposed = exposed_surface(self.subject, scale)
        parts = cut(self.parts or [simplified(self.subject.mesh)], exposed, self.enough)
        self.parts = [part.triangles for part in parts]
        pieces, off = joined(parts, exposed, self.enough), BLUNT * self.subject.extent
        return of_pieces("fitted", [capped(piece, off) for piece in pieces])


def simplified(solid: Solid) -> np.ndarray:
    """Return a surface as triangles (T, 3, 3), by quadric decimation at most about `FACES`."""
    if len(solid.faces) <= FACES:
        return solid.vertices[solid.faces]
    import open3d as o3d

    vertices, faces = o3d.utility.Vector3dVector(solid.vertices), o3d.utility.Vector3iVector(solid.faces)
    fewer = o3d.geometry.TriangleMesh(vertices, faces).simplify_quadric_decimation(FACES)
    return np.asarray(fewer.vertices)[np.asarray(fewer.triangles)]
