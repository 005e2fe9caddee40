"""``python -m spherefunc_bullet.compare.bench.shape_pairs DATA``: is a verdict of "lost" right?

Pairs of an object and a shape of which it is known, since it is made so, whether it keeps everything: cavity closed,
handle closed, seat filled, legs joined, all lowered by 2 cm; and copies whose surface is a little off, which keep all.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from spherefunc_bullet.clouds.cloud import load_cloud
from spherefunc_bullet.console import print_table, say
from spherefunc_bullet.datasets.dataset import open_dataset
from spherefunc_bullet.errors import InputError
from spherefunc_bullet.shapes.comparison import Subject, row_of
from spherefunc_bullet.shapes.rows import Kept
from spherefunc_bullet.shapes.solid import Solid, hull_of, surface

LOWERED = 0.02  # metres
OFF = 0.0008  # of the extent: how far a copy's surface is off
HANDLE = 1.15  # times the radius of the body: what lies beyond on one side is a handle
Pair = tuple[str, bool, Solid]  # kind, whether something is lost, the shape


def joined(kind: str, subject: Subject, corners: np.ndarray) -> Solid:
    """Return an object's surface with the hull of some points added."""
    points, faces = hull_of(corners)
    mesh = subject.mesh
    return surface(kind, np.vstack([mesh.vertices, points]), np.vstack([mesh.faces, faces + len(mesh.vertices)]))


def box(low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Return the corners (8, 3) of a box."""
    return np.array([[a, b, c] for a in (low[0], high[0]) for b in (low[1], high[1]) for c in (low[2], high[2])])


def pairs(subject: Subject, label: str, random: np.random.Generator) -> Iterator[Pair]:
    """Yield the pairs of one object."""
    mesh, low, high = subject.mesh, subject.low, subject.high
    yield "copy", False, surface("copy", mesh.vertices + OFF * subject.extent * random.uniform(-1, 1, 3), mesh.faces)
    scaled = mesh.vertices * (1 + OFF * random.uniform(-1, 1, 3))
    yield "scaled", False, surface("scaled", scaled, mesh.faces)
    middle, height = (low + high) / 2, subject.level.height
    if label == "cup":
        yield "cavity closed", True, joined("cavity closed", subject, mesh.vertices)
        if (handle := handle_of(mesh.vertices)) is not None:
            yield "handle closed", True, joined("handle closed", subject, handle)
        return
    inner = 0.8 * (high - low)[:2] / 2
    legs = box(np.append(middle[:2] - inner, 0.0), np.append(middle[:2] + inner, 0.85 * height))
    yield "legs joined", True, joined("legs joined", subject, legs)
    yield "lowered", True, surface("lowered", mesh.vertices - [0, 0, LOWERED], mesh.faces)
    if label == "sittable":
        seat = box(np.append(middle[:2] - inner, height), np.append(middle[:2] + inner, height + 0.15))
        yield "seat filled", True, joined("seat filled", subject, seat)


def handle_of(vertices: np.ndarray) -> np.ndarray | None:
    """Return the corners of a vessel that lie beyond its body on one side, or None if that is round."""
    rim = vertices[vertices[:, 2] > vertices[:, 2].max() - 0.03 * np.ptp(vertices[:, 2]), :2]
    center, radius = (rim.min(axis=0) + rim.max(axis=0)) / 2, np.ptp(rim, axis=0).mean() / 2
    away = vertices[:, :2] - center
    far = np.linalg.norm(away, axis=1) > HANDLE * radius
    if far.sum() < 20:
        return None
    direction = away[far].mean(axis=0)
    one_side = np.linalg.norm(direction) > radius
    side = away @ (direction / np.linalg.norm(direction)) > 0.95 * radius
    return vertices[side] if one_side else None


def main():
    """Print how often each kind is said to be lost, and precision and recall."""
    parser = argparse.ArgumentParser(description="Is a verdict of lost right?")
    parser.add_argument("data")
    parser.add_argument("--each", type=int, default=5, help="objects of each label")
    parser.add_argument("--without", default="", help="sources that are left out, comma-separated")
    arguments = parser.parse_args()
    said: list[tuple[str, bool, bool, str, str]] = []
    random, left_out = np.random.default_rng(0), arguments.without.split(",")
    objects = [item for item in open_dataset(arguments.data).objects if item.group not in left_out]
    for label in ("cup", "sittable", "table"):
        of_label = [item for item in objects if label in item.functions]
        for item in of_label[:: max(1, len(of_label) // arguments.each)][: arguments.each]:
            subject = Subject(load_cloud(item.path))
            for kind, lost, solid in pairs(subject, label, random):
                try:
                    row = row_of(subject, solid, Kept())
                except InputError as error:
                    say(f"{kind}: {error}")
                    continue
                said.append((kind, lost, not row.keeps, Path(item.path).name, row.verdict))
                say(", ".join(str(value) for value in said[-1]))
    report(said)


def report(said: list[tuple[str, bool, bool, str, str]]):
    """Print the table."""
    kinds = sorted({kind for kind, *_ in said})
    rows = []
    for kind in kinds:
        own = [answer for name, _, answer, *_ in said if name == kind]
        rows.append([kind, len(own), sum(own)])
    print_table("Shapes said to have lost something", ["kind", "pairs", "said lost"], rows)
    right = sum(lost and answer for _, lost, answer, *_ in said)
    precision = right / max(1, sum(answer for _, _, answer, *_ in said))
    recall = right / max(1, sum(lost for _, lost, *_ in said))
    print_table("Verdict", ["precision", "recall"], [[round(precision, 3), round(recall, 3)]])


if __name__ == "__main__":
    main()
