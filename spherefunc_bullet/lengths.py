"""Lengths as people write them (``5mm``, ``0.5cm``, ``0.005``), in metres inside."""

from __future__ import annotations

import math
import re

from .errors import InputError

METRES = {"m": 1.0, "cm": 0.01, "mm": 0.001, "in": 0.0254}

_LENGTH = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*([a-z]*)\s*")


def parse_length(text: str | float) -> float:
    """Return a positive length in metres.

    Parameters
    ----------
    text : str or float
        A number with an optional unit out of m, cm, mm, in; without one, metres.

    Raises
    ------
    InputError
        If it is no length, or not positive and finite.

    Examples
    --------
    >>> parse_length("5mm"), parse_length("0.5 cm"), parse_length(0.005)
    (0.005, 0.005, 0.005)
    """
    match = _LENGTH.fullmatch(str(text).lower())
    if match is None or (match[2] or "m") not in METRES:
        raise InputError(f"length {text!r}: expected a number with m, cm, mm or in, such as 5mm or 0.005")
    value = round(float(match[1]) * METRES[match[2] or "m"], 12)
    if not math.isfinite(value) or value <= 0:
        raise InputError(f"length {text!r}: expected more than zero")
    return value


def parse_lengths(text: str) -> tuple[float, ...]:
    """Return the lengths of a comma-separated list, in metres, ascending and without repeats.

    Raises
    ------
    InputError
        If there is none, or one of them is no length.

    Examples
    --------
    >>> parse_lengths("2cm,1cm,0.02")
    (0.01, 0.02)
    """
    lengths = {parse_length(part) for part in text.split(",") if part.strip()}
    if not lengths:
        raise InputError(f"lengths {text!r}: expected at least one, such as 5mm or 5mm,1cm")
    return tuple(sorted(lengths))


def format_length(metres: float) -> str:
    """Return a length as people read it.

    Examples
    --------
    >>> format_length(0.005), format_length(0.02), format_length(1.5)
    ('5 mm', '2 cm', '1.5 m')
    """
    if metres < 0.01:
        return f"{metres * 1000:g} mm"
    return f"{metres * 100:g} cm" if metres < 1 else f"{metres:g} m"
