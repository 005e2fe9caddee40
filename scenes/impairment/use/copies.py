"""Kinds of copies in use and as sensed: of which functions' objects they are made, and whether they still work."""

from __future__ import annotations

from functools import partial

import numpy as np

from ...household.parts import solids
from ..levels import find_level
from ..specimen import FUNCTIONS, NONE, Change, Impairment, Specimen, box, spike
from ..surfaces import Surface
from . import copies, cups, sensed
from .placing import Placed, bag, book, small_object, upright_box, with_objects

SPIKE = (0.06, 0.14)  # metres high, and
PITCH = (0.05, 0.1)  # metres apart
COAT = (0.35, 0.03, 0.45)  # metres: width, thickness of each side, how far it hangs down


def centred(specimen: Specimen, triangles: np.ndarray, rng: np.random.Generator) -> Surface | None:
    """Return a seat with something put down about its middle, whether it reaches over the edge or not."""
    seat, surface = specimen.level, specimen.surface
    if seat is None or surface.is_cloud:
        return None
    placed = Placed(surface, seat)
    if placed.put(triangles, rng, near=seat.box.mean(axis=0)) or placed.put(triangles, rng):
        return placed.joined()
    return surface.joined(Surface(triangles + [*seat.box.mean(axis=0), seat.height]))


def with_book(specimen: Specimen, rng: np.random.Generator) -> Surface | None:
    """Leave a book or a newspaper on the seat."""
    return centred(specimen, book(rng), rng)


def with_cushion(specimen: Specimen, rng: np.random.Generator) -> Surface | None:
    """Put a cushion on the seat, of nearly its size."""
    if specimen.level is None or specimen.surface.is_cloud:
        return None
    seat = specimen.level
    size = np.minimum((seat.box[1] - seat.box[0]) * rng.uniform(0.6, 0.98, 2), rng.uniform(0.35, 0.6))
    mesh = solids.cushion(*size, rng.uniform(0.03, 0.12), crown=rng.uniform(0, 0.02))
    shift = [*seat.box.mean(axis=0), seat.height - 0.005]
    return specimen.surface.joined(Surface(np.asarray(mesh.triangles) + shift))


def with_bag(specimen: Specimen, rng: np.random.Generator) -> Surface | None:
    """Leave a bag or a soft toy on the seat, somewhere."""
    if specimen.level is None or specimen.surface.is_cloud:
        return None
    placed, triangles = Placed(specimen.surface, specimen.level), bag(rng) * rng.uniform(0.7, 1.0)
    return placed.joined() if placed.put(triangles, rng) else centred(specimen, triangles, rng)


def with_coat(specimen: Specimen, rng: np.random.Generator) -> Surface | None:
    """Hang a jacket over the back, or drop it on the seat where there is no back."""
    seat, surface = specimen.level, specimen.surface
    if seat is None or surface.is_cloud:
        return None
    if specimen.back is None:
        heap = solids.ellipsoid(rng.uniform(0.25, 0.45), rng.uniform(0.2, 0.4), rng.uniform(0.06, 0.14))
        return surface.joined(Surface(np.asarray(heap.triangles) + [*seat.box.mean(axis=0), seat.height]))
    above = surface.centres[surface.centres[:, 2] > seat.upper + 0.15]
    low, high = above.min(axis=0), above.max(axis=0)
    axis = int(np.abs(specimen.back).argmax())
    middle, parts = (low + high) / 2, []
    wide, thick, down = np.array(COAT) * rng.uniform(0.8, 1.3, 3)
    for side in (low[axis] - thick, high[axis]):
        start, end = middle - wide / 2, middle + wide / 2
        start[axis], end[axis] = side, side + thick
        start[2], end[2] = max(high[2] - down, seat.height + 0.03), high[2] + thick
        parts.append(box(start, end))
    start, end = middle - wide / 2, middle + wide / 2
    start[axis], end[axis], start[2], end[2] = low[axis] - thick, high[axis] + thick, high[2], high[2] + thick
    return surface.joined(Surface(np.concatenate([*parts, box(start, end)])))


def spikes_on_seat(specimen: Specimen, rng: np.random.Generator) -> Surface | None:
    """Cover the seat with pyramids, side by side."""
    seat = specimen.level
    if seat is None or specimen.surface.is_cloud:
        return None
    pitch, (low, high) = rng.uniform(*PITCH), seat.box
    xs, ys = (np.arange(start + pitch / 2, end + pitch / 4, pitch) for start, end in zip(low, high, strict=True))
    feet = np.array([(x, y) for x in xs for y in ys]).reshape(-1, 2)
    feet = feet[seat.flat[seat.grid.cells_of(feet)]]
    if not len(feet):
        return None
    tall = rng.uniform(*SPIKE) * rng.uniform(0.9, 1.1, len(feet))
    spikes = [spike(foot, pitch, seat.height - 0.01, seat.height + tip) for foot, tip in zip(feet, tall, strict=True)]
    return specimen.surface.joined(Surface(np.concatenate(spikes)))


