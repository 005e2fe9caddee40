"""What collision shapes cost in the engine, and what is kept for it.

python -m spherefunc_bullet.compare.bench.shape_costs                                     # by faces, pieces, corners
spherefunc shapes FILES --coacd 0.2 --best --report out                                   # then, of real objects:
python -m spherefunc_bullet.compare.bench.shape_costs out --picture docs/images/shapes.svg
"""

from __future__ import annotations

import argparse
import json
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from spherefunc_bullet.console import print_table
from spherefunc_bullet.errors import InputError
from spherefunc_bullet.shapes.comparison import SPHERE
from spherefunc_bullet.shapes.solid import Solid, of_pieces, surface
from spherefunc_bullet.shapes.spheres import step_cost

from ..pages.plates import COLOURS, GREY, MARKERS, SINGLE, STYLE

THICK = 0.02  # of pieces, metres, as everything here of a square of one metre
SURFACES = ("mesh", "voxel")


def tessellated(count: int) -> Solid:
    """Return a square metre as triangles, so many cells along a side."""
    along = np.linspace(0, 1, count + 1)
    corners = np.stack(np.meshgrid(along, along, [0.0], indexing="ij"), axis=-1).reshape(-1, 3)
    first = (np.arange(count)[:, None] * (count + 1) + np.arange(count)).ravel()
    lower, upper = [first, first + count + 1, first + 1], [first + 1, first + count + 1, first + count + 2]
    return surface(f"{2 * count**2} faces", corners, np.vstack([np.column_stack(lower), np.column_stack(upper)]))


def tiled(count: int) -> Solid:
    """Return a slab of a square metre, cut into so many boxes along a side."""
    ends = np.linspace(0, 1, count + 1)
    sides = [ends[n : n + 2] for n in range(count)]
    boxes = [np.stack(np.meshgrid(x, y, [-THICK, 0.0]), axis=-1).reshape(-1, 3) for x in sides for y in sides]
    return of_pieces(f"{count**2} pieces of 8 corners", boxes)


