"""Benchmarks of places, printed as JSON.

python -m spherefunc_bullet.compare.places put|seats|sitters|capacity|scans|proofs|seconds FOLDER
    [--headings FILE] [--every N] [--category NAME] [--objects FOLDER]
"""

from __future__ import annotations

import argparse
import re
import time
from pathlib import Path

import numpy as np
import trimesh
from scipy import ndimage
from scipy.spatial import cKDTree

from spherefunc_bullet.clouds.cloud import Cloud, load_cloud
from spherefunc_bullet.console import print_json, run, say
from spherefunc_bullet.datasets.dataset import csv_table, open_dataset
from spherefunc_bullet.errors import explaining
from spherefunc_bullet.learning.model_file import inference_model, shipped_model
from spherefunc_bullet.places.finding import places_of
from spherefunc_bullet.places.place import Place
from spherefunc_bullet.places.pouring import pour_places
from spherefunc_bullet.scenes.recognition.partial_places import room_places
from spherefunc_bullet.scenes.recognition.recognition import recognise
from spherefunc_bullet.scenes.scans.scan import load_scan

from ..mechanics.sitting import SURE
from .proofs import copies_tried, proofs_benchmark, seconds_taken
from .putting import lay_object, put_benchmark, put_objects, summary

DISC, ABOVE, NEAR = 0.04, 0.15, 0.02  # metres: radius, free height, and how far from its level a point supports it
SUPPORTED = 0.9  # of the disc's area


def scan_benchmark(file: Path) -> dict[str, object]:
    """Return the numbers of places to put in a scan, and of those that are supported and free, and the seconds.

    Places on surfaces that were seen in part are counted separately, as inferred.
    """
    scan = load_scan(file)
    room = recognise(scan, inference_model(shipped_model("fast", scans=True), "fast"))
    started = time.perf_counter()
    found = [place for places in room_places(scan, room).values() for place in places]
    seconds = time.perf_counter() - started
    points = room.levelling.to_level(scan.points)
    some = points[np.random.default_rng(0).integers(len(points), size=2000)]
    spacing = float(np.median(cKDTree(points).query(some, k=2)[0][:, 1]))  # to the nearest other point, metres
    tree = cKDTree(points[:, :2])
    sits = sum(place.kind == "sit" for place in found)
    row: dict[str, object] = {"file": file.name, "sit": sits, "seconds": seconds}
    for kind, inferred in (("put", False), ("inferred", True)):
        put = [place for place in found if place.kind == "put" and place.inferred == inferred]
        middles = room.levelling.to_level(np.array([place.position for place in put]).reshape(-1, 3))
        good = [stands_free(points[tree.query_ball_point(middle[:2], 0.1)], middle, spacing) for middle in middles]
        row |= {kind: len(put), f"{kind} good": sum(good)}
    return row


def stands_free(near: np.ndarray, middle: np.ndarray, spacing: float) -> bool:
    """Return whether a disc at a place (3,) is supported by points (N, 3), and there are none above it."""
    steps = np.arange(-DISC, DISC + 1e-9, 0.01)
    offsets = np.stack(np.meshgrid(steps, steps), -1).reshape(-1, 2)
    disc = middle[:2] + offsets[np.linalg.norm(offsets, axis=1) <= DISC]
    carrying = near[np.abs(near[:, 2] - middle[2]) < NEAR]
    if not len(carrying):
        return False
    supported = cKDTree(carrying[:, :2]).query(disc)[0] <= max(0.01, 1.5 * spacing)
    over = near[np.linalg.norm(near[:, :2] - middle[:2], axis=1) < DISC, 2] - middle[2]
    return bool(supported.mean() >= SUPPORTED and not ((over > NEAR) & (over < ABOVE)).any())


WITHIN_DEG, WITHIN = 30.0, 0.03  # degrees, metres


def headings_by_hand(file: Path) -> dict[str, float | None]:
    """Return the heading of each model, None if it has no back."""
    rows = csv_table(file, "file", "heading_deg")
    with explaining(f"{file}: expected degrees or nothing as heading_deg; got", ValueError, why=" "):
        return {row["file"]: float(row["heading_deg"]) if row["heading_deg"] else None for row in rows}


def catalogue_heights(folder: Path) -> dict[str, float]:
    """Return the height of the seat of each model whose catalogue gives it, metres."""
    rows = csv_table(folder / "manifest.csv", "file", "label", "notes")
    notes = {row["file"]: row["notes"] for row in rows if row["label"] == "sittable"}
    found = {file: re.search(r"dropOnTopElevation ([\d.]+) cm", text) for file, text in notes.items()}
    return {file: float(match[1]) / 100 for file, match in found.items() if match}


def seats(options: argparse.Namespace) -> dict[str, object]:
    """Return the agreement of headings with hand labels, and of heights with the catalogue's, and all differences."""
    headings, heights = headings_by_hand(options.headings), catalogue_heights(options.folder)
    first: dict[str, Place | None] = {}
    for file in sorted({*headings, *heights}):
        first[file] = next(iter(places_of(load_cloud(options.folder / file), scores=SURE, only="sit")), None)
    backed = [file for file, heading in headings.items() if heading is not None]
    facing = [file for file in backed if faces(first[file], headings[file])]
    level = [file for file, height in heights.items() if first[file] and abs(first[file].height - height) <= WITHIN]
    return {
        "headings": len(backed),
        "within 30 degrees": round(len(facing) / len(backed), 3),
        "heights": len(heights),
        "within 3 cm": round(len(level) / len(heights), 3),
        "wrong headings": sorted(set(backed) - set(facing)),
        "wrong heights": sorted(set(heights) - set(level)),
    }


