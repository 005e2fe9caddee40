"""The comparison as one page of HTML: which simulator to use for what, and everything that the answer rests on.

Every number on it comes from the report (`comparison.compare_entries`) and the comparison that it is given.
"""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

from PIL.Image import Image

from spherefunc_bullet.datasets.dataset import label_text
from spherefunc_bullet.learning.validation import THRESHOLD
from spherefunc_bullet.viewer.page import display_html, table_html

from ..machine import options_text
from ..pages.html import drawing, image, report_page
from . import tables
from .charts import accuracy_chart, cost_chart
from .disagreements import Disagreement, Display, clearest, disagreements, displays_of
from .entries import Comparison
from .evaluations import RADIUS_TRIALS
from .experiment import Experiment, as_toml
from .recommendation import Recommendation, prices, recommendation_sentence, recommendation_table, recommendations
from .report import ObjectReport, Report
from .significance import COARSE, enumeration

LONGEST = 60  # disagreements in the list; all are in report.json


def comparison_page(report: Report, comparison: Comparison, experiment: Experiment, copies: Image | None = None) -> str:
    """Return the page; with a picture of what was said of impaired copies, where that was asked."""
    names = list(report["backends"])
    several, chosen = len(names) > 1, recommendations(report)
    parts = [
        introduction(report, chosen),
        *([] if copies is None else [copies_section(report, copies)]),
        *([tasks_section(report)] if "tasks" in report else []),
        accuracy_section(report, chosen),
        cost_section(report, comparison),
        *([agreement_section(report), disagreement_section(report, comparison, experiment)] if several else []),
        quality_section(report),
        making_section(report, experiment),
    ]
    return report_page(f"{' or '.join(names)}? Simulators compared on {report['data']}", parts, displays=several)


def introduction(report: Report, chosen: Sequence[Recommendation]) -> str:
    """Return the answer, what was done, and which simulator to use for what."""
    left = f" {len(report['left_out'])} more were left out: see below." if report["left_out"] else ""
    names = list(report["backends"])
    title = f"{' or '.join(names)}?" if len(names) > 1 else f"What {names[0]} can tell"
    counts = ", ".join(f"{count} {name}" for name, count in report["functions"].items())
    times = enumeration([f"{time} by {name}" for name, time in prices(report).items()])
    return f"""<header><h1>{escape(title)}</h1>
<p class="lead"><b>{escape(recommendation_sentence(chosen))}</b> {escape(report["answer"])}</p>
<p>Small spheres are dropped on a 3D object. Where they come to rest tells what the object
is for: a cup fills up, a table collects one flat layer, a chair holds a slope. Who drops them is a choice between
simulators: <b>fast</b> rolls spheres over the points by geometry, one at a time; <b>bullet</b> moves rigid bodies by
the laws of physics. Here they did it on the same {report["objects"]} objects of <b>{escape(report["data"])}</b>
({escape(counts)}), with the same classifier, splits and seeds.{left}</p>
{recommendation_table(report, chosen)}
<p class="note">One rule for all: the cheapest simulator is used unless another, or what needs no spheres, is better by
more than chance among the trials (95 %, corrected for trials that share objects). F-measure: 1 is perfect, 0 is
useless.{escape(blind_spot(report))}
A thousand such objects take {escape(times)}, on one core.</p></header>"""


def blind_spot(report: Report) -> str:
    """Return how large a difference would not show, where that is much."""
    margins = [row["margin"] or 0.0 for pair in report["agreement"] for row in pair["f_measures"].values()]
    widest = max(margins, default=0.0)
    return f" With so few objects, differences of up to {widest:.2f} do not show." if widest > COARSE else ""


def copies_section(report: Report, copies: Image) -> str:
    """Return what was said of copies that look right and do not work, and of others that do."""
    return f"""<section><h2>Does it still work?</h2><p>Copies of {report["experiment"]["copied"]} objects of each
function were impaired so that they no longer work, or changed in a way that does not matter. Nobody had learnt the
object, nor an impaired one. The picture shows how many are still called by their function.</p>
{image(copies, "Share of useless and harmless copies still called by their function")}
<details><summary>The numbers, kind by kind</summary>{html_table(tables.copies_table(report))}</details></section>"""


