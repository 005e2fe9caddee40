"""Rooms as people leave them: chairs at tables, stacks, shelves, beds, sills, cartons, piles and clutter, by options.

Each kind comes to a share of the rooms, decided by the room's number and the seed alone; what is not asked for changes
nothing, and a room without any of it is, bit for bit, the one that `furnishing` makes.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, fields

import numpy as np

from spherefunc_bullet.datasets.dataset import Dataset, open_dataset
from spherefunc_bullet.errors import InputError

from .chairs_at_tables import chairs_to_tables
from .contents import Contents, decks_by_category
from .fixtures import fixtures_added
from .furnishing import Deck, Stock, VirtualRoom, furnish, take_stock
from .stacking import clutter_on_seats, small_objects_stacked

EVERYTHING = "all"


@dataclass(frozen=True, kw_only=True)
class LivedIn:
    """The share of rooms, 0 to 1, that has each kind of disorder."""

    chairs: float = 0.0  # pushed against and under tables
    stacks: float = 0.0  # small objects on top of each other, and touching
    shelves: float = 0.0  # with objects on their boards
    beds: float = 0.0
    sills: float = 0.0  # of windows, with objects on them
    gaps: float = 0.0  # between cartons
    piles: float = 0.0
    clutter: float = 0.0  # on seats

    def kinds(self, seed: int, number: int) -> frozenset[str]:
        """Return the kinds that a room of a number has."""
        shares = {kind.name: getattr(self, kind.name) for kind in fields(self)}
        # Rooms are distinguished by their number, kinds by their place: another share of one leaves the others alone.
        turn = np.random.default_rng([seed, 7]).uniform(size=len(shares))
        return frozenset(
            name for place, (name, part) in enumerate(shares.items()) if falls(number, part, float(turn[place]))
        )


def falls(number: int, share: float, turn: float) -> bool:
    """Return whether a room of a number is among a share of all, as evenly spread as can be.

    Examples
    --------
    >>> [falls(number, 0.5, 0.2) for number in range(1, 5)]
    [False, True, False, True]
    """
    return bool(np.floor(number * share + turn) > np.floor((number - 1) * share + turn))


def parse_lived_in(text: str | None) -> LivedIn:
    """Return the kinds of a list such as ``chairs=0.5,stacks`` or ``all``; a share left out is 1.

    Raises
    ------
    InputError
        If a kind is none, or its share is not between 0 and 1.

    Examples
    --------
    >>> parse_lived_in("chairs=0.5,beds").chairs
    0.5
    """
    names = [kind.name for kind in fields(LivedIn)]
    shares = {}
    for part in filter(None, (part.strip() for part in (text or "").split(","))):
        name, _, share = part.partition("=")
        for kind in names if name == EVERYTHING else [name]:
            shares[kind] = share_of(share, part)
        if name not in (*names, EVERYTHING):
            raise InputError(f"--lived-in {part}: expected some of {', '.join(names)}, or {EVERYTHING}")
    return LivedIn(**shares)


def share_of(text: str, part: str) -> float:
    """Return a share of rooms."""
    try:
        share = float(text or 1)
    except ValueError:
        share = -1.0
    if not 0 <= share <= 1:
        raise InputError(f"--lived-in {part}: expected a share of rooms from 0 to 1, such as chairs=0.5")
    return share


@dataclass(frozen=True)
class Filling:
    """What rooms are filled up from, and how."""

    lived_in: LivedIn
    stock: Stock
    seed: int

    def filled(self, room: VirtualRoom, number: int) -> VirtualRoom:
        """Return a room with all that its kinds bring."""
        kinds = self.lived_in.kinds(self.seed, number)
        if not kinds:
            return room
        contents = self.contents(room, np.random.default_rng([self.seed, number, 7]))
        fixtures_added(contents, kinds)
        if "chairs" in kinds:
            chairs_to_tables(contents)
        if "stacks" in kinds:
            small_objects_stacked(contents)
        if "clutter" in kinds:
            clutter_on_seats(contents)
        return contents.finished()

    def contents(self, room: VirtualRoom, rng: np.random.Generator) -> Contents:
        """Return what a room holds, and what may be added."""
        return Contents(
            room=room,
            rng=rng,
            small=[Deck(self.stock.small[name], rng) for name in sorted(self.stock.small)],
            seats=[Deck(self.stock.large["sittable"], rng)] if "sittable" in self.stock.large else [],
            surroundings=decks_by_category(open_dataset("surroundings"), rng),
        )


def furnish_lived_in(
    dataset: Dataset, count: int, *, seed: int = 0, failed: Callable[[InputError], None], lived_in: LivedIn
) -> Iterator[VirtualRoom]:
    """Yield the rooms of `furnish`, of which shares are filled up; see there.

    Raises
    ------
    InputError
        If no object of the data set can stand in a room.
    """
    stock = take_stock(dataset, failed)
    filling = Filling(lived_in, stock, seed)
    for number, room in enumerate(furnish(dataset, count, seed=seed, failed=failed, stock=stock), start=1):
        yield filling.filled(room, number)
