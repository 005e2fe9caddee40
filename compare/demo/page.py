"""The demo's report: one page of HTML that needs nothing beside it, not even a network.

Every number on it comes from the results that it is given.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from html import escape

from PIL.Image import Image

from spherefunc_bullet.datasets.dataset import label_text
from spherefunc_bullet.formats.units import format_duration, format_length
from spherefunc_bullet.viewer.page import table_html

from ..comparison.recommendation import recommendation_sentence, recommendation_table, recommendations
from ..comparison.report import Report
from ..comparison.tables import with_spread
from ..evaluation.confusion import Confusion
from ..evaluation.features import SPHERES
from ..evaluation.profiled import POINTS
from ..evaluation.results import Qualities, Result
from ..pages.html import image, report_page

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
    """One object that the classifier had not seen, what it said, and what is true."""

    name: str
    functions: frozenset[str]  # labelled so
    also: frozenset[str]  # true as well, but not the primary function
    scores: dict[str, float]
    predicted: frozenset[str]
    nearest: str  # the training object that counted most for the function of the highest score
    reason: str  # its answer in a sentence
    picture: Image
    radius: float  # of the spheres in the picture, metres
    settled: int

    @property
    def correctness(self) -> str:
        """Return right or wrong; a function that is true as well may be said or not."""
        return "right" if self.predicted - self.also == self.functions - self.also else "wrong"


@dataclass(frozen=True, kw_only=True)
class Summary:
    """What the page shows."""

    data: str  # the data set's name
    objects: int
    results: Sequence[Result]  # as `spherefunc evaluate --json` has them
    confusion: Confusion
    classified: Sequence[ClassifiedObject]
    figure: Image  # the gallery
    impaired: Image  # which impaired copies are still called by their function
    comparison: Report  # of simulators, as `spherefunc compare` reports it, in comparison/report.html
    configuration: dict[str, str]
    seconds: dict[str, float]  # what was done, and how long it took


def page(summary: Summary) -> str:
    """Return the page as HTML."""
    splits = [result for result in summary.results if result["protocol"] == "random_splits"]
    parts = [
        introduction(summary),
        chart_section(splits[-1], summary),
        impaired_section(summary),
        sizes_section(splits),
        classified_section(summary.classified),
        comparison_section(summary.comparison),
        confusion_section(summary.confusion),
        configuration_section(summary),
    ]
    return report_page(f"What {summary.data} objects are for", parts)


def introduction(summary: Summary) -> str:
    """Return what this is, in one sentence and one picture."""
    functions = ", ".join(summary.results[-1]["functions"])
    return f"""<header><h1>What is it for? Ask where spheres come to rest</h1>
<p class="lead">Small spheres are dropped on a 3D object, one at a time; where they come to rest tells what the
object can be used for ({escape(functions)}, or nothing of these), without looking at its appearance.</p>
{image(summary.figure, "Spheres settled on a cup, a table, a chair and a sofa")}
<p class="note">A cup fills up, a table collects one flat layer, a chair holds a slope from the seat's front edge to its
back. Spheres are coloured by height.</p></header>"""


def chart_section(result: Result, summary: Summary) -> str:
    """Return the F-measures of spheres and baselines as bars, one group for each function, and as a table."""
    features = {SPHERES: result["functions"]} | result["baselines"]
    groups = "\n".join(bar_group(name, features) for name in result["functions"])
    rows = [[NAMES[feature], *map(with_spread, qualities.values())] for feature, qualities in features.items()]
    test = summary.objects - summary.objects // 2
    return f"""<section><h2>How well functions are classified</h2>
<p>F-measure (1 is perfect, 0 is useless): {result["trials"]} times, {result["train_size"]} of the
{summary.objects} objects of <b>{escape(summary.data)}</b> were learnt at random and {test} others were tested. The
lower bars are baselines that need no spheres, scored with the same classifier; people have given rules and agents what
to look for, and learn nothing. {escape(rank_sentence(features))}</p>
<div class="groups">{groups}</div>
{table_html(["features", *result["functions"]], rows)}
<p class="note">Mean over trials ± standard deviation. The catalogue is made by a program, so these numbers show that
everything runs; how well the method does on real models is a question for real models.</p></section>"""


def bar_group(function: str, features: Mapping[str, Qualities]) -> str:
    """Return the bars of one function."""
    bars = []
    for feature, qualities in features.items():
        f_measure, kind = qualities[function]["f_measure"], "spheres" if feature == SPHERES else "baseline"
        fill = f'<span class="track"><span class="fill {kind}" style="width:{100 * f_measure:.1f}%"></span></span>'
        number = f'<span class="number">{f_measure:.2f}</span>'
        bars.append(f'<div class="bar"><span>{escape(NAMES[feature])}</span>{fill}{number}</div>')
    return f'<div class="group"><h3>{escape(function)}</h3>{"".join(bars)}</div>'


def rank_sentence(features: Mapping[str, Qualities]) -> str:
    """Return for each function the F-measure of spheres beside the best baseline's."""
    parts = []
    for function, spheres in features[SPHERES].items():
        baselines = {name: rows[function]["f_measure"] for name, rows in features.items() if name != SPHERES}
        best = max(baselines, key=baselines.get)
        parts.append(f"for {function} {spheres['f_measure']:.2f} beside {baselines[best]:.2f} ({NAMES[best]})")
    return f"Spheres have, beside the best baseline of each function, {', '.join(parts)}."


