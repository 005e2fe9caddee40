"""``spherefunc stand``: whether objects stand, alone and with a load where spheres came to rest."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ..console import Failures, print_json, print_table, say, shown_names
from ..errors import blaming
from ..formats.units import format_length, format_mass, parse_length
from . import options

if TYPE_CHECKING:
    from ..clouds.cloud import Cloud
    from ..simulator import Simulator
    from ..simulator.mechanics import StandResult, StandSettings

Row = dict[str, Any]  # JSON entry of one file
BACKENDS = "fast computes statics, exact on level ground; bullet also simulates what tips, rolls or has a round bottom."


def stand(
    files: options.Standing,
    load: Annotated[
        str, typer.Option(help="Load that is put on each place in turn, such as 5kg; a person weighs 75kg.")
    ] = "5kg",
    radius: Annotated[
        str | None, typer.Option(help="Radius of the spheres that find the places. Default: by the object's size.")
    ] = None,
    backend: Annotated[str, typer.Option(help=BACKENDS)] = "fast",
    mass: options.Mass = None,
    area_density: options.AreaDensity = 5.0,
    friction: options.Friction = 0.5,
    restitution: options.Restitution = 0.0,
    seed: options.Seed = 0,
    up: options.Up = options.BY_FILE,
    units: options.Units = "m",
    package_path: options.PackagePath = None,
    picture: Annotated[
        Path | None, typer.Option(metavar="PNG", help="Draw the places that can carry the load.")
    ] = None,
    json: options.Json = False,
):
    """Find whether each object stands, and where it carries a load without tipping."""
    from ..formats.units import parse_mass
    from ..simulator.mechanics import StandSettings, require_ability
    from ..viewer.mechanics_pictures import LOADED, stand_tile, write_tiles

    options.require_drawings(files, picture)
    simulator = require_ability(backend, "stands")
    matter = options.matter_of(mass, area_density, friction, restitution)
    settings = StandSettings(load=parse_mass(load), matter=matter)
    length = None if radius is None else parse_length(radius)
    failures, how = Failures(), (settings, length, seed, up, units)
    results = options.run_on_files(stood_file, files, simulator, how, "standing", failures, picture is not None)
    write_tiles(
        [stand_tile(*stood, settings.load) for _, stood in results if picture],
        picture,
        LOADED.format(load=settings.load),
    )
    if json:
        print_json([row_of(file, result, settings) for file, (_, result) in results])
    else:
        print_stances([(file, result) for file, (_, result) in results], settings.load)
    failures.exit()


def stood_file(
    file: Path, simulator: Simulator, settings: StandSettings, radius: float | None, seed: int, up: str, units: str
) -> tuple[Cloud, StandResult]:
    """Return the cloud of a file, and how the object stands with a load where spheres came to rest."""
    from ..clouds.cloud import load_cloud
    from ..settling.resting_places import resting_places

    cloud = load_cloud(file, up=up, units=units, report=say)
    with blaming(f"{cloud.name}: backend {simulator.name!r}"):
        return cloud, simulator.stands(cloud, settings, resting_places(cloud, radius, seed), seed)


def row_of(file: Path, result: StandResult, settings: StandSettings) -> Row:
    """Return the JSON entry of one file, with null for infinite and unknown values."""
    return {
        "file": str(file),
        "stance": str(result.stance),
        "tilt_deg": finite(round(result.tilt_deg, 2)),
        "mass": round(result.mass, 4),
        "margin": finite(round(result.margin, 4)),
        "load": settings.load,
        "carries": result.share,
        "tipping_load": finite(round(result.tips_from, 3)),
        "places": [
            {"place": place.round(4).tolist(), "carries": bool(carries), "tipping_load": finite(round(float(tips), 3))}
            for place, carries, tips in zip(result.places, result.carries, result.tipping_load, strict=True)
        ],
        "notes": list(result.notes),
        "seconds": round(result.seconds, 3),
        "provenance": result.provenance,
    }


def finite(value: float) -> float | None:
    """Return a number, or None if it is infinite or NaN, which JSON does not have."""
    return value if math.isfinite(value) else None


def print_stances(results: Sequence[tuple[Path, StandResult]], load: float):
    """Print a line for each object."""
    table, shown = [], shown_names(file for file, _ in results)
    for file, result in results:
        name = shown[str(file)]
        options.say_notes(name, result.notes)
        tilt = f"{result.tilt_deg:.1f}°" if math.isfinite(result.tilt_deg) else ""
        margin = format_length(round(result.margin, 3)) if math.isfinite(result.margin) else "none"
        share = "" if result.share is None else f"{result.share:.2f}"
        cells = [tilt, format_mass(result.mass), margin, share, result.tipping_words]
        table.append([name, str(result.stance), *cells])
    head = ["file", "it", "tilt", "mass", "margin", "share of places that carry", "under a load"]
    print_table(f"Do they stand, and carry {load:g} kg where spheres came to rest?", head, table)
