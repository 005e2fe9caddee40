"""A program that reads USD stages, each in a process of its own: damaged files can crash usd-core.

It takes a request a line on stdin, JSON: the ``path`` of a stage, ``out``, and ``names`` or ``colliders``, true or
false. A process that is forked for it, since loading usd-core takes half a second, writes a NumPy archive to ``out``,
with ``about`` (JSON) and the visible meshes as one: ``points`` (N, 3) in the stage's units and frame, the ``counts``
(P,) of corners of its polygons, and all their ``corners`` (C,). Clouds of points are only written if there is nothing
else. With ``colliders`` it writes what collides, seen or not, and ``about`` says how large each mesh is and what it
says to its engine; with ``names`` it writes the names of the files alone. Where it cannot, it writes why to ``out``.
The answer is a line on stdout: how that process ended, 0 with an archive. It imports nothing of this package.
"""

from __future__ import annotations

import json
import os
import resource
import signal
import sys
from collections.abc import Iterator
from typing import Any

import numpy as np
from pxr import Sdf, Usd, UsdGeom, UsdPhysics, UsdUtils

MOST_BYTES = 4 << 30  # of memory
MOST_SECONDS = 120
MOST_PRIMS = 100_000  # a small file can show billions, by references to references
FIRST = Usd.TimeCode.EarliestTime()  # of an animation
SOLIDS = ("Cube", "Sphere", "Cylinder", "Capsule", "Cone", "Cylinder_1", "Capsule_1")
POINT_BASED = ("Mesh", "TetMesh", "Points")
NO_SURFACES = ("Plane", "BasisCurves", "NurbsCurves", "HermiteCurves")  # the ground, and hair
Polygons = tuple[np.ndarray, np.ndarray, np.ndarray]  # points (N, 3), counts (P,), corners (C,)


def layers_of(path: str) -> tuple[list[str], list[str]]:
    """Return the files of a stage other than the first, and the names of those that are missing."""
    layers, _, missing = UsdUtils.ComputeAllDependencies(Sdf.AssetPath(path))
    files = {layer.realPath.partition("[")[0] for layer in layers}  # a package and its members are one file
    return sorted(files - {path}), sorted(name for name in missing if Sdf.FileFormat.FindByExtension(name))


def drawn_parts(stage: Usd.Stage) -> Iterator[Usd.Prim]:
    """Yield the meshes, clouds, solids and other surfaces of a stage, also those of instances."""
    for count, prim in enumerate(stage.Traverse(Usd.TraverseInstanceProxies(Usd.PrimDefaultPredicate))):
        if count == MOST_PRIMS:
            raise ValueError(f"more than {MOST_PRIMS:,} prims")
        if prim.IsA(UsdGeom.PointInstancer):
            raise ValueError(f"a PointInstancer, {prim.GetPath()}; save it with separate parts")
        if prim.IsA(UsdGeom.Gprim) and prim.GetTypeName() not in NO_SURFACES:
            yield prim


def is_visible(prim: Usd.Prim) -> bool:
    """Return whether a renderer shows a part."""
    shown = UsdGeom.Imageable(prim)
    return shown.ComputePurpose() in ("default", "render") and shown.ComputeVisibility(FIRST) != "invisible"


def collides(prim: Usd.Prim) -> bool:
    """Return whether a part is a collider."""
    return prim.HasAPI(UsdPhysics.CollisionAPI) and UsdPhysics.CollisionAPI(prim).GetCollisionEnabledAttr().Get(FIRST)


def collision_of(prim: Usd.Prim) -> dict[str, object]:
    """Return the path of the rigid body of a collider, whether forces move it, and how its mesh is approximated."""
    body = prim
    while body and not body.HasAPI(UsdPhysics.RigidBodyAPI):
        body = body.GetParent()
    moves = bool(body) and not UsdPhysics.RigidBodyAPI(body).GetKinematicEnabledAttr().Get(FIRST)
    shape = UsdPhysics.MeshCollisionAPI(prim).GetApproximationAttr()
    return {"body": str(body.GetPath()) if body else "", "moves": moves, "approximation": shape.Get(FIRST) or "none"}


