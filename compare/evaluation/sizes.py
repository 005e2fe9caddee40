"""How many train: one way to say it for evaluate and figures, each with its rule for what does not fit."""

from __future__ import annotations

from spherefunc_bullet.errors import InputError

TRAIN_SIZES = "20,45,85,half"
FEWEST = 4  # objects: two to learn from, two to test on


def parse_sizes(text: str, count: int) -> list[int]:
    """Return the training sizes of a list such as ``20,45,half``, ascending, whether they fit or not.

    Raises
    ------
    InputError
        If a size is no number.
    """
    try:
        return sorted({count // 2 if part.strip() == "half" else int(part) for part in text.split(",")})
    except ValueError:
        raise InputError(f"--train-sizes {text}: expected numbers and half, such as {TRAIN_SIZES}") from None


def wanted_sizes(text: str, count: int) -> list[int]:
    """Return the training sizes; those of the default list that are too large for the data are left out.

    Raises
    ------
    InputError
        If a size is no number, or one that was asked for is larger than half of the objects.
    """
    half, sizes = count // 2, parse_sizes(text, count)
    if text == TRAIN_SIZES:
        sizes = [size for size in sizes if size <= half]
    if not sizes or sizes[0] < 2 or sizes[-1] > half:
        raise InputError(f"--train-sizes {text}: expected from 2 to {half}, half of the {count} objects")
    return sizes


def fitting_sizes(text: str, count: int) -> tuple[tuple[int, ...], list[int]]:
    """Return the training sizes, half of the objects in place of each that is larger, and those that are.

    Raises
    ------
    InputError
        If a size is no number, or less than two.
    """
    half, asked = count // 2, parse_sizes(text, count)
    if asked[0] < 2:
        raise InputError(f"--train-sizes {text}: expected numbers from 2, got {asked[0]}")
    return tuple(sorted({min(size, half) for size in asked})), [size for size in asked if size > half]


def require_enough(name: str, count: int, which: str = ""):
    """Raise InputError if so few objects cannot be split."""
    if count < FEWEST:
        raise InputError(
            f"{name}: expected at least {FEWEST} objects{which}, half to learn and half to test, got {count}"
        )
