"""Why an object has a function or not: its nearest training objects, and the cubes that speak for and against."""

from __future__ import annotations

from html import escape

import numpy as np

from ..clouds.cloud import Cloud
from ..learning.cube_classifier import CubeClassifier
from ..learning.evidence import Cubes, cube_evidence
from ..learning.validation import THRESHOLD
from ..quantities import format_length
from ..settling.settling import Settled
from .data import Layer, Panel, display
from .page import display_html, table_html


def explanation_html(classifier: CubeClassifier, cloud: Cloud, settled: Settled) -> str:
    """Return a section that says what an object is for, and why, with a panel for each function.

    Parameters
    ----------
    classifier : CubeClassifier
        Fitted.
    cloud : Cloud
    settled : dict of float to (S, 3) float
        The object's settled spheres at each radius that the classifier uses, metres.
    """
    scores = dict(zip(classifier.functions_, classifier.score_settled([settled])[0], strict=True))
    panels = [function_panel(classifier, settled, name, score) for name, score in scores.items()]
    radius = classifier.radius_[max(scores, key=scores.get)]
    backend = getattr(classifier.simulator, "name", classifier.simulator)
    return (
        f"<section><h2>Why: {escape(verdict(scores))}</h2>"
        f"<p class='lead'>By a classifier that learnt from {len(classifier.names_)} objects with the backend "
        f"{escape(str(backend))}. A score above 0.5 is membership. It compares how near, cube by cube, this object's "
        "sphere counts are to those of the nearest training objects that have the function and of the nearest that "
        "do not, at several radii.</p>"
        f"{display_html(display(cloud, panels, radius))}</section>"
    )


def verdict(scores: dict[str, float]) -> str:
    """Return what an object is for, in words.

    Examples
    --------
    >>> verdict({"cup": 0.74, "table": 0.6}), verdict({"cup": 0.2})
    ('cup, table', 'none of cup')
    """
    members = [name for name, score in scores.items() if score > THRESHOLD]
    return ", ".join(members) or f"none of {', '.join(scores)}"


def function_panel(classifier: CubeClassifier, settled: Settled, name: str, score: float) -> Panel:
    """Return the panel of one function, with a layer for each radius that it uses."""
    neighbors = classifier.neighbors(settled, name)
    weights = dict(sorted(classifier.weights_[name].items()))
    layers = []
    for radius, share in weights.items():
        cubes = cube_evidence(classifier, settled, name, radius)
        rows = [row for row in neighbors if row["radius"] == radius]
        note = evidence_note(cubes, name, radius, share)
        layers.append(
            Layer(radius=radius, centers=settled[radius], cubes=cubes, note=note, details=neighbors_html(rows, name))
        )
    return Panel(title=f"{name}: {score:.2f}, {'yes' if score > THRESHOLD else 'no'}", layers=layers)


def evidence_note(cubes: Cubes, name: str, radius: float, share: float) -> str:
    """Return how much a radius counts, and what its cubes say together."""
    pro, contra = np.maximum(cubes.speaks_for, 0).sum(), np.maximum(-cubes.speaks_for, 0).sum()
    total = pro + contra
    balance = (
        f"{pro / total:.0%} of the cubes' weight for, {contra / total:.0%} against" if total else "nothing to tell"
    )
    return f"Spheres of radius {format_length(radius)} make {share:.0%} of the score of {name}; {balance}."


def neighbors_html(rows: list[dict], name: str) -> str:
    """Return a table of the training objects that decide at one radius, heaviest first."""
    head = ["nearest training object", f"is {name}", "distance", "weight"]
    cells = [
        [row["name"], "yes" if row["member"] else "no", f"{row['distance']:.1f}", f"{row['weight']:.3f}"]
        for row in sorted(rows, key=lambda row: -row["weight"])
    ]
    return table_html(head, cells, texts=2, label=f"Nearest training objects, {name}")
