"""What each hand-set number of scan recognition changes: halved and doubled, on virtual rooms that nobody has learnt.

    python -m spherefunc_bullet.compare.rooms.sensitivity DATA [--folders pools] [--rooms 4] [--list] [--json]

Numbers are the constants of modules in four folders, and the fields of their settings. A compiled kernel keeps what it
was compiled with, so what only kernels read is left out. So are labels, which `range` numbers; what is computed from
other constants, which are listed; and zero, which is neither halved nor doubled. A number that changes no answer in
many rooms may go.
"""

from __future__ import annotations

import ast
import importlib
import pkgutil
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path
from typing import Annotated

import numpy as np
import typer

import spherefunc_bullet.scenes as scenes
from spherefunc_bullet.console import Failures, print_json, print_table, progress, run, show
from spherefunc_bullet.datasets.dataset import open_dataset
from spherefunc_bullet.errors import require_known
from spherefunc_bullet.function_model import FunctionModel
from spherefunc_bullet.learning.model_file import load_model, shipped_model
from spherefunc_bullet.scenes.recognition.recognition import recognise
from spherefunc_bullet.scenes.scans.scan import Scan
from spherefunc_bullet.scenes.virtual_rooms.lived_in import furnish_lived_in, parse_lived_in
from spherefunc_bullet.scenes.virtual_rooms.scans import VirtualScan, scan_room

from .matching import Counts, function_counts, match_parts

FOLDERS = ("scans", "segmentation", "pools", "recognition")
VIEWS = (3, 1, 5, 2)  # of the rooms, in turn
FACTORS = (0.5, 2.0)


@dataclass(frozen=True, kw_only=True)
class Number:
    """A constant of a module, or the default of a field of its settings."""

    module: str
    name: str  # ``_REACH`` or ``Segmentation.leaf_size``
    value: float

    @property
    def title(self) -> str:
        """Where it stands."""
        return f"{self.module.removeprefix(scenes.__name__ + '.')}.{self.name}"

    def holders(self) -> list[dict[str, object]]:
        """Return the tables that hold it: of its module and those that import it, or of its settings' defaults."""
        kind, _, name = self.name.rpartition(".")
        if kind:
            return [getattr(sys.modules[self.module], kind).__init__.__kwdefaults__]
        if name.startswith("_"):
            return [vars(sys.modules[self.module])]
        modules = [vars(one) for key, one in sys.modules.items() if key.startswith(f"{scenes.__name__}.")]
        return [one for one in modules if name in one and one[name] is self.value]

    @contextmanager
    def times(self, factor: float) -> Iterator[None]:
        """Have it multiplied for a while."""
        holders, name = self.holders(), self.name.rpartition(".")[2]
        try:
            for holder in holders:
                holder[name] = type(self.value)(self.value * factor)
            yield
        finally:
            for holder in holders:
                holder[name] = self.value


def numbers_of(folder: str) -> Iterator[Number]:
    """Yield the numbers of a folder's modules, those that only kernels read left out."""
    package = importlib.import_module(f"{scenes.__name__}.{folder}")
    for found in pkgutil.iter_modules(package.__path__, f"{package.__name__}."):
        module = importlib.import_module(found.name)
        tree = ast.parse(Path(module.__file__).read_text(encoding="utf-8"))
        kernels, others = names_read(tree, compiled=True), names_read(tree, compiled=False)
        for name in dict.fromkeys(name for node in tree.body for name in names_set(node)):
            kind, _, own = name.rpartition(".")
            value = getattr(getattr(module, kind) if kind else module, own, None)
            is_number = isinstance(value, int | float) and not isinstance(value, bool)
            if is_number and value != 0 and (own in others or own not in kernels):
                yield Number(module=found.name, name=name, value=value)


def names_set(node: ast.stmt) -> Iterator[str]:
    """Yield the names of what a statement of a module sets: constants, or fields of frozen settings."""
    if isinstance(node, ast.Assign) and not is_derived(node.value):
        names = [one.id for target in node.targets for one in ast.walk(target) if isinstance(one, ast.Name)]
        yield from (name for name in names if name.isupper())
    elif isinstance(node, ast.ClassDef):
        fields = [one for one in node.body if isinstance(one, ast.AnnAssign) and isinstance(one.value, ast.Constant)]
        yield from (f"{node.name}.{one.target.id}" for one in fields)