def tasks_section(report: Report) -> str:
    """Return what backends do of the tasks besides labels, and what fidelity buys at each."""
    said = "".join(f"<li>{escape(task['says'])}</li>" for task in report["tasks"].values())
    kept = tables.keeping_table(report)
    curves = html_table(kept) if kept.rows else ""
    return f"""<section><h2>What else rigid bodies tell</h2><p>Here the object itself may move: in which poses it can
lie (is the one in which it is used ranked first by its function?), whether furniture stands and carries its load,
beside copies with a leg sawn off or cut askew, and what a vessel keeps when it is tilted, beside plates, shelves and
tables. Where the statistics cannot distinguish two simulators (sign test, 5 %), they count as level.</p><ul>{said}</ul>
{html_table(tables.task_table(report))}{curves}</section>"""


def accuracy_section(report: Report, chosen: Sequence[Recommendation]) -> str:
    """Return F-measures against seconds, and in words where spheres are not worth their time."""
    behind = [row.function for row in chosen if row.beaten]
    beaten = f" For {enumeration(behind)} the best baseline, which takes no spheres at all, is better."
    words, table = beaten if behind else "", html_table(tables.radius_table(report))
    return f"""<section><h2>Accuracy against time</h2><p>Up is better, left is cheaper. Filled marks: all radii
together, with the spread over {report["experiment"]["trials"]} trials; circles: one radius alone, in centimetres, over
the first {RADIUS_TRIALS} trials at most where drops are read as resting profiles.
Nothing beats what lies on the grey line in both.{escape(words)}</p>
{drawing(accuracy_chart(report), "F-measure against seconds per object, one panel per function")}
<details><summary>The numbers: each radius alone</summary>{table}</details></section>"""


def cost_section(report: Report, comparison: Comparison) -> str:
    """Return what each simulator costs."""
    drops = {count for entry in comparison.entries for record in entry.records for count in record.drops.values()}
    chart = f"""<div class="columns">
{drawing(cost_chart(comparison), "Seconds of a run against the spheres dropped")}
<p>Each point is one run: one object, one radius. Lines join medians. A simulator whose line is steeper than the
number of spheres gets slower as it fills. {escape(report["timing"])}</p></div>"""
    if len(drops - {0}) == 1:  # all runs are of as many drops: nothing to draw against
        chart = f"<p>Each run is of {max(drops)} drops. {escape(report['timing'])}</p>"
    return f"""<section><h2>What it costs</h2>{chart}
{html_table(tables.cost_table(report))}
<p class="note">Times of the median object and of the 95th percentile are over all radii. Peak memory is that of one
whole process with interpreter and libraries.</p></section>"""


def agreement_section(report: Report) -> str:
    """Return whether simulators say the same, beside two seeds of one."""
    return f"""<section><h2>Do they agree?</h2><p>Each object is judged with all others learnt. <b>Same label</b>: the
share of objects of which both say the same; the share for two seeds of one simulator says how much of the rest is
chance. <b>Right alone</b>: objects that only the first, or only the second, has right. <b>Margin</b>: by how much the
difference of F-measures is uncertain (95 %); trials share objects, so it is wider than their spread.</p>
{html_table(tables.label_table(report))}
<p>How far their histograms lie apart, beside two seeds of one simulator: a ratio of 1 would mean that changing the
simulator is no more than changing the seed. <b>Settled</b>: the share of all spheres dropped; a run that ends at its
limit of settled spheres lacks the last ones, which miss. <b>Apart</b>: how far the two simulators' histograms of one
object lie from each other, the square root of the summed squares of the differences of their cubes' counts, in spheres;
<b>two seeds apart</b>: the same for two seeds of each simulator; <b>norm</b>: that length of a histogram itself, beside
which the others are to be seen. All of them are medians over the <b>objects</b> on which histograms differ, with
spheres of that radius.</p>{html_table(tables.histogram_table(report))}</section>"""


def disagreement_section(report: Report, comparison: Comparison, experiment: Experiment) -> str:
    """Return the objects on which simulators disagree, with their spheres side by side."""
    cases = disagreements(report["per_object"])
    differ = [case for case in cases if case.labels_differ]
    displays = displays_of(comparison, clearest(differ or cases), experiment.loading)
    lead = f"They differ about {len(differ)} of {report['objects']} objects."
    if not differ:
        lead = "They give every object the same labels; these are the largest differences of scores."
    parts = "\n".join(display_part(case, display, report) for case, display in displays)
    return f"""<section><h2>Where they disagree</h2><p>{lead} Below, {len(displays)} of the clearest, with the spheres
of each simulator. Drag to turn, right-drag to move, wheel to zoom (click first), double-click to reset.</p>{parts}
{listing(differ, report)}</section>"""


