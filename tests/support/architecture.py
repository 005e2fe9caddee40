"""The files that a first `classify mug.ply` runs through, counted and drawn (docs/architecture.md).

    python tests/support/architecture.py [--picture docs/images/architecture.svg]

What runs while modules are loaded, and kernels, which are compiled, are not counted.
"""

from __future__ import annotations

import inspect
import os
import sys
import tomllib
from collections.abc import Callable
from contextlib import redirect_stdout
from io import StringIO
from pathlib import Path
from tempfile import TemporaryDirectory
from types import FrameType
from typing import Annotated
from unittest.mock import patch

import typer

import spherefunc_bullet
from spherefunc_bullet.commands.command_line import application
from spherefunc_bullet.console import run, show
from spherefunc_bullet.datasets.catalogue import built_catalogue

ROOT = Path(spherefunc_bullet.__file__).parent
OURS, DECISION = "spherefunc_bullet.", "classification"
WIDTH, HEIGHT = 2.35, 0.5  # of a box with its margins, in units of the picture
ABREAST = 7  # boxes in a row


def traced(call: Callable[[], object]) -> dict[str, list[str]]:
    """Return the functions of this package that a call runs, by file, both in the order in which they are reached."""
    found: dict[str, list[str]] = {}

    def note(frame: FrameType, event: str, _: object):
        """Note a function as it is called."""
        name, module = frame.f_code.co_name, frame.f_globals.get("__name__", "")
        if event == "call" and module.startswith(OURS) and name[0] != "<" and not loads_module(frame):
            functions = found.setdefault(module.removeprefix(OURS), [])
            functions += [name] * (name not in functions)

    sys.setprofile(note)
    try:
        call()
    finally:
        sys.setprofile(None)
    return found


def loads_module(frame: FrameType | None) -> bool:
    """Return whether a frame is of a class's body, or runs because a module is loaded."""
    if not frame.f_code.co_flags & inspect.CO_OPTIMIZED:
        return True
    while frame is not None:
        if frame.f_code.co_name == "<module>" and frame.f_globals["__name__"] != "__main__":
            return True
        frame = frame.f_back
    return False


def files_of_classify() -> dict[str, list[str]]:
    """Return what a first `classify` of a mug runs through, see `traced`."""
    mug = built_catalogue("household").parent / "mug_01.ply"
    empty = TemporaryDirectory()
    with empty as cache, patch.dict(os.environ, SPHEREFUNC_CACHE=cache), redirect_stdout(StringIO()):
        return traced(lambda: application("classify")(["classify", str(mug)], standalone_mode=False))


def layers() -> list[str]:
    """Return the folders and modules of the package, the outermost first, as the import linter holds them."""
    contracts = tomllib.loads((ROOT.parent / "pyproject.toml").read_text())["tool"]["importlinter"]["contracts"]
    return [name.strip() for layer in contracts[0]["layers"] for name in layer.split("|")]


def draw(found: dict[str, list[str]], path: Path):
    """Draw a box for each file, a row for each layer, numbered in the order in which they are reached."""
    from matplotlib import rc_context
    from matplotlib.figure import Figure

    numbered = {place: number for number, place in enumerate(found, start=1)}
    rows = []
    for layer in layers():
        own = [place for place in found if place.split(".")[0] == layer]
        rows += [(layer if start == 0 else "", own[start : start + ABREAST]) for start in range(0, len(own), ABREAST)]
    figure = Figure(figsize=(0.72 * WIDTH * (ABREAST + 0.6), 0.72 * HEIGHT * len(rows)))
    axes = figure.add_axes((0, 0, 1, 1), xlim=(-1.4, WIDTH * ABREAST), ylim=(-HEIGHT * len(rows), 0))
    axes.set_axis_off()
    for row, (layer, places) in enumerate(rows):
        middle = -HEIGHT * (row + 0.5)
        axes.text(-1.35, middle, layer, va="center", fontsize=8, weight="bold")
        for column, place in enumerate(places):
            label = f"{numbered[place]}  {place.removeprefix(layer + '.') or layer}"
            style = {"boxstyle": "round,pad=0.35", "fc": "#ffe3b0" if place == DECISION else "#eef2f7"}
            axes.text(WIDTH * (column + 0.1), middle, label, va="center", fontsize=7.5, bbox=style | {"ec": "#8a94a3"})
    with rc_context({"svg.fonttype": "none", "svg.hashsalt": "architecture"}):
        figure.savefig(path, metadata={"Date": None} if path.suffix == ".svg" else None)


def main(picture: Annotated[Path | None, typer.Option(help="Draw them here, as SVG or PNG.")] = None):
    """Print the files that a first `classify` of a mug runs through, and their functions."""
    found = files_of_classify()
    for number, (place, names) in enumerate(found.items(), start=1):
        show(f"{number:2} {place}: {', '.join(names)}")
    show(f"{len(found)} files, {sum(map(len, found.values()))} functions")
    if picture is not None:
        draw(found, picture)


if __name__ == "__main__":
    run(lambda: typer.run(main))
