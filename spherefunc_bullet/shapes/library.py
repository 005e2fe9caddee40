"""Libraries: many objects, each compared in its own task, cached, and shown on one page."""

from __future__ import annotations

import base64
import hashlib
import io
import json
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from .. import __version__
from ..console import say, with_path
from ..errors import InputError, one_line
from ..formats.files import require_not_folder, write_bytes
from ..formats.sources import as_source
from ..processes.tasks import run_tasks
from ..viewer.page import page_html, viewer_file
from .compared import SAYS_COLLISION, Shapes, as_row, compare_shapes
from .comparison import NOTHING
from .loaded import collision_digest
from .solid import Solid

SUFFIX = {"urdf": ".urdf", "sdf": ".sdf", "mjcf": ".xml"}
PICTURE, QUALITY = (168, 132), 55  # pixels of each of two pictures; WebP quality: some 4 kB per object
ELEVATION = 42.0  # degrees, to look into vessels
KINDS = "a data set, URDFs or meshes"  # that a folder must hold
TIME = 600.0  # seconds: limit for one object of a library
USES = {  # by use: the objects, and what they do if they lose it or keep it, in words
    "vessel": ("vessels", "hold nothing", "still hold something"),
    "sittable": ("seats", "are no longer classified as seats", "are still classified as seats"),
    "table": ("tables", "do not carry at their level", "still carry at their level"),
}
Result = dict[str, Any]  # the comparison of one object, JSON-ready


@dataclass(frozen=True, kw_only=True)
class LibraryOptions:
    """How each object of a library is compared."""

    collision: Path | None = None
    shapes: bool = True  # whether candidates are compared too
    coacd: tuple[float, ...] = ()
    keep: float | None = None
    units: str = "m"
    up: str = "file"
    best: str | None = None  # the format in which the best shape is written
    still: bool = False
    out: Path = Path(".")
    root: Path | None = None  # absolute; the best shapes keep their objects' folders below it; None: they keep none
    picture: bool = False

    def best_file(self, file: Path) -> Path:
        """Return the file to which the best shape of an object is written."""
        name = Path(file.stem) if self.root is None else file.absolute().relative_to(self.root).with_suffix("")
        return self.out / name.parent / f"{name.name}{SUFFIX[self.best]}"

    def key(self, file: Path) -> str:
        """Return the name of the cached result for a file, from the content of all that is read."""
        digest = hashlib.sha256(f"{__version__} {file.absolute()} {sorted(asdict(self).items())}".encode())
        for part in (*as_source(file).digests(), collision_digest(self.collision or file)):
            digest.update(part)
        return f"{file.stem}-{digest.hexdigest()[:12]}.json"


def library_result(file: Path, options: LibraryOptions) -> Result:
    """Return the result of one object."""
    require_not_folder(file, KINDS)
    collision = options.collision
    if options.picture and collision is None and file.suffix.lower() not in SAYS_COLLISION:
        collision = file  # an engine would load the mesh itself
    how = {name: getattr(options, name) for name in ("shapes", "coacd", "keep", "units", "up")}
    compared = compare_shapes(file, collision, report=say, **how)
    if not compared.rows:
        raise InputError(f"{file}: expected a file with collision geometry, or --collision; got none to compare")
    result = compared.as_dict(str(file))
    if options.picture:
        result["picture"] = pictures(compared)
    if options.best:
        result["best"] = written(compared, file, options)
    return result


def kept_result(file: Path, options: LibraryOptions, cache: Path) -> Result:
    """Return the result of one object from the cache folder, where it is kept; called in a worker."""
    require_not_folder(file, KINDS)
    known = cache / options.key(file)
    with suppress(OSError, ValueError, TypeError):  # none is kept, or it is damaged
        result = json.loads(known.read_text(encoding="utf-8")) | {"file": str(file)}
        if "best" not in result or Path(result["best"]["file"]).is_file():
            return result
    result = library_result(file, options)
    write_bytes(known, json.dumps(result).encode())
    return result


def written(compared: Shapes, file: Path, options: LibraryOptions) -> Result:
    """Write the best shape of an object, and return its path and row, JSON-ready."""
    shape = compared.best_for(options.still)
    if not shape.row.keeps:
        say(f"{file.name}: none that was tried keeps everything; written is the one that keeps most")
    place = shape.write(options.best_file(file), options.best)
    return {"file": str(place)} | as_row(shape.row)


