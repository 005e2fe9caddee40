"""Receptacles for Habitat: writes an object's places to put, as polygons with holes, beside its `object_config.json`.

    pip install spherefunc-bullet shapely mapbox_earcut
    python3 habitat_receptacles.py table.glb table.object_config.json

Habitat-Lab reads what begins with ``receptacle_mesh_`` under ``user_defined``. Meshes are in the object's own frame, y
up as glTF has it.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np
import trimesh
from shapely.geometry import Polygon

import spherefunc_bullet as sf


def mesh_of(place: sf.Place) -> trimesh.Trimesh:
    """Return the triangles of a place's region, in the object's frame."""
    right = np.cross(place.normal, np.eye(3)[np.abs(place.normal).argmin()])
    right /= np.linalg.norm(right)
    plane = np.stack([right, np.cross(place.normal, right)])
    outline, *holes = [(ring - place.position) @ plane.T for ring in place.region]
    level, faces = trimesh.creation.triangulate_polygon(Polygon(outline, holes), engine="earcut")
    return trimesh.Trimesh(level @ plane + place.position, faces, process=False)


def add_receptacles(model: Path, config: Path) -> int:
    """Write a model's receptacles to its configuration, and a mesh for each beside that; return how many there are."""
    settings = json.loads(config.read_text()) if config.is_file() else {"render_asset": model.name}
    places = [place for place in sf.find_places(model, up="y") if place.kind == "put"]
    for number, place in enumerate(places):
        mesh = config.with_name(f"{model.stem}_receptacle_{number}.glb")
        mesh_of(place).export(mesh)
        settings.setdefault("user_defined", {})[f"receptacle_mesh_{model.stem}_{number}"] = {
            "name": f"receptacle_mesh_{model.stem}_{number}",
            "position": [0, 0, 0],
            "scale": [1, 1, 1],
            "up": [round(float(value), 4) for value in place.normal],
            "mesh_filepath": mesh.name,
        }
    config.write_text(json.dumps(settings, indent=2))
    return len(places)


if __name__ == "__main__":
    print(add_receptacles(Path(sys.argv[1]), Path(sys.argv[2])), "receptacles")
