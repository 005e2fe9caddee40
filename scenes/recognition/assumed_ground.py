"""Claims where no floor is seen: only those that hold wherever the ground may lie below."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

from spherefunc_bullet.clouds.cloud import Cloud
from spherefunc_bullet.function_model import Membership

Memberships = dict[str, Membership]  # by the function's name
_LOWER = (0.1, 0.2)  # metres by which the lowest point of a view may lie above the floor: legs are hidden or cut off


def holding_anywhere(
    clouds: Sequence[Cloud],
    predictions: Sequence[Memberships],
    asked: Callable[[Sequence[int], float], list[Memberships]],
    large: float,
) -> list[Memberships]:
    """Return the predictions for objects, without what a lower ground would make untrue of large ones.

    Parameters
    ----------
    clouds : sequence of Cloud
        Objects, standing on a ground that is only assumed.
    predictions : sequence of dict
        Those for them there.
    asked : callable
        Tells it of some of them, by their places, on a ground so much lower, metres.
    large : float
        Metres: what is smaller stands on what was seen, or is classified by its own height.
    """
    doubted = [
        k
        for k, cloud in enumerate(clouds)
        if cloud.size.max() >= large and any(membership.member for membership in predictions[k].values())
    ]
    kept = list(predictions)
    for lower in _LOWER:
        for k, other in zip(doubted, asked(doubted, lower), strict=True):
            kept[k] = {
                name: replace(membership, member=membership.member and other[name].member)
                for name, membership in kept[k].items()
            }
    return kept
