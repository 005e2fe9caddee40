"""``spherefunc carry``: measure what an object keeps when it is tilted and shaken."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ..console import Failures, print_json, print_table, say, shown_names
from ..errors import blaming
from ..formats.units import format_length, parse_length, parse_numbers
from . import options

if TYPE_CHECKING:
    from ..clouds.cloud import Cloud
    from ..simulator import Simulator
    from ..simulator.mechanics import CarryResult, CarrySettings

Row = dict[str, Any]  # JSON entry of one file


def carry(
    files: options.Standing,
    angles: Annotated[str, typer.Option(help="Tilt angles in degrees, to every side.")] = "15,30,45",
    radius: Annotated[str | None, typer.Option(help="Radius of the spheres. Default: by the object's size.")] = None,
    spheres: Annotated[int, typer.Option(min=1, help="Maximum number of spheres.")] = 300,
    fill: Annotated[float, typer.Option(help="Fill level, as a share of what the object holds.")] = 0.9,
    haste: Annotated[float, typer.Option(help="Relative speed of tilting; 0.1 is ten times slower.")] = 1.0,
    shake: Annotated[str, typer.Option(help="Amplitude of shaking.")] = "1cm",
    frequency: Annotated[float, typer.Option(help="Frequency of shaking, Hz.")] = 3.0,
    friction: options.Friction = 0.5,
    restitution: options.Restitution = 0.0,
    density: Annotated[float, typer.Option(help="Density of the spheres, kg/m3.")] = 1000.0,
    backend: Annotated[str, typer.Option(help="A backend that can carry: bullet.")] = "bullet",
    seed: options.Seed = 0,
    up: options.Up = options.BY_FILE,
    units: options.Units = "m",
    package_path: options.PackagePath = None,
    picture: Annotated[
        Path | None, typer.Option(metavar="PNG", help="Plot the share that stays inside over the angle.")
    ] = None,
    json: options.Json = False,
):
    """Fill each object with spheres, tilt and shake it, and measure what share stays inside."""
    from ..simulator.mechanics import CarrySettings, require_ability
    from ..viewer.mechanics_pictures import TILTED, carry_tile, write_tiles

    options.require_drawings(files, picture)
    simulator = require_ability(backend, "carry")
    settings = CarrySettings(
        radius=None if radius is None else parse_length(radius),
        spheres=spheres,
        fill=fill,
        angles_deg=parse_numbers("--angles", angles, "degrees, such as 15,30,45"),
        haste=haste,
        shake=parse_length(shake),
        frequency=frequency,
        friction=friction,
        restitution=restitution,
        density=density,
    )
    failures, how = Failures(), (settings, seed, up, units)
    results = options.run_on_files(carried_file, files, simulator, how, "carrying", failures, picture is not None)
    rows = [row_of(file, result) for file, (_, result) in results]
    write_tiles([carry_tile(*carried) for _, carried in results if picture], picture, TILTED)
    print_json(rows) if json else print_shares(rows, settings.angles_deg)
    failures.exit()


def carried_file(
    file: Path, simulator: Simulator, settings: CarrySettings, seed: int, up: str, units: str
) -> tuple[Cloud, CarryResult]:
    """Return the cloud of a file, and what the object keeps."""
    from ..clouds.cloud import load_cloud
    from ..settling.settling import warn_of_gaps

    cloud = load_cloud(file, up=up, units=units, report=say)
    with blaming(f"{cloud.name}: backend {simulator.name!r}"):
        result = simulator.carry(cloud, settings, seed)
    warn_of_gaps(cloud, result.radius, say)
    return cloud, result if result.filled else with_water(cloud, result)


def with_water(cloud: Cloud, result: CarryResult) -> CarryResult:
    """Return a result without spheres with a note on the water that the object holds, as a bottle does."""
    from ..places.pouring import pour_places

    capacity = max((place.capacity_ml or 0.0 for place in pour_places(cloud)), default=0.0)
    if not capacity:
        return result
    spheres = f"no sphere of radius {format_length(round(result.radius, 4))} stays in it"
    note = f"{spheres}, though it holds {capacity:.0f} ml of water; try another --radius"
    return replace(result, notes=(note,))


def row_of(file: Path, result: CarryResult) -> Row:
    """Return the JSON entry of one file."""
    return {
        "file": str(file),
        "filled": result.filled,
        "radius": result.radius,
        "holds": round(result.holds, 4),
        "weight": round(result.weight, 4),
        "kept": [
            {"angle_deg": angle, "share": round(share, 4)}
            for angle, share in zip(result.angles_deg, result.kept, strict=True)
        ],
        "kept_shaken": round(result.kept_shaken, 4),
        "notes": list(result.notes),
        "seconds": round(result.seconds, 3),
        "provenance": result.provenance,
    }


def print_shares(rows: Sequence[Row], angles: Sequence[float]):
    """Print a line for each object."""
    table, shown = [], shown_names(row["file"] for row in rows)
    for row in rows:
        name = shown[row["file"]]
        options.say_notes(name, row["notes"])
        start = [name, str(row["filled"]), format_length(round(row["radius"], 4))]
        shares = [f"{step['share']:.2f}" for step in row["kept"]]
        table.append([*start, *shares, f"{row['kept_shaken']:.2f}"])
    head = ["file", "spheres", "radius", *(f"{angle:g}°" for angle in angles), "and shaken"]
    print_table("Share kept when tilted to all sides", head, table)
