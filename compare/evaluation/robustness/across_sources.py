"""The recipe of the models that ship, with each source of other people's objects left out in turn.

``python -m spherefunc_bullet.compare.evaluation.robustness.across_sources DATA...`` takes what ``make model`` learns:
catalogues, objects by other people, and copies of both. Catalogues are always learnt. The objects of a source, and
copies of them, are classified by a model that has learnt nothing of that source; its unsure ranges have not, either.
Copies that follow ``--tested`` are classified likewise, and no model learns them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer

from spherefunc_bullet.batch.simulated import Simulated, simulate_dataset
from spherefunc_bullet.commands import options
from spherefunc_bullet.console import Failures, print_json, print_table, run
from spherefunc_bullet.datasets.dataset import (
    Dataset,
    DatasetObject,
    distinct_names,
    joined_datasets,
    open_dataset,
    sources_of,
)
from spherefunc_bullet.errors import InputError
from spherefunc_bullet.learning.classifier import CloudClassifier
from spherefunc_bullet.learning.function_classifier import FunctionClassifier
from spherefunc_bullet.learning.model_file import load_model
from spherefunc_bullet.scenes.impairment.folder import function_of, read_copies
from spherefunc_bullet.scenes.impairment.specimen import NONE
from spherefunc_bullet.settling.cached_runs import DropConfig
from spherefunc_bullet.settling.records import passed

from ..evaluation import Trial
from ..protocol import Labels, Split, labels_of
from ..readings import ProfileFeatures, UseChecks, calibrated_across_sources, spheres_profiled

WHOLE = "whole objects"
COVERAGES = (1.0, 0.95, 0.9, 0.85, 0.8)  # shares of the answers that are given, the surest first


@dataclass(frozen=True, kw_only=True)
class HeldOutAnswers:
    """The answers about objects of sources that were not learnt."""

    trial: Trial
    labels: Labels  # of all objects
    kinds: np.ndarray  # (N,) str, the kind of copy
    originals: np.ndarray  # (N,) str, the function of the original
    folders: np.ndarray  # (N,) str, the data set


def kinds_of(datasets: Sequence[Dataset]) -> dict[str, str]:
    """Return the kind of each copy by its path."""
    folders = [dataset.folder for dataset in datasets if any(item.of for item in dataset.objects)]
    return {str(copy.item.path): copy.kind for folder in folders for copy in read_copies(folder)}


def profiled_with_model(
    model: CloudClassifier, dataset: Dataset, drop_config: DropConfig, jobs: int, failures: Failures
) -> ProfileFeatures:
    """Return the quantities of a data set's objects that a model has kept, with the checks of objects of sources.

    Raises
    ------
    InputError
        If the model has not learnt these objects, in this order.
    """
    names, _ = distinct_names(dataset.objects)
    if not isinstance(model, FunctionClassifier) or names != list(model.names_):
        learnt = f"expected a model that has learnt the {len(names)} objects of {dataset.name}, in this order"
        raise InputError(f"{learnt}, got one of {len(model.names_)} objects")
    items = [item for item, source in zip(dataset.objects, sources_of(dataset.objects), strict=True) if source]
    of_sources = Dataset(dataset.name, tuple(items))
    checked = simulate_dataset(of_sources, replace(drop_config, radii=()), jobs=jobs, failed=failures.add)
    records = {record.path: record for record in checked.records}
    known = [records.get(item.path) for item in dataset.objects]
    checks = UseChecks(
        fallen=np.array([one is not None and one.falls_over for one in known]),
        uses=tuple(passed if one is None else one.check for one in known),
    )
    classifier = FunctionClassifier(radii=model.radii)
    return ProfileFeatures(profiles=model.profiles_, labels=labels_of(dataset), classifier=classifier, checks=checks)


def with_tested(read: ProfileFeatures, objects: Sequence[DatasetObject], tested: Simulated) -> ProfileFeatures:
    """Return the features of objects followed by those of others, which are only tested."""
    more = spheres_profiled(tested, labels_of(tested), read.classifier.radii)
    checks = UseChecks(
        fallen=np.concatenate([read.checks.fallen, more.checks.fallen]), uses=read.checks.uses + more.checks.uses
    )
    labels = labels_of(Dataset(tested.name, (*objects, *tested.objects)))
    return replace(read, profiles=np.concatenate([read.profiles, more.profiles]), labels=labels, checks=checks)


def answered(
    read: ProfileFeatures, objects: Sequence[DatasetObject], kinds: dict[str, str], learnt: int
) -> HeldOutAnswers:
    """Return the answers about the objects of each source when it is left out; only the first objects are learnt."""
    sources = np.array(sources_of(objects))
    rows = np.arange(len(objects))
    to_learn, names = rows < learnt, sorted(set(sources.tolist()) - {""})
    splits = [Split(rows[(sources != name) & to_learn], rows[sources == name]) for name in names]
    read = calibrated_across_sources(read, objects)
    return described(read.trial(splits), read.labels, objects, kinds)


def described(trial: Trial, labels: Labels, objects: Sequence[DatasetObject], kinds: dict[str, str]) -> HeldOutAnswers:
    """Return answers with each object's kind of copy, the function of its original, and its data set."""
    names, originals = distinct_names(objects)
    of = {name: function_of(item) or NONE for name, item in zip(names, objects, strict=True) if not item.of}
    return HeldOutAnswers(
        trial=trial,
        labels=labels,
        kinds=np.array([kinds.get(str(item.path), WHOLE) for item in objects]),
        originals=np.array([of.get(original or name, NONE) for name, original in zip(names, originals, strict=True)]),
        folders=np.array([item.path.parent.name for item in objects]),
    )


