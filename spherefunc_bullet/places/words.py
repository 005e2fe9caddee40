"""Places in words: the cells of a table, on the console and on pages."""

from __future__ import annotations

from typing import Any

Row = dict[str, Any]  # a place for JSON, see `Place.as_json`
HEAD = ("place to", "score", "position", "facing", "height", "details")  # lengths in the coordinates of the input


def lengths_in(unit: str) -> str:
    """Return the unit of lengths in words, of a file whose unit is not known if it is empty."""
    return f"lengths in {unit}" if unit else "lengths as in the file"


def place_columns(place: Row, unit: str = "m") -> list[str]:
    """Return the cells of a place's row, under `HEAD`."""
    where = " ".join(f"{round(value, 2) + 0.0:.2f}" for value in place["position"])
    facing = "any" if place["heading_deg"] is None else f"{round(place['heading_deg']) % 360}°"
    return [place["kind"], f"{place['score']:.2f}", where, facing, f"{place['height']:.3g}", details(place, unit)]


def details(place: Row, unit: str = "m") -> str:
    """Return the details that matter for a kind of place, as a text."""
    from .pouring import HOLE

    unit = f" {unit}" if unit else ""
    if place["kind"] == "pour":
        spills = f", spills at {place['spill_tilt_deg']:.0f}°" if "spill_tilt_deg" in place else ""
        hole = ", has a hole" if place.get("note") == HOLE else ""
        return f"holds {place['capacity_ml']:.0f} ml{spills}{hole}"
    if place["kind"] == "put":
        square, count = f"{unit}²" if unit else "", len(place.get("poses", ()))
        poses = f", {count} pose{'s' * (count > 1)}" if count else ""
        return f"{figures(place['area'])}{square} free, {figures(2 * place['radius'])}{unit} wide{poses}"
    has = [name for name in ("back", "arms") if place.get(name)]
    deep = [f"{figures(place['depth'])}{unit} deep"] if "depth" in place else []
    return ", ".join([*deep, *([f"with {' and '.join(has)}"] if has else [])])


def figures(number: float) -> str:
    """Return a number with two significant digits.

    Examples
    --------
    >>> figures(0.4231), figures(93456.0)
    ('0.42', '93000')
    """
    return f"{float(f'{number:.2g}'):.10g}"
