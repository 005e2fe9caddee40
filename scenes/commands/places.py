"""``spherefunc places``: where and how objects can be used."""

from __future__ import annotations

import re
import time
import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from spherefunc_bullet.commands import options
from spherefunc_bullet.console import Failures, print_json, print_table, show, shown_names
from spherefunc_bullet.errors import InputError
from spherefunc_bullet.formats.units import parse_length
from spherefunc_bullet.places.words import HEAD, lengths_in, place_columns

if TYPE_CHECKING:
    from spherefunc_bullet.clouds.cloud import Cloud
    from spherefunc_bullet.places.place import Place, Similarity
    from spherefunc_bullet.simulator import Simulator

Row = dict[str, Any]  # of one file, for JSON


def places(
    files: Annotated[list[Path], typer.Argument(metavar="FILE...", readable=False, help="Models or scans of objects.")],
    put: Annotated[
        Path | None, typer.Option(metavar="OBJECT", help="An object, in metres, for which poses are found.")
    ] = None,
    prove: Annotated[
        bool, typer.Option("--prove", help="Test the places by rigid bodies: sit down, put down, pour.")
    ] = False,
    person: Annotated[str, typer.Option(help="Height of the person who sits.")] = "1.75m",
    backend: Annotated[str, typer.Option(help="Simulator that tests places; fast can only propose them.")] = "bullet",
    seed: options.Seed = 0,
    up: options.Up = options.BY_FILE,
    units: options.Units = "m",
    package_path: options.PackagePath = None,
    picture: Annotated[Path | None, typer.Option(metavar="PNG", help="Draw each object with its places.")] = None,
    page: Annotated[Path | None, typer.Option(metavar="HTML", help="Write an interactive page of them.")] = None,
    json: options.Json = False,
):
    """Find the places where each object can be used: to sit, to put down and to pour."""
    from spherefunc_bullet.simulator import make_simulator
    from spherefunc_bullet.simulator.mechanics import require_ability
    from spherefunc_bullet.simulator.proofs import ProofSettings

    options.require_drawings([*files, *([put] if put else [])], picture, page)
    simulator = make_simulator(backend)
    if prove:
        require_ability(simulator, "prove")
    tall = ProofSettings(person=parse_length(person)).person
    with warnings.catch_warnings(action="ignore"):  # which come with each file
        read_put(put)  # one failure, not one for each file
    failures, how = Failures(), (put, prove, tall, up, units, seed)
    results = options.run_on_files(places_of_file, files, simulator, how, "finding places", failures)
    rows = [
        {"file": str(file), "places": [place.as_json() for place in found], "seconds": round(seconds, 3)}
        for file, (found, seconds) in results
    ]
    if results and (picture is not None or page is not None):
        draw([(file, found) for file, (found, _) in results], picture, page, up, units, tall)
    print_json(rows) if json else print_places(rows, units)
    failures.exit()


def read_put(put: Path | None) -> tuple[Cloud, Similarity] | None:
    """Return the object of ``--put``, see `cloud_and_frame`; it is in metres, whatever the unit of the others is."""
    from spherefunc_bullet.places.finding import cloud_and_frame

    if put is None:
        return None
    try:
        return cloud_and_frame(put)
    except InputError as error:
        raise InputError("--put " + re.sub(' units="[a-z]+"', " it is read in metres", str(error))) from error


def places_of_file(
    file: Path, simulator: Simulator, put: Path | None, prove: bool, person: float, up: str, units: str, seed: int
) -> tuple[list[Place], float]:
    """Return the places of one file's object, and the time that it took, seconds."""
    from ..recognition.objects import find_places

    started = time.perf_counter()
    tester = simulator.name if prove else None
    found = find_places(file, put, prove, person, backend=tester, up=up, units=units, seed=seed)
    return found, time.perf_counter() - started


def draw(
    found: Sequence[tuple[Path, Sequence[Place]]],
    picture: Path | None,
    page: Path | None,
    up: str,
    units: str,
    person: float,
):
    """Draw objects with their places, and a sitter of the given height, metres."""
    from spherefunc_bullet.formats.files import write_bytes
    from spherefunc_bullet.places.finding import cloud_and_frame
    from spherefunc_bullet.viewer.place_pictures import places_picture, write_places_page

    shown = [(*cloud_and_frame(file, up=up, units=units), places) for file, places in found]
    if picture is not None:
        named = [
            (cloud.name, cloud.points, [place.moved_back(to_input) for place in places])
            for cloud, to_input, places in shown
        ]
        write_bytes(picture, places_picture(named, person))
    if page is not None:
        write_places_page(shown, page, person, unit_of(units))


def print_places(rows: Sequence[Row], units: str):
    """Print a line for every place of every object, without places of low score."""
    from spherefunc_bullet.places.place import SHOWN, Proof

    table, unit, shown = [], unit_of(units), shown_names(row["file"] for row in rows)
    for row in rows:
        for number, place in enumerate(worth_showing(row["places"])):
            start = shown[row["file"]] if number == 0 else ""
            proof = Proof(**place["proven"]) if place["proven"] else ""
            table.append([start, *place_columns(place, unit), str(proof)])
    count = 1 + len(HEAD) + any(cells[-1] for cells in table)  # with the column of proofs if there is one
    title = f"Where objects can be used; {lengths_in(unit)}"
    print_table(title, ["file", *HEAD, "proof"][:count], [row[:count] for row in table])
    for row in rows:
        left = len(row["places"]) - len(worth_showing(row["places"]))
        if not row["places"]:
            show(f"{shown[row['file']]}: no place to sit, to put or to pour")
        elif left:
            which = "1 place" if left == 1 else f"{left} places"
            show(f"{shown[row['file']]}: not shown, {which} with a score below {SHOWN}; --json has all")


def unit_of(units: str) -> str:
    """Return the unit of the lengths that are printed; nothing if the file's unit is not known."""
    return "" if units == "auto" else units


def worth_showing(places: Sequence[Row]) -> list[Row]:
    """Return the places that are printed."""
    from spherefunc_bullet.places.place import SHOWN

    return [place for place in places if place["score"] >= SHOWN]
