"""Damaged files, many of them, for every reader: bits flipped, cut off, headers swapped, numbers made extreme.

By hand: ``python tests/support/fuzzing.py --files 10000`` (``make fuzz``) prints what became of them. Each is read in a
process of its own kind, that may take 5 s a file and 2 GiB, so that a crash, a hang and hunger are distinguished.
"""

from __future__ import annotations

import argparse
import json
import random
import struct
import sys
import tempfile
import time
import traceback
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

from cloud_files import USD_ENDINGS, cloud_bytes, mesh_bytes, missing_packages, mug

from spherefunc_bullet.clouds.cloud import load_cloud
from spherefunc_bullet.errors import InputError
from spherefunc_bullet.processes.tasks import run_tasks
from spherefunc_bullet.settling.settling import peak_bytes, reset_peak

MESHES = ("ply", "ply ascii", "obj", "stl", "stl ascii", "off", "glb", "gltf", "3ds", "npz", "dae", "3mf", "urdf")
MESHES += ("sdf", "xml", "mjcf", *USD_ENDINGS)
CLOUDS = ("pcd ascii", "pcd binary", "pcd binary_compressed", "xyz", "csv", "txt", "las", "laz", "npy")
KINDS = MESHES + CLOUDS
SECONDS, MEMORY = 5.0, 2 << 30  # what one file may take
EXTREMES = (0, 1, 2**15, 2**16 - 1, 2**31 - 1, 2**31, 2**32 - 1, 0x7FC00000, 0x7F800000, 0x7F7FFFFF)
WORDS = (b"-1", b"0", b"nan", b"inf", b"1e308", b"1e18", b"4294967295", b"99999999999999999999", b"\xff", b"x", b"")


def good(kind: str) -> bytes:
    """Return a whole file of a format."""
    vertices, faces = mug()
    if kind == "gltf":
        return as_gltf(mesh_bytes("glb", vertices, faces))
    return cloud_bytes(kind, vertices) if kind in CLOUDS else mesh_bytes(kind, vertices, faces)


def as_gltf(glb: bytes) -> bytes:
    """Return a GLB file as a glTF file that holds its buffer in itself."""
    import base64

    length = int.from_bytes(glb[12:16], "little")
    tree = json.loads(glb[20 : 20 + length])
    body = base64.b64encode(glb[28 + length :]).decode()
    tree["buffers"][0]["uri"] = f"data:application/octet-stream;base64,{body}"
    return json.dumps(tree).encode()


HERE = tuple(kind for kind in KINDS if not missing_packages(kind))  # what can be read with what is installed
GOOD = {kind: good(kind) for kind in HERE}


def damaged(kind: str, number: int) -> bytes:
    """Return a damaged file; the same number, the same damage."""
    chance = random.Random(f"{kind} {number}")
    data = GOOD[kind]
    for _ in range(chance.choice((1, 1, 1, 2, 5))):
        data = chance.choice(DAMAGES)(data or b"\0", chance)
    return data


def place(data: bytes, chance: random.Random) -> int:
    """Return a position, every other time in the header."""
    return chance.randrange(min(len(data), chance.choice((400, len(data)))))


def flip_bits(data: bytes, chance: random.Random) -> bytes:
    changed = bytearray(data)
    for _ in range(chance.choice((1, 1, 3, 30))):
        changed[place(data, chance)] ^= 1 << chance.randrange(8)
    return bytes(changed)


def cut(data: bytes, chance: random.Random) -> bytes:
    return data[: place(data, chance)]


def cut_out(data: bytes, chance: random.Random) -> bytes:
    at = place(data, chance)
    return data[:at] + data[at + chance.randrange(1, 200) :]


def repeat(data: bytes, chance: random.Random) -> bytes:
    at = place(data, chance)
    return data[:at] + data[at : at + 100] * chance.randrange(2, 20) + data[at:]


def swap_header(data: bytes, chance: random.Random) -> bytes:
    """Return the header of another file before the body of this one, or the other way round."""
    other, at = GOOD[chance.choice(HERE)], chance.choice((4, 20, 84, 150, 300))
    return other[:at] + data[at:] if chance.random() < 0.5 else data[:at] + other[at:]


