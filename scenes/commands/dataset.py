"""``spherefunc dataset``: build, import and describe data sets."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from spherefunc_bullet.commands.options import Json
from spherefunc_bullet.console import Failures, passed, print_json, progress, say

if TYPE_CHECKING:
    from spherefunc_bullet.datasets.dataset import Dataset, DatasetObject

app = typer.Typer(help="Make, import and describe data sets.", no_args_is_help=True)
Data = Annotated[str, typer.Argument(help="A folder, a manifest.csv, or the name of a catalogue.")]
Directory = Annotated[Path, typer.Argument(help="Folder for the objects and their manifest.csv.")]
Views = Annotated[str, typer.Option(help="Number of Kinect views that are fused, such as 3; or whole: all surfaces.")]
Noise = Annotated[float, typer.Option(min=0, help="Noise as a multiple of a Kinect's; 0: no noise and no lost pixels.")]
LivedInText = Annotated[
    str | None,
    typer.Option(
        "--lived-in",
        help="Additional contents, each with the share of rooms that have it: all, or some of chairs=0.5, stacks, "
        "shelves, beds, sills, gaps, piles, clutter.",
    ),
]
Fused = Annotated[str | None, typer.Option(help="Fuse a scan to one point in cells of this side, such as 2.5cm.")]
Points = Annotated[int | None, typer.Option(help="Maximum number of points of a scan.")]


@app.command()
def rooms(
    data: Annotated[str, typer.Argument(metavar="DATA", help="Meshes: a folder, or the name of a catalogue.")],
    directory: Annotated[Path, typer.Argument(help="Folder for scans, and for objects with a manifest.csv.")],
    count: Annotated[int, typer.Option("--rooms", min=1, help="How many rooms.")] = 10,
    views: Views = "3",
    noise: Noise = 1.0,
    lived_in: LivedInText = None,
    fused: Fused = None,
    points: Points = None,
    seed: Annotated[int, typer.Option(min=0, help="Random seed of the rooms.")] = 0,
    as_json: Json = False,
) -> None:
    """Furnish virtual rooms and scan them with a virtual Kinect; the object of every point is known."""
    from spherefunc_bullet.datasets.dataset import open_dataset
    from spherefunc_bullet.formats.files import prepare_folder
    from spherefunc_bullet.formats.units import parse_length

    from ..virtual_rooms.folder import RoomFolder
    from ..virtual_rooms.lived_in import furnish_lived_in, parse_lived_in
    from ..virtual_rooms.scans import Resolution, parse_views, partial_views, scan_room

    failures, number, disorder = Failures(), parse_views(views), parse_lived_in(lived_in)
    resolution, dataset = Resolution(leaf=parse_length(fused) if fused else None, points=points), open_dataset(data)
    _require_other_folder(dataset, data, directory)
    prepare_folder(directory)
    folder = RoomFolder(directory, dataset.name)
    rooms = furnish_lived_in(dataset, count, seed=seed, failed=failures.add, lived_in=disorder)
    for room in progress(rooms, count, "scanning rooms"):
        scan = scan_room(room, number, noise, seed, resolution)
        folder.write(scan, (cloud.points for _, cloud in partial_views(scan)))
    manifest = folder.close()
    about = {"scans": folder.scans, "objects": len(folder.rows), "manifest": str(manifest)}
    print_json(about) if as_json else say(f"{len(folder.scans)} scans of {len(folder.rows)} objects in {directory}")
    failures.exit()


@app.command()
def build(
    catalogue: Annotated[str, typer.Argument(help="Name of a catalogue, such as household.")],
    directory: Directory,
    seed: Annotated[int, typer.Option(min=0, help="Random seed of the objects.")] = 0,
    stretch: Annotated[
        float, typer.Option(min=0, max=1, help="Change proportions: each side longer or shorter by up to this share.")
    ] = 0.0,
    as_json: Json = False,
) -> None:
    """Write a built-in catalogue as PLY files with a manifest."""
    from spherefunc_bullet.datasets.catalogue import make_catalogue, write_catalogue

    from ..household.parts.legs import stretched

    objects = make_catalogue(catalogue, seed)
    objects = stretched(objects, stretch, seed) if stretch else objects
    manifest = write_catalogue(progress(objects, len(objects), "writing"), directory, catalogue)
    labels = _count(item.label for item in objects)
    _say({"manifest": str(manifest), "objects": len(objects), "labels": labels, "seed": seed}, as_json)


@app.command("import")
def import_furniture(
    file: Annotated[Path, typer.Argument(help="A Sweet Home 3D furniture library (.sh3f).")],
    directory: Directory,
    include_all: Annotated[
        bool, typer.Option("--all", help="Also objects whose function is disputed: beds, bowls, dressers.")
    ] = False,
    as_json: Json = False,
) -> None:
    """Write the objects of a furniture library, labelled by their names."""
    from ..sweethome3d.library import import_library

    def importing(entries: list) -> Iterable:
        return progress(entries, len(entries), "importing")

    summary = import_library(file, directory, include_ambiguous=include_all, report=say, progress=importing)
    about = {
        "manifest": str(summary.manifest),
        "objects": summary.imported,
        "labels": dict(sorted(summary.labels.items())),
        "ambiguous": summary.ambiguous,
        "skipped": summary.skipped,
    }
    _say(about, as_json)


@app.command()
def describe(data: Data, as_json: Json = False) -> None:
    """Count the objects of a data set by label, category and source, and print their sizes."""
    from spherefunc_bullet.datasets.dataset import label_text, open_dataset

    objects, failures = open_dataset(data).objects, Failures()
    about = {
        "objects": len(objects),
        "labels": _count(label_text(item.functions) for item in objects),
        "also": _count(name for item in objects for name in item.also),
        "categories": _count(item.category for item in objects),
        "groups": _count(item.group for item in objects),
        "height": _heights(_measured(objects, failures)),
    }
    _say(about, as_json)
    failures.exit()


@app.command()
def select(
    data: Data,
    directory: Directory,
    up_to: Annotated[str | None, typer.Option(help="Largest extent of an object, such as 50cm.")] = None,
    least: Annotated[str | None, typer.Option("--from", help="Smallest length of the longest side.")] = None,
    permissive: Annotated[
        bool,
        typer.Option(
            "--permissive", help="Only objects whose licence allows training on them and distributing the model."
        ),
    ] = False,
    as_json: Json = False,
) -> None:
    """Copy the objects of some sizes or licences, with their labels."""
    from shutil import copyfile

    from spherefunc_bullet.datasets.catalogue import COLUMNS, require_no_others, write_manifest
    from spherefunc_bullet.datasets.dataset import is_permissive, label_text, open_dataset
    from spherefunc_bullet.errors import InputError, one_line
    from spherefunc_bullet.formats.files import prepare_folder, writing
    from spherefunc_bullet.formats.units import parse_length

    lower, upper = parse_length(least) if least else 0.0, parse_length(up_to) if up_to else float("inf")
    dataset, failures = open_dataset(data), Failures()
    _require_other_folder(dataset, data, directory)
    objects = [item for item in dataset.objects if not permissive or is_permissive(item.license)]
    if not objects:
        raise InputError(f"{data}: expected objects with a licence such as CC-BY, got none among {len(dataset)}")
    sized = [item for item, size in _measured(objects, failures) if lower <= max(size) <= upper]
    chosen = [item for item in sized if _is_one_file(item.path, failures)]
    if not chosen:
        limits = " ".join(f"{word} {length}" for word, length in (("from", least), ("up to", up_to)) if length)
        wanted = f"objects {limits} in extent" if limits else "objects that can be copied"
        raise InputError(f"{data}: expected {wanted}, got none among {len(objects)}")
    prepare_folder(directory)
    # A manifest cannot hold every name of a file.
    names, rows = [f"{number:04d}_{one_line(item.path.name)}" for number, item in enumerate(chosen)], []
    require_no_others(directory, names)
    for name, item in zip(names, chosen, strict=True):
        with writing(directory / name):
            copyfile(item.path, directory / name)
        also = ";".join(sorted(item.also))
        rows.append((name, label_text(item.functions), also, item.category, item.group, item.source, item.license))
    manifest = write_manifest(directory, (*COLUMNS, "source", "license"), rows)
    _say({"manifest": str(manifest), "objects": len(chosen), "of": len(objects)}, as_json)
    failures.exit()


@app.command()
def impair(
    data: Data,
    directory: Directory,
    seed: Annotated[int, typer.Option(min=0, help="Random seed of holes, angles and noise.")] = 0,
    kinds: Annotated[str | None, typer.Option(help="Only these kinds, such as hole,tilted,turned.")] = None,
    copied: Annotated[
        int | None, typer.Option(min=1, help="Number of objects of each function that are copied. Default: all.")
    ] = None,
    points: Annotated[
        int | None, typer.Option(min=100, help="Write copies as this many points, at random on their triangles.")
    ] = None,
    as_json: Json = False,
) -> None:
    """Write copies that do not work, copies with harmless changes, and copies in use or as sensed."""
    from spherefunc_bullet.datasets.dataset import open_dataset

    from ..impairment.folder import evenly_spread, impair_dataset
    from ..impairment.impairments import chosen_kinds

    failures, dataset, impairments = Failures(), open_dataset(data), chosen_kinds(kinds.split(",") if kinds else None)
    _require_other_folder(dataset, data, directory)
    functions = dict.fromkeys(function for impairment in impairments for function in impairment.functions)
    some = [item for function in functions for item in evenly_spread(dataset.objects, function, copied)]
    dataset, failed = replace(dataset, objects=tuple(some)), failures.add
    copies = impair_dataset(
        dataset, directory, seed=seed, impairments=impairments, points=points, jobs=-1, failed=failed
    )
    made, left_out = copies.made, copies.left_out
    about = {"manifest": str(copies.manifest), "objects": sum(made.values()), "made": made, "left_out": left_out}
    _say(about | {"seed": seed}, as_json)
    failures.exit()


def _require_other_folder(dataset: Dataset, data: str, directory: Path) -> None:
    """Raise InputError if the copies of a data set would replace its manifest, or be more of its objects."""
    from spherefunc_bullet.datasets.dataset import require_no_label
    from spherefunc_bullet.errors import InputError

    require_no_label(str(directory), directory, Path(data))
    if dataset.folder is not None and dataset.folder.resolve() == directory.resolve():
        raise InputError(f"{directory}: expected another folder than that of the data set, whose labels would be lost")


def _count(names: Iterable[str]) -> dict[str, int]:
    """Return the number of occurrences of each name, by name."""
    return dict(sorted(Counter(names).items()))


def _measured(objects: Sequence[DatasetObject], failures: Failures) -> Iterable[tuple[DatasetObject, list[float]]]:
    """Yield each object with its width, depth and height; files that cannot be used are reported and left out."""
    from spherefunc_bullet.errors import attempt

    outcomes = ((number, attempt(_extents, (item.path,))) for number, item in enumerate(objects))
    for number, size in passed(outcomes, len(objects), "measuring", failures.add):
        yield objects[number], size


def _is_one_file(path: Path, failures: Failures) -> bool:
    """Return whether an object is one file, whose copy is whole; one that names others is reported."""
    from spherefunc_bullet.errors import InputError
    from spherefunc_bullet.formats.sources import as_source

    _, *named = as_source(path).parts()
    if named:
        failures.add(InputError(f"{path}: expected one file to copy, it names {named[0].path.name}; save it as GLB"))
    return not named


def _heights(objects: Iterable[tuple[DatasetObject, list[float]]]) -> dict[str, dict[str, float]]:
    """Return the least, median and greatest height of each label's objects, metres."""
    from statistics import median

    from spherefunc_bullet.datasets.dataset import label_text

    heights: dict[str, list[float]] = {}
    for item, (*_, height) in objects:
        heights.setdefault(label_text(item.functions), []).append(height)
    kinds = {"min": min, "median": median, "max": max}
    return {
        label: {kind: round(summary(heights[label]), 3) for kind, summary in kinds.items()} for label in sorted(heights)
    }