def pictures(compared: Shapes) -> str:
    """Return a picture of the visual mesh next to the first shape as the engine loads it, as WebP in base64."""
    from PIL import Image

    from ..viewer.pictures import CameraView, render

    view = CameraView(size=PICTURE, elevation_deg=ELEVATION)
    both = Image.new("RGB", (2 * PICTURE[0], PICTURE[1]))
    shown: list[Solid] = [compared.subject.mesh, compared.solids[0]]
    for number, solid in enumerate(shown):
        both.paste(render(solid.vertices, solid.faces, solid.vertices[:0], 1.0, view), (number * PICTURE[0], 0))
    buffer = io.BytesIO()
    both.save(buffer, "webp", quality=QUALITY)
    return base64.b64encode(buffer.getvalue()).decode()


def library_results(
    files: Sequence[Path], options: LibraryOptions, jobs: int = 1, cache: Path | None = None
) -> Iterator[Result]:
    """Yield the result of each object, errors as `{file, error}`, in the order of completion.

    With a cache folder, each object runs in its own process, and results that are in the folder are not computed again.
    CoACD runs in another process as well: Ctrl-C would wait until it ends, and it may take minutes.
    """
    if cache is None:
        isolate = bool(options.coacd)
        tasks = run_tasks(library_result, [(file, options) for file in files], files, jobs=jobs, isolate=isolate)
    else:
        each = [(file, options, cache) for file in files]
        tasks = run_tasks(kept_result, each, files, jobs=jobs, isolate=True, time_limit=TIME)
    for index, outcome in tasks:
        failed = isinstance(outcome, InputError)
        yield {"file": str(files[index]), "error": one_line(with_path(outcome, files[index]))} if failed else outcome


def loses(result: Result, name: str) -> bool | None:
    """Return whether the first shape of an object loses one of the `USES`; None if the object has no such use.

    The shape of a vessel holds nothing; that of a seat is not classified as a seat; that of a table lacks its level.
    """
    row = result["shapes"][0]
    if name == "vessel":
        return row["capacity_kept"] < NOTHING if result["capacity_ml"] else None
    if not result["functions"].get(name, {}).get("member"):
        return None
    return row["level_kept"] < result["keep"] if name == "table" else not row["functions"][name]["member"]


def summary(results: Sequence[Result]) -> dict[str, int]:
    """Return the number of objects, and how many of them lose each use."""
    read = [result for result in results if result.get("shapes")]
    counts = {"objects": len(read), "failed": len(results) - len(read)}
    counts["keep everything"] = sum(result["shapes"][0]["keeps"] for result in read)
    for name, (those, loss, _) in USES.items():
        lost = [lost for result in read if (lost := loses(result, name)) is not None]
        counts |= {those: len(lost), f"{those} that {loss}": sum(lost)} if lost else {}
    return counts


def counts_kept(results: Sequence[Result]) -> list[tuple[int, int, str]]:
    """Return, for each use that occurs, how many objects keep it, how many have it, and a description."""
    counts = summary(results)
    return [
        (counts[those] - counts[f"{those} that {loss}"], counts[those], f"{those} {kept}")
        for those, loss, kept in USES.values()
        if those in counts
    ]


def page(title: str, results: Sequence[Result]) -> str:
    """Return the page of a library."""
    from jinja2 import Environment, StrictUndefined

    environment = Environment(autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    template = environment.from_string(viewer_file("page.html", __package__))
    read = [result for result in results if result.get("shapes")]
    failed = [result for result in results if "error" in result]
    counts = {"counts": summary(results), "kept": counts_kept(results)}
    body = template.render(title=title, results=read, failed=failed, said=verdict_text, short=short, **counts)
    return page_html(title, [body], style="", kind="shapes")


def verdict_text(result: Result) -> str:
    """Return the functions of an object in words."""
    names = [name for name, about in result["functions"].items() if about["member"]]
    return ", ".join([*names, *(["vessel"] if result["capacity_ml"] and "cup" not in names else [])])


def short(result: Result) -> str:
    """Return the name of an object's file with its folder."""
    return "/".join(Path(result["file"]).parts[-2:])
