"""Kinds of copies in use and as sensed: seats in use, every kind with its functions, and whether it still works."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import numpy as np

from ...household.parts import solids
from ..levels import LevelPart, find_level
from ..specimen import FUNCTIONS, NONE, Specimen, box, kinds, needs
from ..surfaces import ObjectSurface
from ..useless import spiked
from . import cups, sensed
from .placing import LoadedLevel, bag, book, small_object, upright_box, with_objects

SPIKE = (0.06, 0.14)  # metres high, and
PITCH = (0.05, 0.1)  # metres apart
BESIDE = 0.5  # metres from one sitter to the next
COAT = (0.35, 0.03, 0.45)  # metres: width, thickness of each side, how far it hangs down
STRIP = 0.05  # metres of height of which a back has one thickness
THICKEST = 0.25  # metres of a back: parts farther in front of its rear are an arm or the seat


def centred(surface: ObjectSurface, seat: LevelPart, triangles: np.ndarray, rng: np.random.Generator) -> ObjectSurface:
    """Return a seat with an object put down near its middle, even where it reaches over the edge."""
    placed = LoadedLevel(surface, seat)
    if placed.put(triangles, rng, near=seat.box.mean(axis=0)) or placed.put(triangles, rng):
        return placed.joined()
    return surface.joined(ObjectSurface(triangles + [*seat.box.mean(axis=0), seat.height]))


@needs("level", triangles=True)
def with_book(specimen: Specimen, seat: LevelPart, rng: np.random.Generator) -> ObjectSurface:
    """Leave a book or a newspaper on the seat."""
    return centred(specimen.surface, seat, book(rng), rng)


@needs("level", triangles=True)
def with_cushion(specimen: Specimen, seat: LevelPart, rng: np.random.Generator) -> ObjectSurface:
    """Put a cushion on the seat, of nearly its size."""
    size = np.minimum((seat.box[1] - seat.box[0]) * rng.uniform(0.6, 0.98, 2), rng.uniform(0.35, 0.6))
    mesh = solids.cushion(*size, rng.uniform(0.03, 0.12), crown=rng.uniform(0, 0.02))
    shift = [*seat.box.mean(axis=0), seat.height - 0.005]
    return specimen.surface.joined(ObjectSurface(np.asarray(mesh.triangles) + shift))


@needs("level", triangles=True)
def with_bag(specimen: Specimen, seat: LevelPart, rng: np.random.Generator) -> ObjectSurface | None:
    """Leave a bag or a soft toy on the seat, somewhere."""
    placed, triangles = LoadedLevel(specimen.surface, seat), bag(rng) * rng.uniform(0.7, 1.0)
    return placed.joined() if placed.put(triangles, rng) else centred(specimen.surface, seat, triangles, rng)


@needs("level", triangles=True)
def with_coat(specimen: Specimen, seat: LevelPart, rng: np.random.Generator) -> ObjectSurface:
    """Hang a jacket over the back, or drop it on the seat where there is no back."""
    surface = specimen.surface
    if specimen.back is None:
        heap = solids.ellipsoid(rng.uniform(0.25, 0.45), rng.uniform(0.2, 0.4), rng.uniform(0.06, 0.14))
        return surface.joined(ObjectSurface(np.asarray(heap.triangles) + [*seat.box.mean(axis=0), seat.height]))
    return surface.joined(ObjectSurface(coat_over_back(specimen, seat, rng)))


def coat_over_back(specimen: Specimen, seat: LevelPart, rng: np.random.Generator) -> np.ndarray:
    """Return the triangles (K, 3, 3) of a jacket that hangs over the middle of a seat's back."""
    wide, thick, down = np.array(COAT) * rng.uniform(0.8, 1.3, 3)
    toward, points = specimen.back, specimen.cloud.points
    across = np.abs(toward[::-1])
    above = points[points[:, 2] > seat.upper + 0.15]
    middle = np.median(above[:, :2] @ across)
    covered = np.abs(above[:, :2] @ across - middle) < wide / 2
    below_coat = above[covered] if covered.any() else above
    back = np.column_stack([below_coat[:, :2] @ toward, below_coat[:, 2]])
    hanging = list(strips(back, max(below_coat[:, 2].max() - down, seat.height + 0.03)))
    _, top, front, rear = hanging[0]
    parts = [(front - thick, rear + thick, top, top + thick)]
    for lower, upper, front, rear in hanging:
        parts += [(front - thick, front, lower, upper), (rear, rear + thick, lower, upper)]
    sides = middle - wide / 2, middle + wide / 2
    slabs = []
    for front, rear, lower, upper in parts:
        one = [*(front * toward + sides[0] * across), lower]
        corners = np.array([one, [*(rear * toward + sides[1] * across), upper]])
        slabs.append(box(corners.min(axis=0), corners.max(axis=0)))
    return np.concatenate(slabs)


def strips(back: np.ndarray, lowest: float) -> Iterator[tuple[float, float, float, float]]:
    """Yield the strips of a back from its top down: lower and upper height, then the positions of its front and rear.

    Where a strip is empty, as between slats, the coat hangs as it does above.

    Parameters
    ----------
    back : (N, 2) float
        Distance towards the back, and height, metres.
    """
    upper = back[:, 1].max()
    while upper > lowest:
        lower = max(upper - STRIP, lowest)
        row = back[(back[:, 1] >= lower) & (back[:, 1] <= upper), 0]
        if len(row):
            rear = row.max()
            front = row[row > rear - THICKEST].min()
        yield lower, upper, front, rear
        upper = lower


