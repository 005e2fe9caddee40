"""Furniture that no longer stands well: a leg sawn off, or all of them cut askew.

Each change takes a specimen and a generator, and returns a surface, or None. They are not among `IMPAIRMENTS`, and no
model learns from them, since spheres on an object do not show whether it stands.
"""

from __future__ import annotations

from collections.abc import Iterable
from functools import partial

import numpy as np
import trimesh
from scipy import ndimage
from scipy.spatial import ConvexHull, QhullError

from .levels import Cavity, LevelPart
from .specimen import Impairment, Specimen, kinds, level_direction, needs
from .surfaces import ObjectSurface
from .useless import along_and_across

CUTS = (0.5, 0.3, 0.15, 0.08)  # of the level's height: a leg is sawn at the highest below which legs are apart
FEWEST = 3  # legs
WIDEST = 0.15  # of the footprint's box, the largest leg: more is a body
FOOT = 0.02  # of the level's height, below which points are on the ground
NEEDED = 0.25  # of the supported part of the seat or the top, that is no longer supported without a leg that counts
ASKEW_DEG = (5.0, 10.0)


@needs("level", triangles=True)
def leg_sawn_off(specimen: Specimen, level: LevelPart, rng: np.random.Generator) -> ObjectSurface | None:
    """Saw off one leg, as high up as legs are separate; only a leg without which the object is supported less.

    A sofa that has lost one of eight feet, or a desk that also stands on panels, is as sound as before.
    """
    surface = specimen.surface
    for cut in CUTS:
        low = surface.centres[:, 2] < cut * level.height
        parts, count = ndimage.label(np.isfinite(level.grid.tops(surface.centres[low])), structure=np.ones((3, 3)))
        sizes = np.bincount(parts.ravel())[1:]
        if count >= FEWEST and sizes.max() <= WIDEST * np.prod(surface.size[:2]) / level.grid.cell**2:
            feet = surface.centres[surface.centres[:, 2] < max(FOOT * level.height, level.grid.cell)]
            over = level.grid.places(level.flat)
            needed = needed_legs(feet[:, :2], parts[level.grid.cells_of(feet)], count, over)
            if not len(needed):
                return None
            leg = needed[int(rng.integers(len(needed)))]
            return surface.without(low & (parts[level.grid.cells_of(surface.centres)] == leg))
    return None


def needed_legs(feet: np.ndarray, legs: np.ndarray, count: int, over: np.ndarray) -> list[int]:
    """Return which of the legs 1 to ``count`` a good part of the seat or the top is not supported without.

    Only outlines count: of feet (N, 2), metres, each of one of the legs (N,), around places (P, 2) of the level.
    """
    whole = within_outline(over, feet)
    lost = {leg: whole & ~within_outline(over, feet[legs != leg]) for leg in range(1, count + 1)}
    return [leg for leg, gone in lost.items() if whole.any() and gone.sum() >= NEEDED * whole.sum()]


def within_outline(places: np.ndarray, feet: np.ndarray) -> np.ndarray:
    """Return which places (P, 2) are within the convex outline of feet (N, 2), (P,) bool; none if it is a line."""
    try:
        sides = ConvexHull(feet).equations
    except (QhullError, ValueError):
        return np.zeros(len(places), bool)
    return (places @ sides[:, :2].T + sides[:, 2] <= 0).all(axis=1)


@needs("level", triangles=True)
def legs_cut_askew(specimen: Specimen, level: LevelPart, rng: np.random.Generator) -> ObjectSurface | None:
    """Cut off all that lies below a plane that slopes by a few degrees and spares one side."""
    surface = specimen.surface
    slope, toward = np.radians(rng.uniform(*ASKEW_DEG)), level_direction(rng.uniform(0, 2 * np.pi))
    feet = surface.vertices[surface.vertices[:, 2] < FOOT * level.height]
    normal = np.array([*(-np.sin(slope) * toward), np.cos(slope)])
    spared = feet[(feet[:, :2] @ toward).argmin()]
    vertices, faces = surface.mesh()
    vertices, faces, _ = trimesh.intersections.slice_faces_plane(vertices, faces, normal, spared + [0, 0, 1e-6])
    return ObjectSurface(vertices[faces]) if len(faces) else None


SAWN = kinds(("sittable", "table"), False, leg_sawn_off=leg_sawn_off, legs_cut_askew=legs_cut_askew)


def copies_of(specimen: Specimen, name: str, some: Iterable[Impairment]) -> list[tuple[Impairment, ObjectSurface]]:
    """Return the copies of some kinds that can be made of an object, each with its kind."""
    made = [(kind, kind.applied(specimen, name, 0)) for kind in some if specimen.function in kind.functions]
    return [(kind, surface) for kind, surface in made if surface is not None]


HEIGHTS = (0.25, 0.5, 0.75)  # of the way from a cavity's floor to its brim: the middle of the hole
ACROSS = 16.0  # radii of the carried spheres to an object's largest extent, see `simulator.mechanics`
WIDE = 1.5  # such radii, the hole's radius, so that a sphere passes easily


@needs("cavity", triangles=True)
def hole_in_wall(specimen: Specimen, cup: Cavity, rng: np.random.Generator, height: float) -> ObjectSurface | None:
    """Cut a round hole into a vessel's wall, level and away from a handle, at a share of its depth."""
    surface = specimen.surface
    middle = cup.floor + height * (cup.brim - cup.floor)
    radius = max(WIDE * surface.size.max() / ACROSS, 2 * cup.grid.cell)
    along, across = along_and_across(surface, cup, rng)
    beyond = along > 0.5 * np.interp(middle, cup.heights, cup.radii)
    gone = beyond & (np.hypot(across, surface.centres[:, 2] - middle) < radius)
    return surface.without(gone) if gone.any() else None


HOLED = kinds(("cup",), False, **{f"hole_at_{round(100 * at)}": partial(hole_in_wall, height=at) for at in HEIGHTS})