def report_of(answers: HeldOutAnswers) -> dict[str, Any]:
    """Return F-measures of whole objects, in all and of each data set, their errors, and the shares of every kind."""
    trial, labels, wrong = answers.trial, answers.labels, answers.trial.wrong(answers.labels)
    kinds, originals, folders = (each[trial.rows] for each in (answers.kinds, answers.originals, answers.folders))
    whole, data_sets = kinds == WHOLE, {}
    for name in dict.fromkeys(folders[whole].tolist()):
        of_set = whole & (folders == name)
        figures = {"f_measure": f_measures(trial, labels, of_set)}
        data_sets[name] = figures | rates(trial, wrong, originals, of_set, labels.functions)
    by_kind = [(kind, kinds == kind) for kind in dict.fromkeys(kinds.tolist())]
    surest = np.argsort(-np.abs(trial.scores - 0.5).min(axis=1)[whole], kind="stable")
    return {
        "objects": int(whole.sum()),
        "f_measure_fair": f_measures(trial, labels, whole),
        "error_at_coverage": {str(part): mean(wrong[whole][surest[: round(part * len(surest))]]) for part in COVERAGES},
        "data_sets": data_sets,
        "kinds": {kind: rates(trial, wrong, originals, of_kind, labels.functions) for kind, of_kind in by_kind},
    }


def f_measures(trial: Trial, labels: Labels, which: np.ndarray) -> dict[str, float]:
    """Return the F-measure of each function over some answers (T,) bool."""
    chosen = trial.kept(which)
    return {name: round(chosen.quality(labels, column)[1], 4) for column, name in enumerate(labels.functions)}


def rates(
    trial: Trial, wrong: np.ndarray, originals: np.ndarray, rows: np.ndarray, functions: Sequence[str]
) -> dict[str, float | int | None]:
    """Return the shares of some answers (T,) bool: classified by each function, unsure, wrong and sure."""
    called = {name: mean(trial.predicted[rows & (originals == name), column]) for column, name in enumerate(functions)}
    right_of_sure, wrong_and_sure = mean(~wrong[rows & ~trial.unsure]), mean((wrong & ~trial.unsure)[rows])
    shares = {"unsure": mean(trial.unsure[rows]), "wrong_and_sure": wrong_and_sure, "right_of_sure": right_of_sure}
    return called | {"objects": int(rows.sum())} | shares


def mean(which: np.ndarray) -> float | None:
    """Return the share that is True, to four places; None if there is nothing."""
    return round(float(which.mean()), 4) if len(which) else None


def print_report(report: dict[str, Any]):
    """Print the report as tables."""

    def cell(value: float | None, places: int = 2) -> str:
        return "" if value is None else f"{value:.{places}f}"

    functions = list(report["f_measure_fair"])
    figures = {f"F {name}": f_measure for name, f_measure in report["f_measure_fair"].items()}
    figures |= {f"error of {float(part):.0%}": error for part, error in report["error_at_coverage"].items()}
    title = f"{report['objects']} objects of sources that were not learnt"
    print_table(title, list(figures), [[cell(value, 3) for value in figures.values()]])
    rows = [
        [name, str(row["objects"]), *(cell(value, 3) for value in row["f_measure"].values())]
        + [cell(row["unsure"]), cell(row["right_of_sure"])]
        for name, row in report["data_sets"].items()
    ]
    titles = ["data set", "objects", *(f"F {name}" for name in functions), "unsure", "right of sure"]
    print_table("\nwhole objects by data set", titles, rows)
    columns = [*functions, "unsure", "wrong_and_sure", "right_of_sure"]
    kinds = report["kinds"].items()
    rows = [[kind, str(row["objects"]), *(cell(row[name]) for name in columns)] for kind, row in kinds]
    plain = [[text.replace("_", " ") for text in line] for line in (["kind", "objects", *columns], *rows)]
    print_table("\nshare classified by the original's function", plain[0], plain[1:])


def main(
    data: Annotated[list[str], typer.Argument(help="Training data: catalogues, models by other people, copies.")],
    backend: options.Backend = "fast",
    model: Annotated[Path | None, typer.Option(help="A model trained on DATA, whose quantities are used.")] = None,
    tested: Annotated[
        list[str] | None, typer.Option(help="Copies of DATA that are tested and not learnt, such as of a new kind.")
    ] = None,
    seed: options.Seed = 0,
    jobs: options.Jobs = -1,
    json: options.Json = False,
):
    """Measure a recipe on the sources that it would learn, each left out in turn."""
    failures, datasets = Failures(), [open_dataset(name) for name in data]
    drop_config = options.drop_config(backend, None, None, seed, options.BY_FILE, "m")
    dataset = joined_datasets(datasets)
    if not any(sources_of(dataset.objects)):
        raise InputError(
            f"{dataset.name}: expected objects of other people, with group and license in manifest.csv; got none"
        )
    if model is None:
        simulated = simulate_dataset(dataset, drop_config, jobs=jobs, failed=failures.add)
        objects, read = simulated.objects, spheres_profiled(simulated, labels_of(simulated), drop_config.radii)
    else:
        objects, read = dataset.objects, profiled_with_model(load_model(model), dataset, drop_config, jobs, failures)
    learnt, kinds, copies = len(objects), kinds_of(datasets), [open_dataset(name) for name in tested or ()]
    if copies:
        more = simulate_dataset(joined_datasets(copies), drop_config, jobs=jobs, failed=failures.add)
        objects, read = (*objects, *more.objects), with_tested(read, objects, more)
        kinds |= {path: f"{kind}, not learnt" for path, kind in kinds_of(copies).items()}
    report = report_of(answered(read, objects, kinds, learnt))
    print_json(report) if json else print_report(report)
    failures.exit()


if __name__ == "__main__":
    run(lambda: typer.run(main))
