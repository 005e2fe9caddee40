"""Round bottoms, of which a mesh makes facets: whether they roll, and to which pose they right themselves.

A facet of a round bottom is no rest: a bowl does not lean on the triangle that it happens to have been put on. Its
corners lie on the surface that was meant, so that this is known. The object is at rest where the surface is nearest to
its centre of mass, and stable where that lies below the centre of curvature.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .facets import TURN_DEG, Facets

ALIKE = 4.0  # times as large as the faces around it: what is larger is a foot, and no face that a mesh has made
CLEAR = 1 / 3  # of the largest turn at a bottom: what turns less is an unevenness
RIM = 0.6  # of the farthest corner around: a bottom that turns only farther out than that is flat
FEWEST = 10  # corners: a polynomial of six terms fits six of them however they lie
FLATTEST = 3.0  # extents, the radius of curvature: what is flatter is a foot that is not quite level
MISFIT = 0.01  # of the radius of curvature: corners are no farther, root mean square, from the surface that was meant
NEUTRAL = 0.02  # of the radius of curvature: a centre of mass that is no lower below its centre rights nothing
ROLLING = 0.005  # of the height of the centre of mass: who rises no more than that on the way to another pose rolls
ROLLS_DEG = 45.0  # how far that pose is at least; what is nearer may be a way to rock


@dataclass(frozen=True, kw_only=True, eq=False)
class RestState:
    """How a body is at rest."""

    down: np.ndarray  # (3,) the direction of the body that points down
    flat: bool = True  # on a face of its hull, of which statics is exact
    rolls: bool = False


@dataclass(frozen=True, kw_only=True, eq=False)
class NearestPoint:
    """Where a smooth surface is nearest to the centre of mass."""

    down: np.ndarray  # (3,) the direction
    rise: float  # share of the radius of curvature by which the centre of mass is below its centre, where that is least
    radius: float  # of the sphere that fits the surface best, extents
    misfit: float  # of the radius: how far corners are from the surface, root mean square
    roughness: float  # the same, from the sphere


def rest_at(facets: Facets, facet: int) -> RestState:
    """Return how a body is at rest whose hull has come to lie on one of its resting facets."""
    lying = RestState(down=facets.normals[facet])
    if rolls_away(facets, facet):
        return RestState(down=lying.down, flat=False, rolls=True)
    bottom = bottom_of(facets, facet)
    around = extended(facets, bottom)
    farther = extended(facets, around)
    if len(around) == len(bottom) or is_foot(facets, bottom, around) or has_even_middle(facets, bottom, farther):
        return lying  # the tip of a cone, too, on which nothing stands
    corners = facets.corners[np.unique(facets.triangles[farther])]
    surface = nearest_surface(corners, facets.normals[bottom].mean(axis=0))
    if len(corners) < FEWEST or surface.radius > FLATTEST or surface.misfit > MISFIT:
        return lying
    if abs(surface.rise) < NEUTRAL and surface.roughness < MISFIT:  # a ball; what else wanders has been found
        return RestState(down=lying.down, flat=False, rolls=True)
    near = (facets.normals[bottom] @ surface.down).max() > np.cos(np.radians(TURN_DEG / 2))
    return RestState(down=surface.down, flat=False) if near and surface.rise >= NEUTRAL else lying


def rolls_away(facets: Facets, rest: int) -> bool:
    """Return whether a body rolls from the facet it rests on to one that is far from it, at a touch."""
    left, seen = [rest], {rest}
    limit, level = facets.heights[rest] * (1 + ROLLING), facets.heights[rest] * (1 - ROLLING)
    while left:
        facet = left.pop()
        if facets.normals[facets.rests_on[facet]] @ facets.normals[rest] < np.cos(np.radians(ROLLS_DEG)):
            return True
        low = facets.neighbors[facet][facets.sills[facet] <= limit]
        low = low[facets.heights[facets.rests_on[low]] >= level]  # what ends lower has tipped
        left += [int(facet_number) for facet_number in low if facet_number not in seen]
        seen.update(int(facet_number) for facet_number in low)
    return False


def bottom_of(facets: Facets, facet: int) -> np.ndarray:
    """Return the facets (K,) of the round bottom of which one is a part: those no far turn from the lowest near it."""
    rests = facets.stable[facets.bottoms[facets.stable] == facets.bottoms[facet]]
    close = rests[facets.normals[rests] @ facets.normals[facet] > np.cos(np.radians(TURN_DEG))]
    lowest = close[facets.heights[close].argmin()]
    near = facets.normals[rests] @ facets.normals[lowest] > np.cos(np.radians(TURN_DEG))
    return np.flatnonzero(np.isin(facets.faces, facets.faces[rests[near]]))


def extended(facets: Facets, bottom: np.ndarray) -> np.ndarray:
    """Return facets (K,) and those to which the hull goes on at a small turn, a face as a whole."""
    beyond = facets.neighbors[bottom]
    smooth = np.einsum("ksi,ki->ks", facets.normals[beyond], facets.normals[bottom]) > np.cos(np.radians(TURN_DEG))
    return np.flatnonzero(np.isin(facets.faces, facets.faces[np.append(bottom, beyond[smooth])]))


def is_foot(facets: Facets, bottom: np.ndarray, around: np.ndarray) -> bool:
    """Return whether one of the faces on which a body can rest, of facets (K,), is a foot: larger than those around."""
    others = np.setdiff1d(facets.faces[around], facets.faces[bottom])
    return bool(facets.face_areas[facets.faces[bottom]].max() > ALIKE * np.median(facets.face_areas[others]))


def has_even_middle(facets: Facets, bottom: np.ndarray, around: np.ndarray) -> bool:
    """Return whether facets (K,) turn only at the rim of a bottom, as those of a foot do that is not quite level."""
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
    """Return where the smooth surface on which corners lie is nearest to the centre of mass.

    About the centre of the sphere that fits it best, the square of the distance from the centre of mass is a square
    polynomial of equal-area coordinates: exactly, where the surface is a sphere, however coarse the mesh.

    Parameters
    ----------
    corners : (V, 3) points of the surface, about the centre of mass
    toward : (3,) about where it is nearest
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
