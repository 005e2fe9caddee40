"""Are objects that are put at the places still there two seconds later, on bare tables and on laid ones?"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from spherefunc_bullet.clouds.cloud import Cloud, cloud_from_mesh, load_cloud
from spherefunc_bullet.places.finding import places_of
from spherefunc_bullet.places.place import Place

from .world import OwnWorld, Stayed

POSES = 20  # of each table and object, chosen at random


def put_objects(folder: Path) -> dict[str, Cloud]:
    """Return a mug, a bottle, a plate and a book."""
    import trimesh

    book = trimesh.creation.box((0.15, 0.21, 0.03))
    named = {"mug": "misc_pybullet_mug.ply", "bottle": "bs0_023_bottle.ply", "plate": "jsk_coffee-cup-saucer_plate.ply"}
    objects = {name: load_cloud(folder / file) for name, file in named.items()}
    return objects | {"book": cloud_from_mesh(book.vertices, book.faces, "book")}


def laid(table: Cloud, objects: dict[str, Cloud], rng: np.random.Generator) -> Cloud | None:
    """Return a table with a mug, a bottle and a book on it, as one mesh; None where they find no place."""
    vertices, faces = [table.mesh.vertices], [table.mesh.faces]
    for name in ("mug", "bottle", "book"):
        poses = [pose for place in put_on(table, objects[name]) for pose in place.poses]
        if not poses:
            return None
        pose, own = poses[rng.integers(len(poses))], objects[name].mesh
        faces.append(own.faces + sum(map(len, vertices)))
        vertices.append(own.vertices @ pose[:3, :3].T + pose[:3, 3])
    return cloud_from_mesh(np.vstack(vertices), np.vstack(faces), f"laid {table.name}")


def put_on(cloud: Cloud, put: Cloud) -> list[Place]:
    """Return where an object can be put."""
    return [place for place in places_of(cloud, put=put, scores={}) if place.kind == "put"]


def examined(cloud: Cloud, objects: dict[str, Cloud], rng: np.random.Generator) -> dict[str, Stayed | None]:
    """Return what becomes of each object at random poses on one table; None where there are no poses."""
    world, rows = OwnWorld(cloud), {}
    for name, put in objects.items():
        poses = [pose for place in put_on(cloud, put) for pose in place.poses]
        chosen = [poses[k] for k in rng.permutation(len(poses))[:POSES]]
        rows[name] = world.stayed(put, chosen) if chosen else None
    world.close()
    return rows


def summary(rows: Sequence[dict[str, Stayed | None]]) -> dict[str, dict[str, float]]:
    """Return for each object the poses asked, the share that stayed, those touched, and tables without a pose."""
    results = {}
    for name in rows[0] if rows else ():
        got = [row[name] for row in rows if row[name] is not None]
        asked = sum(one.asked for one in got)
        results[name] = {
            "poses": asked,
            "stayed": round(sum(one.stayed for one in got) / max(1, asked), 4),
            "touched": sum(one.touched for one in got),
            "without": sum(row[name] is None for row in rows),
        }
    return results
