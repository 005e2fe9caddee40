"""``spherefunc shapes``: which functions of an object its collision shapes keep, and what they cost."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ..console import Failures, print_json, print_table, progress, show
from ..errors import InputError
from ..formats.units import parse_numbers
from .options import BY_FILE, Jobs, Json, PackagePath, Units, Up, require_beside

if TYPE_CHECKING:
    from ..shapes.library import LibraryOptions

COLUMNS = ["name", "pieces", "faces", "bytes", "build_seconds", "step_us", "capacity_ml", "capacity_kept", "level_kept"]
COLUMNS += ["level_higher_mm", "settled_kept", "moved_mm", "deeper", "openings_closed", "keeps", "verdict"]


def shapes(
    files: Annotated[
        list[Path],
        typer.Argument(metavar="FILE...", readable=False, help="Meshes, URDFs, their folders, or data sets."),
    ],
    collision: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Collision geometry: URDF, SDF, MJCF, USD, or a mesh.")
    ] = None,
    best: Annotated[
        bool, typer.Option("--best", help="Find and write the cheapest shape that keeps everything.")
    ] = False,
    still: Annotated[
        bool, typer.Option("--static", help="The object never moves, so --best may be the concave mesh.")
    ] = False,
    out: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Folder for the files of --best. Default: the current one.")
    ] = None,
    form: Annotated[
        str | None, typer.Option("--format", help="Format of the files of --best: urdf, sdf or mjcf. Default: urdf.")
    ] = None,
    keep: Annotated[
        float | None,
        typer.Option(help="Share of capacity, level and places to keep. Default: 0.9; for --best see docs."),
    ] = None,
    coacd: Annotated[
        str | None, typer.Option(help="Also shapes by CoACD with these thresholds, such as 0.05,0.2; takes minutes.")
    ] = None,
    only: Annotated[bool, typer.Option("--only-collision", help="Compare only the collision geometry.")] = False,
    table: Annotated[
        Path | None, typer.Option("--csv", metavar="FILE", help="Write a row per shape, also for files that failed.")
    ] = None,
    report: Annotated[
        Path | None,
        typer.Option(metavar="DIR", help="Folder for a page and a CSV; objects that are there are not computed again."),
    ] = None,
    jobs: Jobs = 1,
    up: Up = BY_FILE,
    units: Units = "m",
    package_path: PackagePath = None,
    json: Json = False,
):
    """Compare collision shapes: what each keeps of what the object holds, carries and lets through, and its cost."""
    from ..formats.files import prepare_folder, require_place, write_bytes
    from ..shapes.library import SUFFIX, LibraryOptions, library_results, page

    require_beside("--best", best, {}, {"--out": out, "--format": form, "--static": still or None})
    require_beside("--only-collision", only, {"--coacd": coacd}, {})
    out, form = out or Path(), form or "urdf"
    if form not in SUFFIX:
        raise InputError(f"--format {form}: expected urdf, sdf or mjcf")
    if still and form == "mjcf":
        raise InputError("--static: expected --format urdf or sdf, since MuJoCo takes the hull of every mesh")
    prepare_folder(out if best else None)
    thresholds = parse_numbers("--coacd", coacd, "numbers, such as 0.05,0.2") if coacd else ()
    chosen = list(objects_in(files))
    options = LibraryOptions(
        collision=collision, shapes=not only, coacd=thresholds, keep=keep, units=units, up=up,
        best=form if best else None, still=still, out=out, root=folder_kept_below(chosen), picture=report is not None,
    )  # fmt: skip
    failures, results = Failures(), []
    prepare_folder(report)
    if table is not None:
        prepare_folder(table.parent)
        require_place(table, [*chosen, *([collision] if collision else [])])
    if best:
        require_apart(chosen, options)
    cache = None if report is None else report / "objects"
    for result in progress(library_results(chosen, options, jobs, cache), len(chosen), "comparing"):
        if "error" in result:
            failures.add(result["error"])
        results.append(result)
    results.sort(key=lambda result: chosen.index(Path(result["file"])))
    if report is not None:
        write_bytes(report / "report.html", page("What collision shapes keep", results).encode())
        table = table or report / "shapes.csv"
    if table is not None:
        write_table(table, results)
    if json:
        print_json([{name: value for name, value in result.items() if name != "picture"} for result in results])
    elif report is not None:
        print_library(results)
    else:
        for row in results:
            if "error" not in row:
                print_shapes(row)
    failures.exit()


def folder_kept_below(files: Sequence[Path]) -> Path | None:
    """Return the folder that holds all files, absolute, if some have the same name; None if all differ."""
    if len({file.stem for file in files}) == len(files):
        return None
    return Path(os.path.commonpath([file.absolute().parent for file in files]))


def require_apart(files: Sequence[Path], options: LibraryOptions):
    """Raise InputError if the best shapes would overwrite each other or an input file."""
    targets = [options.best_file(file) for file in files]
    if len(set(targets)) < len(files):
        raise InputError("--best: expected files of different names in each folder, since shapes are named after them")
    for file, target in zip(files, targets, strict=True):
        if file.resolve().parent == target.parent.resolve():
            raise InputError(f"--best: expected --out of another folder than that of {file}, which it might overwrite")


def print_library(results: list[dict[str, Any]]):
    """Print one line for each object of a library, and how many keep their functions."""
    from ..shapes.library import short, summary, verdict_text

    rows = []
    for result in results:
        if result.get("shapes"):
            row = result["shapes"][0]
            shares = [row[name] for name in ("capacity_kept", "level_kept", "settled_kept")]
            shares = ["" if share is None else f"{share:.2f}" for share in shares]
            keeps = "yes" if row["keeps"] else "no"
            rows.append([short(result), verdict_text(result), *shares, str(row["pieces"]), keeps])
    print_table("Collision shapes", ["object", "is for", "capacity", "level", "spheres", "pieces", "keeps all"], rows)
    show("\n".join(f"{name}: {count}" for name, count in summary(results).items()))


def objects_in(files: list[Path]) -> Iterator[Path]:
    """Yield files; of a data set those in its manifest, of other folders URDFs, else meshes, else the folder itself."""
    from ..datasets.dataset import SUFFIXES, names_below, open_dataset
    from ..formats.files import is_broken_link

    for file in files:
        if not file.is_dir():
            yield file
            continue
        if (file / "manifest.csv").is_file():
            yield from (item.path for item in open_dataset(file).objects)
            continue
        inside = [path for path in names_below(file) if path.is_file() or is_broken_link(path)]
        found = [path for path in inside if path.suffix.lower() == ".urdf"]
        yield from found or [path for path in inside if path.suffix.lower() in SUFFIXES] or [file]


def write_table(path: Path, results: list[dict[str, Any]]):
    """Write all shapes of all objects as CSV."""
    from ..formats.files import write_csv

    rows = []
    for result in results:
        for row in shapes_of(result) or [{}]:
            rows.append([result["file"], *(row.get(name, "") for name in COLUMNS), result.get("error", "")])
    write_csv(path, ["file", *COLUMNS, "error"], rows)


def shapes_of(result: dict[str, Any]) -> list[dict[str, Any]]:
    """Return the rows of all shapes of an object, the best one last."""
    return [*result.get("shapes", []), *([result["best"]] if "best" in result else [])]


def print_shapes(results: dict[str, Any]):
    """Print the table of an object."""
    head = ["shape", "pieces", "faces", "build s", "step µs", "capacity", "level", "spheres", "moved mm"]
    names = ["name", "pieces", "faces", "build_seconds", "step_us"]
    names += ["capacity_kept", "level_kept", "settled_kept", "moved_mm"]
    table = [["" if row[name] is None else row[name] for name in names] for row in shapes_of(results)]
    holds = f", holds {results['capacity_ml']:.0f} ml" if results["capacity_ml"] else ""
    functions = [name for name, about in results["functions"].items() if about["member"]]
    seed = f"another seed keeps {results['seed_spread']:.2f}"
    title = f"{results['file']}: {', '.join(functions) or 'no function'}{holds}; {seed}"
    print_table(title, head, table)
    show("\n".join(f"{row['name']}: {row['verdict']}" for row in results["shapes"]))
    if "best" in results:
        show(f"written to {results['best']['file']}: {results['best']['name']}, {results['best']['verdict']}")
