"""A table while it is being laid: still a table, object by object, until there is no more room."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

import spherefunc_bullet as sf
from spherefunc_bullet.clouds.cloud import Cloud, cloud_from_mesh
from spherefunc_bullet.console import progress
from spherefunc_bullet.datasets.catalogue import make_catalogue
from spherefunc_bullet.formats.units import parse_length
from spherefunc_bullet.scenes.impairment.specimen import Specimen
from spherefunc_bullet.scenes.impairment.surfaces import ObjectSurface
from spherefunc_bullet.scenes.impairment.use.cups import full
from spherefunc_bullet.scenes.impairment.use.placing import LoadedLevel, small_object
from spherefunc_bullet.settling.drops import RunLimit
from spherefunc_bullet.settling.settling import settle
from spherefunc_bullet.viewer.mechanics_pictures import captioned, write_picture
from spherefunc_bullet.viewer.pictures import CameraView, object_picture

from .gallery import tiled

SEED, NAME = 7, "dining_table_03"  # of a catalogue that no model has learnt
STEPS = (0, 1, 2, 4, 8)  # objects on the table
LAYING = 2  # the seed of the objects on it
DRAWN, FALLEN = parse_length("2cm"), RunLimit(drops=150)  # spheres in the picture: few, so that objects are seen


def laid_table() -> Iterator[tuple[str, Cloud]]:
    """Yield a table with more and more objects on it, and at last without a free hand's breadth."""
    mesh = next(item.mesh for item in make_catalogue("household", seed=SEED) if item.name == NAME)
    bare = cloud_from_mesh(mesh.vertices, mesh.faces, NAME)
    specimen, rng = Specimen(bare, "table"), np.random.default_rng(LAYING)
    placed = LoadedLevel(specimen.surface, specimen.level)
    for count in STEPS:
        while len(placed.parts) < count:
            placed.put(small_object(rng), rng)
        yield f"{count} objects" if count != 1 else "1 object", cloud_of(placed.joined() or specimen.surface)
    yield "full", cloud_of(full(specimen, rng))


def cloud_of(surface: ObjectSurface) -> Cloud:
    """Return a surface as a cloud on which spheres can be dropped."""
    vertices, faces = surface.mesh()
    return cloud_from_mesh(vertices, faces, NAME)


def write_laid_table(out: Path) -> Path:
    """Write ``laid_table.png``, pictures of the table with the answers of the model of the package; return its path."""
    steps = []
    for title, cloud in progress(laid_table(), len(STEPS) + 1, "laying a table"):
        rests = settle(cloud, "fast", [DRAWN], 0, FALLEN)[DRAWN].rests
        answer = sf.classify(cloud, backend="fast")
        name, unsure = "table" if "table" in answer.functions else "no table", " (unsure)" * answer.unsure
        words = f"{title}: {name}, {answer.scores['table']:.2f}{unsure}"
        steps.append(captioned(object_picture(cloud, rests, DRAWN, CameraView()), words, ""))
    return write_picture(tiled(steps), out / "laid_table.png")
