"""``spherefunc figures``: the paper's figures from a data set (§III-B and §IV)."""

from __future__ import annotations

import json as json_format
from pathlib import Path
from typing import Annotated

import typer

from spherefunc_bullet.commands.options import (
    DEFAULT_RADII,
    Backend,
    Jobs,
    Json,
    Method,
    Radii,
    Seed,
    Shape,
    Units,
    Up,
    simulator_options,
)
from spherefunc_bullet.console import Failures, print_json, progress, say
from spherefunc_bullet.errors import InputError
from spherefunc_bullet.quantities import parse_lengths

SIZES = "20,45,85"  # the paper's


def figures(
    data: Annotated[str, typer.Argument(metavar="DATA", help="A folder with manifest.csv, or a catalogue's name.")],
    out: Annotated[Path, typer.Option(help="Folder for the figures.")] = Path("figures"),
    trials: Annotated[int, typer.Option(min=1, help="Random equal splits.")] = 10,
    train_sizes: Annotated[str, typer.Option(help="Training examples of the confusion matrices.")] = SIZES,
    backend: Backend = "fast",
    shape: Shape = None,
    method: Method = "default",
    radii: Radii = DEFAULT_RADII,
    seed: Seed = 0,
    up: Up = "z",
    units: Units = "m",
    jobs: Jobs = -1,
    json: Json = False,
):
    """Draw the paper's figures from a data set: PNG, SVG and CSV."""
    from spherefunc_bullet.batch.simulated import simulate_dataset
    from spherefunc_bullet.datasets.dataset import open_dataset
    from spherefunc_bullet.learning.method import find_method
    from spherefunc_bullet.settling.records import Loading
    from spherefunc_bullet.simulator import make_simulator

    from ..figures.study import Protocol, run_study

    failures = Failures()
    lengths, chosen, loading = parse_lengths(radii), find_method(method), Loading(up=up, units=units)
    simulator = make_simulator(backend, **simulator_options(shape))
    dataset = open_dataset(data)
    require_splittable(dataset, train_sizes)
    make_folder(out)
    simulated = simulate_dataset(
        dataset, simulator, lengths, seed=seed, loading=loading, jobs=jobs, failed=failures.add
    )
    sizes = told_sizes(train_sizes, len(simulated.objects))
    protocol = Protocol(sizes=sizes, trials=trials, seed=seed)
    study = run_study(simulated, lengths, chosen, loading, protocol)
    written = write_figures(study, out, simulator, failures.count)
    print_json([str(path) for path in written]) if json else print(*written, sep="\n")
    failures.exit()


def require_splittable(dataset, train_sizes: str):
    """Raise InputError before the spheres fall, which may take hours, if no figure could be drawn from them."""
    from spherefunc_bullet.batch.simulated import Simulated

    from ..evaluation.evaluation import labels_of
    from ..evaluation.sizes import fitting_sizes, require_enough

    labels_of(Simulated(dataset.name, dataset.objects, ()))
    require_enough(dataset.name, len(dataset))
    fitting_sizes(train_sizes, len(dataset))


def make_folder(out: Path):
    """Make the folder for the figures."""
    try:
        out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{out}: expected a folder that can be made; {error.strerror}") from error


def told_sizes(train_sizes: str, count: int) -> tuple[int, ...]:
    """Return the training sizes that fit, and say what stands in for those that do not."""
    from ..evaluation.sizes import fitting_sizes

    sizes, too_large = fitting_sizes(train_sizes, count)
    if too_large:
        listed = ", ".join(map(str, too_large))
        say(f"{listed} training examples are more than half of the {count} objects; drawn with {count // 2} instead")
    return sizes


def write_figures(study, out: Path, simulator, left_out: int) -> list[Path]:
    """Write all figures, their captions, and how they were made; return the paths."""
    from ..figures.confusion_matrices import confusion_matrices
    from ..figures.function_quality import function_quality
    from ..figures.histogram_slice import histogram_slice
    from ..figures.learning_curve import learning_curve
    from ..figures.membership import membership
    from ..figures.typical_objects import typical_objects
    from ..pages.plates import write_plate

    kinds = (typical_objects, histogram_slice, learning_curve, function_quality, confusion_matrices, membership)
    paths, captions = [], []
    for kind in progress(kinds, len(kinds), "drawing"):
        plate = kind(study)
        paths += write_plate(plate, out)
        captions.append(f"**{plate.stem}.** {plate.caption}\n")
    about = json_format.dumps(configuration(study, simulator, left_out), indent=2)
    return [*paths, write_text(out / "captions.md", "\n".join(captions)), write_text(out / "figures.json", about)]


def configuration(study, simulator, left_out: int) -> dict:
    """Return what decides the figures."""
    from ..machine import versions

    return {
        "data": study.simulated.name,
        "objects": len(study.simulated.objects),
        "files_left_out": left_out,
        "functions": study.labels.functions,
        "backend": simulator.name,
        "backend_version": simulator.version,
        "backend_options": simulator.options(),
        "method": study.method.name,
        "radii": study.radii,
        "seed": study.protocol.seed,
        "trials": study.protocol.trials,
        "train_sizes": list(study.runs),
        "versions": versions(),
    }


def write_text(path: Path, text: str) -> Path:
    """Write a text file and return its path."""
    try:
        path.write_text(text + "\n", encoding="utf-8")
    except OSError as error:
        raise InputError(f"{path}: expected a file that can be written; {error.strerror}") from error
    return path
