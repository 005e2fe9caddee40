"""``spherefunc demo``: all steps on the built-in catalogue, or a page on which to try objects."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from spherefunc_bullet.console import show


def demo(
    live: Annotated[bool, typer.Option("--live", help="Serve a page with sliders instead (extra `viser`).")] = False,
    port: Annotated[int, typer.Option(help="Port of the page, on this machine only.")] = 8080,
    out: Annotated[Path, typer.Option(help="Folder for the report and all other files.")] = Path("demo"),
    backend: Annotated[str, typer.Option(help="Simulator that drops the spheres.")] = "fast",
    jobs: Annotated[int, typer.Option(help="Number of parallel processes; -1: one per core.")] = -1,
):
    """Write a report on the built-in catalogue, or with --live serve a page on which to try objects."""
    if live:
        from ..demo.live import serve

        serve(port)
        return
    from ..demo.demo import run_demo

    path = run_demo(out, backend, jobs)
    show(f"\nThe report is in {path}, that on the simulators in {path.parent / 'comparison' / 'report.html'}.")
