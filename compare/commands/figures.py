"""``spherefunc figures``: the paper's figures from a data set (§III-B and §IV)."""

from __future__ import annotations

import json as json_format
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from spherefunc_bullet.commands import options
from spherefunc_bullet.console import Failures, print_json, progress, say, show

if TYPE_CHECKING:
    from ..figures.evaluated_data import EvaluatedData

SIZES = "20,45,85"  # the paper's


def figures(
    data: Annotated[str, typer.Argument(metavar="DATA", help="A folder with manifest.csv, or a catalogue's name.")],
    out: Annotated[Path, typer.Option(help="Folder for the figures.")] = Path("figures"),
    trials: Annotated[int, typer.Option(min=1, help="Number of random equal splits.")] = 10,
    train_sizes: Annotated[str, typer.Option(help="Numbers of training examples for the confusion matrices.")] = SIZES,
    backend: options.Backend = "fast",
    shape: options.Shape = None,
    method: options.Method = "cubes",
    radii: options.Radii = None,
    seed: options.Seed = 0,
    up: options.Up = options.BY_FILE,
    units: options.Units = "m",
    jobs: options.Jobs = -1,
    json: options.Json = False,
):
    """Draw the paper's figures from a data set: PNG, SVG and CSV."""
    from spherefunc_bullet.batch.simulated import simulate_dataset
    from spherefunc_bullet.datasets.dataset import open_dataset
    from spherefunc_bullet.formats.files import prepare_folder
    from spherefunc_bullet.learning.method import find_cube_method

    from ..evaluation.protocol import Protocol, fitting_sizes, labels_of, require_enough
    from ..figures.evaluated_data import evaluate_data

    failures = Failures()
    chosen = find_cube_method(method)
    drop_config = options.drop_config(backend, shape, radii, seed, up, units, method)
    dataset = open_dataset(data)
    # Errors of data from which no figure can be drawn come before the simulation, which may take hours.
    labels_of(dataset)
    require_enough(dataset.name, len(dataset))
    fitting_sizes(train_sizes, len(dataset))
    prepare_folder(out)
    simulated = simulate_dataset(dataset, drop_config, jobs=jobs, failed=failures.add)
    count = len(simulated.objects)
    sizes, too_large = fitting_sizes(train_sizes, count)
    if too_large:
        listed = ", ".join(map(str, too_large))
        say(f"{listed} training examples are more than half of the {count} objects; drawn with {count // 2} instead")
    protocol = Protocol(train_sizes=sizes, trials=trials, seed=seed)
    evaluated = evaluate_data(simulated, drop_config, chosen, protocol)
    written = write_figures(evaluated, out, failures.count)
    print_json([str(path) for path in written]) if json else show("\n".join(map(str, written)))
    failures.exit()


def write_figures(data: EvaluatedData, out: Path, left_out: int) -> list[Path]:
    """Write all figures, their captions, and their settings; return the paths."""
    from spherefunc_bullet.formats.files import write_text

    from ..figures.accuracy import confusion_matrices, function_quality, learning_curve
    from ..figures.histogram_slice import histogram_slice
    from ..figures.membership import membership
    from ..figures.typical_objects import typical_objects
    from ..pages.plates import write_plate

    kinds = (typical_objects, histogram_slice, learning_curve, function_quality, confusion_matrices, membership)
    paths, captions = [], []
    for kind in progress(kinds, len(kinds), "drawing"):
        plate = kind(data)
        paths += write_plate(plate, out)
        captions.append(f"**{plate.stem}.** {plate.caption}\n")
    about = json_format.dumps(configuration(data, left_out), indent=2)
    paths.append(write_text(out / "captions.md", "\n".join(captions) + "\n"))
    return [*paths, write_text(out / "figures.json", about + "\n")]


def configuration(data: EvaluatedData, left_out: int) -> dict[str, Any]:
    """Return the settings that decide the figures."""
    from ..machine import versions

    simulator = data.drop_config.simulator
    return {
        "data": data.name,
        "objects": len(data.simulated.objects),
        "files_left_out": left_out,
        "functions": data.labels.functions,
        "backend": simulator.name,
        "backend_version": simulator.version,
        "backend_options": simulator.options(),
        "method": data.evaluation.method.name,
        "radii": data.radii,
        "seed": data.protocol.seed,
        "trials": data.protocol.trials,
        "train_sizes": list(data.evaluation.trials),
        "versions": versions(),
    }
