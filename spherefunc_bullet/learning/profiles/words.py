"""Explanations in words: where spheres came to rest, and the quantities that decided.

For a chair: a level 46 cm above the ground, on which spheres lie up to 8 cm deep.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ...formats.units import format_length
from ...function_model import THRESHOLD, Reading
from ...settling.drops import settled_count
from .quantities import QUANTITY, Profile

DECIDING = 4  # number of quantities that are named
LEAST_GAIN = 0.05  # of a score: a quantity that would raise it by less does not explain why it is low
NEAREST = 3  # number of training objects that are named
Row = dict[str, Any]  # ready for JSON


def sentences(reading: Reading) -> list[str]:
    """Return a sentence for each function that an object has; if it has none, for that with the highest score."""
    functions, scores = reading.model.functions_, reading.rounded
    score_of = dict(zip(functions, scores, strict=True))
    names = [name for name in functions if score_of[name] > THRESHOLD]
    if names:
        return [f"{name} {score_of[name]:.2f}: {contact_sentence(reading, name)}" for name in names]
    likeliest = functions[int(np.argmax(scores))]
    sentence = contact_sentence(reading, likeliest) + counter_evidence(reading, likeliest)
    return [f"{likeliest} {score_of[likeliest]:.2f}: {sentence}"]


def contact_sentence(reading: Reading, name: str) -> str:
    """Return a sentence on where the spheres rest that count most for a function."""
    radius = most_important_radius(reading, name)
    if radius is None:
        return "no sphere stays on it"
    names = reading.model.quantities
    start = list(reading.model.radii).index(radius) * len(names)
    profile = dict(zip(names, reading.profile[start : start + len(names)].tolist(), strict=True))
    walls = ", with walls on every side" if profile["walled_in"] > 0.5 else ""
    count = settled_count(reading.drops, radius)  # more than lie on the level, such as on a rim
    return (
        f"a level {text_of(profile, 'level_height')} above the ground, {text_of(profile, 'level_area')} large and "
        f"{text_of(profile, 'level_width')} wide{walls}, on which spheres of radius {format_length(radius)} lie "
        f"{text_of(profile, 'level_depth')} deep; {count if count > 1 else 'one'} {'stay' if count > 1 else 'stays'}, "
        f"{text_of(profile, 'stays')} of the drops within their outline"
    )


def most_important_radius(reading: Reading, name: str) -> float | None:
    """Return the radius that counts most for a function, of those with settled spheres; None if none settled."""
    radii = [radius for radius in reading.model.radii if settled_count(reading.drops, radius)]
    if not radii:
        return None
    chosen = reading.model.radius_[name]
    return chosen if chosen in radii else radii[-1]


def counter_evidence(reading: Reading, name: str) -> str:
    """Return the quantity that speaks most against a function, as a clause; empty if none does.

    Each quantity in turn is set, at all radii, to the median of the training objects that have the function; the one
    that raises the score most is named.
    """
    radius = most_important_radius(reading, name)
    if radius is None:
        return ""
    model, profile = reading.model, reading.profile
    column, count = model.functions_.index(name), len(model.quantities)
    members = model.members_[:, column] & (model.copy_groups_.weights == 1)
    if not members.any():
        return ""
    medians = np.median(model.profiles_[members], axis=0)
    changed = np.tile(profile, (count, 1))
    for number in range(count):
        changed[number, number::count] = medians[number::count]
    gains = model.score_profiles(changed)[:, column] - reading.scores[column]
    best = int(gains.argmax())
    if gains[best] < LEAST_GAIN:
        return ""
    quantity, at = QUANTITY[model.quantities[best]], count * list(model.radii).index(radius) + best
    value, median = (with_unit(float(row[at]), quantity.unit) for row in (profile, medians))
    return f"; what speaks most against it: {quantity.meaning}, {value} instead of {median}"


def deciding_quantities(reading: Reading, name: str, count: int = DECIDING) -> list[Row]:
    """Return the quantities with the largest effect on the score of a function, the largest first; see `Reason`.

    ``share`` is the loss of the score when the quantity is set to the median of the training objects.
    """
    model, profile = reading.model, reading.profile
    column = model.functions_.index(name)
    medians = np.median(model.profiles_, axis=0)
    changed = np.tile(profile, (len(profile), 1))
    np.fill_diagonal(changed, medians)
    scores = model.score_profiles(np.vstack([profile, changed]))[:, column]
    shares = scores[0] - scores[1:]
    columns = [(radius, quantity) for radius in model.radii for quantity in model.quantities]
    order = np.argsort(-np.abs(shares), kind="stable")[:count]
    return [
        {
            "quantity": columns[i][1],
            "meaning": QUANTITY[columns[i][1]].meaning,
            "radius": columns[i][0],
            "value": round(float(profile[i]), 4),
            "median": round(float(medians[i]), 4),
            "share": round(float(shares[i]), 4),
        }
        for i in order.tolist()
        if shares[i]
    ]


def nearest(reading: Reading, count: int = NEAREST) -> list[Row]:
    """Return the most similar training objects, nearest first; copies are left out.

    ``distance`` is the mean difference of ranks among the training objects, 0 to 1.
    """
    model, rows = reading.model, reading.model.references
    distances = model.distances(reading.profile[None])[0]
    distances[model.copy_groups_.weights[rows] < 1] = np.inf
    return [
        {
            "name": model.names_[rows[i]],
            "functions": [name for name, has in zip(model.functions_, model.members_[rows[i]], strict=True) if has],
            "distance": round(float(distances[i]), 4),
        }
        for i in np.argsort(distances, kind="stable")[:count].tolist()
    ]


def text_of(profile: Profile, name: str) -> str:
    """Return the value of a quantity with its unit."""
    return with_unit(profile[name], QUANTITY[name].unit)


def table_cells(decided: Row) -> list[str]:
    """Return a deciding quantity as table cells: meaning, radius, value, median, change of the score without it."""
    values = (with_unit(decided[key], QUANTITY[decided["quantity"]].unit) for key in ("value", "median"))
    return [decided["meaning"], format_length(decided["radius"]), *values, f"{-decided['share']:+.2f}"]


def with_unit(value: float, unit: str) -> str:
    """Return a value with its unit, rounded for reading.

    Examples
    --------
    >>> with_unit(0.463, "m"), with_unit(0.16, "m2"), with_unit(0.64, "share")
    ('46 cm', '0.16 m²', '64 %')
    >>> with_unit(170.0, ""), with_unit(0.034, "")
    ('170', '0.034')
    """
    if unit == "m":
        return f"{100 * value:.0f} cm" if abs(value) >= 0.1 else f"{100 * value:.1f} cm"
    if unit == "m2":
        return f"{in_digits(value)} m²" if value >= 0.1 else f"{1e4 * value:.0f} cm²"
    return f"{100 * value:.0f} %" if unit == "share" else in_digits(value)


def in_digits(value: float) -> str:
    """Return a value with two significant digits, without an exponent."""
    return f"{float(f'{value:.2g}'):,.10g}"