@needs("level", triangles=True)
def spikes_on_seat(specimen: Specimen, seat: LevelPart, rng: np.random.Generator) -> ObjectSurface | None:
    """Cover the seat with pyramids, side by side."""
    pitch = rng.uniform(*PITCH)
    return spiked(specimen.surface, seat, pitch, lambda count: rng.uniform(*SPIKE) * rng.uniform(0.9, 1.1, count))


@needs("level", triangles=True)
def taken(specimen: Specimen, seat: LevelPart, rng: np.random.Generator) -> ObjectSurface:
    """Seat persons until nobody else has room; each has thighs, trunk and head, and shins down to the ground."""
    toward = np.array([0.0, 1.0]) if specimen.back is None else specimen.back
    scale, thighs, trunk = rng.uniform(0.85, 1.1), np.array([0.36, 0.46, 0.15]), np.array([0.42, 0.24, 0.56])
    parts = [upright_box(thighs), upright_box(trunk) + [0, 0.16, 0.05]]
    parts.append(np.asarray(solids.ellipsoid(0.17, 0.2, 0.24, 0, 0.14, 0.76).triangles))
    parts.append(upright_box(np.array([0.3, 0.12, seat.height / scale])) + [0, -0.26, -seat.height / scale])
    sideways = np.array([[toward[1], toward[0], 0], [-toward[0], toward[1], 0], [0, 0, 1]])
    person = scale * np.concatenate(parts) @ sideways.T
    people = [person + [*place, seat.height - 0.01] for place in places_to_sit(seat, toward)]
    return specimen.surface.joined(ObjectSurface(np.concatenate(people)))


def places_to_sit(seat: LevelPart, toward: np.ndarray) -> list[np.ndarray]:
    """Return where people sit (2,), metres, on a seat with its back that way: in the middle, then side by side."""
    cells, middle = seat.grid.places(seat.flat), seat.box.mean(axis=0)
    places = [middle]
    while True:
        free = cells[np.min([np.linalg.norm(cells - place, axis=1) for place in places], axis=0) > BESIDE]
        if not len(free):
            return places
        out_of_row = np.abs((free - middle) @ toward)
        places.append(free[(out_of_row + 0.1 * np.linalg.norm(free - middle, axis=1)).argmin()])


VIEWPOINTS = 4  # that are tried
SHOWN = 0.35  # of the level's cells, at least: from behind a chair the seat is not seen
EVERYTHING = (*FUNCTIONS, NONE)


def laden(specimen: Specimen, rng: np.random.Generator) -> ObjectSurface | None:
    """Put one to five objects on an object without a function, if it has a level."""
    if specimen.surface.is_cloud or specimen.surface.size[:2].min() < 0.15:
        return None
    level = find_level(specimen.surface, 0.1, 2.0)
    objects = [small_object(rng) for _ in range(rng.integers(1, 6))]
    return None if level is None else with_objects(specimen.surface, level, objects, rng)


def as_sensed(
    specimen: Specimen, rng: np.random.Generator, corrupt: sensed.Corrupt, least: float, most: float
) -> ObjectSurface | None:
    """Return points of an object, corrupted with a severity between two, evenly distributed by its logarithm.

    None where too little of the seat or the top is among them.
    """
    for _ in range(VIEWPOINTS):
        how = float(np.exp(rng.uniform(np.log(least), np.log(most))))
        points = corrupt(specimen.cloud.points, how, rng)
        if len(points) >= sensed.LEFT and shows_level(specimen, points):
            return ObjectSurface(points=points)
    return None


def shows_level(specimen: Specimen, points: np.ndarray) -> bool:
    """Return whether points (N, 3) show enough of the seat or the top, where there is one."""
    level = specimen.level
    if level is None:
        return True
    on_level = points[np.abs(points[:, 2] - level.height) < 0.15 * level.height]
    return len(np.unique(np.column_stack(level.grid.cells_of(on_level)), axis=0)) > SHOWN * level.flat.sum()


IN_USE = (
    *kinds(
        ("table",),
        True,
        laid=partial(cups.laid, least=1, most=1),
        laid_few=partial(cups.laid, least=2, most=4),
        laid_many=partial(cups.laid, least=5, most=8),
        cloth=cups.cloth,
        chairs_under=cups.chairs_under,
        at_wall=cups.at_wall,
    ),
    *kinds(("table",), False, full=cups.full),
    *kinds(("sittable",), True, book=with_book, cushion=with_cushion, bag=with_bag, coat=with_coat),
    *kinds(("sittable",), False, spikes=spikes_on_seat, taken=taken),
    *kinds(("cup",), True, spoon=cups.with_spoon, liquid=cups.with_liquid, saucer=cups.on_saucer, held=cups.held),
    *kinds((NONE,), True, laden=laden),
)
AS_SENSED = kinds(
    EVERYTHING,
    True,
    noisy=partial(as_sensed, corrupt=sensed.noise, least=0.003, most=0.025),
    sparse=partial(as_sensed, corrupt=sensed.sparse, least=0.04, most=0.5),
    one_view=partial(as_sensed, corrupt=sensed.views, least=1, most=1),
    some_views=partial(as_sensed, corrupt=sensed.views, least=2, most=3),
    stray_points=partial(as_sensed, corrupt=sensed.outliers, least=0.005, most=0.05),
)
