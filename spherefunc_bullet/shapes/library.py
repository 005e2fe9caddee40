"""Many objects at once: each is asked about in its own task, kept, and shown on one page."""

from __future__ import annotations

import base64
import hashlib
import io
import json
import math
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from ..console import say
from ..errors import InputError, one_line
from ..formats.files import write_bytes
from ..processes.tasks import run_tasks
from ..viewer.page import page_html, viewer_file
from .compared import SAYS_COLLISION, Shapes, as_row, compare_shapes
from .rows import NOTHING
from .solid import Solid

SUFFIX = {"urdf": ".urdf", "sdf": ".sdf", "mjcf": ".xml"}
PICTURE, QUALITY = (168, 132), 55  # pixels of each of two; of WebP: some 4 kB an object
ELEVATION = 42.0  # degrees: into a vessel
TIME = 600.0  # seconds of one object of a library
USES = {  # what objects of a use are called, what those do that lose it, and those that keep it
    "vessel": ("vessels", "hold nothing", "still hold something"),
    "sittable": ("seats", "are no longer classified as seats", "are still classified as seats"),
    "table": ("tables", "do not carry at their level", "still carry at their level"),
}
Result = dict[str, Any]  # what is printed of an object, as JSON has it


@dataclass(frozen=True, kw_only=True)
class LibraryOptions:
    """What is asked of each object."""

    collision: Path | None = None
    shapes: bool = True  # beside the collision geometry
    coacd: tuple[float, ...] = ()
    keep: float | None = None
    units: str = "m"
    up: str = "file"
    best: str | None = None  # the format in which the best shape is written
    still: bool = False
    out: Path = Path(".")
    picture: bool = False

    def key(self, file: Path) -> str:
        """Return a name for the answer about a file as it is now."""
        about = file.stat()
        text = f"{file.absolute()} {about.st_size} {about.st_mtime_ns} {sorted(asdict(self).items())}"
        return f"{file.stem}-{hashlib.sha256(text.encode()).hexdigest()[:12]}.json"


def library_result(file: Path, options: LibraryOptions) -> Result:
    """Return what is printed of one object."""
    collision = options.collision
    if options.picture and collision is None and file.suffix.lower() not in SAYS_COLLISION:
        collision = file  # a mesh of a library is what an engine would load
    how = {
        "shapes": options.shapes,
        "coacd": options.coacd,
        "keep": options.keep,
        "units": options.units,
        "up": options.up,
    }
    compared = compare_shapes(file, collision, report=say, **how)
    result = compared.as_dict(str(file))
    if options.picture:
        result["picture"] = pictures(compared)
    if options.best:
        result["best"] = written(compared, file, options)
    return result


def written(compared: Shapes, file: Path, options: LibraryOptions) -> Result:
    """Write the best shape of an object, and return what is printed of it."""
    shape = compared.best_for(options.still)
    if not shape.row.keeps:
        say(f"{file.name}: none that was tried keeps everything; written is the one that keeps most")
    place = shape.write(options.out / f"{file.stem}{SUFFIX[options.best]}", options.best)
    return {"file": str(place)} | as_row(shape.row)


def pictures(compared: Shapes) -> str:
    """Return what is seen beside what the first shape is for the engine, as WebP in base64."""
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
    """Yield what is printed of each object, errors as `{file, error}`, in the order in which they are done.

    With a folder to keep them in, each is in a process of its own, and those that are there already are not done again.
    """
    left = []
    for file in files:
        known = None if cache is None else cache / options.key(file)
        if known is not None and known.is_file():
            yield json.loads(known.read_text(encoding="utf-8"))
        else:
            left.append((file, known))
    limit = math.inf if cache is None else TIME
    tasks = run_tasks(library_result, [(file, options) for file, _ in left], [file for file, _ in left], jobs=jobs,
                      isolate=cache is not None, time_limit=limit)  # fmt: skip
    for index, outcome in tasks:
        file, known = left[index]
        failed = isinstance(outcome, InputError)
        result = {"file": str(file), "error": one_line(outcome)} if failed else outcome
        if known is not None and not failed:
            write_bytes(known, json.dumps(result).encode())
        yield result


def loses(result: Result, name: str) -> bool | None:
    """Return whether an object's first shape loses one of the `USES`; None where the object has no such use.

    A vessel holds nothing any more; a seat is none by the model; the level of a table is elsewhere.
    """
    row = result["shapes"][0]
    if name == "vessel":
        return row["capacity_kept"] < NOTHING if result["capacity_ml"] else None
    if not result["functions"].get(name, {}).get("member"):
        return None
    return row["level_kept"] < result["keep"] if name == "table" else not row["functions"][name]["member"]


def summary(results: Sequence[Result]) -> dict[str, int]:
    """Return how many objects there are, and how many of them lose what they are for."""
    read = [result for result in results if result.get("shapes")]
    counts = {"objects": len(read), "failed": len(results) - len(read)}
    counts["keep everything"] = sum(result["shapes"][0]["keeps"] for result in read)
    for name, (those, loss, _) in USES.items():
        lost = [lost for result in read if (lost := loses(result, name)) is not None]
        counts |= {those: len(lost), f"{those} that {loss}": sum(lost)} if lost else {}
    return counts


def counts_kept(results: Sequence[Result]) -> list[tuple[int, int, str]]:
    """Return of each use that there is how many objects keep it, how many there are, and what they do."""
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
    """Return what an object is for, in words."""
    names = [name for name, about in result["functions"].items() if about["member"]]
    return ", ".join([*names, *(["vessel"] if result["capacity_ml"] and "cup" not in names else [])])


def short(result: Result) -> str:
    """Return an object's file with its folder."""
    return "/".join(Path(result["file"]).parts[-2:])
