"""``spherefunc train``: learn functions from a data set."""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ..console import Failures, print_json, print_table, say
from ..datasets.dataset import label_text
from ..errors import InputError
from ..formats.files import require_place
from ..formats.units import format_length
from . import options

if TYPE_CHECKING:
    from ..batch.simulated import Simulated
    from ..datasets.dataset import Dataset
    from ..learning.classifier import CloudClassifier
    from ..settling.cached_runs import DropConfig

Summary = dict[str, Any]  # JSON entry of a training
FEW = 3  # least number of examples of a function to learn from


def train(
    data: Annotated[
        list[str], typer.Argument(metavar="DATA...", help="Folders with manifest.csv, or names of catalogues.")
    ],
    out: Annotated[Path, typer.Option(help="The model file to write.")],
    backend: options.Backend = "fast",
    shape: options.Shape = None,
    radii: options.Radii = None,
    method: options.Method = options.DEFAULT_METHOD,
    seed: options.Seed = 0,
    up: options.Up = options.BY_FILE,
    units: options.Units = "m",
    package_path: options.PackagePath = None,
    jobs: options.Jobs = -1,
    run: options.RunDir = None,
    json: options.Json = False,
):
    """Train a model on labelled objects and write it to a file."""
    from ..batch.simulated import simulate_dataset
    from ..datasets.agreement import require_agreement
    from ..datasets.dataset import joined_datasets, open_dataset
    from ..learning.model_file import save_model

    failures, how = Failures(), options.drop_config(backend, shape, radii, seed, up, units, method)
    datasets = [open_dataset(name) for name in data]
    manifests = [each.folder / "manifest.csv" for each in datasets if each.folder is not None]
    dataset = joined_datasets(datasets)
    require_place(out, [*manifests, *(item.path for item in dataset.objects)])
    require_agreement(dataset)
    remarks = label_remarks(dataset)
    for remark in remarks:
        say(remark)
    simulated = simulate_dataset(dataset, how, jobs=jobs, run=run, failed=failures.add)
    require_smaller_spheres(simulated, how)
    model = train_on(simulated, how, method)
    save_model(model, out)
    if json:
        print_json(summary(model, backend) | {"remarks": remarks})
    else:
        print_learnt(model, method)
        say(f"wrote {out}")
    failures.exit()


def summary(model: CloudClassifier, backend: str) -> Summary:
    """Return the JSON entry of a training."""
    counts = {name: int(count) for name, count in zip(model.functions_, model.members_.sum(0), strict=True)}
    return {
        "backend": backend,
        "radii": model.radius_,
        "functions": counts,
        "objects": len(model.names_),
        "f_measure_held_out": model.held_out_f_measures(),
    }


def print_learnt(model: CloudClassifier, method: str):
    """Print for each function its examples, its radius, and the accuracy on held-out objects."""
    measured, total = model.held_out_f_measures(), len(model.names_)
    rows = []
    for name, count in zip(model.functions_, model.members_.sum(0).tolist(), strict=True):
        f_measure = "too few" if measured[name] is None else f"{measured[name]:.2f}"
        rows.append([name, str(count), str(total - count), format_length(model.radius_[name]), f_measure])
    how = "three folds, those that calibrate it" if method == "profile" else "one at a time, radii as chosen from all"
    title = f"Learnt from {total} objects; F-measure on objects held out ({how})"
    print_table(title, ["function", "examples", "others", "spheres", "F held out"], rows)


def label_remarks(dataset: Dataset) -> list[str]:
    """Return warnings about the labels of a data set, a line for each.

    Raises
    ------
    InputError
        If all objects have the same functions: nothing can be learnt from that.
    """
    total, counts = len(dataset), Counter(name for item in dataset.objects for name in item.functions)
    if not counts:
        raise InputError(f"{dataset.name}: expected objects with a function, all are labelled none")
    if len({item.functions for item in dataset.objects}) == 1:
        only = label_text(counts)
        raise InputError(f"{dataset.name}: all {total} objects are {only}: expected others too; add some labelled none")
    few = [
        f"{dataset.name}: {name} has {count} example{'s' * (count > 1)}; expected {FEW} at least; is its name misspelt?"
        for name, count in sorted(counts.items())
        if count < FEW
    ]
    everywhere = sorted(name for name, count in counts.items() if count == total)
    return few + [f"{dataset.name}: all objects are {name}, so everything will be" for name in everywhere]


def require_smaller_spheres(simulated: Simulated, how: DropConfig):
    """Raise InputError if the spheres of some radius are larger than every object."""
    largest = max(float(record.size.max()) for record in simulated.records)
    radius = max(how.radii)
    if radius > largest:
        size = format_length(float(f"{largest:.3g}"))
        got = f"got {format_length(radius)} for objects of at most {size}; are the units right?"
        raise InputError(f"{simulated.name}: expected spheres smaller than the objects, {got}")


def train_on(simulated: Simulated, how: DropConfig, method: str = options.DEFAULT_METHOD) -> CloudClassifier:
    """Return a classifier fitted to all objects of a data set."""
    from ..datasets.dataset import distinct_names, sources_of
    from ..learning.model_file import new_classifier

    labels = [item.functions for item in simulated.objects]
    if not any(labels):
        raise InputError(f"{simulated.name}: expected objects with a function, all are labelled none")
    names, originals = distinct_names(simulated.objects)
    classifier = new_classifier(how, method)
    if method != "profile":
        return classifier.fit_settled(simulated.settled, labels, names)
    return classifier.fit_settled(simulated.settled, labels, names, originals, sources_of(simulated.objects))
