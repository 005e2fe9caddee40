"""An evaluation as tables on the terminal, or as JSON."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from spherefunc_bullet.batch.simulated import Simulated
from spherefunc_bullet.console import print_json, print_table, say, show
from spherefunc_bullet.formats.units import format_length
from spherefunc_bullet.learning.method import AnyMethod

from .evaluation import Evaluation, Qualities, confusion_report
from .features import SPHERES
from .impaired import Shares, print_shares
from .protocol import FAIR, Protocol, Split, Splits, labels_of
from .readings import readings
from .robustness.corruptions import Corruptions, print_corruptions

Result = dict[str, Any]  # one protocol's figures at one training size, see `result`


def evaluate_features(
    simulated: Simulated, radii: tuple[float, ...], method: AnyMethod, protocol: Protocol
) -> dict[str, Evaluation]:
    """Return the evaluation of the spheres and of every baseline; see `readings`."""
    splits = protocol.splits(labels_of(simulated))
    return {name: read.evaluation(splits) for name, read in readings(simulated, radii, method).items()}


def results_of(evaluations: Mapping[str, Evaluation]) -> list[Result]:
    """Return the results of all protocols, random halves first."""
    spheres, results = evaluations[SPHERES], []
    for size, trials in spheres.trials.items():
        figures = {name: evaluation.quality(size) for name, evaluation in evaluations.items()}
        confusion = confusion_report(spheres.labels, trials)
        results.append(result("random_splits", size, figures) | {"trials": len(trials), "said": confusion})
    for protocol, pooled in spheres.left_out.items():
        figures = {name: evaluation.left_out_quality(protocol) for name, evaluation in evaluations.items()}
        results.append(result(protocol, pooled.learnt, figures) | {"said": confusion_report(spheres.labels, [pooled])})
    return results


def result(protocol: str, train_size: int, figures: dict[str, Qualities]) -> Result:
    """Return one protocol's figures, with the baselines separate from the spheres."""
    baselines = {name: qualities for name, qualities in figures.items() if name != SPHERES}
    return {"protocol": protocol, "train_size": train_size, "functions": figures[SPHERES], "baselines": baselines}


def transfer_result(learnt: Simulated, tested: Simulated, radii: tuple[float, ...], method: AnyMethod) -> Result:
    """Return the result of learning on one data set and testing on another.

    Raises
    ------
    InputError
        If all objects to learn from have one label.
    """
    known = labels_of(learnt).functions
    unknown = set().union(*(item.functions for item in tested.objects)) - set(known)
    if unknown:
        say(f"{tested.name}: no training object is labelled {', '.join(sorted(unknown))}; so these cannot be found")
    both = learnt + tested
    labels, count = labels_of(both), len(learnt.objects)
    splits = Splits(halves={count: [Split(np.arange(count), np.arange(count, len(labels)))]})
    evaluations = {name: read.evaluation(splits) for name, read in readings(both, radii, method).items()}
    figures = {name: evaluation.quality(count) for name, evaluation in evaluations.items()}
    return result("test", count, figures) | {"said": confusion_report(labels, evaluations[SPHERES].trials[count])}


def print_results(
    about: dict[str, Any],
    results: Sequence[Result],
    json: bool,
    impaired: Shares | None = None,
    confusion: bool = False,
    tasks: dict[str, dict[str, Any]] | None = None,
    corruptions: Corruptions | None = None,
):
    """Print the results, and those of impaired copies and corrupted clouds where there are any, as JSON or tables.

    The results of other tasks are printed as JSON only.
    """
    last_split = [result for result in results if result["protocol"] in ("random_splits", "test")][-1]
    if json:
        more = {"impaired": impaired, "tasks": tasks, "corruptions": corruptions}
        more = {name: value for name, value in more.items() if value is not None}
        print_json(about | {"results": results, "baselines": last_split["baselines"]} | more)
        return
    print_table(
        f"{about['data']}, {about['objects']} objects, backend {about['backend']}, method {about['method']}; " + FAIR,
        ["protocol", "train", "function", "F", "spread", "F fair", "precision", "recall", "accuracy", "radius"],
        [row for result in results for row in result_rows(result)],
    )
    pooled = [result for result in results if result["protocol"].startswith("leave")]
    for result in results if len(results) < 3 else [last_split, *pooled]:
        rows = [
            [name.replace("_", " "), *(f"{row['f_measure']:.3f} ({row['f_measure_fair']:.3f})" for row in by.values())]
            for name, by in ({SPHERES: result["functions"]} | result["baselines"]).items()
        ]
        print_table(f"{result_title(result)}: F-measure (fair)", ["features", *result["functions"]], rows)
    for result in results if confusion else []:
        print_confusion(result)
    if impaired is not None:
        print_shares(impaired)
    if corruptions is not None:
        print_corruptions(corruptions)


def result_title(result: Result) -> str:
    """Return the protocol and the training size of a result, after an empty line."""
    return f"\n{result['protocol'].replace('_', ' ')}, {result['train_size']} training objects"


def result_rows(result: Result) -> list[list[str]]:
    """Return one result's table rows, one for each function."""
    rows = []
    for name, row in result["functions"].items():
        spread = "" if row["f_measure_std"] is None else f"{row['f_measure_std']:.3f}"
        start = [result["protocol"].replace("_", " "), str(result["train_size"]), name, f"{row['f_measure']:.3f}"]
        figures = [f"{row[key]:.3f}" for key in ("f_measure_fair", "precision", "recall", "accuracy")]
        rows.append([*start, spread, *figures, format_length(row["radius"])])
    return rows


def print_confusion(result: Result):
    """Print the confusion matrix of one result, the mean of its trials (paper, Fig. 4), and the chosen radii."""
    confusion, trials = result["said"], result.get("trials", 1)
    rows = [[label, *(f"{n / trials:.1f}" for n in row.values())] for label, row in confusion["confusion"].items()]
    several = "".join(f", {n / trials:.1f} {name}" for name, n in confusion["memberships"].items())
    title = f"{result_title(result)}, {confusion['tested'] / trials:g} tested: predicted functions{several}"
    print_table(title, ["labelled", *(f"predicted {name}" for name in confusion["confusion"])], rows)
    counted = [
        f"{name} {', '.join(f'{format_length(float(radius))} {n}x' for radius, n in radii.items())}"
        for name, radii in confusion["radii"].items()
    ]
    show(f"radii chosen: {'; '.join(counted)}")
