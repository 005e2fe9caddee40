"""The files of a comparison's report, above all a page: which simulator to use for what, and what that rests on.

Every number on it comes from the report (`comparison.compare_entries`) and the comparison that it is given; its words
are in ``page.html``.
"""

from __future__ import annotations

import json as json_format
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path

from PIL import Image

from spherefunc_bullet.console import progress, say
from spherefunc_bullet.datasets.dataset import label_text
from spherefunc_bullet.formats.files import write_text
from spherefunc_bullet.learning.validation import THRESHOLD

from ..machine import options_text
from ..pages.html import filled_template, report_page
from . import tables
from .charts import accuracy_chart, cost_chart
from .disagreements import Disagreement, clearest, disagreements, displays_of
from .entries import Comparison
from .evaluations import RADIUS_TRIALS
from .experiment import Experiment, as_toml
from .recommendation import prices, recommendation_sentence, recommendation_table, recommendations
from .significance import COARSE, Report, enumeration
from .tables import TextTable

IMPAIRED = "impaired.png"  # in the report's folder, where it was asked about
LONGEST = 60  # disagreements in the list; all are in report.json


def write_report(folder: Path, report: Report, comparison: Comparison, experiment: Experiment):
    """Write the page to look at, everything that was found, its tables, and the experiment that repeats it."""
    picture = Image.open(folder / IMPAIRED).convert("RGB") if "impaired" in report else None
    about = "# Repeats this comparison: spherefunc compare experiment.toml. Lengths are in metres.\n"
    accuracy, cost = cache(lambda: accuracy_chart(report)), cache(lambda: cost_chart(comparison))
    files = {  # what can be read by programs first, so that it is there if drawing is interrupted
        "report.json": lambda: json_format.dumps(report, indent=1) + "\n",
        "report.md": lambda: tables.markdown(report),
        "experiment.toml": lambda: about + as_toml(experiment),
        "accuracy.svg": accuracy,
        "cost.svg": cost,
        "report.html": lambda: comparison_page(
            report, comparison, experiment, {"accuracy": accuracy(), "cost": cost()}, picture
        ),
    }
    for name, content in progress(files.items(), len(files), "drawing the report"):
        write_text(folder / name, content())
    say(f"wrote {', '.join(files)} in {folder}")


def comparison_page(
    report: Report,
    comparison: Comparison,
    experiment: Experiment,
    charts: Mapping[str, str],
    copies: Image.Image | None = None,
) -> str:
    """Return the page, with charts as SVG; with a picture of what was said of impaired copies, where that was asked."""
    names, chosen = list(report["backends"]), recommendations(report)
    several = len(names) > 1
    cases = disagreements(report["per_object"]) if several else []
    differ = [case for case in cases if case.labels_differ]
    drops = {count for entry in comparison.entries for record in entry.records for count in record.drops.values()}
    body = filled_template(
        "page.html",
        __package__,
        report=report,
        copies=copies,
        names=names,
        several=several,
        sentence=recommendation_sentence(chosen),
        recommended=recommendation_table(report, chosen),
        times=enumeration([f"{time} by {name}" for name, time in prices(report).items()]),
        hidden=hidden_difference(report),
        beaten=enumeration([row.function for row in chosen if row.beaten]),
        tables=tables,
        qualities=qualities(report),
        charts=charts,
        drops=list(drops - {0}),
        radius_trials=RADIUS_TRIALS,
        differ=differ,
        listing=listing(differ, report),
        simulators=simulators(report),
        displays=displays_of(comparison, clearest(differ or cases), experiment.loading) if several else [],
        predicted=predicted,
        labels=labels,
        threshold=THRESHOLD,
        reasons=[f"{name}: {reason}" for name, row in report["backends"].items() for reason in row["reasons"]],
        toml=as_toml(experiment),
    )
    return report_page(f"{' or '.join(names)}? Simulators compared on {report['data']}", [body], displays=several)


def hidden_difference(report: Report) -> float | None:
    """Return how large a difference would not show, where that is much."""
    margins = [row["margin"] or 0.0 for pair in report["agreement"] for row in pair["f_measures"].values()]
    widest = max(margins, default=0.0)
    return widest if widest > COARSE else None


def predicted(scores: dict[str, float]) -> str:
    """Return the functions that scores amount to."""
    return ", ".join(name for name, score in scores.items() if score > THRESHOLD) or label_text(())


def labels(item: Report) -> str:
    """Return an object's label, and what is true of it as well."""
    return label_text(item["functions"], ", ") + (f" (also {', '.join(item['also'])})" if item["also"] else "")


def listing(differ: Sequence[Disagreement], report: Report) -> TextTable:
    """Return the objects that simulators label differently."""

    def said(scores: dict[str, float]) -> str:
        return f"{predicted(scores)} ({', '.join(f'{name} {score:.2f}' for name, score in scores.items())})"

    items = [report["per_object"][case.row] for case in differ[:LONGEST]]
    rows = [[item["file"], labels(item), *(said(row["scores"]) for row in item["backends"].values())] for item in items]
    return TextTable(
        title="list", columns=["file", "label", *(f"{name} says" for name in report["backends"])], rows=rows
    )


def simulators(report: Report) -> TextTable:
    """Return what was compared, and with which options."""
    rows = [
        [name, f"{row['backend']} {row['version']}", f"{row['sphere_limit']:,}", options_text(row["options"])]
        for name, row in report["backends"].items()
    ]
    return TextTable(
        title="simulators", columns=["simulator", "version", "settled spheres at most", "options"], rows=rows
    )


def qualities(report: Report) -> list[TextTable]:
    """Return one table for each function, simulators and baselines."""
    whole = tables.quality_table(report)
    features, _, *figures = whole.columns
    rows_of = {
        function: [[name, *row] for name, of, *row in whole.rows if of == function] for function in report["functions"]
    }
    return [TextTable(title=function, columns=[features, *figures], rows=rows) for function, rows in rows_of.items()]
