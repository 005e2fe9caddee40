"""An evaluation as tables on the terminal, or as JSON."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NotRequired, TypedDict

from spherefunc_bullet.console import print_json, print_table, show
from spherefunc_bullet.formats.units import format_length

from .features import SPHERES
from .impaired import Shares, print_shares
from .results import Result
from .robustness.corruptions import Corruptions, print_corruptions


class About(TypedDict):
    """What was evaluated."""

    backend: str
    method: str
    data: str
    objects: int
    radii: NotRequired[Sequence[float]]  # metres


def print_results(
    about: About,
    results: Sequence[Result],
    json: bool,
    impaired: Shares | None = None,
    confusion: bool = False,
    tasks: dict[str, dict[str, Any]] | None = None,
    corruptions: Corruptions | None = None,
):
    """Print the results, and those of impaired copies and corrupted clouds if they were asked for, as JSON or tables.

    What was measured of other tasks goes into JSON alone.
    """
    last_split = [result for result in results if result["protocol"] in ("random_splits", "test")][-1]
    if json:
        more = {"impaired": impaired, "tasks": tasks, "corruptions": corruptions}
        more = {name: value for name, value in more.items() if value is not None}
        print_json(about | {"results": results, "baselines": last_split["baselines"]} | more)
        return
    print_table(
        f"{about['data']}, {about['objects']} objects, backend {about['backend']}, method {about['method']}; "
        "F fair: without objects of which it is true as well",
        ["protocol", "train", "function", "F", "spread", "F fair", "precision", "recall", "accuracy", "radius"],
        [row for result in results for row in result_rows(result)],
    )
    pooled = [result for result in results if result["protocol"].startswith("leave")]
    for result in results if len(results) < 3 else [last_split, *pooled]:
        print_baselines(result)
    for result in results if confusion else []:
        print_confusion(result)
    if impaired is not None:
        print_shares(impaired)
    if corruptions is not None:
        print_corruptions(corruptions)


def result_rows(result: Result) -> list[list[str]]:
    """Return one result's table rows, a function each."""
    rows = []
    for name, row in result["functions"].items():
        spread = "" if row["f_measure_std"] is None else f"{row['f_measure_std']:.3f}"
        start = [result["protocol"].replace("_", " "), str(result["train_size"]), name, f"{row['f_measure']:.3f}"]
        figures = [f"{row[key]:.3f}" for key in ("f_measure_fair", "precision", "recall", "accuracy")]
        rows.append([*start, spread, *figures, format_length(row["radius"])])
    return rows


def print_confusion(result: Result):
    """Print who was said to have which function, of one result: the mean of its trials (paper, Fig. 4)."""
    said, trials = result["said"], result.get("trials", 1)
    rows = [[label, *(f"{n / trials:.1f}" for n in row.values())] for label, row in said["confusion"].items()]
    several = "".join(f", {n / trials:.1f} {name}" for name, n in said["memberships"].items())
    print_table(
        f"\n{result['protocol'].replace('_', ' ')}, {result['train_size']} training objects, "
        f"{said['tested'] / trials:g} tested: said to have functions{several}",
        ["labelled", *(f"said {name}" for name in said["confusion"])],
        rows,
    )
    counted = [
        f"{name} {', '.join(f'{format_length(float(radius))} {n}x' for radius, n in radii.items())}"
        for name, radii in said["radii"].items()
    ]
    show(f"radii chosen: {'; '.join(counted)}")


def print_baselines(result: Result):
    """Print the spheres beside the baselines of one result."""
    rows = [
        [name.replace("_", " "), *(f"{row['f_measure']:.3f} ({row['f_measure_fair']:.3f})" for row in rows.values())]
        for name, rows in ({SPHERES: result["functions"]} | result["baselines"]).items()
    ]
    title = f"\n{result['protocol'].replace('_', ' ')}, {result['train_size']} training objects: F-measure (fair)"
    print_table(title, ["features", *result["functions"]], rows)
