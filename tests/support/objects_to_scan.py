"""A small data set of boxes and slabs, whose sizes are known, to furnish virtual rooms with."""

from __future__ import annotations

from pathlib import Path

import trimesh

from spherefunc_bullet.datasets.catalogue import COLUMNS, write_manifest

THINGS = {  # name: extents in metres, label; a table's top is a slab on four posts
    "desk": ((0.9, 0.6, 0.74), "table"),
    "stand": ((0.7, 0.7, 0.6), "table"),
    "seat": ((0.5, 0.5, 0.9), "sittable"),
    "bench": ((0.8, 0.3, 0.5), "sittable"),
    "chest": ((0.6, 0.4, 0.5), "none"),
    "mug": ((0.08, 0.08, 0.1), "cup"),
    "tin": ((0.1, 0.2, 0.06), "none"),
    "pen": ((0.01, 0.15, 0.01), "none"),
    "bus": ((9.0, 2.5, 3.0), "none"),
}


def slab_on_posts(width, depth, height):
    top = trimesh.creation.box((width, depth, 0.04))
    top.apply_translation([0, 0, height - 0.02])
    posts = [trimesh.creation.box((0.05, 0.05, height)) for _ in range(4)]
    for post, (x, y) in zip(posts, [(1, 1), (1, -1), (-1, 1), (-1, -1)], strict=True):
        post.apply_translation([x * (width / 2 - 0.05), y * (depth / 2 - 0.05), height / 2])
    return trimesh.util.concatenate([top, *posts])


def write_objects(folder: Path, names=tuple(THINGS)) -> Path:
    """Write objects as meshes with a manifest; return the folder."""
    for name in names:
        size, label = THINGS[name]
        mesh = slab_on_posts(*size) if label == "table" else trimesh.creation.box(size)
        mesh.export(folder / f"{name}.ply")
    write_manifest(folder, COLUMNS, [(f"{name}.ply", THINGS[name][1], "", name, "test") for name in names])
    return folder
