"""Explanations of a classification: quantities and sentences, or nearest training objects and cubes of space."""

from __future__ import annotations

from html import escape

import numpy as np

from ..classification import Decision, check_stability
from ..clouds.cloud import Cloud
from ..formats.units import format_length
from ..learning.classifier import CloudClassifier
from ..learning.cube_classifier import CubeClassifier
from ..learning.function_classifier import FunctionClassifier
from ..learning.profiles.words import deciding_quantities, nearest, table_cells
from ..learning.reasons.cubes import Cubes, cube_evidence
from ..learning.validation import THRESHOLD
from ..settling.cached_runs import CloudObject
from ..settling.drops import NO_DROPS, DropsByRadius
from .data import Layer, Panel, sphere_layer
from .page import table_html
from .still import pictured

QUANTITIES_SHOWN = 6  # of each function


def explanation_html(classifier: CloudClassifier, cloud: Cloud, settled: DropsByRadius) -> str:
    """Return a section with the functions of an object and their explanation.

    Parameters
    ----------
    classifier : CloudClassifier
        Fitted.
    cloud : Cloud
    settled : dict of float to Drops
        The drops on the object at each radius that the classifier uses, as `settle` returns them.
    """
    item = CloudObject(raw_cloud=cloud, drop_config=classifier.drop_config())
    decision = check_stability(classifier.reading_of(settled), item, classifier)
    scores = {name: membership.score for name, membership in decision.memberships.items()}
    if isinstance(classifier, FunctionClassifier):
        return words_html(classifier, cloud, decision, scores)
    return cubes_html(classifier, cloud, settled, scores)


def words_html(classifier: FunctionClassifier, cloud: Cloud, decision: Decision, scores: dict[str, float]) -> str:
    """Return the section of a classifier by resting profiles: sentences, and the quantities that decided."""
    reading, falls = decision.reading, decision.fails_stability_check
    sure = "".join(f"<p class='lead'><strong>Unsure:</strong> {escape(doubt)}.</p>" for doubt in decision.doubts())
    near = ", ".join(f"{row['name']} ({', '.join(row['functions']) or 'none'})" for row in nearest(reading))
    tables, head = "", ["quantity", "spheres", "here", "median of training objects", "change without it"]
    for name, score in scores.items():
        decided = [] if falls else deciding_quantities(reading, name, QUANTITIES_SHOWN)
        if rows := [table_cells(row) for row in decided if round(row["share"], 2)]:  # others would be 0.00
            table = table_html(head, rows, texts=2, label=f"What decided, {name}")
            tables += f"<h3>{escape(name)} {score:.2f}</h3>{table}"
    return (
        f"<section><h2>Why: {escape(verdict(scores))}</h2>"
        f"<p class='lead'>{'<br>'.join(escape(sentence) for sentence in decision.reasons())}.</p>{sure}"
        f"<p class='lead'>Nearest of the {len(classifier.names_):,} objects and copies that it learnt, by name: "
        f"{escape(near)}.</p>"
        f"{drops_html(classifier, cloud, reading.drops, max(scores, key=scores.get))}{tables}</section>"
    )


def drops_html(classifier: FunctionClassifier, cloud: Cloud, settled: DropsByRadius, name: str) -> str:
    """Return the display of the drops behind the answer, at first those that count most for a function."""
    layers = []
    for radius in classifier.radii:
        drops = settled.get(radius, NO_DROPS)
        if not len(drops):
            continue
        centers = np.asarray(drops.rests, float)
        note = f"{len(centers)} of {len(drops)} drops of spheres of radius {format_length(radius)} stayed."
        layers.append(sphere_layer(radius, centers, note))
    if not layers:
        return ""
    radius = classifier.radius_[name] if len(settled.get(classifier.radius_[name], ())) else layers[-1].radius
    panels = [Panel(title="what the answer is read from", layers=layers)]
    return pictured(cloud, panels, panels, radius)


def cubes_html(classifier: CubeClassifier, cloud: Cloud, settled: DropsByRadius, scores: dict[str, float]) -> str:
    """Return the section of a classifier by cubes, with a panel for each function."""
    panels = [function_panel(classifier, settled, name, score) for name, score in scores.items()]
    radius = classifier.radius_[max(scores, key=scores.get)]
    backend = getattr(classifier.simulator, "name", classifier.simulator)
    return (
        f"<section><h2>Why: {escape(verdict(scores))}</h2>"
        f"<p class='lead'>By a classifier that learnt from {len(classifier.names_)} objects with the backend "
        f"{escape(str(backend))}. A score above 0.5 is membership. It compares how near, cube by cube, this object's "
        "sphere counts are to those of the nearest training objects that have the function and of the nearest that "
        "do not, at several radii.</p>"
        f"{pictured(cloud, panels, panels[:1], radius)}</section>"
    )


def verdict(scores: dict[str, float]) -> str:
    """Return the functions of an object as text.

    Examples
    --------
    >>> verdict({"cup": 0.74, "table": 0.6}), verdict({"cup": 0.2})
    ('cup, table', 'none of cup')
    """
    members = [name for name, score in scores.items() if score > THRESHOLD]
    return ", ".join(members) or f"none of {', '.join(scores)}"


def function_panel(classifier: CubeClassifier, settled: DropsByRadius, name: str, score: float) -> Panel:
    """Return the panel of one function, with a layer for each radius that it uses."""
    neighbors = classifier.neighbors(settled, name)
    weights = dict(sorted(classifier.weights_[name].items()))
    layers = []
    for radius, share in weights.items():
        cubes = cube_evidence(classifier, settled, name, radius)
        rows = [row for row in neighbors if row["radius"] == radius]
        note, table = evidence_note(cubes, name, radius, share), neighbors_html(rows, name)
        layers.append(Layer(radius=radius, centers=settled[radius].rests, cubes=cubes, note=note, details=table))
    return Panel(title=f"{name}: {score:.2f}, {'yes' if score > THRESHOLD else 'no'}", layers=layers)


def evidence_note(cubes: Cubes, name: str, radius: float, share: float) -> str:
    """Return the weight of a radius, and the evidence of its cubes together, as a sentence."""
    pro, contra = np.maximum(cubes.speaks_for, 0).sum(), np.maximum(-cubes.speaks_for, 0).sum()
    balance = "no evidence from cubes"
    if total := pro + contra:
        balance = f"{pro / total:.0%} of the cubes' weight for, {contra / total:.0%} against"
    return f"Spheres of radius {format_length(radius)} make {share:.0%} of the score of {name}; {balance}."


def neighbors_html(rows: list[dict], name: str) -> str:
    """Return a table of the training objects that decide at one radius, with the largest weight first."""
    head = ["nearest training object", f"is {name}", "distance", "weight"]
    cells = [
        [row["name"], "yes" if row["member"] else "no", f"{row['distance']:.1f}", f"{row['weight']:.3f}"]
        for row in sorted(rows, key=lambda row: -row["weight"])
    ]
    return table_html(head, cells, texts=2, label=f"Nearest training objects, {name}")
