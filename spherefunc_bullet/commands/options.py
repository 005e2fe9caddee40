"""Options that several subcommands share."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Sequence
from operator import itemgetter
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ..console import Failures, passed, say, with_path
from ..errors import InputError
from ..formats.units import BY_FILE as BY_FILE
from ..formats.units import format_length, parse_lengths, parse_mass

if TYPE_CHECKING:
    from ..settling.cached_runs import DropConfig
    from ..simulator import Simulator
    from ..simulator.mechanics import Material


# A file that cannot be read is reported like any other that fails, and costs the others nothing.
Files = Annotated[list[Path], typer.Argument(metavar="FILE...", readable=False, help="Models or scans.")]
Standing = Annotated[
    list[Path], typer.Argument(metavar="FILE...", readable=False, help="Models or scans, as they stand.")
]
Model = Annotated[Path | None, typer.Option(help="A model file. Default: the model that comes with the package.")]
Backend = Annotated[str, typer.Option(help="Simulator that drops the spheres; `spherefunc backends` lists them.")]
Shape = Annotated[str | None, typer.Option(help="Collision shape (bullet only).")]
Seed = Annotated[int, typer.Option(min=0, help="Random seed of the drops.")]
Up = Annotated[
    str, typer.Option(help="Axis that points up: z, -z, y, -y, x, -x or auto; file: y for glTF, z for others.")
]
Units = Annotated[str, typer.Option(help="Unit of the file's coordinates: m, cm, mm, in or auto.")]
PackagePath = Annotated[
    list[Path] | None,
    typer.Option(
        "--package-path",
        metavar="DIR",
        callback=lambda folders: point_to_packages(folders),
        help="Folder of ROS packages, or of layers, that URDF or USD files refer to; may be repeated. "
        "Used with ROS_PACKAGE_PATH.",
    ),
]
Radii = Annotated[str | None, typer.Option(help="Sphere radii, such as 5mm,1cm,2cm. Default: those of the method.")]
Method = Annotated[
    str,
    typer.Option(help="profile: named quantities of the drops; cubes: histogram; paper: exactly as Hinkle and Olson."),
]
MaxSpheres = Annotated[int, typer.Option(min=1, help="Stop a run when this many spheres have settled.")]
MissLimit = Annotated[
    int | None, typer.Option(min=1, help="Consecutive spheres not placed that end a run (paper, §III-A). Default: 50.")
]
Jobs = Annotated[int, typer.Option(help="Number of parallel processes; -1: one per core.")]
RunDir = Annotated[
    Path | None, typer.Option("--run", metavar="DIR", help="Use the results of this run of `spherefunc batch`.")
]
Mass = Annotated[str | None, typer.Option(help="Mass of the object, such as 300g or 5kg. Default: from its surface.")]
AreaDensity = Annotated[float, typer.Option(help="Mass per surface area, kg/m2, if no mass is given.")]
Friction = Annotated[float, typer.Option(help="Coefficient of friction.")]
Restitution = Annotated[float, typer.Option(help="Coefficient of restitution, 0 to 0.9.")]
Json = Annotated[bool, typer.Option("--json", help="Print JSON on stdout.")]

DEFAULT_METHOD = "profile"


def drop_config(
    backend: str,
    shape: str | None,
    radii: str | None,
    seed: int,
    up: str,
    units: str,
    method: str = DEFAULT_METHOD,
    miss_limit: int | None = None,
) -> DropConfig:
    """Return the drop config for the given options, with the defaults of a method."""
    from ..function_model import SPHERES
    from ..learning.method import find_method
    from ..settling.cached_runs import DropConfig, LoadOptions
    from ..simulator import make_simulator

    simulator = make_simulator(backend, **simulator_options(shape=shape))
    way, loading = find_method(method), LoadOptions(up=up, units=units)
    lengths = way.radii if radii is None else parse_lengths(radii)
    if odd := [length for length in lengths if not SPHERES[0] <= length <= SPHERES[1]]:
        limits = f"expected spheres of {' to '.join(map(format_length, SPHERES))}, got {format_length(odd[-1])}"
        raise InputError(f"--radii {radii}: {limits}; give a unit, such as 2cm or 2mm")
    run_limit = way.run_limit.ending(miss_limit)
    return DropConfig(simulator=simulator, radii=lengths, seed=seed, loading=loading, run_limit=run_limit)


def point_to_packages(folders: Sequence[Path] | None):
    """Make this process and its workers search these folders first for the packages of URDF files."""
    from ..formats.scenes.named_meshes import PACKAGE_PATH

    for folder in folders or ():
        if not folder.is_dir():
            raise InputError(f"--package-path {folder}: expected a folder of ROS packages, found none; check the path")
    if folders:
        places = [*(str(folder.absolute()) for folder in folders), os.environ.get(PACKAGE_PATH, "")]
        os.environ[PACKAGE_PATH] = os.pathsep.join(filter(None, places))


def simulator_options(**given: str | int | None) -> dict:
    """Return the options of a simulator without those that are None."""
    return {name: value for name, value in given.items() if value is not None}


def matter_of(mass: str | None, area_density: float, friction: float, restitution: float) -> Material:
    """Return the material of an object for the given options."""
    from ..simulator.mechanics import Material

    kilograms = None if mass is None else parse_mass(mass)
    return Material(area_density=area_density, mass=kilograms, friction=friction, restitution=restitution)


def require_beside(option: str, given: bool, others: dict[str, object], only: dict[str, object]):
    """Raise InputError for others that do not go with an option, and for those that go only with it."""
    wrong, where = (others, "without") if given else (only, "with")
    for name, value in wrong.items():
        if value is not None:
            raise InputError(f"{name}: expected {where} {option}")


def require_drawings(inputs: Iterable[Path], picture: Path | None, page: Path | None = None):
    """Raise InputError, before anything is computed, if a picture or page cannot be written, or is an input or both."""
    from ..formats.files import prepare_folder, require_place
    from ..viewer.mechanics_pictures import require_png

    require_png(picture)
    for file in filter(None, (picture, page)):
        prepare_folder(file.parent)
        require_place(file, inputs)
    if picture is not None and page is not None and picture.resolve() == page.resolve():
        raise InputError(f"--page {page}: expected another file than --picture")


def run_on_files(
    function: Callable,
    files: Sequence[Path],
    simulator: Simulator,
    how: tuple,
    doing: str,
    failures: Failures,
    drawn: bool = True,
    jobs: int = 1,
) -> list[tuple[Path, Any]]:
    """Return each file with the result of the function, in their order; a file that fails is reported and left out.

    Parameters
    ----------
    function : callable
        Its arguments are a file, the simulator, and those of ``how``.
    doing : str
        Text of the progress bar.
    drawn : bool
        If not, the first part of each result, a cloud to draw, is replaced by None: those of a library fill the memory.
    """
    from ..processes.tasks import run_tasks
    from ..simulator import isolated

    tasks = [(file, simulator, *how) for file in files]
    outcomes = run_tasks(function, tasks, files, jobs=jobs, isolate=isolated(simulator))
    located = ((index, with_path(outcome, files[index])) for index, outcome in outcomes)
    results = passed(located, len(files), doing, failures.add)
    kept = [(index, result if drawn else (None, *result[1:])) for index, result in results]
    return [(files[index], result) for index, result in sorted(kept, key=itemgetter(0))]


def say_notes(name: str, notes: Iterable[str]):
    """Print notes about an object on stderr."""
    for note in notes:
        say(f"{name}: {note}")
