"""``spherefunc train``: learn functions from a data set."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ..console import Failures, print_json, say
from ..errors import InputError
from ..formats.writing import require_place
from ..quantities import format_length
from . import options

if TYPE_CHECKING:
    from ..batch.simulated import Simulated
    from ..learning.classifier import CloudClassifier
    from ..settling.records import Dropping


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
    jobs: options.Jobs = -1,
    run: options.RunDir = None,
    json: options.Json = False,
):
    """Learn every function's radius and examples, and write the model."""
    from ..batch.simulated import simulate_dataset
    from ..datasets.dataset import joined_datasets, open_dataset
    from ..learning.model_file import save_model

    require_place(out)
    failures, how = Failures(), options.dropping(backend, shape, radii, seed, up, units, method)
    dataset = joined_datasets([open_dataset(name) for name in data])
    simulated = simulate_dataset(dataset, how, jobs=jobs, run=run, failed=failures.add)
    model = train_on(simulated, how, method)
    save_model(model, out)
    if json:
        counts = {name: int(count) for name, count in zip(model.functions_, model.members_.sum(0), strict=True)}
        print_json({"backend": backend, "radii": model.radius_, "functions": counts, "objects": len(model.names_)})
    else:
        chosen = ", ".join(f"{name} {format_length(radius)}" for name, radius in model.radius_.items())
        say(f"learnt {len(model.names_)} objects ({chosen}); wrote {out}")
    failures.exit()


def train_on(simulated: Simulated, how: Dropping, method: str = options.DEFAULT_METHOD) -> CloudClassifier:
    """Return a classifier that has learnt all objects of a data set."""
    from ..learning.model_file import new_classifier

    labels = [item.functions for item in simulated.objects]
    if not any(labels):
        raise InputError(f"{simulated.name}: expected objects with a function, all are labelled none")
    names = [item.path.name for item in simulated.objects]
    classifier = new_classifier(how, method)
    if method != "profile":
        return classifier.fit_settled(simulated.settled, labels, names)
    originals = [Path(item.of).name for item in simulated.objects]
    return classifier.fit_settled(simulated.settled, labels, names, originals)