def set_number(data: bytes, chance: random.Random) -> bytes:
    at = place(data, chance)
    value = struct.pack(chance.choice("<>") + "I", chance.choice(EXTREMES))
    return data[:at] + value + data[at + 4 :]


def set_word(data: bytes, chance: random.Random) -> bytes:
    words = data.split(b" ")
    words[chance.randrange(min(len(words), chance.choice((12, len(words)))))] = chance.choice(WORDS)
    return b" ".join(words)


DAMAGES = (flip_bits, cut, cut_out, repeat, swap_header, set_number, set_word)


def judge(kind: str, first: int, count: int, seconds: float) -> dict:
    """Read damaged files until so many are read or so many seconds of processor time are spent; called in a worker."""
    found, slowest = Counter(), (0.0, first)
    with tempfile.TemporaryDirectory() as scratch:
        path = Path(scratch) / f"model.{kind.split()[0]}"
        load(path, GOOD[kind])  # compiles and loads what it needs
        reset_peak()
        until = time.process_time() + seconds
        for number in range(first, first + count):
            started = time.process_time()  # a machine under load is not the file's fault; a standstill ends otherwise
            verdict = load(path, damaged(kind, number))
            found[verdict if verdict in ("loaded", "refused") else f"{verdict} (number {number})"] += 1
            slowest = max(slowest, (time.process_time() - started, number))
            if time.process_time() > until:
                break
    return {"kind": kind, "found": found, "slowest": slowest, "peak": peak_bytes() or 0}


def load(path: Path, data: bytes) -> str:
    """Return what becomes of a file: loaded, refused in one clear line, or what is wrong with us."""
    path.write_bytes(data)
    try:
        load_cloud(path)
    except InputError as error:
        clear = str(error).startswith((path.name, str(path))) and len(str(error).splitlines()) == 1
        return "refused" if clear else f"unclear: {error}"
    except Exception:
        return f"traceback: {traceback.format_exc().splitlines()[-1]}"
    return "loaded"


def fuzz(tasks: list[tuple], jobs: int = 1) -> Iterator[dict]:
    """Yield what `judge` finds for each task; a process that dies is a finding, too."""
    limits = {"time_limit": 60 * (SECONDS + max(task[3] for task in tasks)), "memory_limit": MEMORY}
    for index, outcome in run_tasks(judge, tasks, [task[0] for task in tasks], jobs=jobs, isolate=True, **limits):
        kind = tasks[index][0]
        lost = {"kind": kind, "found": Counter([f"{outcome} {tasks[index]}"]), "slowest": (SECONDS, 0), "peak": 0}
        yield lost if isinstance(outcome, InputError) else outcome


def main():
    """Print a table of what became of so many files."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--files", type=int, default=10_000)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--jobs", type=int, default=1)
    given = parser.parse_args()
    each = -(-given.files // len(HERE))
    tasks = [
        (kind, first, min(50, given.first + each - first), 600.0)
        for kind in HERE
        for first in range(given.first, given.first + each, 50)
    ]
    totals, wrong = {kind: [Counter(), (0.0, 0), 0] for kind in HERE}, []
    for result in fuzz(tasks, given.jobs):
        total = totals[result["kind"]]
        total[0] += result["found"]
        total[1:] = max(total[1], result["slowest"]), max(total[2], result["peak"])
        wrong += [f"{result['kind']}: {each}" for each in result["found"] if each not in ("loaded", "refused")]
    print(f"{'format':<24}{'files':>7}{'refused':>9}{'loaded':>8}{'other':>7}{'slowest s':>11}{'peak MiB':>10}")
    for kind, (found, slowest, peak) in totals.items():
        files, clear = found.total(), found["refused"] + found["loaded"]
        counted = f"{files:>7}{found['refused']:>9}{found['loaded']:>8}{files - clear:>7}"
        print(f"{kind:<24}{counted}{slowest[0]:>11.2f}{peak >> 20:>10}")
        wrong += [f"{kind}: {slowest[0]:.1f} s for number {slowest[1]}"] if slowest[0] > SECONDS else []
    print(f"{sum(total[0].total() for total in totals.values())} files, {len(wrong)} findings", *wrong, sep="\n")
    sys.exit(bool(wrong))


if __name__ == "__main__":
    main()
