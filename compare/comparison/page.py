"""The files of a comparison's report, above all a page: which simulator to use for what, and why.

Every number on the page comes from the report (`comparison.compare_entries`) and the comparison; its words are in
``page.html``.
"""

from __future__ import annotations

import json as json_format
from collections.abc import Callable, Mapping, Sequence
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
from .agreement import Disagreement, clearest, disagreements, displays_of
from .charts import accuracy_chart, cost_chart
from .comparison import RADIUS_TRIALS
from .entries import Comparison
from .experiment import Experiment, as_toml
from .recommendation import prices, recommendation_sentence, recommendation_table, recommendations
from .significance import COARSE, Report, enumeration, unseen
from .tables import TextTable

IMPAIRED = "impaired.png"  # in the report's folder, where copies were measured
LONGEST = 60  # disagreements in the list; all are in report.json


def write_report(folder: Path, report: Report, comparison: Comparison, experiment: Experiment):
    """Write the page, all results as JSON, their tables and charts, and the experiment that repeats the comparison."""
    picture = Image.open(folder / IMPAIRED).convert("RGB") if "impaired" in report else None
    about = "# Repeats this comparison: spherefunc compare experiment.toml. Lengths are in metres.\n"
    charts = {"accuracy": cache(lambda: accuracy_chart(report)), "cost": cache(lambda: cost_chart(comparison))}
    files = {  # the files for programs first, so that they are there if drawing is interrupted
        "report.json": lambda: json_format.dumps(report, indent=1) + "\n",
        "report.md": lambda: tables.markdown(report),
        "experiment.toml": lambda: about + as_toml(experiment),
        **{f"{name}.svg": draw for name, draw in charts.items()},
        "report.html": lambda: comparison_page(report, comparison, experiment, charts, picture),
    }
    for name, content in progress(files.items(), len(files), "drawing the report"):
        write_text(folder / name, content())
    say(f"wrote {', '.join(files)} in {folder}")


def comparison_page(
    report: Report,
    comparison: Comparison,
    experiment: Experiment,
    charts: Mapping[str, Callable[[], str]],
    copies: Image.Image | None = None,
) -> str:
    """Return the page with charts, which are drawn as SVG, and with a picture of impaired copies, if there is one."""
    names, chosen = list(report["backends"]), recommendations(report)
    several = len(names) > 1
    margins = [row["margin"] or 0.0 for pair in report["agreement"] for row in pair["f_measures"].values()]
    widest = max(margins, default=0.0)
    cases = disagreements(report["per_object"]) if several else []
    differ = [case for case in cases if case.labels_differ]
    drops = {count for entry in comparison.entries for record in entry.records for count in record.drops.values()}
    body = filled_template(
        __package__,
        report=report,
        copies=copies,
        names=names,
        several=several,
        sentence=recommendation_sentence(chosen),
        recommended=recommendation_table(report, chosen),
        times=enumeration([f"{time} by {name}" for name, time in prices(report).items()]),
        unseen=unseen(widest) if widest > COARSE else "",  # differences that may be chance, where these are large
        beaten=enumeration([row.function for row in chosen if row.beaten]),
        tables=tables,
        qualities=qualities(report),
        charts={name: draw() for name, draw in charts.items()},
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
    return report_page(f"{' or '.join(names)}? Simulators compared on {report['data']}", body, displays=several)


def predicted(scores: dict[str, float]) -> str:
    """Return the names of the functions with positive scores."""
    return ", ".join(name for name, score in scores.items() if score > THRESHOLD) or label_text(())


def labels(item: Report) -> str:
    """Return an object's label, and the functions that it has as well."""
    return label_text(item["functions"], ", ") + (f" (also {', '.join(item['also'])})" if item["also"] else "")


def listing(differ: Sequence[Disagreement], report: Report) -> TextTable:
    """Return a table of the objects that simulators label differently."""

    def said(scores: dict[str, float]) -> str:
        return f"{predicted(scores)} ({', '.join(f'{name} {score:.2f}' for name, score in scores.items())})"

    items = [report["per_object"][case.row] for case in differ[:LONGEST]]
    rows = [[item["file"], labels(item), *(said(row["scores"]) for row in item["backends"].values())] for item in items]
    head = ["file", "label", *(f"{name} says" for name in report["backends"])]
    return TextTable(title="list", columns=head, rows=rows)


def simulators(report: Report) -> TextTable:
    """Return a table of the simulators with their versions and options."""
    rows = [
        [name, f"{row['backend']} {row['version']}", f"{row['sphere_limit']:,}", options_text(row["options"])]
        for name, row in report["backends"].items()
    ]
    head = ["simulator", "version", "settled spheres at most", "options"]
    return TextTable(title="simulators", columns=head, rows=rows)


def qualities(report: Report) -> list[TextTable]:
    """Return one table for each function, simulators and baselines."""
    whole = tables.quality_table(report)
    features, _, *figures = whole.columns
    by: dict[str, list[list[str]]] = {function: [] for function in report["functions"]}
    for name, function, *row in whole.rows:
        by[function].append([name, *row])
    return [TextTable(title=function, columns=[features, *figures], rows=rows) for function, rows in by.items()]
