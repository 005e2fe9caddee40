"""The demo's report: one HTML page that needs no other file and no network.

Every number on it comes from a `Summary`; its words are in ``page.html``.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from PIL.Image import Image

from spherefunc_bullet.datasets.dataset import label_text
from spherefunc_bullet.formats.units import format_duration, format_length

from ..comparison.recommendation import recommendation_sentence, recommendation_table, recommendations
from ..comparison.significance import Report
from ..comparison.tables import with_spread
from ..evaluation.evaluation import Confusion, Qualities
from ..evaluation.features import SPHERES
from ..evaluation.readings import POINTS
from ..evaluation.tables import Result
from ..pages.html import filled_template, report_page

NAMES = {
    SPHERES: "settled spheres",
    POINTS: "the object's own points",
    "bounding_box": "bounding box",
    "occupancy": "occupied cubes",
    "occupancy_sqrt": "occupied cubes, square roots",
    "height_map": "top-view heights",
    "rules": "rules on heights and areas",
    "examiner": "agents that try it",
}


@dataclass(frozen=True, kw_only=True)
class ClassifiedObject:
    """One object that the classifier has not learnt, with the answer and the label."""

    name: str
    functions: frozenset[str]  # of the label
    also: frozenset[str]  # true as well, but not the primary function
    scores: dict[str, float]
    predicted: frozenset[str]
    nearest: str  # the training object with the largest weight for the function of the highest score
    reason: str  # the answer in a sentence
    picture: Image
    radius: float  # of the spheres in the picture, metres
    settled: int

    @property
    def correctness(self) -> str:
        """Return right or wrong; a function that is true as well may be predicted or not."""
        return "right" if self.predicted - self.also == self.functions - self.also else "wrong"

    @property
    def score_rows(self) -> list[list[str]]:
        """Return each function's score, and whether it was predicted."""
        predicted = {name: "yes" if name in self.predicted else "no" for name in self.scores}
        return [[name, f"{score:.2f}", predicted[name]] for name, score in self.scores.items()]


@dataclass(frozen=True, kw_only=True)
class Summary:
    """The results that the page shows."""

    data: str  # the data set's name
    objects: int
    results: Sequence[Result]  # as `spherefunc evaluate --json` has them
    confusion: Confusion
    classified: Sequence[ClassifiedObject]
    figure: Image  # the gallery
    impaired: Image  # the impaired copies that are still classified by their function
    laid: Image  # a table with more and more objects on it
    comparison: Report  # of simulators, as `spherefunc compare` reports it, in comparison/report.html
    configuration: dict[str, str]
    seconds: dict[str, float]  # by step


def page(summary: Summary) -> str:
    """Return the page as HTML."""
    splits = [result for result in summary.results if result["protocol"] == "random_splits"]
    features = {SPHERES: splits[-1]["functions"]} | splits[-1]["baselines"]
    chosen, confusion = recommendations(summary.comparison), summary.confusion
    lines = zip(confusion.labels, confusion.objects, confusion.counts, strict=True)
    steps = summary.seconds | {"all together": sum(summary.seconds.values())}
    body = filled_template(
        __package__,
        summary=summary,
        result=splits[-1],
        functions=list(splits[-1]["functions"]),
        features=features,
        feature_names=NAMES,
        feature_rows=[[NAMES[feature], *map(with_spread, row.values())] for feature, row in features.items()],
        rank_sentence=rank_sentence(features),
        size_rows=[[str(split["train_size"]), *map(with_spread, split["functions"].values())] for split in splits],
        right=sum(item.correctness == "right" for item in summary.classified),
        label_text=label_text,
        format_length=format_length,
        advice=recommendation_sentence(chosen),
        recommended=recommendation_table(summary.comparison, chosen),
        confusion_head=["labelled", "objects", *(f"said: {name}" for name in confusion.labels)],
        confusion_rows=[[label, str(count), *map(str, taken)] for label, count, taken in lines],
        times=[[name, format_duration(seconds)] for name, seconds in steps.items()],
    )
    return report_page(f"What {summary.data} objects are for", body)


def rank_sentence(features: Mapping[str, Qualities]) -> str:
    """Return for each function the F-measures of spheres and of the best baseline in a sentence."""
    parts = []
    for function, spheres in features[SPHERES].items():
        baselines = {name: rows[function]["f_measure"] for name, rows in features.items() if name != SPHERES}
        best = max(baselines, key=baselines.get)
        parts.append(f"for {function} {spheres['f_measure']:.2f} beside {baselines[best]:.2f} ({NAMES[best]})")
    return f"Spheres have, beside the best baseline of each function, {', '.join(parts)}."
