"""Lessons on disk: rooms take many seconds to scan, and a classifier that learns of them few."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

import numpy as np

from spherefunc_bullet.errors import InputError
from spherefunc_bullet.formats import FormatError
from spherefunc_bullet.formats.npz import DAMAGE, read_arrays
from spherefunc_bullet.formats.writing import write_whole, writing
from spherefunc_bullet.learning.function_classifier import FunctionClassifier
from spherefunc_bullet.scenes.virtual_rooms.furnishing import VirtualRoom
from spherefunc_bullet.settling.cache import packed as npz_bytes
from spherefunc_bullet.settling.drops import drops_from_rows
from spherefunc_bullet.simulator import make_simulator

from .lesson import Lesson, Sight, record_of, room_lessons

FORMAT = 5  # of the files; another number, scanned anew
_SOURCE = "thing"  # what files call the source of a lesson
_RADIUS = "drops at "  # begins the name of the drops of a radius in metres


def kept_lessons(
    room: VirtualRoom, sight: Sight, model: FunctionClassifier, seed: int, folder: Path | None
) -> list[Lesson]:
    """Return what a room teaches, from a folder where it has it; else that is computed, and kept there.

    Raises
    ------
    InputError
        If the folder cannot be written, or holds a file of that name that cannot be read.
    """
    if folder is None:
        return room_lessons(room, sight, model, seed)
    path = folder / f"{room_hash(room, sight, model, seed)}.npz"
    if not path.is_file():
        write_lessons(path, room_lessons(room, sight, model, seed))
    return read_lessons(path)


def room_hash(room: VirtualRoom, sight: Sight, model: FunctionClassifier, seed: int) -> str:
    """Return the name of a room's lessons: the hash of all that decides them but the code that scans."""
    simulator = make_simulator(model.simulator)
    how = [simulator.name, simulator.version, simulator.options(), model.radii, model.drops, model.seed]
    digest = hashlib.sha256(json.dumps([FORMAT, room.name, asdict(sight), seed, how], default=str).encode())
    for placed in room.objects:
        digest.update(placed.item.path.name.encode() + placed.points.tobytes())
    return digest.hexdigest()[:24]


def write_lessons(path: Path, lessons: Sequence[Lesson]):
    """Write lessons as arrays, whole or not at all."""
    records = [one.record for one in lessons]
    arrays = {name: np.array([getattr(one, name) for one in lessons], str) for name in ("name", "source")}
    arrays[_SOURCE] = arrays.pop("source")
    arrays |= {name: np.array([getattr(one, name) for one in lessons], float) for name in ("overlap", "shown")}
    arrays["functions"] = np.array([";".join(sorted(one.functions)) for one in lessons], str)
    arrays["beside"] = np.array([one.beside for one in lessons], float)
    arrays["size"] = np.array([record.size for record in records], float).reshape(-1, 3)
    arrays |= packed("voxels", [record.voxels for record in records])
    for radius in records[0].settled if records else ():
        arrays |= packed(f"{_RADIUS}{radius!r}", [record.settled[radius].rows() for record in records])
    with writing(path):
        write_whole(path, npz_bytes(arrays))


def read_lessons(path: Path) -> list[Lesson]:
    """Return the lessons of a file.

    Raises
    ------
    InputError
        If it is none, or damaged.
    """
    try:
        return lessons_of(read_arrays(path))
    except (FormatError, *DAMAGE) as error:
        raise InputError(f"{path}: expected lessons of a room, as scan_model keeps them; cannot be read") from error


def lessons_of(arrays: dict[str, np.ndarray]) -> list[Lesson]:
    """Return lessons of the arrays of their file."""
    voxels = unpacked("voxels", arrays) if len(arrays["name"]) else []
    radii = [name.removeprefix(_RADIUS) for name in arrays if name.startswith(_RADIUS) and "," not in name]
    drops = {float(radius): unpacked(f"{_RADIUS}{radius}", arrays) for radius in radii}
    return [
        Lesson(
            name=str(name),
            source=str(arrays[_SOURCE][row]),
            functions=frozenset(filter(None, str(arrays["functions"][row]).split(";"))),
            overlap=float(arrays["overlap"][row]),
            shown=float(arrays["shown"][row]),
            beside=arrays["beside"][row],
            record=record_of(
                Path(str(name)),
                {"size": arrays["size"][row], "voxels": voxels[row]},
                {radius: drops_from_rows(radius, runs[row]) for radius, runs in drops.items()},
            ),
        )
        for row, name in enumerate(arrays["name"])
    ]


def packed(name: str, parts: Sequence[np.ndarray]) -> dict[str, np.ndarray]:
    """Return arrays of one width as one, and how long each is; nothing where there are none."""
    lengths = {f"{name}, lengths": np.array([len(part) for part in parts], int)}
    return lengths | {name: np.concatenate(parts)} if parts else {}


def unpacked(name: str, arrays: dict[str, np.ndarray]) -> list[np.ndarray]:
    """Return the arrays that `packed` was given."""
    return np.split(arrays[name], np.cumsum(arrays[f"{name}, lengths"])[:-1])
