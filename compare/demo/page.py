"""The demo's report: one page of HTML that needs nothing beside it, not even a network.

Every number on it comes from the results that it is given.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from html import escape

from spherefunc_bullet.datasets.dataset import NONE
from spherefunc_bullet.quantities import format_length
from spherefunc_bullet.viewer.page import table_html

from ..comparison.advice import advice_table, recommendation
from ..evaluation.confusion import Confusion
from ..pages.html import image, report_page

SPHERES = "spheres"
NAMES = {
    SPHERES: "settled spheres",
    "bounding_box": "bounding box",
    "occupancy": "occupied cubes",
    "occupancy_sqrt": "occupied cubes, square roots",
    "height_map": "top-view heights",
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
    picture: object  # PIL.Image.Image
    radius: float  # of the spheres in the picture, metres
    settled: int

    @property
    def verdict(self) -> str:
        """Return right or wrong; a function that is true as well may be said or not."""
        return "right" if self.predicted - self.also == self.functions - self.also else "wrong"


@dataclass(frozen=True, kw_only=True)
class Summary:
    """What the page shows."""

    data: str  # the data set's name
    objects: int
    results: Sequence[dict]  # as `spherefunc evaluate --json` has them
    confusion: Confusion
    classified: Sequence[ClassifiedObject]
    figure: object  # PIL.Image.Image, the gallery
    comparison: dict  # of simulators, as `spherefunc compare` reports it, in comparison/report.html
    configuration: dict[str, str]
    seconds: dict[str, float]  # what was done, and how long it took


def page(summary: Summary) -> str:
    """Return the page as HTML."""
    splits = [each for each in summary.results if each["protocol"] == "random_splits"]
    parts = [
        introduction(summary),
        chart_section(splits[-1], summary),
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


def chart_section(result: dict, summary: Summary) -> str:
    """Return the F-measures of spheres and baselines as bars, one group for each function, and as a table."""
    features = {SPHERES: result["functions"]} | result["baselines"]
    groups = "\n".join(bar_group(name, features) for name in result["functions"])
    rows = [
        [NAMES.get(feature, feature), *(cell(scores[name]) for name in result["functions"])]
        for feature, scores in features.items()
    ]
    test = summary.objects - summary.objects // 2
    return f"""<section><h2>How well functions are told</h2>
<p>F-measure (1 is perfect, 0 is useless): {result["trials"]} times, {result["train_size"]} of the
{summary.objects} objects of <b>{escape(summary.data)}</b> were learnt at random and {test} others were tested. The
lower bars are baselines that need no spheres, scored with the same classifier. {escape(standing(features))}</p>
<div class="groups">{groups}</div>
{table_html(["features", *result["functions"]], rows)}
<p class="note">Mean over trials ± standard deviation. The catalogue is made by a program, so these numbers show that
everything runs; how well the method does on real models is a question for real models.</p></section>"""


def bar_group(function: str, features: dict[str, dict]) -> str:
    """Return the bars of one function."""
    bars = []
    for feature, scores in features.items():
        f_measure = scores[function]["f_measure"]
        kind = "spheres" if feature == SPHERES else "baseline"
        fill = f'<span class="track"><span class="fill {kind}" style="width:{100 * f_measure:.1f}%"></span></span>'
        name = escape(NAMES.get(feature, feature))
        bars.append(f'<div class="bar"><span>{name}</span>{fill}<span class="number">{f_measure:.2f}</span></div>')
    return f'<div class="group"><h3>{escape(function)}</h3>{"".join(bars)}</div>'


def standing(features: dict[str, dict]) -> str:
    """Return a sentence on each function: whether spheres are ahead of the best baseline."""
    said = []
    for function, row in features[SPHERES].items():
        best = max((name for name in features if name != SPHERES), key=lambda name: f_of(features, name, function))
        side = "ahead" if row["f_measure"] > f_of(features, best, function) else "not ahead"
        said.append(f"for {function} {side} ({NAMES.get(best, best)})")
    return f"Against the best baseline of each function, spheres are {', '.join(said)}."


def f_of(features: dict[str, dict], feature: str, function: str) -> float:
    """Return the F-measure of one feature for one function."""
    return features[feature][function]["f_measure"]


def cell(row: dict) -> str:
    """Return an F-measure with its spread over trials."""
    return f"{row['f_measure']:.3f} ± {row['f_measure_std']:.3f}"


def sizes_section(splits: Sequence[dict]) -> str:
    """Return how the F-measure of the spheres grows with the number of training objects (paper, Fig. 3)."""
    functions = list(splits[-1]["functions"])
    rows = [
        [str(each["train_size"]), *(cell(each["functions"][name]) for name in functions)] for each in splits
    ]
    return f"""<section><h2>How many examples it takes</h2><p>F-measure of the settled spheres by the number of
