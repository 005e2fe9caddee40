"""``spherefunc view``: an object, its settled spheres and its histogram, as an interactive page."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ..console import Failures, passed, print_json, say, shown_names, with_path
from ..errors import InputError
from ..formats.files import require_place, unused_name, write_text
from ..formats.units import format_length, parse_lengths
from .options import (
    BY_FILE,
    Files,
    Json,
    MaxSpheres,
    PackagePath,
    Seed,
    Shape,
    Units,
    Up,
    require_beside,
    simulator_options,
)

if TYPE_CHECKING:
    from ..clouds.cloud import Cloud
    from ..learning.classifier import CloudClassifier
    from ..settling.drops import DropsByRadius
    from ..simulator import DropResult, Simulator

RADII = (0.005, 0.01, 0.02, 0.03, 0.05)  # metres; one of them is chosen by the size of the object
SPHERES_ACROSS = 36  # approximate number of radii along the longest side: spheres are seen one by one, and how they lie


@dataclass(eq=False)
class ViewedObject:
    """The object of one file, and the drops on it."""

    file: Path
    cloud: Cloud
    radii: tuple[float, ...]  # metres
    results: dict[str, list[DropResult]] = field(default_factory=dict)  # backend -> one per radius
    settled: DropsByRadius | None = None  # for the explanation


def view(
    files: Files,
    backend: Annotated[str, typer.Option(help="Simulators to show side by side, such as fast,bullet.")] = "fast",
    radius: Annotated[
        str | None, typer.Option(help="Sphere radii, such as 1cm or 1cm,2cm. Default: by the object's size.")
    ] = None,
    explain: Annotated[
        bool, typer.Option("--explain", help="Explain the classification: quantities, or neighbours and cubes.")
    ] = False,
    model: Annotated[
        Path | None, typer.Option(help="A model file for --explain. Default: the model that comes with the package.")
    ] = None,
    out: Annotated[
        Path | None, typer.Option(help="An .html file for all objects, or a folder. Default: FILE.html.")
    ] = None,
    rerun: Annotated[
        Path | None, typer.Option(metavar="FILE.rrd", help="Also write a recording of the drops for Rerun's viewer.")
    ] = None,
    open: Annotated[bool | None, typer.Option(help="Open the page in a browser. Default: only on a terminal.")] = None,
    shape: Shape = None,
    seed: Seed = 0,
    max_spheres: MaxSpheres = 20_000,
    up: Up = BY_FILE,
    units: Units = "m",
    package_path: PackagePath = None,
    json: Json = False,
):
    """Show objects with settled spheres and histogram cubes as interactive pages."""
    from ..simulator import backend_names

    require_beside("--explain", explain, {}, {"--model": model})
    names = backend_names(backend)
    radii = parse_lengths(radius) if radius else None
    require_page_place(out)
    if rerun is not None:
        require_place(rerun)
    classifier = explaining_model(model, names) if explain else None
    failures = Failures()
    simulators = usable_simulators(names, shape, failures)
    objects = loaded_objects(files, radii, up, units, failures) if simulators else []
    for simulator in simulators:
        drop_on_all(objects, simulator, max_spheres, seed, failures)
    if classifier is not None:
        settle_on_all(objects, classifier, failures)
    shown = [viewed for viewed in objects if viewed.results]
    pages = write_pages(shown, out, classifier, failures)
    if rerun is not None:
        record(shown, rerun, failures)
    if json:
        print_json([str(page) for page in pages])
    else:
        say("\n".join(f"wrote {page}" for page in pages) if pages else "no page was written")
    if pages:
        open_browser(pages[0], open)
    failures.exit()


def explaining_model(model: Path | None, names: Sequence[str]) -> CloudClassifier:
    """Return the given model, or else the model that ships for the first of the backends that has one."""
    from ..learning.model_file import load_model, shipped_model

    if model is not None:
        return load_model(model)
    for name in names:
        try:
            return load_model(shipped_model(name))
        except InputError as error:
            missing = error
    raise missing


def require_page_place(out: Path | None):
    """Raise InputError, before spheres are dropped, if pages cannot be written to a file or folder."""
    if out is None:
        return
    if not out.is_dir() and out.suffix.lower() not in (".html", ".htm"):
        raise InputError(f"{out}: expected a name that ends in .html, or an existing folder")
    require_place(out / "page.html" if out.is_dir() else out)


def usable_simulators(names: Sequence[str], shape: str | None, failures: Failures) -> list[Simulator]:
    """Return the simulators that are available, and report errors of the others; only bullet has shapes."""
    from ..simulator import make_simulator

    simulators = []
    for name in names:
        try:
            options = simulator_options(shape=shape) if name == "bullet" or len(names) == 1 else {}
            simulators.append(make_simulator(name, **options))
        except InputError as error:
            failures.add(error)
    return simulators


def loaded_objects(
    files: Sequence[Path], radii: tuple[float, ...] | None, up: str, units: str, failures: Failures
) -> list[ViewedObject]:
    """Return the objects of the files that can be used, and report errors of the others."""
    from ..clouds.cloud import load_cloud
    from ..viewer.pictures import fitting_radius

    objects = []
    for file in files:
        try:
            cloud = load_cloud(file, up=up, units=units, report=say)
        except InputError as error:
            failures.add(with_path(error, file))
        else:
            objects.append(ViewedObject(file, cloud, radii or (fitting_radius(RADII, cloud.size, SPHERES_ACROSS),)))
    return objects


def drop_on_all(objects: Sequence[ViewedObject], simulator: Simulator, max_spheres: int, seed: int, failures: Failures):
    """Drop spheres on every object by one backend."""
    from ..processes.tasks import run_tasks
    from ..simulator import isolated

    tasks = [(viewed.cloud, simulator, viewed.radii, max_spheres, seed) for viewed in objects]
    outcomes = run_tasks(dropped, tasks, [viewed.file for viewed in objects], isolate=isolated(simulator))
    for index, results in passed(outcomes, len(tasks), f"dropping by {simulator.name}", failures.add):
        objects[index].results[simulator.name] = results


def dropped(
    cloud: Cloud, simulator: Simulator, radii: Sequence[float], max_spheres: int, seed: int
) -> list[DropResult]:
    """Return the result of a run on a cloud at each radius; for a worker."""
    from ..simulator import DropSettings, drop_on

    runs = [DropSettings(radius=radius, max_spheres=max_spheres) for radius in radii]
    return [drop_on(cloud, simulator, settings, seed) for settings in runs]


def settle_on_all(objects: Sequence[ViewedObject], classifier: CloudClassifier, failures: Failures):
    """Drop as many spheres on every object as `spherefunc classify` does."""
    from ..processes.tasks import run_tasks
    from ..simulator import isolated, make_simulator

    tasks, files = [(viewed.cloud, classifier) for viewed in objects], [viewed.file for viewed in objects]
    outcomes = run_tasks(drops_read, tasks, files, isolate=isolated(make_simulator(classifier.simulator)))
    for index, settled in passed(outcomes, len(objects), "explaining", failures.add):
        objects[index].settled = settled


def drops_read(cloud: Cloud, classifier: CloudClassifier) -> DropsByRadius:
    """Return the drops from which a classifier computes its answer about a cloud; for a worker."""
    from ..settling.cached_runs import CloudObject

    return classifier.read(CloudObject(raw_cloud=cloud, drop_config=classifier.drop_config()).drops).drops


def write_pages(
    objects: Sequence[ViewedObject], out: Path | None, classifier: CloudClassifier | None, failures: Failures
) -> list[Path]:
    """Write one page per object, or one for all where its name is given, and return those written."""
    from ..viewer.page import display_page

    together = out is not None and not out.is_dir()
    groups = [objects] if together and objects else [[viewed] for viewed in objects]
    written: list[Path] = []
    shown = shown_names(viewed.file for viewed in objects)
    for group in groups:
        path = out if together else unused_name(out or Path(), group[0].file.stem, ".html", written)
        names = [shown[str(viewed.file)] for viewed in group]
        each = zip(group, names, strict=True)
        html = display_page(", ".join(names), [part for one in each for part in object_parts(*one, classifier)])
        try:
            written.append(write_text(path, html))
        except InputError as error:
            failures.add(error)
    return written


def record(objects: Sequence[ViewedObject], path: Path, failures: Failures):
    """Write the drops on all objects for Rerun's viewer, and say where."""
    from ..viewer.recording import write_recording

    names: list[Path] = []  # distinct: what has the name of another would be drawn over it
    for viewed in objects:
        names.append(unused_name(Path(), viewed.file.stem, "", names))
    named = [(name.name, viewed.cloud, viewed.results) for name, viewed in zip(names, objects, strict=True)]
    try:
        say(f"wrote {write_recording(named, path)}")
    except InputError as error:
        failures.add(error)