def faces(place: Place | None, heading: float) -> bool:
    """Return whether a place faces nearly a heading."""
    if place is None or place.heading_deg is None:
        return False
    return abs((place.heading_deg - heading + 180) % 360 - 180) <= WITHIN_DEG


CELLS = 110  # along the largest extent


def water_ml(cloud: Cloud) -> float:
    """Return the capacity of a mesh, millilitres: in each layer, cells that are enclosed at or below that layer.

    Walls are voxels that the surface meets; half of each wall voxel next to water is added.
    """
    mesh = trimesh.Trimesh(cloud.mesh.vertices, cloud.mesh.faces, process=False)
    pitch = float(cloud.size.max()) / CELLS
    wall = np.pad(mesh.voxelized(pitch).matrix, 2)
    wet, below = np.zeros_like(wall), np.zeros_like(wall)
    for layer in range(2, wall.shape[2] - 2):
        below[:, :, : layer + 1] = True
        dry = ndimage.label(~wall & below)[0]
        outside = dry[0, 0, 0]
        wet |= below & ~wall & (dry != outside) & open_above(wall, dry, outside, layer)
    halves = ndimage.binary_dilation(wet) & wall
    return float((wet.sum() + 0.5 * halves.sum()) * pitch**3 * 1e6)


def open_above(wall: np.ndarray, dry: np.ndarray, outside: int, layer: int) -> np.ndarray:
    """Return the cells of enclosed regions whose uppermost layer is open above somewhere."""
    sky = ~np.logical_or.accumulate(wall[:, :, ::-1], axis=2)[:, :, ::-1]
    named = np.unique(dry[:, :, layer][sky[:, :, layer] & (dry[:, :, layer] != outside)])
    return np.isin(dry, named[named > 0])


def main():
    """Run one benchmark of places."""
    parser = argparse.ArgumentParser(description="Run a benchmark of places.")
    parser.add_argument("benchmark", choices=sorted(BENCHMARKS))
    parser.add_argument("folder", type=Path)
    parser.add_argument("--headings", type=Path, default=Path("tests/places/seat_headings.csv"))
    parser.add_argument("--every", type=int, default=1)
    parser.add_argument("--category", help="put: objects of this category of the manifest instead of tables")
    parser.add_argument("--objects", type=Path, help="put: folder with the mug, the bottle and the plate")
    options = parser.parse_args()
    print_json(BENCHMARKS[options.benchmark](options))


def files_of(options: argparse.Namespace, label: str) -> list[Path]:
    """Return every n-th file of one label, or of the category of the options."""
    objects, category = open_dataset(str(options.folder)).objects, options.category
    chosen = [item for item in objects if (label in item.functions if category is None else item.category == category)]
    return [item.path for item in chosen[:: options.every]]


def put(options: argparse.Namespace) -> dict[str, object]:
    """Return the results of setting a mug, a bottle, a plate and a book down on bare and on laid tables."""
    objects, rng, bare, full = put_objects(options.objects or options.folder), np.random.default_rng(0), [], []
    for file in files_of(options, "table"):
        table = load_cloud(file)
        bare.append(put_benchmark(table, objects, rng))
        if (with_others := lay_object(table, objects, rng)) is not None:
            full.append(put_benchmark(with_others, objects, rng))
        say(file.name)
    return {"tables": len(bare), "bare": summary(bare), "laid tables": len(full), "laid": summary(full)}


def capacity(options: argparse.Namespace) -> dict[str, object]:
    """Return the capacities of vessels next to those of a flood over voxels."""
    rows = []
    for file in files_of(options, "cup"):
        cloud = load_cloud(file)
        found = pour_places(cloud)
        rows.append((file.name, round(found[0].capacity_ml, 1) if found else 0.0, round(water_ml(cloud), 1)))
    near = [abs(ours - water) <= 0.1 * water for _, ours, water in rows]
    return {"vessels": len(rows), "within a tenth": round(float(np.mean(near)), 3), "rows": rows}


def scans(options: argparse.Namespace) -> dict[str, object]:
    """Return the numbers of places to put in real scans."""
    rows = [scan_benchmark(file) for file in sorted(options.folder.glob("*.ply"))[:: options.every]]
    total = {key: sum(row[key] for row in rows) for key in ("put", "put good", "inferred", "inferred good")}
    return {**total, "supported and free": round(total["put good"] / max(1, total["put"]), 3), "rows": rows}


BENCHMARKS = {one.__name__: one for one in (put, seats, capacity, scans)} | {
    "proofs": lambda options: proofs_benchmark(options.folder),
    "sitters": lambda options: copies_tried(open_dataset(str(options.folder)).objects, options.every),
    "seconds": lambda options: seconds_taken(options.folder, options.every),
}

if __name__ == "__main__":
    run(main)