def is_derived(value: ast.expr) -> bool:
    """Return whether an expression numbers labels, or computes something from other constants."""
    names = [one.id for one in ast.walk(value) if isinstance(one, ast.Name)]
    return "range" in names or any(name.isupper() for name in names)


def names_read(tree: ast.Module, *, compiled: bool) -> set[str]:
    """Return the names that a module's functions read, those that are compiled or the others."""
    functions = [one for one in tree.body if isinstance(one, ast.FunctionDef | ast.ClassDef)]
    own = [one for one in functions if compiled == any("njit" in ast.unparse(way) for way in one.decorator_list)]
    return {part.id for one in own for part in ast.walk(one) if isinstance(part, ast.Name)}


def answers(scanned: Sequence[VirtualScan], model: FunctionModel) -> tuple[Counts, list[bytes]]:
    """Return how many functions are found, false and missed in rooms, and each room's answer to compare."""
    total, found = Counts(), []
    for scan in scanned:
        seen = scan.seen().tolist()
        room = recognise(Scan(name=scan.room.name, points=scan.points), model)
        given = {item.id: item.members for item in room.objects}
        truth = {number: scan.room.objects[number].item.functions for number in seen}
        matches = match_parts(scan.labels, room.labels, seen)
        total = sum((function_counts(matches, given, truth, name) for name in model.functions_), total)
        of_points = np.array(["+".join(sorted(given.get(k, ()))) for k in range(-3, len(room.objects))])
        found.append(of_points[room.labels + 3].tobytes())
    return total, found


def row_of(number: Number, scanned: Sequence[VirtualScan], model: FunctionModel, before: Sequence[bytes]) -> list[str]:
    """Return a line: the number, and what becomes of the rooms with it halved and doubled."""
    row = [number.title, f"{number.value:g}"]
    for factor in FACTORS:
        with number.times(factor):
            try:
                counts, after = answers(scanned, model)
            except Exception as error:  # a setting that nothing can be done with, which is an answer too
                row += ["-", "-", type(error).__name__]
                continue
        changed = sum(one != other for one, other in zip(after, before, strict=True))
        row += [str(counts.hits), str(counts.false_alarms), str(changed)]
    return row


def print_list(numbers: Sequence[Number]):
    """Print how many numbers there are in each file, and which."""
    for module, own in groupby(numbers, key=lambda number: number.module):
        values = [f"{number.name}={number.value:g}" for number in own]
        show(f"{len(values):3} {module.removeprefix(f'{scenes.__name__}.')}: {', '.join(values)}")
    show(f"{len(numbers)} hand-set numbers")


def main(
    data: Annotated[
        str, typer.Argument(help="Models that furnish the rooms, which the model for scans has not learnt.")
    ],
    folders: Annotated[str, typer.Option(help="Some of the four, with commas.")] = ",".join(FOLDERS),
    rooms: Annotated[int, typer.Option(min=1, help="How many.")] = 4,
    seed: Annotated[int, typer.Option(min=0)] = 0,
    listed: Annotated[bool, typer.Option("--list", help="Only list them, by file.")] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
):
    """Measure and print."""
    chosen, failures = folders.split(","), Failures()
    require_known("--folders", chosen, FOLDERS)
    numbers = [number for folder in chosen for number in numbers_of(folder)]
    if listed:
        print_list(numbers)
        return
    model = load_model(shipped_model("fast", scans=True))
    furnished = furnish_lived_in(
        open_dataset(data), rooms, seed=seed, failed=failures.add, lived_in=parse_lived_in("all=0.5")
    )
    scanned = [scan_room(room, VIEWS[k % len(VIEWS)], 1.0, seed) for k, room in enumerate(furnished)]
    counts, before = answers(scanned, model)
    rows = [row_of(number, scanned, model, before) for number in progress(numbers, len(numbers), "changing numbers")]
    columns = ["number", "value", *(f"{what}, x{by:g}" for by in FACTORS for what in ("found", "false", "changed"))]
    if as_json:
        print_json([dict(zip(columns, row, strict=True)) for row in rows])
    else:
        still = sum(row[4] == row[7] == "0" for row in rows)
        title = (
            f"{rooms} rooms: {counts.hits} found, {counts.false_alarms} false; {still} of {len(rows)} change nothing"
        )
        print_table(title, columns, rows)
    failures.exit()


if __name__ == "__main__":
    run(lambda: typer.run(main))
