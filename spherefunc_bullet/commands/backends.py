"""``spherefunc backends``: which simulators there are."""

from __future__ import annotations

from ..console import print_json, print_table
from ..errors import InputError
from .options import Json


def backends(json: Json = False):
    """List the simulators that are installed, with their versions and options."""
    from ..simulator import backend_entry_points

    rows = [description(name) for name in sorted(backend_entry_points())]
    if json:
        print_json(rows)
        return
    table = [[row["name"], row["version"] or "-", row["error"] or str(row["options"])] for row in rows]
    print_table("Backends", ["name", "version", "options"], table)


def description(name: str) -> dict:
    """Return what is known of a backend, also of one that cannot be imported."""
    from ..simulator import make_simulator

    try:
        simulator = make_simulator(name)
    except InputError as error:
        return {"name": name, "available": False, "version": None, "options": {}, "error": str(error)}
    return {
        "name": name,
        "available": True,
        "version": simulator.version,
        "options": simulator.options(),
        "error": None,
    }
