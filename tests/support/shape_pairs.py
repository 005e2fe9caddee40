"""``python tests/support/shape_pairs.py DATA``: is a verdict of "lost" right?

Pairs of an object and a shape of which it is known, since it is made so, whether it keeps everything: cavity closed,
handle closed, seat filled, legs joined, all lowered by 2 cm; and copies whose surface is a little off, and hulls of
all triangles, which keep all.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator

import numpy as np
from scipy.spatial import Delaunay, cKDTree

from spherefunc_bullet.clouds.cloud import load_cloud
from spherefunc_bullet.console import print_table, say
from spherefunc_bullet.datasets.dataset import joined_datasets, open_dataset
from spherefunc_bullet.formats.sources import joined_meshes
from spherefunc_bullet.shapes.comparison import KeepCriteria, Subject, row_of
from spherefunc_bullet.shapes.solid import Solid, dense_points, hull_of, of_pieces, surface
from spherefunc_bullet.shapes.spaces import WIDE

LOWERED = 0.02  # metres
OFF = 0.0008  # of the extent: how far a copy's surface is off
FACES = 3_000  # at most, of what is cut in pieces
HANDLE = 1.15  # times the radius of the body: what lies beyond on one side is a handle
GAP, CELLS = 0.01, 80  # of the extent, between points on a surface; of a picture of a handle, along a side
Pair = tuple[str, bool, Solid]  # kind, whether something is lost, the shape


def joined(kind: str, subject: Subject, corners: np.ndarray) -> Solid:
    """Return an object's surface with the hull of some points added."""
    return surface(kind, *joined_meshes([(subject.mesh.vertices, subject.mesh.faces), hull_of(corners)]))


