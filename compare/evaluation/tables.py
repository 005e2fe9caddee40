"""An evaluation as tables on the terminal, or as JSON."""

from __future__ import annotations

from spherefunc_bullet.console import print_json, print_table
from spherefunc_bullet.quantities import format_length


def report(about: dict, results: list[dict], json: bool):
    """Print the results as JSON or as tables."""
    last_split = [each for each in results if each["protocol"] in ("random_splits", "test")][-1]
    if json:
        print_json(about | {"results": results, "baselines": last_split["baselines"]})
        return
    print_table(
        f"{about['data']}, {about['objects']} objects, backend {about['backend']}, method {about['method']}",
        ["protocol", "train", "function", "F", "spread", "F fair", "precision", "recall", "accuracy", "radius"],
        [row for each in results for row in result_rows(each)],
    )
    for each in results if len(results) < 3 else [last_split, *pooled(results)]:
        print_baselines(each)


def pooled(results: list[dict]) -> list[dict]:
    """Return the results in which every object was tested once."""
    return [each for each in results if each["protocol"].startswith("leave")]


def result_rows(each: dict) -> list[list[str]]:
    """Return one result's table rows, a function each."""
    rows = []
    for name, row in each["functions"].items():
        spread = "" if row["f_measure_std"] is None else f"{row['f_measure_std']:.3f}"
        figures = [f"{row[key]:.3f}" for key in ("f_measure_fair", "precision", "recall", "accuracy")]
        start = [each["protocol"].replace("_", " "), str(each["train_size"]), name, f"{row['f_measure']:.3f}", spread]
        rows.append([*start, *figures, format_length(row["radius"])])
    return rows


def print_baselines(each: dict):
    """Print the spheres beside the baselines of one result."""
    table = {"spheres": each["functions"]} | each["baselines"]
    rows = [
        [name.replace("_", " "), *(f"{f['f_measure']:.3f} ({f['f_measure_fair']:.3f})" for f in scores.values())]
        for name, scores in table.items()
    ]
    title = f"\n{each['protocol'].replace('_', ' ')}, {each['train_size']} training objects: F-measure (fair)"
    print_table(title, ["features", *each["functions"]], rows)
