"""Examine places, and print what came out as JSON.

python -m spherefunc_bullet.compare.places put|seats|capacity|scans|proofs FOLDER
    [--headings FILE] [--every N] [--category NAME]
"""

from __future__ import annotations

import argparse
import csv
from pathlib import Path

import numpy as np

from spherefunc_bullet.clouds.cloud import load_cloud
from spherefunc_bullet.console import print_json, say


def main():
    """Run one exam."""
    parser = argparse.ArgumentParser(description="Examine places.")
    parser.add_argument("exam", choices=sorted(EXAMS))
    parser.add_argument("folder", type=Path)
    parser.add_argument("--headings", type=Path, default=Path("tests/seat_headings.csv"))
    parser.add_argument("--every", type=int, default=1)
    parser.add_argument("--category", help="put: objects of this category of the manifest in place of tables")
    options = parser.parse_args()
    print_json(EXAMS[options.exam](options))


def files_of(options: argparse.Namespace, label: str) -> list[Path]:
    """Return the files of one label, each so-and-so-many-th."""
    with (options.folder / "manifest.csv").open() as rows:
        asked = ("label", label) if options.category is None else ("category", options.category)
        return [options.folder / row["file"] for row in csv.DictReader(rows) if row[asked[0]] == asked[1]][
            :: options.every
        ]


def put(options: argparse.Namespace) -> dict[str, object]:
    """Set a mug, a bottle, a plate and a book down on bare and on laid tables."""
    from .putting import examined, laid, put_objects, summary

    objects, rng, bare, full = put_objects(options.folder), np.random.default_rng(0), [], []
    for file in files_of(options, "table"):
        table = load_cloud(file)
        bare.append(examined(table, objects, rng))
        if (with_others := laid(table, objects, rng)) is not None:
            full.append(examined(with_others, objects, rng))
        say(file.name)
    return {"tables": len(bare), "bare": summary(bare), "laid tables": len(full), "laid": summary(full)}


def seats(options: argparse.Namespace) -> dict[str, object]:
    """Compare headings with those labelled by hand, and heights with the catalogue's."""
    from .seats import seats_examined

    return seats_examined(options.folder, options.headings)


def capacity(options: argparse.Namespace) -> dict[str, object]:
    """Compare what vessels hold with a flood over voxels."""
    from spherefunc_bullet.places.pouring import pour_places

    from .capacity import water_ml

    rows = []
    for file in files_of(options, "cup"):
        cloud = load_cloud(file)
        found = pour_places(cloud)
        rows.append((file.name, round(found[0].capacity_ml, 1) if found else 0.0, round(water_ml(cloud), 1)))
    near = [abs(ours - water) <= 0.1 * water for _, ours, water in rows]
    return {"vessels": len(rows), "within a tenth": round(float(np.mean(near)), 3), "rows": rows}


def scans(options: argparse.Namespace) -> dict[str, object]:
    """Look at the places to put of real scans."""
    from .scans import scan_examined

    rows = [scan_examined(file) for file in sorted(options.folder.glob("*.ply"))[:: options.every]]
    total = {key: sum(row[key] for row in rows) for key in ("put", "put good", "inferred", "inferred good")}
    return {**total, "supported and free": round(total["put good"] / max(1, total["put"]), 3), "rows": rows}


def proofs(options: argparse.Namespace) -> dict[str, object]:
    """Say what proofs of seats buy across sources, and on copies on which nobody can sit."""
    from .proofs import proofs_examined

    return proofs_examined(options.folder, options.every)


EXAMS = {"put": put, "seats": seats, "capacity": capacity, "scans": scans, "proofs": proofs}

if __name__ == "__main__":
    main()