def box(low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Return the corners (8, 3) of a box."""
    return np.array([[a, b, c] for a in (low[0], high[0]) for b in (low[1], high[1]) for c in (low[2], high[2])])


def pairs(subject: Subject, label: str, random: np.random.Generator) -> Iterator[Pair]:
    """Yield the pairs of one object."""
    mesh, low, high = subject.mesh, subject.low, subject.high
    yield "copy", False, surface("copy", mesh.vertices + OFF * subject.extent * random.uniform(-1, 1, 3), mesh.faces)
    scaled = mesh.vertices * (1 + OFF * random.uniform(-1, 1, 3))
    yield "scaled", False, surface("scaled", scaled, mesh.faces)
    if len(mesh.faces) <= FACES:
        yield "cut in pieces", False, of_pieces("pieces", mesh.vertices[mesh.faces])
    middle, height = (low + high) / 2, subject.level.height
    if label == "cup":
        yield "cavity closed", True, joined("cavity closed", subject, mesh.vertices)
        rim = mesh.vertices[mesh.vertices[:, 2] > high[2] - 0.03 * (high - low)[2]]
        yield "lid on", True, joined("lid on", subject, rim)
        yield from handle_pairs(subject)
        return
    inner = 0.8 * (high - low)[:2] / 2
    legs = box(np.append(middle[:2] - inner, 0.0), np.append(middle[:2] + inner, 0.85 * height))
    yield "legs joined", True, joined("legs joined", subject, legs)
    yield "lowered", True, surface("lowered", mesh.vertices - [0, 0, LOWERED], mesh.faces)
    if label == "sittable":
        seat = box(np.append(middle[:2] - inner, height), np.append(middle[:2] + inner, height + 0.15))
        yield "seat filled", True, joined("seat filled", subject, seat)


def handle_pairs(subject: Subject) -> Iterator[Pair]:
    """Yield a vessel with its handle filled as wide as that is, and closed by a thin plate across the loop, if any."""
    if (found := handle_of(subject)) is not None:
        handle, wall, side = found
        across = np.vstack([handle, wall])
        across -= np.outer((across - handle.mean(axis=0)) @ side, side)
        plate = np.vstack([across + way * OFF * subject.extent * side for way in (-1, 1)])
        yield "handle filled", True, joined("handle filled", subject, handle)
        yield "handle closed", True, joined("handle closed", subject, plate)


def handle_of(subject: Subject) -> tuple[np.ndarray, np.ndarray, np.ndarray] | None:
    """Return points (N, 3) of a vessel's handle and of the wall behind it (M, 3), and the way through its loop (3,).

    None where there is none: where what lies beyond the rim lies all around, or a finger fits through nowhere.
    """
    points = dense_points(subject.mesh, GAP * subject.extent)
    rim = points[points[:, 2] > subject.high[2] - 0.03 * (subject.high - subject.low)[2], :2]
    middle, radius = np.median([rim.min(axis=0), rim.max(axis=0)], axis=0), np.ptp(rim, axis=0).min() / 2
    away = points[:, :2] - middle
    far = np.linalg.norm(away, axis=1) > HANDLE * radius
    way = away[far].mean(axis=0) if far.any() else np.zeros(2)
    if np.linalg.norm(way) < radius:
        return None
    way /= np.linalg.norm(way)
    out, side = away @ way, np.append(-way[1], way[0])
    handle = points[out > radius]
    between = (points[:, 2] > handle[:, 2].min()) & (points[:, 2] < handle[:, 2].max())
    wall = points[between & (np.abs(away @ side) < GAP * subject.extent) & (out > 0.7 * radius) & (out <= radius)]
    return (handle, wall, np.append(side, 0.0)) if loop_width(handle, wall, side) > 2 * WIDE * subject.extent else None


def loop_width(handle: np.ndarray, wall: np.ndarray, side: np.ndarray) -> float:
    """Return the diameter, metres, of the largest sphere that goes through between a handle and the wall behind it."""
    seen = np.vstack([handle, wall]) @ np.array([[-side[1], 0.0], [side[0], 0.0], [0.0, 1.0]])
    steps = [np.linspace(*ends, CELLS) for ends in zip(seen.min(axis=0), seen.max(axis=0), strict=True)]
    places = np.stack(np.meshgrid(*steps), axis=-1).reshape(-1, 2)
    inside = places[Delaunay(seen).find_simplex(places) >= 0]
    return 2 * float(cKDTree(seen).query(inside)[0].max())


def main():
    """Print how often each kind is said to be lost, and precision and recall."""
    parser = argparse.ArgumentParser(description="Is a verdict of lost right?")
    parser.add_argument("data", nargs="+")
    parser.add_argument("--each", type=int, default=5, help="objects of each label; of all cups the handles are asked")
    arguments = parser.parse_args()
    said: list[tuple[str, bool, bool]] = []
    random = np.random.default_rng(0)
    objects = joined_datasets([open_dataset(data) for data in arguments.data]).objects
    for label in ("cup", "sittable", "table"):
        of_label = [item for item in objects if label in item.functions]
        every = max(1, len(of_label) // arguments.each)
        for number, item in enumerate(of_label):
            whole = number % every == 0 and number // every < arguments.each
            subject = Subject(load_cloud(item.path))
            asked = pairs(subject, label, random) if whole else handle_pairs(subject) if label == "cup" else ()
            for kind, lost, solid in asked:
                row = row_of(subject, solid, KeepCriteria())
                said.append((kind, lost, not row.keeps))
                say(f"{item.path.name}, {kind}, {'right' if row.keeps != lost else 'WRONG'}: {row.verdict}")
    report(said)


def report(said: list[tuple[str, bool, bool]]):
    """Print how many pairs of each kind are said to have lost something, and precision and recall."""
    rows = []
    for kind in dict.fromkeys(kind for kind, *_ in said):
        own = [(lost, answer) for name, lost, answer in said if name == kind]
        rows.append([kind, len(own), "lost" if own[0][0] else "kept", sum(answer for _, answer in own)])
    print_table("Shapes said to have lost something", ["kind", "pairs", "is", "said lost"], rows)
    right = sum(lost and answer for _, lost, answer in said)
    precision = right / max(1, sum(answer for *_, answer in said))
    recall = right / max(1, sum(lost for _, lost, _ in said))
    print_table("Verdict", ["pairs", "precision", "recall"], [[len(said), round(precision, 3), round(recall, 3)]])


if __name__ == "__main__":
    main()
