"""``spherefunc demo``: all steps on the built-in catalogue, or a page on which to try objects."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from spherefunc_bullet.commands.options import require_beside
from spherefunc_bullet.console import show


def demo(
    live: Annotated[bool, typer.Option("--live", help="Serve a page with sliders instead (extra `viser`).")] = False,
    port: Annotated[
        int | None, typer.Option(min=1, max=65535, help="Port of the page, on this machine only. Default: 8080.")
    ] = None,
    out: Annotated[Path | None, typer.Option(help="Folder for the report and all other files. Default: demo.")] = None,
    backend: Annotated[str | None, typer.Option(help="Simulator that drops the spheres. Default: fast.")] = None,
    jobs: Annotated[int | None, typer.Option(help="Number of parallel processes. Default: one per core.")] = None,
):
    """Write a report on the built-in catalogue, or with --live serve a page on which to try objects."""
    require_beside("--live", live, {"--out": out, "--backend": backend, "--jobs": jobs}, {"--port": port})
    if live:
        from ..demo.live import serve

        serve(port or 8080)
        return
    from ..demo.demo import run_demo

    path = run_demo(out or Path("demo"), backend or "fast", -1 if jobs is None else jobs)
    show(f"\nThe report is in {path}, that on the simulators in {path.parent / 'comparison' / 'report.html'}.")
