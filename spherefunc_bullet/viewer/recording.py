"""Drops as a recording for Rerun's viewer: spheres come to rest along a timeline of drop numbers."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ..clouds.cloud import Cloud
from ..errors import explaining
from ..formats.files import writing
from ..simulator import DropResult, Outcome
from .colours import sphere_colours

if TYPE_CHECKING:
    from rerun import RecordingStream

TIMELINE = "drop"
FRAMES = 200  # most frames of one run; each holds all spheres settled so far
POINT = 0.001  # metres, radius of the points of an object


def write_recording(objects: Iterable[tuple[str, Cloud, Mapping[str, Iterable[DropResult]]]], path: Path) -> Path:
    """Write objects, each with its name and its results by backend, as a file for ``rerun FILE.rrd``.

    Raises
    ------
    InputError
        If the package is missing, or the file cannot be written.
    """
    with explaining("--rerun: expected the package rerun-sdk; pip install 'spherefunc-bullet[rerun]'", ImportError):
        import rerun
    stream = rerun.RecordingStream("spherefunc")
    with writing(path):
        path.open("ab").close()  # raises a clearer error than Rerun
        stream.save(path)
    stream.log("/", rerun.ViewCoordinates.RIGHT_HAND_Z_UP, static=True)
    for name, cloud, results in objects:
        stream.log(f"{name}/object", rerun.Points3D(cloud.points, radii=POINT, colors=[150, 150, 150]), static=True)
        for backend, runs in results.items():
            for result in runs:
                log_drops(stream, f"{name}/{backend}", result)
    stream.flush()
    stream.disconnect()
    return path


def log_drops(stream: RecordingStream, entity: str, result: DropResult):
    """Log the spheres of one run that have settled so far, at some of the drops that settled."""
    import rerun

    if not len(result.centers):
        return
    radius, numbers = result.provenance["settings"]["radius"], settled_drops(result)
    entity += f"/{1000 * radius:g}mm"
    colours = (255 * sphere_colours(result.centers[:, 2])).astype(np.uint8)
    for count in np.unique(np.linspace(1, len(numbers), FRAMES).astype(int)).tolist():
        stream.set_time(TIMELINE, sequence=int(numbers[count - 1]))
        stream.log(entity, rerun.Points3D(result.centers[:count], radii=radius, colors=colours[:count]))


def settled_drops(result: DropResult) -> np.ndarray:
    """Return the number of each drop that settled, (S,) int from 1; without outcomes, only settled drops count."""
    settled = np.flatnonzero(np.asarray(result.outcomes) == Outcome.SETTLED)
    return 1 + (settled if len(settled) == len(result.centers) else np.arange(len(result.centers)))