objects learnt.</p>{table_html(["objects learnt", *functions], rows)}</section>"""


def classified_section(objects: Sequence[ClassifiedObject]) -> str:
    """Return pictures of objects that were not learnt, with what was said of them."""
    right = sum(each.verdict == "right" for each in objects)
    cards = "\n".join(card(each) for each in objects)
    return f"""<section><h2>Objects it had never seen</h2>
<p>{right} of {len(objects)} right. These were made anew by the program that made the training
objects, from another seed, and not learnt: a training object of the same name is another object. A score above 0.5
means that the object has the function. Small objects are drawn cut open, to show what settled inside.</p>
<div class="cards">{cards}</div></section>"""


def card(each: ClassifiedObject) -> str:
    """Return one object's picture, verdict, scores and label."""
    rows = [[name, f"{score:.2f}", "yes" if name in each.predicted else "no"] for name, score in each.scores.items()]
    also = f" (also {escape(names(each.also))})" if each.also else ""
    drawn = f"r = {format_length(each.radius)}, {each.settled:,} spheres settled"
    return f"""<article>{image(each.picture, f"{each.name} with settled spheres")}
<h3>{escape(each.name)} <span class="verdict {each.verdict}">{each.verdict}</span></h3>
<p>Said to be: <b>{escape(names(each.predicted))}</b><br>Label: <b>{escape(names(each.functions))}</b>{also}</p>
{table_html(["function", "score", "member"], rows, kind="scores")}
<p class="note">Training object that counted most: {escape(each.nearest)}<br>{drawn}</p></article>"""


def names(functions: Iterable[str]) -> str:
    """Return functions as words; none for none."""
    return ", ".join(sorted(functions)) or NONE


def comparison_section(comparison: dict) -> str:
    """Return which simulator to use, and where the whole comparison is."""
    return f"""<section><h2>By geometry or by physics?</h2><p>Two simulators dropped spheres on
{comparison["objects"]} of the objects: <b>{escape(recommendation(comparison))}</b> {escape(comparison["answer"])}</p>
{advice_table(comparison)}<p><a href="comparison/report.html">The whole comparison</a>, with objects to turn about.</p>
</section>"""


def confusion_section(confusion: Confusion) -> str:
    """Return who was taken for what, every object tested on all others."""
    rows = [
        [label, str(count), *(str(each) for each in taken)]
        for label, count, taken in zip(confusion.labels, confusion.objects, confusion.counts, strict=True)
    ]
    head = ["labelled", "objects", *(f"said: {name}" for name in confusion.labels)]
    return f"""<section><h2>What is taken for what</h2><p>Every object was tested with all others learnt (leave one
out). An object may be said to have several functions, so a row may add up to more than its objects.</p>
{table_html(head, rows)}</section>"""


def configuration_section(summary: Summary) -> str:
    """Return how this page was made, and how long each step took."""
    seconds = {name: f"{value:.1f} s" for name, value in summary.seconds.items()}
    total = {"all together": f"{sum(summary.seconds.values()):.1f} s"}
    made = table_html(["setting", "value"], list(summary.configuration.items()), texts=None)
    return f"""<section><h2>How this was made</h2><div class="columns">{made}
{table_html(["step", "time"], list((seconds | total).items()))}</div>
<p class="note">Settled spheres are kept in a cache: a second run takes less time.</p></section>"""
