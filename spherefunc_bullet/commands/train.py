"""``spherefunc train``: learn functions from a data set."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ..console import Failures, print_json, say
from ..errors import InputError
from ..formats.writing import require_place
from ..quantities import format_length, parse_lengths
from .options import (
    DEFAULT_RADII,
    Backend,
    Jobs,
    Json,
    Method,
    Radii,
    RunDir,
    Seed,
    Shape,
    Units,
    Up,
    simulator_options,
)

if TYPE_CHECKING:
    from ..batch.simulated import Simulated
    from ..learning.function_classifier import FunctionClassifier
    from ..simulator import Simulator


def train(
    data: Annotated[
        list[str], typer.Argument(metavar="DATA...", help="Folders with manifest.csv, or names of catalogues.")
    ],
    out: Annotated[Path, typer.Option(help="The model file to write.")],
    backend: Backend = "fast",
    shape: Shape = None,
    radii: Radii = DEFAULT_RADII,
    method: Method = "default",
    seed: Seed = 0,
    up: Up = "z",
    units: Units = "m",
    jobs: Jobs = -1,
    run: RunDir = None,
    json: Json = False,
):
    """Learn every function's radius and examples, and write the model."""
    from ..batch.simulated import simulate_dataset
    from ..datasets.dataset import joined_datasets, open_dataset
    from ..learning.model_file import save_model
    from ..settling.records import Loading
    from ..simulator import make_simulator

    require_place(out)
    failures = Failures()
    simulator = make_simulator(backend, **simulator_options(shape))
    lengths = parse_lengths(radii)
    loading = Loading(up=up, units=units)
    dataset = joined_datasets([open_dataset(name) for name in data])
    simulated = simulate_dataset(
        dataset, simulator, lengths, seed=seed, loading=loading, jobs=jobs, run=run, failed=failures.add
    )
    model = train_on(simulated, simulator, lengths, method=method, seed=seed)
    save_model(model, out)
    if json:
        counts = {name: int(count) for name, count in zip(model.functions_, model.members_.sum(0), strict=True)}
        print_json({"backend": backend, "radii": model.radius_, "functions": counts, "objects": len(model.names_)})
    else:
        chosen = ", ".join(f"{name} {format_length(radius)}" for name, radius in model.radius_.items())
        say(f"learnt {len(model.names_)} objects ({chosen}); wrote {out}")
    failures.exit()


def train_on(
    simulated: Simulated, simulator: str | Simulator, radii: Sequence[float], *, method: str = "default", seed: int = 0
) -> FunctionClassifier:
    """Return a classifier that has learnt all objects of a data set."""
    from ..learning.function_classifier import FunctionClassifier
    from ..learning.method import find_method

    model = FunctionClassifier(simulator, radii=tuple(radii), method=find_method(method), seed=seed)
    labels = [item.functions for item in simulated.objects]
    if not any(labels):
        raise InputError(f"{simulated.name}: expected objects with a function, all are labelled none")
    return model.fit_settled(simulated.settled, labels, [item.path.name for item in simulated.objects])
