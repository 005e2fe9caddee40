"""Collision shapes into the engine, and a look at what has arrived there.

Through files, since meshes passed as lists leak and are cut off at 131,072 vertices; under names that are new each
time, since the engine remembers files by name.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from ..clouds.cloud import corners_of
from ..errors import InputError, explaining
from .collision.shape import CollisionShape
from .engine import pybullet

RAYS = 2_000  # that look whether a shape has arrived, where one of the first few misses
FIRST_RAYS = 200
SHORT = 0.05  # radii: half the length of a ray through a face
LONG = 2.0  # radii: the same through convex pieces, which do not see a ray that starts inside them
MISSING = 0.01  # of the rays may miss: those along edges, by rounding
# What is to be seen is a small box: without it the engine would tessellate every sphere.
URDF = """<robot name="rest">
<link name="rest">
<inertial><mass value="0"/><inertia ixx="0" ixy="0" ixz="0" iyy="0" iyz="0" izz="0"/></inertial>
<visual><geometry><box size="0.1 0.1 0.1"/></geometry></visual>
{spheres}</link>
</robot>"""


def load_shape(shape: CollisionShape, scale: float, client: int) -> int:
    """Return the engine's number of a collision shape.

    Raises
    ------
    InputError
        If the engine refuses it.
    """
    p = pybullet()
    with TemporaryDirectory(prefix="spherefunc-") as folder:
        if shape.pieces is None:
            path = Path(folder) / f"{Path(folder).name}.stl"
            write_stl(path, shape.vertices * scale, shape.faces)
            flags = p.GEOM_FORCE_CONCAVE_TRIMESH
        else:
            path = Path(folder) / f"{Path(folder).name}.obj"
            write_groups(path, [piece * scale for piece in shape.pieces])
            flags = 0
        with explaining(f"{shape.name}: expected a shape that PyBullet accepts, it says", p.error, why=": "):
            return p.createCollisionShape(p.GEOM_MESH, fileName=str(path), flags=flags, physicsClientId=client)


def load_spheres(compounds: Iterable[np.ndarray], scale: float, client: int) -> list[int]:
    """Return new bodies that stand still, each made of spheres at centres (S, 3), in radii.

    By way of files, since what is made of lists has 16 parts at most.
    """
    bodies, still = [], {"useFixedBase": 1, "useMaximalCoordinates": 1}
    with TemporaryDirectory(prefix="spherefunc-") as folder:
        for number, centers in enumerate(compounds):
            path = Path(folder) / f"{number}.urdf"
            spheres = "".join(sphere_of_urdf(center, scale) for center in (centers * scale).tolist())
            path.write_text(URDF.format(spheres=spheres))
            bodies.append(pybullet().loadURDF(str(path), physicsClientId=client, **still))
    return bodies


def sphere_of_urdf(center: Sequence[float], radius: float) -> str:
    """Return a line, since the engine reads no file whose lines are too long."""
    x, y, z = center
    shape = f'<geometry><sphere radius="{radius:.9g}"/></geometry>'
    return f'<collision><origin xyz="{x:.9g} {y:.9g} {z:.9g}"/>{shape}</collision>\n'


def write_stl(path: Path, vertices: np.ndarray, faces: np.ndarray):
    """Write triangles as binary STL, which the engine reads fastest."""
    record = np.zeros(len(faces), dtype=[("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
    record["corners"] = vertices[faces]
    with path.open("wb") as file:
        file.write(bytes(80) + np.uint32(len(faces)).tobytes())
        record.tofile(file)


def write_groups(path: Path, pieces: list[np.ndarray]):
    """Write pieces as OBJ, a group for each: the engine makes a convex hull of every group."""
    lines, first = [], 1
    for i, piece in enumerate(pieces):
        lines.append(f"o {i}")
        lines += [f"v {x:.7g} {y:.7g} {z:.7g}" for x, y, z in piece]
        lines += [f"f {first} {first + k} {first + k + 1}" for k in range(1, len(piece) - 1)]
        first += len(piece)
    path.write_text("\n".join(lines) + "\n")


def require_arrived(shape: CollisionShape, body: int, scale: float, client: int):
    """Check by its box and by rays that the engine holds all of a shape.

    Raises
    ------
    InputError
        If some of it is missing.
    """
    bounds = np.array(pybullet().getAABB(body, physicsClientId=client)) / scale
    expected = corners_of(shape.vertices[shape.faces.ravel()])
    share = share_met(shape, body, scale, client, FIRST_RAYS)
    if share < 1:
        share = share_met(shape, body, scale, client, RAYS)
    if share < 1 - MISSING or np.abs(bounds - expected).max() > SHORT:
        raise InputError(
            f"{shape.name}: expected PyBullet to hold the whole shape of {len(shape.faces):,} faces, "
            f"{share:.1%} of it was met by rays; try another shape= or a larger radius"
        )


def share_met(shape: CollisionShape, body: int, scale: float, client: int, count: int) -> float:
    """Return the share of about this many rays that meet a body."""
    starts, ends = rays(shape, count)
    hits = pybullet().rayTestBatch((starts * scale).tolist(), (ends * scale).tolist(), physicsClientId=client)
    return float(np.mean([hit[0] == body for hit in hits]))


def rays(shape: CollisionShape, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Return starts and ends (R, 3) of about this many short rays through faces all over the shape, in radii."""
    faces = shape.faces
    if len(faces) > 2 * count:  # by chance: evenly chosen they could miss what is missing regularly
        faces = faces[np.random.default_rng(0).integers(len(faces), size=2 * count)]
    corners = shape.vertices[faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    areas = np.linalg.norm(normals, axis=1)
    wide = np.flatnonzero(areas > np.median(areas) / 4)
    chosen = wide[:: max(1, len(wide) // count)]
    length = SHORT if shape.pieces is None else LONG
    middles, across = corners[chosen].mean(axis=1), length * normals[chosen] / areas[chosen, None]
    return middles + across, middles - across
