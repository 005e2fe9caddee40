"""Loading of collision shapes into the engine, and a check that they are complete there.

They are loaded from files, since meshes passed as lists leak memory and are cut off at 131,072 vertices; each file has
a new name, since the engine caches files by name.
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

FIRST_RAYS = 200  # that check whether a shape is complete
RAYS = 2_000  # the same if one of the first rays misses
SHORT = 0.05  # radii: half the length of a ray through a face
LONG = 2.0  # radii: the same for convex pieces, which are not hit by a ray that starts inside them
MISSING = 0.01  # share of rays that may miss: those along edges, by rounding
# The visual shape is a small box; otherwise the engine would tessellate every sphere.
URDF = """<robot name="rest">
<link name="rest">
<inertial><mass value="0"/><inertia ixx="0" ixy="0" ixz="0" iyy="0" iyz="0" izz="0"/></inertial>
<visual><geometry><box size="0.1 0.1 0.1"/></geometry></visual>
{spheres}</link>
</robot>"""


def load_shape(shape: CollisionShape, scale: float, client: int) -> int:
    """Load a collision shape and return its number in the engine.

    Raises
    ------
    InputError
        If the engine refuses it.
    """
    p = pybullet()
    with TemporaryDirectory(prefix="spherefunc-") as folder:
        concave = shape.pieces is None
        path = Path(folder) / f"{Path(folder).name}.{'stl' if concave else 'obj'}"
        if concave:
            write_stl(path, shape.vertices * scale, shape.faces)
        else:
            write_groups(path, [piece * scale for piece in shape.pieces])
        flags = p.GEOM_FORCE_CONCAVE_TRIMESH if concave else 0
        with explaining(f"{shape.name}: expected a shape that PyBullet accepts, it says", p.error, why=": "):
            return p.createCollisionShape(p.GEOM_MESH, fileName=str(path), flags=flags, physicsClientId=client)


def load_spheres(compounds: Iterable[np.ndarray], scale: float, client: int) -> list[int]:
    """Return new static bodies, each a compound of spheres at centres (S, 3), in radii.

    They are loaded from files, since compounds made from lists have at most 16 parts.
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
    """Return a collision sphere as one line of URDF: the engine reads no file whose lines are too long."""
    x, y, z = center
    shape = f'<geometry><sphere radius="{radius:.9g}"/></geometry>'
    return f'<collision><origin xyz="{x:.9g} {y:.9g} {z:.9g}"/>{shape}</collision>\n'


def write_stl(path: Path, vertices: np.ndarray, faces: np.ndarray):
    """Write triangles as binary STL, the format that the engine reads fastest."""
    record = np.zeros(len(faces), dtype=[("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
    record["corners"] = vertices[faces]
    with path.open("wb") as file:
        file.write(bytes(80) + np.uint32(len(faces)).tobytes())
        record.tofile(file)


def write_groups(path: Path, pieces: list[np.ndarray]):
    """Write convex pieces as OBJ with a group for each: the engine makes a convex hull of every group."""
    lines, first = [], 1
    for i, piece in enumerate(pieces):
        lines.append(f"o {i}")
        lines += [f"v {x:.7g} {y:.7g} {z:.7g}" for x, y, z in piece]
        lines += [f"f {first} {first + k} {first + k + 1}" for k in range(1, len(piece) - 1)]
        first += len(piece)
    path.write_text("\n".join(lines) + "\n")


def require_arrived(shape: CollisionShape, body: int, scale: float, client: int):
    """Raise InputError unless the engine holds a whole shape, by its bounding box and by rays."""
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
    """Return the share of about ``count`` rays that hit a body."""
    starts, ends = rays(shape, count)
    hits = pybullet().rayTestBatch((starts * scale).tolist(), (ends * scale).tolist(), physicsClientId=client)
    return float(np.mean([hit[0] == body for hit in hits]))


def rays(shape: CollisionShape, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Return starts and ends (R, 3), in radii, of about ``count`` short rays through faces all over the shape."""
    faces = shape.faces
    if len(faces) > 2 * count:  # at random: a regular choice could miss faces that are missing at regular intervals
        faces = faces[np.random.default_rng(0).integers(len(faces), size=2 * count)]
    corners = shape.vertices[faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    areas = np.linalg.norm(normals, axis=1)
    wide = np.flatnonzero(areas > np.median(areas) / 4)
    chosen = wide[:: max(1, len(wide) // count)]
    length = SHORT if shape.pieces is None else LONG
    middles, across = corners[chosen].mean(axis=1), length * normals[chosen] / areas[chosen, None]
    return middles + across, middles - across