def display_part(case: Disagreement, display: Display, report: Report) -> str:
    """Return one object with its label, what was said of it, and its spheres."""
    item, function = report["per_object"][case.row], case.function
    answers = "; ".join(f"{name} says {predicted(row['scores'])}" for name, row in item["backends"].items())
    scores = ", ".join(f"{name} {row['scores'][function]:.2f}" for name, row in item["backends"].items())
    return f"""<article><h3>{escape(item["file"])} <span class="label">labelled {escape(labels(item))}</span></h3>
<p>{escape(answers)}. Scores of {escape(function)}: {escape(scores)}; above {THRESHOLD} it is.</p>
{display_html(display)}</article>"""


def predicted(scores: dict[str, float]) -> str:
    """Return the functions that scores amount to."""
    return ", ".join(name for name, score in scores.items() if score > THRESHOLD) or label_text(())


def labels(item: ObjectReport) -> str:
    """Return an object's label, and what is true of it as well."""
    return label_text(item["functions"], ", ") + (f" (also {', '.join(item['also'])})" if item["also"] else "")


def listing(differ: Sequence[Disagreement], report: Report) -> str:
    """Return all objects on which simulators disagree, as a table to open."""
    if not differ:
        return ""

    def said(scores: dict[str, float]) -> str:
        return f"{predicted(scores)} ({', '.join(f'{name} {score:.2f}' for name, score in scores.items())})"

    items = [report["per_object"][case.row] for case in differ[:LONGEST]]
    rows = [[item["file"], labels(item), *(said(row["scores"]) for row in item["backends"].values())] for item in items]
    more = f", the first {LONGEST}" if len(differ) > LONGEST else ""
    head = ["file", "label", *(f"{name} says" for name in report["backends"])]
    summary = f"<summary>All {len(differ)} in a list{more}</summary>"
    return f"<details>{summary}{table_html(head, rows, texts=None)}</details>"


def quality_section(report: Report) -> str:
    """Return one table per function, simulators and baselines."""
    whole, parts = tables.quality_table(report), []
    features, _, *figures = whole.columns
    for function in report["functions"]:
        rows = [[name, *row] for name, own, *row in whole.rows if own == function]
        parts.append(f"<h3>{escape(function)}</h3>{table_html([features, *figures], rows)}")
    return f"""<section><h2>Function by function</h2><p>{report["train_size"]} objects learnt at random,
{report["test_size"]} tested, {report["experiment"]["trials"]} times: mean ± standard deviation. Baselines need no
spheres and have the same classifier; <b>always no</b> says no to everything. <b>F</b>: the F-measure, the
harmonic mean of precision and recall. <b>F fair</b>: the same without the objects of which the function is true as well
although it is not their label (<code>also</code> in the manifest). <b>F leave-one-out</b>: every object classified by
what all others teach, of resting profiles by what nine tenths of them do. The paper's numbers are its authors' on
their own 200 models, half of them learnt.</p>
{"".join(parts)}</section>"""


def making_section(report: Report, experiment: Experiment) -> str:
    """Return the configuration, versions, the machine, and what was left out."""
    head = ["simulator", "version", "settled spheres at most", "options"]
    rows = [
        [name, f"{row['backend']} {row['version']}", f"{row['sphere_limit']:,}", options_text(row["options"])]
        for name, row in report["backends"].items()
    ]
    return f"""<section><h2>How this was made</h2>{left_out(report)}
{table_html(["on", ""], list(report["machine"].items()), texts=None)}
{table_html(head, rows, texts=None)}
<p>This file repeats it, from the cache where it can: <code>spherefunc compare experiment.toml</code></p>
<pre>{escape(as_toml(experiment))}</pre></section>"""


def left_out(report: Report) -> str:
    """Return which objects no mean is over, and why."""
    reasons = [f"{name}: {reason}" for name, row in report["backends"].items() for reason in row["reasons"]]
    if not reasons:
        return "<p>No object failed.</p>"
    rows = "".join(f"<li>{escape(reason)}</li>" for reason in reasons)
    return f"<p>Failed, and left out of every simulator's figures:</p><ul>{rows}</ul>"


def html_table(table: tables.Table) -> str:
    """Return a table of the report as HTML."""
    return table_html(table.columns, table.rows)
