"""Round bottoms, which a mesh approximates by facets: whether they roll, and to which pose they right themselves.

An object does not rest on a facet of a round bottom: a bowl does not lean on the triangle on which it happens to be
put. The corners of the facets lie on the intended surface, which can be fitted to them. The object is at rest where
this surface is nearest to its centre of mass, and stable if the centre of mass is below the centre of curvature.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .facets import TURN_DEG, Facets

ALIKE = 4.0  # ratio of areas: a face that exceeds those around it by more is a foot, not a facet of a round surface
CLEAR = 1 / 3  # of the largest angle between facets at a bottom: smaller angles are unevenness
RIM = 0.6  # of the distance of the farthest corner: a bottom that bends only farther out is flat
FEWEST = 10  # corners: a polynomial with six terms fits any six of them
FLATTEST = 3.0  # extents, the radius of curvature: flatter bottoms are feet that are not quite level
MISFIT = 0.01  # of the radius of curvature: largest root mean square distance of corners from the fitted surface
NEUTRAL = 0.02  # of the radius of curvature: depth of the centre of mass below its centre that is needed for righting
ROLLING = 0.005  # of the height of the centre of mass: largest rise on the way to another pose of a body that rolls
ROLLS_DEG = 45.0  # smallest angle to that pose; towards nearer poses a body may just rock


@dataclass(frozen=True, kw_only=True, eq=False)
class RestState:
    """The state of a body at rest."""

    down: np.ndarray  # (3,) the direction of the body that points down
    flat: bool = True  # on a face of its hull, for which statics is exact
    rolls: bool = False


@dataclass(frozen=True, kw_only=True, eq=False)
class NearestPoint:
    """The point of a smooth surface that is nearest to the centre of mass."""

    down: np.ndarray  # (3,) its direction
    rise: float  # smallest depth of the centre of mass below the centre of curvature, relative to the radius
    radius: float  # of the best-fitting sphere, extents
    misfit: float  # root mean square distance of the corners from the surface, relative to the radius
    roughness: float  # the same from the sphere


def rest_at(facets: Facets, facet: int) -> RestState:
    """Return the state of a body that has come to rest on one of its resting facets."""
    lying = RestState(down=facets.normals[facet])
    if rolls_away(facets, facet):
        return RestState(down=lying.down, flat=False, rolls=True)
    bottom = bottom_of(facets, facet)
    around = extended(facets, bottom)
    farther = extended(facets, around)
    if len(around) == len(bottom) or is_foot(facets, bottom, around) or has_even_middle(facets, bottom, farther):
        return lying  # also for the tip of a cone
    corners = facets.corners[np.unique(facets.triangles[farther])]
    surface = nearest_surface(corners, facets.normals[bottom].mean(axis=0))
    if len(corners) < FEWEST or surface.radius > FLATTEST or surface.misfit > MISFIT:
        return lying
    if (
        abs(surface.rise) < NEUTRAL and surface.roughness < MISFIT
    ):  # a ball; `rolls_away` has found other rolling bodies
        return RestState(down=lying.down, flat=False, rolls=True)
    near = (facets.normals[bottom] @ surface.down).max() > np.cos(np.radians(TURN_DEG / 2))
    return RestState(down=surface.down, flat=False) if near and surface.rise >= NEUTRAL else lying


def rolls_away(facets: Facets, rest: int) -> bool:
    """Return whether a body rolls easily from the facet on which it rests to a distant one."""
    left, seen = [rest], {rest}
    limit, level = facets.heights[rest] * (1 + ROLLING), facets.heights[rest] * (1 - ROLLING)
    while left:
        facet = left.pop()
        if facets.normals[facets.rests_on[facet]] @ facets.normals[rest] < np.cos(np.radians(ROLLS_DEG)):
            return True
        low = facets.neighbors[facet][facets.sills[facet] <= limit]
        low = low[facets.heights[facets.rests_on[low]] >= level]  # a body that ends lower has tipped
        left += [number for number in low.tolist() if number not in seen]
        seen.update(low.tolist())
    return False


def bottom_of(facets: Facets, facet: int) -> np.ndarray:
    """Return the facets (K,) of the round bottom that contains a facet: those near the lowest one around it."""
    rests = facets.stable[facets.bottoms[facets.stable] == facets.bottoms[facet]]
    close = rests[facets.normals[rests] @ facets.normals[facet] > np.cos(np.radians(TURN_DEG))]
    lowest = close[facets.heights[close].argmin()]
    near = facets.normals[rests] @ facets.normals[lowest] > np.cos(np.radians(TURN_DEG))
    return np.flatnonzero(np.isin(facets.faces, facets.faces[rests[near]]))


def extended(facets: Facets, bottom: np.ndarray) -> np.ndarray:
    """Return facets (K,) and the faces to which the hull continues from them at a small angle."""
    beyond = facets.neighbors[bottom]
    smooth = np.einsum("ksi,ki->ks", facets.normals[beyond], facets.normals[bottom]) > np.cos(np.radians(TURN_DEG))
    return np.flatnonzero(np.isin(facets.faces, facets.faces[np.append(bottom, beyond[smooth])]))


def is_foot(facets: Facets, bottom: np.ndarray, around: np.ndarray) -> bool:
    """Return whether one of the faces of a bottom (K,) is a foot, much larger than those around it."""
    others = np.setdiff1d(facets.faces[around], facets.faces[bottom])
    return bool(facets.face_areas[facets.faces[bottom]].max() > ALIKE * np.median(facets.face_areas[others]))


def has_even_middle(facets: Facets, bottom: np.ndarray, around: np.ndarray) -> bool:
    """Return whether facets (K,) bend only at the rim of a bottom, like those of a foot that is not quite level."""
    lowest = bottom[facets.heights[bottom].argmin()]
    middle = facets.normals[lowest] * facets.heights[lowest]
    turns = np.einsum("ksi,ki->ks", facets.normals[facets.neighbors[around]], facets.normals[around])
    turns = np.where(turns > np.cos(np.radians(TURN_DEG)), np.arccos(np.clip(turns, -1, 1)), 0.0)
    rows, sides = np.nonzero(turns > CLEAR * turns.max())
    start, end = (facets.corners[facets.triangles[around[rows], (sides + k) % 3]] for k in (1, 2))
    along = end - start
    share = np.einsum("ei,ei->e", middle - start, along) / np.maximum(np.einsum("ei,ei->e", along, along), 1e-300)
    nearest = np.linalg.norm(start + np.clip(share, 0, 1)[:, None] * along - middle, axis=1).min()
    farthest = np.linalg.norm(facets.corners[facets.triangles[around]] - middle, axis=2).max()
    return bool(nearest > RIM * farthest)


def nearest_surface(corners: np.ndarray, toward: np.ndarray) -> NearestPoint:
    """Return the point nearest to the centre of mass of the smooth surface on which corners lie.

    In equal-area coordinates about the centre of the best-fitting sphere, the squared distance from the centre of mass
    is fitted by a quadratic polynomial: exactly if the surface is a sphere, however coarse the mesh.

    Parameters
    ----------
    corners : (V, 3) points of the surface, about the centre of mass
    toward : (3,) approximate direction of the nearest point
    """
    squares = (corners**2).sum(axis=1)
    middle = np.linalg.lstsq(np.column_stack([2 * corners, np.ones(len(corners))]), squares, rcond=1e-9)[0][:3]
    reach = np.linalg.norm(corners - middle, axis=1)
    radius, out = reach.mean(), (corners - middle) / reach[:, None]
    frame = np.linalg.svd(toward[None])[2]  # its first row is along `toward`, up to its sign
    frame[0] *= np.sign(frame[0] @ toward)
    x, y = (out @ frame[1:].T * np.sqrt(2 / np.maximum(1 + out @ frame[0], 1e-3))[:, None]).T
    terms = np.column_stack([np.ones(len(x)), x, y, x * x, x * y, y * y])
    fit = np.linalg.lstsq(terms, squares / radius**2, rcond=1e-9)[0]
    misfit = np.sqrt(np.mean((terms @ fit - squares / radius**2) ** 2)) / 2
    bend = np.array([[2 * fit[3], fit[4]], [fit[4], 2 * fit[5]]])
    at = -np.linalg.pinv(bend) @ fit[1:3]
    at *= min(1.0, 1.4 / max(np.linalg.norm(at), 1e-12))  # no farther than a right angle
    along = 1 - at @ at / 2
    down = middle + radius * (along * frame[0] + np.sqrt((1 + along) / 2) * at @ frame[1:])
    rise = float(np.linalg.eigvalsh(bend)[0]) / 2
    roughness = float(reach.std() / radius)
    down = down / np.linalg.norm(down)
    return NearestPoint(down=down, rise=rise, radius=float(radius), misfit=float(misfit), roughness=roughness)
