"""Table tops."""

from __future__ import annotations

from .solids import (
    circle,
    prism,
    rounded_rectangle,
    superellipse,
)


def top(shape: str, width: float, depth: float, thickness: float, height: float):
    """Return a table top of the given plan whose upper face is at ``height``, metres."""
    outlines = {
        "rectangle": lambda: rounded_rectangle(width, depth, 0.004, steps=1),
        "rounded": lambda: rounded_rectangle(width, depth, 0.25 * min(width, depth), steps=6),
        "round": lambda: circle(width / 2, 40),
        "oval": lambda: superellipse(width, depth, 2.0, 40),
        "boat": lambda: superellipse(width, depth, 3.2, 40),
    }
    return prism(outlines[shape](), thickness, height - thickness)