def polygons_of(prim: Usd.Prim) -> Polygons:
    """Return the polygons of a mesh, before it is subdivided, counterclockwise seen from outside; of a cloud none."""
    if prim.GetTypeName() not in POINT_BASED:
        raise ValueError(f"a {prim.GetTypeName()}, {prim.GetPath()}; save it as a mesh")
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
    names = ("size", "radius", "height", "radiusTop", "radiusBottom")
    sizes = {name: prim.GetAttribute(name).Get(FIRST) for name in names if prim.HasAttribute(name)}
    if "radiusTop" in sizes:
        sizes["radius"], bottom = sizes.pop("radiusTop"), sizes.pop("radiusBottom")
        if sizes["radius"] != bottom:
            raise ValueError(f"a {prim.GetTypeName()} of two radii, {prim.GetPath()}; save it as a mesh")
    axis = prim.GetAttribute("axis").Get() if prim.HasAttribute("axis") else "Z"
    return {"kind": prim.GetTypeName().lower().removesuffix("_1"), "axis": axis, **sizes}


def box_around(points: np.ndarray) -> np.ndarray:
    """Return the corners (8, 3) of the bounding box of points (N, 3)."""
    return np.array(np.meshgrid(*zip(points.min(axis=0), points.max(axis=0), strict=True))).reshape(3, -1).T


def bounding_sphere(points: np.ndarray, transform: np.ndarray) -> dict[str, object]:
    """Return a sphere around the middle of points (N, 3), as a solid; ``transform`` (4, 4) is of rows."""
    place = np.eye(4)
    place[3, :3] = (points.min(axis=0) + points.max(axis=0)) / 2
    radius = float(np.linalg.norm(points - place[3, :3], axis=1).max())
    return {"kind": "sphere", "axis": "Z", "radius": radius, "transform": (place @ transform).T.tolist()}


def write_stage(path: str, out: str, names: bool, colliders: bool):
    """Write the archive."""
    files, missing = layers_of(path)
    about: dict[str, object] = {"files": files, "missing": missing}
    meshes: list[Polygons] = []
    if not names:
        stage, cache, solids = Usd.Stage.Open(path), UsdGeom.XformCache(FIRST), []
        if errors := stage.GetCompositionErrors():
            raise ValueError(f"{errors[0].rootSite.path} refers to what is not there or of another format")
        sizes: list[dict[str, object]] = []
        for prim in filter(collides if colliders else is_visible, drawn_parts(stage)):
            transform = np.array(cache.GetLocalToWorldTransform(prim))  # of rows: a point is multiplied from the left
            physics = collision_of(prim) if colliders else {}
            if prim.GetTypeName() in SOLIDS:
                solids.append({"transform": transform.T.tolist(), **solid_of(prim), **physics})
            elif physics.get("approximation") == "boundingSphere":
                solids.append(bounding_sphere(polygons_of(prim)[0], transform) | physics)
            else:
                points, counts, corners = polygons_of(prim)
                if physics.get("approximation") == "boundingCube":
                    points, counts, corners = box_around(points), *np.empty((2, 0), np.int64)
                moved = points @ transform[:3, :3] + transform[3, :3], counts, corners
                meshes.append(turned_over(moved) if np.linalg.det(transform[:3, :3]) < 0 else moved)
                sizes.append({"points": len(points), "polygons": len(counts), **physics})
        unit, up = UsdGeom.GetStageMetersPerUnit(stage), UsdGeom.GetStageUpAxis(stage)
        about |= {"metres": unit, "up": up, "solids": solids, "meshes": sizes}
        surfaces = [mesh for mesh in meshes if len(mesh[1])]
        meshes = surfaces if not colliders and (surfaces or solids) else meshes
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
    with open(out, "wb") as archive:
        np.savez(archive, about=np.array(json.dumps(about)), **written)


def answered(request: dict[str, Any]) -> int:
    """Do what a request asks for, in a process that ends then; return 0, or 1 if it wrote why it cannot."""
    os.dup2(2, 1)  # what usd-core prints is no answer
    resource.setrlimit(resource.RLIMIT_AS, (MOST_BYTES, MOST_BYTES))
    signal.alarm(MOST_SECONDS)
    try:
        write_stage(**request)
        return 0
    except MemoryError:
        why = f"it takes more than {MOST_BYTES >> 30} GiB of memory"
    except Exception as error:  # whatever damaged bytes raise is the answer; of usd-core's own, no line is for readers
        why = str(error) if isinstance(error, ValueError) else "usd-core cannot open it"
    with open(request["out"], "w", encoding="utf-8") as file:
        file.write(why)
    return 1


if __name__ == "__main__":
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the program that asks
    for line in sys.stdin:
        if not (child := os.fork()):
            os._exit(answered(json.loads(line)))
        sys.stdout.write(f"{os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])}\n")
        sys.stdout.flush()
