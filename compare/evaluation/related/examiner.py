"""Agents that try an object, after Bar-Aviv and Rivlin: it has a function if an agent can use it accordingly.

E. Bar-Aviv and E. Rivlin, "Functional 3D object classification using simulation of embodied agent", BMVC 2006 (the
paper's [18]): for each function an agent is set on the object in many poses, and the object has the function if in one
of them the agent's constraints are met. Theirs is a jointed person in a physics engine. Here an agent is a few boxes,
or a ball, whose places relative to each other are fixed; it is let down on the object from above at every place of a
grid and in every heading, to find out whether it fits, is supported, and is free above:

sittable
    A seated person: a box for the trunk, one for the thighs in front of it, one for the lower legs in front of these.
    The trunk rests on the object between 35 and 55 cm above the ground, and at least half of its base is supported;
    nothing is higher under the thighs; nothing taller than 10 cm stands where the feet are.
table
    The same person at a table: a place setting rests between 60 and 80 cm above the ground, and at least three quarters
    of it, the share of an oval mat in its box, lie on a level surface; the knees fit under it from the front, and
    nothing taller than 10 cm stands where the person sits.
cup
    A ball as large as a sip. It is let down on the object, and moved along it in all directions. The object holds it if
    it cannot leave without being lifted by its own diameter, and if a hand can grasp the object.

Lengths are those of people (hip breadth, buttock to knee, knee height: medians of adults) and of a place setting;
they were set before any model was looked at, and nothing is fitted to labels.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from scipy import ndimage

from spherefunc_bullet.learning.method import CUBES
from spherefunc_bullet.settling.records import VOXEL, ObjectRecord

from ..evaluation import FeatureMethod, Trial
from ..features import of_each
from ..protocol import Labels, Split
from .rules import NOTHING, TopView, functions_by_rules, top_view

SQUARE = 0.02  # metres between the places that are tried
TURNS = (0.0, 30.0, 60.0)  # degrees; with quarter turns, a heading every 30 degrees
BROAD = 0.36  # metres: a person's breadth
TRUNK, THIGHS, FEET = 0.30, 0.18, 0.14  # metres from back to front: 48 cm from the back to the hollow of the knee
SEAT = (0.35, 0.55)  # metres above the ground
SOFT = 0.05  # metres by which a cushion is compressed
FOOTREST = 0.10  # metres: lower objects are stepped on
BOARD, ALONG = 0.60, 0.40  # metres, a place setting from left to right and from front to back
TOP = (0.60, 0.80)  # metres above the ground
MAT = 0.75  # of a place setting
LEVEL = 0.02  # metres: unevenness that a mat bridges, and that thighs tolerate
KNEES, UNDER = 0.55, 0.30  # metres: the height of knees, and their reach under a top
AROUND = TRUNK + THIGHS + FEET  # metres of ground around an object that a person may need
SIP = 0.03  # metres, the diameter of a ball of 14 ml
HAND, TALLEST = 0.12, 0.25  # metres: the span of a hand, and the height of a wine glass


def functions_by_agents(record: ObjectRecord) -> frozenset[str]:
    """Return which of the functions cup, sittable and table an object has for the agents."""
    functions = {"cup"} if holds_a_ball(record) else set()
    if record.size[2] >= SEAT[0]:
        for above, knee_high in headings(record):
            if "sittable" not in functions and carries_a_person(above):
                functions.add("sittable")
            if "table" not in functions and serves_a_person(above, knee_high):
                functions.add("table")
    return frozenset(functions)


def headings(record: ObjectRecord) -> Iterator[tuple[TopView, TopView]]:
    """Yield an object's top view, and that of its parts below the knees, for a person who faces +x, in all headings."""
    views = top_view(record), top_view(record, below=KNEES)
    for degrees in TURNS:
        above, knee_high = (view.turned(degrees, SQUARE, margin=AROUND) for view in views)
        for _ in range(4):
            yield above, knee_high
            above, knee_high = above.quarter_turned(), knee_high.quarter_turned()


def carries_a_person(above: TopView) -> bool:
    """Return whether a person who faces +x can sit somewhere on an object."""
    seat = highest(above, TRUNK, BROAD)
    thighs = highest(above, THIGHS, BROAD, ahead=(TRUNK + THIGHS) / 2)
    feet = highest(above, FEET, BROAD, ahead=TRUNK / 2 + THIGHS + FEET / 2)
    fits = (seat >= SEAT[0]) & (seat <= SEAT[1]) & (thighs <= seat + LEVEL) & (feet <= FOOTREST)
    return bool((carried(above, TRUNK, BROAD, fits, seat, SOFT) >= 0.5).any())


