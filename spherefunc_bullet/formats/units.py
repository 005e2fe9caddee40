"""Lengths, masses, durations and amounts of memory as text; internally in metres, kilograms, seconds and bytes."""

from __future__ import annotations

import math
import re
import time

from ..errors import InputError, explaining

BY_FILE = "file"  # the up axis of the file's format: y for glTF, z for formats that do not define one
METRES = {"m": 1.0, "cm": 0.01, "mm": 0.001, "in": 0.0254}
_LENGTH = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*([a-z]*)\s*")
KILOGRAMS = {"": 1.0, "kg": 1.0, "g": 0.001}
SECONDS = {"": 1, "s": 1, "min": 60, "m": 60, "h": 3600, "d": 86400}
BYTES = {"": 1, "b": 1} | {
    f"{letter}{ending}": base**power
    for power, letter in enumerate("kmgt", start=1)
    for ending, base in (("", 1024), ("b", 1000), ("ib", 1024))
}
_AMOUNT = re.compile(r"\s*(\d+\.?\d*|\.\d+)\s*([a-z]*)\s*")


def parse_length(text: str | float) -> float:
    """Return a positive length in metres.

    Parameters
    ----------
    text : str or float
        A number with an optional unit, m, cm, mm or in; without one, metres.

    Raises
    ------
    InputError
        If it is not a length, or not positive and finite.

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
    """Return the lengths of a comma-separated list, in metres, ascending and without duplicates.

    Raises
    ------
    InputError
        If the list is empty, or one of its parts is not a length.

    Examples
    --------
    >>> parse_lengths("2cm,1cm,0.02")
    (0.01, 0.02)
    """
    lengths = {parse_length(part) for part in text.split(",") if part.strip()}
    if not lengths:
        raise InputError(f"lengths {text!r}: expected at least one, such as 5mm or 5mm,1cm")
    return tuple(sorted(lengths))


def parse_numbers(option: str, text: str, expected: str) -> tuple[float, ...]:
    """Return the comma-separated numbers of an option.

    Examples
    --------
    >>> parse_numbers("--angles", "15,30", "degrees")
    (15.0, 30.0)
    """
    with explaining(f"{option} {text!r}: expected {expected}", ValueError):
        return tuple(float(part) for part in text.split(","))


def format_length(metres: float) -> str:
    """Return a length as text with a suitable unit.

    Examples
    --------
    >>> format_length(0.005), format_length(0.02), format_length(1.5), format_length(-0.05)
    ('5 mm', '2 cm', '1.5 m', '-5 cm')
    """
    if abs(metres) < 0.01:
        return f"{metres * 1000:g} mm"
    return f"{metres * 100:g} cm" if abs(metres) < 1 else f"{metres:g} m"


def parse_duration(text: str | None) -> float:
    """Return a duration in seconds; infinite if there is no text.

    Examples
    --------
    >>> parse_duration("90"), parse_duration("1.5min"), parse_duration("2h"), parse_duration(None)
    (90.0, 90.0, 7200.0, inf)
    """
    return math.inf if text is None else _amount(text, SECONDS, "a duration such as 90s, 30min or 2h")


def parse_memory(text: str | None) -> int | None:
    """Return an amount of memory in bytes; None if there is no text.

    Examples
    --------
    >>> parse_memory("800MiB"), parse_memory("4G"), parse_memory("1.5 GB"), parse_memory(None)
    (838860800, 4294967296, 1500000000, None)
    """
    return None if text is None else int(_amount(text, BYTES, "an amount of memory such as 800MiB or 4GiB"))


def parse_mass(text: str) -> float:
    """Return a mass in kilograms.

    Examples
    --------
    >>> parse_mass("5kg"), parse_mass("300 g"), parse_mass("0.5")
    (5.0, 0.3, 0.5)
    """
    return _amount(text, KILOGRAMS, "a mass such as 5kg or 300g")


def format_mass(kilograms: float) -> str:
    """Return a mass as text, rounded to two digits.

    Examples
    --------
    >>> format_mass(0.3471), format_mass(4.72), format_mass(38.4), format_mass(123.4)
    ('350 g', '4.7 kg', '38 kg', '120 kg')
    """
    rounded = float(f"{kilograms:.2g}")
    return f"{rounded:g} kg" if rounded >= 1 else f"{1000 * rounded:g} g"


def _amount(text: str, units: dict[str, int] | dict[str, float], wanted: str) -> float:
    """Return a positive number in the base unit."""
    match = _AMOUNT.fullmatch(text.lower())
    value = float(match[1]) * units[match[2]] if match and match[2] in units else 0.0
    if not 0 < value < math.inf:
        raise InputError(f"{text!r}: expected {wanted}, above zero")
    return value


class Stopwatch:
    """Measures the seconds that each step takes, in order."""

    def __init__(self):
        self.seconds: dict[str, float] = {}
        self._last = time.perf_counter()

    def lap(self, step: str):
        """Add the time since the last call to the step of this name."""
        now = time.perf_counter()
        self.seconds[step] = self.seconds.get(step, 0.0) + now - self._last
        self._last = now


def format_duration(seconds: float) -> str:
    """Return a duration as text with suitable units.

    Examples
    --------
    >>> format_duration(0.0123), format_duration(4.25), format_duration(100), format_duration(7260)
    ('12 ms', '4.2 s', '1 min 40 s', '2 h 1 min')
    """
    if seconds < 1:
        return f"{1000 * seconds:.{0 if seconds >= 0.01 or not seconds else 1}f} ms"
    if seconds < 60:
        return f"{seconds:.1f} s"
    if seconds < 3600:
        return f"{int(seconds // 60)} min {int(seconds % 60)} s"
    if seconds < 86400:
        return f"{int(seconds // 3600)} h {int(seconds % 3600 // 60)} min"
    return f"{int(seconds // 86400)} d {int(seconds % 86400 // 3600)} h"


def format_memory(size: float) -> str:
    """Return an amount of memory as text with a suitable unit.

    Examples
    --------
    >>> format_memory(900), format_memory(5 * 2**20), format_memory(3.2e12)
    ('900 B', '5.0 MiB', '2.9 TiB')
    """
    units = ["B", "KiB", "MiB", "GiB", "TiB"]
    while size >= 1024 and len(units) > 1:
        size, units = size / 1024, units[1:]
    return f"{size:.0f} B" if units[0] == "B" else f"{size:.1f} {units[0]}"
