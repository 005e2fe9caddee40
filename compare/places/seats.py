"""Do seats face the way that people say, and are they as high as their catalogue says?"""

from __future__ import annotations

import csv
import re
from pathlib import Path

from spherefunc_bullet.clouds.cloud import load_cloud
from spherefunc_bullet.places.finding import places_of
from spherefunc_bullet.places.place import Place

WITHIN_DEG, WITHIN = 30.0, 0.03  # degrees, metres


def headings_by_hand(file: Path) -> dict[str, float | None]:
    """Return the heading of each model, None where it has no back."""
    with file.open() as rows:
        return {row["file"]: float(row["heading_deg"]) if row["heading_deg"] else None for row in csv.DictReader(rows)}


def catalogue_heights(folder: Path) -> dict[str, float]:
    """Return the height of the seat of each model whose catalogue tells it, metres."""
    with (folder / "manifest.csv").open() as rows:
        notes = {row["file"]: row["notes"] for row in csv.DictReader(rows) if row["label"] == "sittable"}
    found = {file: re.search(r"dropOnTopElevation ([\d.]+) cm", text) for file, text in notes.items()}
    return {file: float(match[1]) / 100 for file, match in found.items() if match}


def seats_examined(folder: Path, by_hand: Path) -> dict[str, object]:
    """Return the shares of seats that face and are as high as they should, and which are not."""
    headings, heights = headings_by_hand(by_hand), catalogue_heights(folder)
    first = {file: best_seat(folder / file) for file in sorted({*headings, *heights})}
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


def best_seat(file: Path) -> Place | None:
    """Return the best place to sit on an object that is known as a seat."""
    found = [place for place in places_of(load_cloud(file), scores={"sittable": 1.0}) if place.kind == "sit"]
    return found[0] if found else None


def faces(place: Place | None, heading: float) -> bool:
    """Return whether a place faces nearly some way."""
    if place is None or place.heading_deg is None:
        return False
    return abs((place.heading_deg - heading + 180) % 360 - 180) <= WITHIN_DEG