def object_parts(viewed: ViewedObject, title: str, classifier: CloudClassifier | None) -> list[str]:
    """Return the HTML of one object: its title, a display of each backend's runs, and the explanation if requested."""
    from html import escape

    from ..viewer.data import Panel, sphere_layer
    from ..viewer.explanation import explanation_html
    from ..viewer.still import pictured

    panels = []
    for name, results in viewed.results.items():
        pairs = zip(viewed.radii, results, strict=True)
        layers = [sphere_layer(radius, result.centers, run_note(radius, result)) for radius, result in pairs]
        panels.append(Panel(title=name, layers=layers))
    size = " × ".join(f"{100 * side:.3g}" for side in viewed.cloud.size)
    origin = "" if viewed.cloud.mesh is None else " sampled from a mesh"
    parts = [
        f"<h1>{escape(title)}</h1>",
        f"<p class='lead'>{size} cm, {len(viewed.cloud):,} points{origin}. "
        "Drag to turn, right-drag to move, wheel to zoom (click first), double-click to reset.</p>",
        pictured(viewed.cloud, panels, panels),
    ]
    if viewed.settled is not None:
        parts.append(explanation_html(classifier, viewed.cloud, viewed.settled))
    return parts


def run_note(radius: float, result: DropResult) -> str:
    """Return the radius, the outcomes and the time of a run as a sentence."""
    from ..simulator import Stop

    counts = [(result.settled, "settled"), (result.rolled_off, "rolled off"), (result.rejected, "rejected")]
    counts += [(result.timed_out, "timed out")] if result.timed_out else []
    outcomes = ", ".join(f"{count:,} {what}" for count, what in counts)
    cut = "; stopped at the limit of spheres" if result.stop == Stop.SPHERE_LIMIT else ""
    return f"Spheres of radius {format_length(radius)}: {outcomes}, in {result.seconds:.3g} s{cut}."


def open_browser(page: Path, requested: bool | None):
    """Open a page if requested, by default on a terminal, and if there is a display; report a failure."""
    import webbrowser

    graphical = sys.platform in ("win32", "darwin") or any(map(os.environ.get, ("DISPLAY", "WAYLAND_DISPLAY")))
    wanted = sys.stdout.isatty() if requested is None else requested
    if graphical and wanted and not webbrowser.open(page.absolute().as_uri()):
        say(f"no browser could be opened; the page is {page}")
