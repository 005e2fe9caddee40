"""What is doubtful about an answer by resting profiles."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from ...settling.drops import settled_count
from ...settling.settling import Settled
from .quantities import rank_distances

if TYPE_CHECKING:
    from .profile_model import ProfileModel

HAIR = 0.1  # score either side of the threshold that is no answer
FEW = 5  # settled spheres of all radii together from which much can be told


def doubts(classifier: ProfileModel, settled: Settled, scores: Sequence[float]) -> list[str]:
    """Return why the answer is unsure, each a sentence; none where it is sure."""
    found = [
        f"{name} by a hair's breadth: {score:.2f}, where 0.5 decides"
        for name, score in zip(classifier.functions_, scores, strict=True)
        if abs(score - 0.5) < HAIR
    ]
    stayed = sum(settled_count(settled, radius) for radius in classifier.radii)
    dropped = sum(len(settled.get(radius, ())) for radius in classifier.radii)
    if stayed < FEW:
        return [*found, f"hardly a sphere stayed: {stayed} of {dropped}"]
    away = float(rank_distances(classifier.profiles([settled]), classifier.profiles_).min())
    if away > classifier.familiar_:
        found.append(
            f"unlike all {len(classifier.names_)} training objects: {away:.2f} from the nearest, where "
            f"{classifier.familiar_:.2f} is far for one of them"
        )
    return found