def taken(specimen: Specimen, rng: np.random.Generator) -> Surface | None:
    """Seat a person: thighs, trunk and head, shins down to the ground."""
    seat, surface = specimen.level, specimen.surface
    if seat is None or surface.is_cloud:
        return None
    toward = np.array([0.0, 1.0]) if specimen.back is None else specimen.back
    scale, thighs, trunk = rng.uniform(0.85, 1.1), np.array([0.36, 0.46, 0.15]), np.array([0.42, 0.24, 0.56])
    parts = [upright_box(thighs), upright_box(trunk) + [0, 0.16, 0.05]]
    parts.append(np.asarray(solids.ellipsoid(0.17, 0.2, 0.24, 0, 0.14, 0.76).triangles))
    parts.append(upright_box(np.array([0.3, 0.12, seat.height / scale])) + [0, -0.26, -seat.height / scale])
    sideways = np.array([[toward[1], toward[0], 0], [-toward[0], toward[1], 0], [0, 0, 1]])
    person = scale * np.concatenate(parts) @ sideways.T
    return surface.joined(Surface(person + [*seat.box.mean(axis=0), seat.height - 0.01]))


VIEWPOINTS = 4  # that are tried
SHOWN = 0.35  # of the level's cells: from behind a chair nobody sees the seat
EVERYTHING = (*FUNCTIONS, NONE)


def used(function: str, **changes: Change) -> list[Impairment]:
    """Return kinds of use that objects of one function keep it in."""
    return [
        Impairment(kind=kind, functions=(function,), works=True, change=change, used=True)
        for kind, change in changes.items()
    ]


def used_up(function: str, **changes: Change) -> list[Impairment]:
    """Return kinds of use that leave nothing of a function."""
    return [
        Impairment(kind=kind, functions=(function,), works=False, change=change, used=True)
        for kind, change in changes.items()
    ]


def laden(specimen: Specimen, rng: np.random.Generator) -> Surface | None:
    """Put one to five objects on an object without a function, if it has a level."""
    if specimen.surface.is_cloud or specimen.surface.size[:2].min() < 0.15:
        return None
    level = find_level(specimen.surface, 0.1, 2.0)
    objects = [small_object(rng) for _ in range(rng.integers(1, 6))]
    return None if level is None else with_objects(specimen.surface, level, objects, rng)


def as_sensed(
    specimen: Specimen, rng: np.random.Generator, corrupt: sensed.Corrupt, least: float, most: float
) -> Surface | None:
    """Return points of an object, corrupted between two severities, evenly by their logarithm.

    None where those of the seat or the top are not among them.
    """
    for _ in range(VIEWPOINTS):
        how = float(np.exp(rng.uniform(np.log(least), np.log(most))))
        points = corrupt(specimen.cloud.points, how, rng)
        if len(points) >= sensed.LEFT and shows_level(specimen, points):
            return Surface(points=points)
    return None


def shows_level(specimen: Specimen, points: np.ndarray) -> bool:
    """Return whether points (N, 3) show enough of the seat or the top to tell, where there is one."""
    level = specimen.level
    if level is None:
        return True
    on_level = points[np.abs(points[:, 2] - level.height) < 0.15 * level.height]
    return len(np.unique(np.column_stack(level.grid.cells_of(on_level)), axis=0)) > SHOWN * level.flat.sum()


IN_USE = (
    *used(
        "table",
        laid=partial(cups.laid, least=1, most=1),
        laid_few=partial(cups.laid, least=2, most=4),
        laid_many=partial(cups.laid, least=5, most=8),
        cloth=cups.cloth,
        chairs_under=cups.chairs_under,
        at_wall=cups.at_wall,
    ),
    *used_up("table", full=cups.full),
    *used(
        "sittable",
        book=copies.with_book,
        cushion=copies.with_cushion,
        bag=copies.with_bag,
        coat=copies.with_coat,
    ),
    *used_up("sittable", spikes=copies.spikes_on_seat, taken=copies.taken),
    *used("cup", spoon=cups.with_spoon, liquid=cups.with_liquid, saucer=cups.on_saucer, held=cups.held),
    *used(NONE, laden=laden),
)
AS_SENSED = tuple(
    Impairment(kind=kind, functions=EVERYTHING, works=True, change=change, used=True)
    for kind, change in (
        ("noisy", partial(as_sensed, corrupt=sensed.noise, least=0.003, most=0.025)),
        ("sparse", partial(as_sensed, corrupt=sensed.sparse, least=0.04, most=0.5)),
        ("one_view", partial(as_sensed, corrupt=sensed.views, least=1, most=1)),
        ("some_views", partial(as_sensed, corrupt=sensed.views, least=2, most=3)),
        ("stray_points", partial(as_sensed, corrupt=sensed.outliers, least=0.005, most=0.05)),
    )
)
