"""The files of a comparison's report."""

from __future__ import annotations

import json as json_format
from pathlib import Path

from spherefunc_bullet.console import say
from spherefunc_bullet.errors import InputError


def write_report(folder: Path, found: dict, contest, experiment):
    """Write the page to look at, everything that was found, its tables, and the experiment that repeats it."""
    from .charts import accuracy_chart, cost_chart
    from .experiment import as_toml
    from .page import comparison_page
    from .tables import markdown

    about = "# Repeats this comparison: spherefunc compare experiment.toml. Lengths are in metres.\n"
    files = {
        "report.html": comparison_page(found, contest, experiment),
        "accuracy.svg": accuracy_chart(found),
        "cost.svg": cost_chart(contest),
        "report.json": json_format.dumps(found, indent=1) + "\n",
        "report.md": markdown(found),
        "experiment.toml": about + as_toml(experiment),
    }
    for name, text in files.items():
        try:
            (folder / name).write_text(text, encoding="utf-8")
        except OSError as error:
            raise InputError(f"{folder / name}: expected a file that can be written; {error.strerror}") from error
    say(f"wrote {', '.join(files)} in {folder}")
