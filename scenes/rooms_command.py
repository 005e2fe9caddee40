"""``spherefunc dataset rooms``: virtual rooms and their scans, with the truth beside them."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from spherefunc_bullet.console import Failures, print_json, progress, say
from spherefunc_bullet.errors import InputError

WHOLE = "whole"

Views = Annotated[str, typer.Option(help="Kinect views that are fused, such as 3; or whole: all surfaces.")]
Noise = Annotated[float, typer.Option(min=0, help="Times a Kinect's noise; 0: none, and no pixel is lost.")]


def rooms(
    data: Annotated[str, typer.Argument(metavar="DATA", help="Meshes: a folder, or the name of a catalogue.")],
    directory: Annotated[Path, typer.Argument(help="Folder for scans, and for objects with a manifest.csv.")],
    count: Annotated[int, typer.Option("--rooms", min=1, help="How many rooms.")] = 10,
    views: Views = "3",
    noise: Noise = 1.0,
    seed: Annotated[int, typer.Option(min=0, help="Another seed, other rooms.")] = 0,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON to standard output.")] = False,
) -> None:
    """Furnish virtual rooms and scan them by a virtual Kinect; every point's owner is known."""
    from spherefunc_bullet.dataset import open_dataset

    from .partial_views import partial_views
    from .room_files import RoomFolder
    from .rooms import furnish

    failures, number, dataset = Failures(), parse_views(views), open_dataset(data)
    folder = RoomFolder(directory, dataset.name)
    for room in progress(furnish(dataset, count, seed=seed, failed=failures.add), count, "scanning rooms"):
        scan = scan_room(room, number, noise, seed)
        folder.write(scan, (cloud.points for _, cloud in partial_views(scan)))
    manifest = folder.close()
    about = {"scans": folder.scans, "objects": len(folder.rows), "manifest": str(manifest)}
    print_json(about) if as_json else say(f"{len(folder.scans)} scans of {len(folder.rows)} objects in {directory}")
    failures.exit()


def scan_room(room, views: int | None, noise: float, seed: int):
    """Return a room's scan: by so many views, or of whole surfaces; the same room and numbers, the same scan."""
    import numpy as np

    from .kinect import Kinect
    from .room_scans import seen_scan, whole_scan

    if views is None:
        return whole_scan(room)
    number = int(room.name.rpartition("_")[2])
    rng = np.random.default_rng([seed, number, views])
    return seen_scan(room, views, Kinect(noise=noise, dropouts=noise > 0), rng)


def parse_views(text: str) -> int | None:
    """Return a number of views, None for whole surfaces.

    Raises
    ------
    InputError
        If it is neither.
    """
    if text.strip() == WHOLE:
        return None
    try:
        views = int(text)
    except ValueError:
        views = 0
    if views < 1:
        raise InputError(f"--views {text}: expected a number from 1, or {WHOLE}")
    return views