def impaired_section(summary: Summary) -> str:
    """Return the picture of impaired copies and their answers."""
    return f"""<section><h2>Does it still work?</h2><p>Copies of objects that were not learnt: made useless, though they
look right, or changed in ways that do not matter. What tells functions must drop the first and keep the second.</p>
{image(summary.impaired, "Share of useless and harmless copies still called by their function")}</section>"""


def sizes_section(splits: Sequence[Result]) -> str:
    """Return how the F-measure of the spheres grows with the number of training objects (paper, Fig. 3)."""
    rows = [[str(result["train_size"]), *map(with_spread, result["functions"].values())] for result in splits]
    return f"""<section><h2>How many examples it takes</h2><p>F-measure of the settled spheres by the number of
objects learnt.</p>{table_html(["objects learnt", *splits[-1]["functions"]], rows)}</section>"""


def classified_section(objects: Sequence[ClassifiedObject]) -> str:
    """Return pictures of objects that were not learnt, with what was said of them."""
    right = sum(item.correctness == "right" for item in objects)
    return f"""<section><h2>Objects it had never seen</h2>
<p>{right} of {len(objects)} right. These were made anew by the program that made the training
objects, from another seed, and not learnt: a training object of the same name is another object. A score above 0.5
means that the object has the function. Small objects are drawn cut open, to show what settled inside.</p>
<div class="cards">{"".join(map(card, objects))}</div></section>"""


def card(item: ClassifiedObject) -> str:
    """Return one object's picture, scores and label."""
    rows = [[name, f"{score:.2f}", "yes" if name in item.predicted else "no"] for name, score in item.scores.items()]
    also = f" (also {escape(label_text(item.also, ', '))})" if item.also else ""
    answer, label = (escape(label_text(functions, ", ")) for functions in (item.predicted, item.functions))
    drawn = f"r = {format_length(item.radius)}, {item.settled:,} spheres settled"
    return f"""<article>{image(item.picture, f"{item.name} with settled spheres")}
<h3>{escape(item.name)} <span class="verdict {item.correctness}">{item.correctness}</span></h3>
<p>Said to be: <b>{answer}</b><br>Label: <b>{label}</b>{also}</p>
{table_html(["function", "score", "member"], rows, kind="scores")}
<p class="note">{escape(item.reason)}.<br>Most like it: {escape(item.nearest)}<br>{drawn}</p></article>"""


def comparison_section(comparison: Report) -> str:
    """Return which simulator to use, and where the whole comparison is."""
    chosen = recommendations(comparison)
    sentences = f"<b>{escape(recommendation_sentence(chosen))}</b> {escape(comparison['answer'])}"
    return f"""<section><h2>By geometry or by physics?</h2><p>Two simulators dropped spheres on
the same {comparison["objects"]} objects: {sentences}</p>{recommendation_table(comparison, chosen)}
<p><a href="comparison/report.html">The whole comparison</a>, with objects interactive.</p></section>"""


def confusion_section(confusion: Confusion) -> str:
    """Return who was taken for what, every object tested on nine tenths of the others."""
    lines = zip(confusion.labels, confusion.objects, confusion.counts, strict=True)
    rows = [[label, str(count), *map(str, taken)] for label, count, taken in lines]
    head = ["labelled", "objects", *(f"said: {name}" for name in confusion.labels)]
    return f"""<section><h2>What is taken for what</h2><p>Every object was classified with nine tenths of
the catalogue learnt, itself not among them. An object may be said to have several functions, so a row may add up to
more than its objects.</p>
{table_html(head, rows)}</section>"""


def configuration_section(summary: Summary) -> str:
    """Return how this page was made, and how long each step took."""
    steps = summary.seconds | {"all together": sum(summary.seconds.values())}
    times = [[name, format_duration(seconds)] for name, seconds in steps.items()]
    made = table_html(["setting", "value"], list(summary.configuration.items()), texts=None)
    return f"""<section><h2>How this was made</h2><div class="columns">{made}
{table_html(["step", "time"], times)}</div>
<p class="note">Settled spheres are kept in a cache: a second run takes less time.</p></section>"""