def disc(corners: int) -> Solid:
    """Return one round piece around the same square."""
    angles = np.arange(corners // 2) * 4 * np.pi / corners
    ring = 0.5 + np.sqrt(0.6) * np.column_stack([np.cos(angles), np.sin(angles)])
    return of_pieces(
        f"1 piece of {corners} corners", [np.vstack([np.c_[ring, np.full(len(ring), z)] for z in (0, -THICK)])]
    )


def costs() -> Iterator[list[Any]]:
    """Yield shape, contacts of a sphere, and microseconds of a step with 50 spheres less one with them in the air."""
    grid = (np.arange(7) + 0.5) / 7
    centers = np.stack(np.meshgrid(grid, grid, [SPHERE]), axis=-1).reshape(-1, 3)
    air, _ = step_cost(tessellated(1), centers + [0, 0, 1e3 * SPHERE], SPHERE)
    shapes = [tessellated(n) for n in (1, 7, 20, 50, 100, 200)] + [tiled(n) for n in (1, 4, 8, 16, 32)]
    for solid in [*shapes, *map(disc, (8, 32, 64, 256, 1024))]:
        cost, contacts = step_cost(solid, centers, SPHERE)
        yield [solid.name, contacts, cost - air]


def measured(folder: Path) -> dict[str, list[dict[str, Any]]]:
    """Return the rows of each kind of shape over all objects of a report, with what they keep and cost."""
    kinds = defaultdict(list)
    for path in sorted((folder / "objects").glob("*.json")):
        result = json.loads(path.read_text())
        mesh = next(row for row in result["shapes"] if row["name"] == "mesh")
        chosen = result["best"] | {"name": "--best"} if "best" in result else {}
        for row in [*result["shapes"], *([chosen] if chosen else [])]:
            if not (mesh["step_us"] and row["step_us"]):
                continue
            shares = [row[name] for name in ("capacity_kept", "level_kept", "settled_kept")]
            kept = min(share for share in shares if share is not None)
            about = {"kept": kept, "cost": row["step_us"] / mesh["step_us"], "object": path.stem}
            kinds[kind_of(row["name"], result["file"])].append(row | about)
    if not kinds:
        raise InputError(f"{folder}: expected a report of `spherefunc shapes --report`, with mesh, found none")
    return kinds


def kind_of(name: str, file: str) -> str:
    """Return the kind of a shape; what an engine makes of a mesh that it loads is named for the file."""
    return "as loaded" if name == Path(file).stem else "voxel" if name.startswith("voxel") else name


def winners(kinds: dict[str, list[dict[str, Any]]], left_out: tuple[str, ...]) -> list[str]:
    """Return for each object the kind of its cheapest shape that keeps all, some kinds left out."""
    best: dict[str, tuple[float, str]] = {}
    for kind, rows in kinds.items():
        for row in rows if kind not in left_out else []:
            if row["keeps"]:
                best[row["object"]] = min(best.get(row["object"], (np.inf, "")), (row["cost"], kind))
    return [kind for _, kind in best.values()]


def kept_table(kinds: dict[str, list[dict[str, Any]]]) -> list[list[Any]]:
    """Return a line for each kind: what it keeps and costs, and of how many objects it is the cheapest that keeps all.

    Of all that may move, then without what ``--best`` finds; mesh and voxels are surfaces, which cannot move.
    """
    every, others = (winners(kinds, left_out) for left_out in (SURFACES, (*SURFACES, "--best")))
    table = []
    for kind, rows in kinds.items():
        medians = [np.median([row[name] for row in rows]) for name in ("kept", "pieces", "cost", "build_seconds")]
        keeps = np.mean([row["keeps"] for row in rows])
        about = [len({row["object"] for row in rows}), f"{keeps:.2f}", *(f"{median:.3g}" for median in medians)]
        table.append([kind, *about, every.count(kind), others.count(kind)])
    return table


def draw(kinds: dict[str, list[dict[str, Any]]], path: Path):
    """Draw kept against cost: objects pale, of each kind the mean kept at its median cost, and their front."""
    import matplotlib
    from matplotlib.figure import Figure

    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(1.6 * SINGLE, SINGLE), layout="constrained")
        axes, typical = figure.add_subplot(), []
        for number, (kind, rows) in enumerate(kinds.items()):
            look = {"color": COLOURS[number % len(COLOURS)], "marker": MARKERS[number // len(COLOURS)]}
            cost, kept = [row["cost"] for row in rows], [row["kept"] for row in rows]
            axes.scatter(cost, kept, s=5, alpha=0.3, linewidths=0, **look)
            typical.append((float(np.median(cost)), float(np.mean(kept))))
            axes.scatter(*typical[-1], s=34, label=kind, zorder=3, **look)
        front = [one for one in sorted(typical) if all(c > one[0] or k <= one[1] for c, k in typical)]
        axes.plot(*zip(*front, strict=True), color=GREY, linewidth=0.8, zorder=1)
        axes.set(xscale="log", xlabel="Cost of a step, times that of the mesh", ylabel="Kept (least of three shares)")
        figure.legend(loc="outside right center")
        figure.savefig(path, metadata={"Date": None})


def main():
    """Print what shapes cost, or what those of a report keep for it."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("report", nargs="?", type=Path)
    parser.add_argument("--picture", type=Path)
    arguments = parser.parse_args()
    if arguments.report is None:
        rows = [[name, f"{count:.2f}", f"{cost:.0f}"] for name, count, cost in costs()]
        print_table("What contacts of 50 spheres cost", ["shape", "contacts of a sphere", "µs per step"], rows)
        return
    kinds = measured(arguments.report)
    head = ["shape", "objects", "keep all", "kept", "pieces", "cost", "build s", "cheapest", "but --best"]
    print_table("Shapes of real objects, medians", head, kept_table(kinds))
    if arguments.picture:
        draw(kinds, arguments.picture)


if __name__ == "__main__":
    main()
