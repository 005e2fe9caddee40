"""The files of a comparison's report."""

from __future__ import annotations

import json as json_format
from functools import cache
from pathlib import Path

from PIL import Image

from spherefunc_bullet.console import progress, say
from spherefunc_bullet.formats.files import write_text

from .charts import accuracy_chart, cost_chart
from .entries import Comparison
from .experiment import Experiment, as_toml
from .page import comparison_page
from .report import Report
from .tables import markdown

IMPAIRED = "impaired.png"  # in the report's folder, where it was asked about


def write_report(folder: Path, report: Report, comparison: Comparison, experiment: Experiment):
    """Write the page to look at, everything that was found, its tables, and the experiment that repeats it."""
    picture = Image.open(folder / IMPAIRED).convert("RGB") if "impaired" in report else None
    about = "# Repeats this comparison: spherefunc compare experiment.toml. Lengths are in metres.\n"
    accuracy, cost = cache(lambda: accuracy_chart(report)), cache(lambda: cost_chart(comparison))
    files = {  # what can be read by programs first, so that it is there if drawing is interrupted
        "report.json": lambda: json_format.dumps(report, indent=1) + "\n",
        "report.md": lambda: markdown(report),
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
