"""What objects are for, as tables: scores, sentences, and what decided about each function."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from ..console import print_table, say, show
from ..formats.units import format_length

Row = dict[str, Any]  # what the contract prints of one file
SHOWN = 4  # functions with a column of their own; of more, an object's best are named
BEST = 2  # functions that are named then


def members_of(row: Row) -> list[str]:
    """Return the functions that a file's object has."""
    return [name for name, membership in row["functions"].items() if membership["member"]]


def print_functions(rows: Sequence[Row], functions: Sequence[str], explain: bool):
    """Print what each object is for, with its scores, and how many files could not be classified."""
    done = [row for row in rows if "error" not in row]
    each_has_column = len(functions) <= SHOWN and table_width(done, functions) <= terminal_width()
    columns = ["file", "for", *(functions if each_has_column else ["best scores"])]
    table = [
        [Path(row["file"]).name, answer_text(row), *(scores_of(row) if each_has_column else [best_scores(row)])]
        for row in done
    ]
    print_table("What objects are for (scores; positive if > 0.5)", columns, table)
    if not explain:
        print_lying(done)
    if len(done) < len(rows) > 1:
        say(f"{len(rows) - len(done)} of {len(rows)} files could not be classified, as said above")
    for row in done if explain else []:
        print_reasons(row)
        for name in functions:
            if "quantities" in row:
                print_quantities(row, name)
            else:
                print_neighbors(row, name)
                print_cubes(row, name)


def print_lying(rows: Sequence[Row]):
    """Print which objects lie as a file does whose y axis points up."""
    from ..classification import LIES

    for row in rows:
        if LIES in row.get("reasons", ()):
            show(f"{Path(row['file']).name}: {LIES}")


def answer_text(row: Row) -> str:
    """Return an object's functions, and whether that is unsure."""
    return (", ".join(members_of(row)) or "none") + (", unsure" if row["unsure"] else "")


def scores_of(row: Row) -> list[str]:
    """Return an object's scores."""
    return [f"{membership['score']:.2f}" for membership in row["functions"].values()]


def best_scores(row: Row) -> str:
    """Return an object's best scores with what they are for, as many as a narrow table holds."""
    memberships = sorted(row["functions"].items(), key=lambda item: -item[1]["score"])
    return " ".join(f"{name} {membership['score']:.2f}" for name, membership in memberships[:BEST])


def table_width(rows: Sequence[Row], functions: Sequence[str]) -> int:
    """Return how many characters a table with a column for each function takes."""
    texts = [("file", "for", *functions)]
    texts += [(Path(row["file"]).name, answer_text(row), *scores_of(row)) for row in rows]
    return sum(max(map(len, column)) + 2 for column in zip(*texts, strict=True))


def terminal_width() -> int:
    """Return how many characters a line has; a pipe's has no end."""
    from rich.console import Console

    console = Console()
    return console.width if console.is_terminal else sys.maxsize


def print_reasons(row: Row):
    """Print one object's answer in sentences, and the training objects that are most like it."""
    if not row["reasons"]:
        return
    show(f"\n{Path(row['file']).name}")
    first, *others = row["reasons"]
    show(f"  {first}" if members_of(row) else f"  likeliest: {first}")
    for reason in others:
        show(f"  {reason}")
    if rejected := [f"{name} {one['score']:.2f}" for name, one in row["functions"].items() if not one["member"]]:
        show(f"  not {', '.join(rejected)}")
    if near := named_neighbors(row):
        show(f"  nearest training objects: {', '.join(near)}")


def named_neighbors(row: Row) -> list[str]:
    """Return the nearest training objects with their functions: agreeing ones, or all if unsure."""
    return [
        f"{near['name']} ({', '.join(near['functions']) or 'none'})"
        for near in row.get("nearest", [])
        if row["unsure"] or set(near["functions"]) == set(members_of(row))
    ]


def print_quantities(row: Row, name: str):
    """Print which quantities decided about one function of one object."""
    from ..learning.profiles.words import cells_of

    table = [cells_of(decided) for decided in row["quantities"][name]]
    title = f"\n{Path(row['file']).name}: why {name} {row['functions'][name]['score']:.2f}"
    print_table(title, ["quantity", "spheres", "here", "median learnt", "change without it"], table)


def print_neighbors(row: Row, name: str):
    """Print which training objects decided one function of one object."""
    table = [
        [
            neighbor["name"],
            format_length(neighbor["radius"]),
            "yes" if neighbor["member"] else "no",
            f"{neighbor['distance']:.2f}",
            f"{neighbor['weight']:.3f}",
        ]
        for neighbor in row["neighbors"][name]
    ]
    title = f"\n{Path(row['file']).name}: why {name} {row['functions'][name]['score']:.2f}, by nearest training objects"
    print_table(title, ["training object", "spheres", f"is {name}", "distance", "weight"], table)


def print_cubes(row: Row, name: str):
    """Print which cubes of space speak for and against one function of one object."""
    table = [
        [
            "for" if cube["share"] > 0 else "against",
            " ".join(f"{100 * (low + cube['side'] / 2):.1f}" for low in cube["corner"]),
            *(f"{cube[key]:.1f}" for key in ("spheres", "members", "others")),
            f"{abs(cube['share']):.0%}",
        ]
        for cube in row["cubes"][name]
    ]
    if table:
        first = row["cubes"][name][0]
        title = f"by cubes of {100 * first['side']:.3g} cm, spheres of {format_length(first['radius'])}"
        head = ["speaks", "middle x y z, cm", "spheres here", f"nearest {name}", "nearest others", "weight"]
        print_table(title, head, table)