def serves_a_person(above: TopView, knee_high: TopView) -> bool:
    """Return whether a person who faces +x can sit somewhere at an object, with a place setting on it."""
    mat = highest(above, ALONG, BOARD)
    person = highest(above, TRUNK, BROAD, ahead=-(ALONG + TRUNK) / 2)
    knees = highest(knee_high, UNDER, BROAD, ahead=(UNDER - ALONG) / 2)
    fits = (mat >= TOP[0]) & (mat <= TOP[1]) & (person <= FOOTREST) & (knees <= FOOTREST)
    return bool((carried(above, ALONG, BOARD, fits, mat, LEVEL) >= MAT).any())


def highest(view: TopView, length: float, breadth: float, ahead: float = 0.0) -> np.ndarray:
    """Return the height (X, Y) at which a box comes to rest ahead of each place, metres; NOTHING off the object."""
    size = view.cells(length), view.cells(breadth)
    tops = ndimage.maximum_filter(view.heights, size, mode="constant", cval=NOTHING)
    return np.roll(tops, -round(ahead / view.cell), axis=0)  # the margin is free, so nothing comes round


def carried(
    view: TopView, length: float, breadth: float, fits: np.ndarray, rest: np.ndarray, give: float
) -> np.ndarray:
    """Return the supported share of a box's base at the places (X, Y) bool where it fits, (P,).

    Parameters
    ----------
    rest : (X, Y) float
        The height at which it rests, metres.
    give : float
        How far below that a surface still supports it, metres.
    """
    size = np.array([view.cells(length), view.cells(breadth)])
    places = np.argwhere(fits)
    bases = np.lib.stride_tricks.sliding_window_view(view.heights, size)[tuple((places - size // 2).T)]
    return (bases >= (rest[fits] - give)[:, None, None]).mean(axis=(1, 2))


def holds_a_ball(record: ObjectRecord) -> bool:
    """Return whether a hand can grasp an object, and a ball in it cannot leave."""
    if record.size[2] > TALLEST or record.size[:2].min() > HAND:
        return False
    bottoms = ball_bottoms(top_view(record).turned(0.0, VOXEL, margin=SIP), SIP / 2)
    for brim in np.arange(SIP, max(bottoms.max(), SIP) + VOXEL, VOXEL):
        pools, count = ndimage.label(bottoms < brim, np.ones((3, 3)))
        lowest = ndimage.minimum(bottoms, pools, np.arange(1, count + 1))
        if ((lowest > NOTHING) & (lowest <= brim - SIP + 1e-9)).any():
            return True
    return False


def ball_bottoms(view: TopView, radius: float) -> np.ndarray:
    """Return the height of the lowest point (X, Y) of a ball let down on an object, metres; NOTHING off the object."""
    reach = int(radius / view.cell)
    across = np.hypot(*np.mgrid[-reach : reach + 1, -reach : reach + 1]) * view.cell
    rise = np.sqrt(np.maximum(radius**2 - across**2, 0)) - radius
    return ndimage.grey_dilation(
        view.heights, footprint=across <= radius, structure=rise, mode="constant", cval=NOTHING
    )


Classify = Callable[[ObjectRecord], frozenset[str]]  # the functions that an object has
RELATED: dict[str, Classify] = {"rules": functions_by_rules, "examiner": functions_by_agents}


@dataclass(frozen=True, kw_only=True, eq=False)
class FixedScores(FeatureMethod):
    """The scores of all objects, which do not depend on training."""

    method = CUBES

    scores: np.ndarray  # (N, F) float, 0 or 1
    labels: Labels

    def trials(self, splits_of_trials: Sequence[Sequence[Split]]) -> list[Trial]:
        """Return several trials, each of the objects that its splits test."""

        def tested(split: Split) -> Trial:
            return Trial(learnt=len(split.train), rows=split.test, scores=self.scores[split.test], weights=())

        return [Trial.joined(list(map(tested, splits))) for splits in splits_of_trials]


def related(records: Sequence[ObjectRecord], labels: Labels) -> dict[str, FixedScores]:
    """Return the scores of objects by the baselines of related work; functions that they do not know score 0."""
    return {name: fixed(classify, records, labels) for name, classify in RELATED.items()}


def fixed(classify: Classify, records: Sequence[ObjectRecord], labels: Labels) -> FixedScores:
    """Return one baseline's scores of objects."""
    predicted = of_each(classify, records)
    scores = [[float(function in functions) for function in labels.functions] for functions in predicted]
    return FixedScores(scores=np.array(scores).reshape(len(records), len(labels.functions)), labels=labels)
