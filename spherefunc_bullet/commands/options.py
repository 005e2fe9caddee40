"""Options that several subcommands share."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ..quantities import parse_lengths

if TYPE_CHECKING:
    from ..settling.records import Dropping

Backend = Annotated[str, typer.Option(help="Which simulator drops the spheres; see `spherefunc backends`.")]
Shape = Annotated[str | None, typer.Option(help="The bullet backend's collision shape.")]
Seed = Annotated[int, typer.Option(min=0, help="The same seed gives the same spheres.")]
Up = Annotated[str, typer.Option(help="Which axis of the file points up: z, y, x or auto.")]
Units = Annotated[str, typer.Option(help="What the file's numbers mean: m, cm, mm, in or auto.")]
Radii = Annotated[str, typer.Option(help="Sphere radii to choose from, such as 5mm,1cm,2cm.")]
Method = Annotated[str, typer.Option(help="default, or paper: Hinkle and Olson's method to the letter.")]
Jobs = Annotated[int, typer.Option(help="Processes that work at once; -1: one per core.")]
RunDir = Annotated[
    Path | None, typer.Option("--run", metavar="DIR", help="A run of `spherefunc batch`, whose results are used.")
]
Json = Annotated[bool, typer.Option("--json", help="Print JSON on stdout.")]

DEFAULT_RADII = "5mm,1cm,2cm,3cm,5cm"


def dropping(
    backend: str, shape: str | None, radii: str, seed: int, up: str, units: str, to_the_end: bool = False
) -> Dropping:
    """Return how spheres are dropped, as options say it."""
    from ..settling.records import Dropping, Loading
    from ..simulator import make_simulator

    simulator = make_simulator(backend, **simulator_options(shape))
    lengths = parse_lengths(radii)
    loading = Loading(up=up, units=units)
    return Dropping(simulator=simulator, radii=lengths, seed=seed, loading=loading, to_the_end=to_the_end)


def simulator_options(shape: str | None) -> dict:
    """Return the options that go to the simulator, those that were given."""
    return {} if shape is None else {"shape": shape}
