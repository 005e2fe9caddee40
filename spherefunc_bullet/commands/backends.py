"""``spherefunc backends``: list the installed simulators."""

from __future__ import annotations

from typing import Any

from ..console import print_json, print_table, say
from ..errors import InputError
from .options import Json


def backends(json: Json = False):
    """List the simulators that are installed, with their versions and options."""
    from ..simulator import backend_entry_points

    rows = [description(name) for name in sorted(backend_entry_points())]
    if json:
        print_json(rows)
        return
    print_table("Backends", ["name", "version", "option", "default"], [line for row in rows for line in lines(row)])
    for row in rows:
        if row["error"]:
            say(row["error"])


def lines(row: dict[str, Any]) -> list[list[str]]:
    """Return the rows of a backend in the table, one for each option."""
    options = [[name, str(value)] for name, value in row["options"].items()] or [["", ""]]
    start = [row["name"], row["version"] or "not available"]
    return [(start if i == 0 else ["", ""]) + option for i, option in enumerate(options)]


def description(name: str) -> dict[str, Any]:
    """Return the version and options of a backend, or the error if it cannot be imported."""
    from ..simulator import make_simulator

    row = {"name": name, "available": False, "version": None, "options": {}, "error": None}
    try:
        simulator = make_simulator(name)
    except InputError as error:
        return row | {"error": str(error)}
    return row | {"available": True, "version": simulator.version, "options": simulator.options()}
