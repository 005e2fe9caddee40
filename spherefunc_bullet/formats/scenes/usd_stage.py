"""A program that reads a USD stage and writes what is in it, in a process of its own: damaged files can crash usd-core.

``python usd_stage.py FILE [--names]`` writes a NumPy archive to stdout, with ``about`` (JSON) and the visible meshes as
one: ``points`` (N, 3) in the stage's units and frame, the ``counts`` (P,) of corners of its polygons, and all their
``corners`` (C,). Clouds of points are only written if there is nothing else. With ``--names`` it writes the names of
the files alone. It imports nothing of this package, so that it starts quickly.
"""

from __future__ import annotations

import io
import json
import sys
from collections.abc import Iterator
from contextlib import suppress

import numpy as np
from pxr import Sdf, Usd, UsdGeom, UsdUtils

MOST_BYTES = 4 << 30  # of memory
MOST_PRIMS = 100_000  # a small file can show billions, by references to references
FIRST = Usd.TimeCode.EarliestTime()  # of an animation
SOLIDS = ("Cube", "Sphere", "Cylinder", "Capsule", "Cone")
POINT_BASED = ("Mesh", "TetMesh", "Points")
Polygons = tuple[np.ndarray, np.ndarray, np.ndarray]  # points (N, 3), counts (P,), corners (C,)


def layers_of(path: str) -> tuple[list[str], list[str]]:
    """Return the files of a stage other than the first, and the names of those that are missing."""
    layers, _, missing = UsdUtils.ComputeAllDependencies(Sdf.AssetPath(path))
    files = {layer.realPath.partition("[")[0] for layer in layers}  # a package and its members are one file
    return sorted(files - {path}), sorted(name for name in missing if Sdf.FileFormat.FindByExtension(name))


def visible_parts(stage: Usd.Stage) -> Iterator[Usd.Prim]:
    """Yield the meshes, clouds and solids that a renderer shows, also those of instances."""
    for count, prim in enumerate(stage.Traverse(Usd.TraverseInstanceProxies(Usd.PrimDefaultPredicate))):
        if count == MOST_PRIMS:
            raise ValueError(f"more than {MOST_PRIMS:,} prims")
        if prim.IsA(UsdGeom.PointInstancer):
            raise ValueError(f"a PointInstancer, {prim.GetPath()}; save it with separate parts")
        shown = UsdGeom.Imageable(prim)
        drawn = prim.GetTypeName() in (*SOLIDS, *POINT_BASED)
        if drawn and shown.ComputePurpose() in ("default", "render") and shown.ComputeVisibility(FIRST) != "invisible":
            yield prim


def polygons_of(prim: Usd.Prim) -> Polygons:
    """Return the polygons of a mesh, before it is subdivided, counterclockwise seen from outside; of a cloud none."""
    mesh = UsdGeom.Mesh(prim)
    points = values(UsdGeom.PointBased(prim).GetPointsAttr(), np.float64).reshape(-1, 3)
    counts = values(mesh.GetFaceVertexCountsAttr(), np.int64)
    corners = values(mesh.GetFaceVertexIndicesAttr(), np.int64)
    if prim.IsA(UsdGeom.TetMesh):
        corners = np.array(UsdGeom.TetMesh.ComputeSurfaceFaces(UsdGeom.TetMesh(prim), FIRST), np.int64).ravel()
        counts = np.full(len(corners) // 3, 3)
    if counts.sum() != len(corners) or (len(corners) and not 0 <= corners.min() <= corners.max() < len(points)):
        raise ValueError(f"{prim.GetPath()}: faces of other points than its {len(points)}")
    left_handed = mesh.GetOrientationAttr().Get() == UsdGeom.Tokens.leftHanded
    return turned_over((points, counts, corners)) if left_handed else (points, counts, corners)


def values(attribute: Usd.Attribute, kind: type) -> np.ndarray:
    """Return an array of an attribute, empty without a value."""
    return np.array(attribute.Get(FIRST) or [] if attribute else [], kind)


def turned_over(polygons: Polygons) -> Polygons:
    """Return polygons that are seen from the other side."""
    points, counts, corners = polygons
    return points, counts[::-1], corners[::-1]


def solid_of(prim: Usd.Prim) -> dict[str, object]:
    """Return the kind of a solid, its sizes, and its axis."""
    sizes = {
        name: prim.GetAttribute(name).Get(FIRST) for name in ("size", "radius", "height") if prim.HasAttribute(name)
    }
    axis = prim.GetAttribute("axis").Get() if prim.HasAttribute("axis") else "Z"
    return {"kind": prim.GetTypeName().lower(), "axis": axis, **sizes}


def main(path: str, names_alone: bool):
    """Write the archive."""
    with suppress(ImportError):  # not on Windows
        import resource

        resource.setrlimit(resource.RLIMIT_AS, (MOST_BYTES, MOST_BYTES))
    files, missing = layers_of(path)
    about: dict[str, object] = {"files": files, "missing": missing}
    meshes: list[Polygons] = []
    if not names_alone:
        stage, cache, solids = Usd.Stage.Open(path), UsdGeom.XformCache(FIRST), []
        if errors := stage.GetCompositionErrors():
            raise ValueError(f"{errors[0].rootSite.path} refers to what is not there or of another format")
        for prim in visible_parts(stage):
            transform = np.array(cache.GetLocalToWorldTransform(prim))  # of rows: a point is multiplied from the left
            if prim.GetTypeName() in POINT_BASED:
                points, counts, corners = polygons_of(prim)
                moved = points @ transform[:3, :3] + transform[3, :3], counts, corners
                meshes.append(turned_over(moved) if np.linalg.det(transform[:3, :3]) < 0 else moved)
            else:
                solids.append(solid_of(prim) | {"transform": transform.T.tolist()})
        unit, up = UsdGeom.GetStageMetersPerUnit(stage), UsdGeom.GetStageUpAxis(stage)
        about |= {"metres": unit, "up": up, "solids": solids}
        surfaces = [mesh for mesh in meshes if len(mesh[1])]
        meshes = surfaces if surfaces or solids else meshes
    starts = np.cumsum([0, *(len(points) for points, _, _ in meshes)])
    written = {
        "points": np.concatenate([np.empty((0, 3)), *(points for points, _, _ in meshes)]),
        "counts": np.concatenate([np.empty(0, np.int64), *(counts for _, counts, _ in meshes)]),
        "corners": np.concatenate(
            [
                np.empty(0, np.int64),
                *(corners + start for (_, _, corners), start in zip(meshes, starts[:-1], strict=True)),
            ]
        ),
    }
    np.savez(archive := io.BytesIO(), about=np.array(json.dumps(about)), **written)
    sys.stdout.buffer.write(archive.getvalue())


if __name__ == "__main__":
    try:
        main(sys.argv[1], "--names" in sys.argv)
    except MemoryError:
        sys.exit(f"it takes more than {MOST_BYTES >> 30} GiB of memory")
    except Exception as error:  # whatever damaged bytes raise is the answer; of usd-core's own, no line is for readers
        sys.exit(str(error) if isinstance(error, ValueError) else "usd-core cannot open it")
