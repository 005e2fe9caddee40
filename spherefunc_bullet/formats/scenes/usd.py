"""USD, read by usd-core: the parts that a renderer shows, in metres and z up, as the stage states its unit and axis.

Meshes are read as they are before subdivision. Other processes read them, since damaged files can crash usd-core: one
program loads it, and is forked for each file. They read copies of the bytes that were hashed, in a folder where nothing
else is.
"""

from __future__ import annotations

import atexit
import json
import os
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from ...errors import explaining
from .. import FormatError
from ..sources import Geometry, Source, fan_triangles, inside
from .named_meshes import PACKAGE_PATH
from .parts import Part, joined, primitive, turned_over

_PROGRAM = Path(__file__).with_name("usd_stage.py")
_ASKING = threading.Lock()
# Rotations from the axis of trimesh's solids to that of USD's: the columns are where x, y and z go.
_AXES = {"X": [[0, 0, 1], [1, 0, 0], [0, 1, 0]], "Y": [[0, 1, 0], [0, 0, 1], [1, 0, 0]], "Z": np.eye(3)}
_UP = {"Y": np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]]), "Z": np.eye(3)}


@cache
def _reader(process: int) -> subprocess.Popen[str]:
    """Return the program that reads stages for a process of ours; one that is forked has a reader of its own."""
    command, environment = [sys.executable, "-P", str(_PROGRAM)], os.environ | {"OPENBLAS_NUM_THREADS": "1"}
    streams = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": subprocess.DEVNULL}
    reader = subprocess.Popen(command, env=environment, text=True, **streams)
    atexit.register(_end, reader)
    return reader


def _end(reader: subprocess.Popen[str]):
    reader.kill()
    reader.communicate()


def _ask(**request: str | bool) -> int:
    """Return how the process that read a stage ended."""
    if _reader(os.getpid()).poll() is not None:
        _reader.cache_clear()
    reader = _reader(os.getpid())
    try:
        print(json.dumps(request), file=reader.stdin, flush=True)
        return int(reader.stdout.readline())
    except BaseException:  # also Ctrl-C: what it answers later is not for the next request
        _reader.cache_clear()
        _end(reader)
        raise


def _stage(path: Path, *, names: bool = False, colliders: bool = False) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
    """Return what the program says about a stage, and its arrays; see `usd_stage`."""
    import pxr  # noqa: F401 - missing here, it is missing in the other process

    with TemporaryDirectory() as folder:
        out = Path(folder, "stage")
        with _ASKING, explaining("expected usd-core to read it, but its process ended", OSError, ValueError):
            code = _ask(path=str(path.resolve()), out=str(out), names=names, colliders=colliders)
        if code == -signal.SIGALRM:
            raise FormatError("expected a stage that is read in 2 minutes; simplify it")
        if code:
            why = out.read_text("utf-8")[:160] if code > 0 else "usd-core crashed on it"
            raise FormatError(f"expected a stage of USD, could not read it ({why}); is it damaged?")
        with np.load(out) as archive:
            arrays = dict(archive)
    return json.loads(str(arrays["about"])), arrays


def named_sources(source: Source) -> dict[str, Source]:
    """Return the other layers of the stage, by their paths; all must be below its folder or one of a package."""
    source.data  # noqa: B018 - refuses a pipe, which the other process would wait for
    about, _ = _stage(source.path, names=True)
    folder = source.path.parent.resolve()
    trees = [folder, *(Path(part).resolve() for part in os.environ.get(PACKAGE_PATH, "").split(os.pathsep) if part)]
    for name in about["missing"] + [name for name in about["files"] if inside(Path(name), trees) is None]:
        found = "is missing" if name in about["missing"] else "is elsewhere"
        places = f"put it there, or name its folder in {PACKAGE_PATH}"
        raise FormatError(f"expected the files that it refers to in its own folder, {name[-80:]!r} {found}; {places}")
    return {os.path.relpath(name, folder): Source(Path(name), "") for name in about["files"]}


@dataclass(frozen=True, kw_only=True)
class Collider:
    """A part of a stage that collides, metres, z up, and what the stage says that an engine makes of it."""

    body: str  # path of its rigid body; empty for a static collider
    moves: bool  # whether forces move that body
    approximation: str  # of a mesh, as UsdPhysics names it; a solid, a box and a sphere are convex
    part: Part


def read_usd(source: Source) -> Geometry:
    """Return the vertices (N, 3) in metres, z up, and triangles (M, 3)."""
    about, arrays = _copied_stage(source)
    parts = [_solid(**solid) for solid in about["solids"]]
    if len(arrays["points"]):
        parts.append((arrays["points"], fan_triangles(arrays["counts"], arrays["corners"])))
    return Geometry(*_placed(joined(parts), about))


def colliders(source: Source) -> Iterator[Collider]:
    """Yield the parts of a stage that collide, seen or not."""
    about, arrays = _copied_stage(source, colliders=True)
    points, counts, corners = (arrays[name] for name in ("points", "counts", "corners"))
    for mesh in about["meshes"]:
        own, polygons = mesh.pop("points"), mesh.pop("polygons")
        end = counts[:polygons].sum()
        part = points[:own], fan_triangles(counts[:polygons], corners[:end])
        yield Collider(**mesh, part=_placed(part, about))
        points, counts, corners = points[own:], counts[polygons:], corners[end:] - own
    for solid in about["solids"]:
        physics = {name: solid.pop(name) for name in ("body", "moves", "approximation")}
        yield Collider(**physics | {"approximation": "convexHull"}, part=_placed(_solid(**solid), about))


def _placed(part: Part | Geometry, about: dict[str, Any]) -> Part:
    """Return vertices and faces in a stage's unit and frame in metres, z up."""
    vertices, faces = part if isinstance(part, tuple) else (part.vertices, part.faces)
    return about["metres"] * vertices @ _UP[about["up"]].T, faces


def _copied_stage(source: Source, colliders: bool = False) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
    """Return what the program says about copies of a stage's files, which are all that it may read."""
    files = {part.path.resolve(): part.data for part in source.parts()}
    root = os.path.commonpath([path.parent for path in files])
    with TemporaryDirectory() as folder:
        copies = [Path(folder).resolve() / path.relative_to(root) for path in files]
        for copy, data in zip(copies, files.values(), strict=True):
            copy.parent.mkdir(parents=True, exist_ok=True)
            copy.write_bytes(data)
        about, arrays = _stage(copies[0], colliders=colliders)
    if others := [*about["missing"], *({*about["files"]} - {*map(str, copies)})]:
        raise FormatError(f"expected relative names of all other files, got {others[0][-80:]!r}; save it with these")
    return about, arrays


def _solid(kind: str, axis: str, transform: list[list[float]], **sizes: float) -> Part:
    """Return the vertices and faces of a solid in the stage's frame."""
    matrix = np.array(transform)
    if kind == "cube":
        vertices, faces = primitive("box", extents=3 * [sizes["size"]])
    elif kind == "sphere":
        vertices, faces = primitive("icosphere", radius=sizes["radius"])
    else:
        vertices, faces = primitive(kind, radius=sizes["radius"], height=sizes["height"])
        middle = {"cone": sizes["height"] / 2, "capsule": 0.0}.get(kind, 0.0)
        vertices = (vertices - [0, 0, middle]) @ np.transpose(_AXES[axis])
    return vertices @ matrix[:3, :3].T + matrix[:3, 3], turned_over(faces, matrix[:3, :3])