def _extents(path: Path) -> list[float]:
    """Return width, depth and height of an object, in the units of its file; glTF files are y up."""
    import numpy as np

    from spherefunc_bullet.clouds.orientation import promised_up
    from spherefunc_bullet.errors import InputError
    from spherefunc_bullet.formats.sources import read_geometry

    geometry = read_geometry(path)
    points = geometry.vertices[np.unique(geometry.faces)] if len(geometry.faces) else geometry.vertices
    points = points[np.isfinite(points).all(axis=1)]  # a cloud may hold NaN where the sensor measured nothing
    if not len(points):
        raise InputError(f"{path}: expected points, got none that are finite; did the sensor measure nothing?")
    x, y, z = np.ptp(points, axis=0).tolist()
    return [x, z, y] if promised_up(path) == "y" else [x, y, z]


def _say(about: dict[str, object], as_json: bool) -> None:
    """Print a result: JSON on standard output, or lines of text on standard error."""
    if as_json:
        print_json(about)
        return
    for name, value in about.items():
        texts = []
        for key, figure in value.items() if isinstance(value, dict) else ():
            span = f"{figure['min']:g} to {figure['max']:g} m" if isinstance(figure, dict) else figure
            texts.append(f"{key or 'unnamed'} {span}")
        say(f"{name}: {', '.join(texts) or value}")
