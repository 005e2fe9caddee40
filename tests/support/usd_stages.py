"""Stages of USD with one mesh, which may be a collider."""

from __future__ import annotations

import trimesh

STAGE = """#usda 1.0
(
    defaultPrim = "Mug"
    upAxis = "%s"
    metersPerUnit = %g
)
def Xform "Mug"%s
{
    def Mesh "Seen"%s
    {
        int[] faceVertexCounts = %s
        int[] faceVertexIndices = %s
        point3f[] points = %s
        %s
    }
%s
}
"""
COLLIDER = ' (prepend apiSchemas = ["PhysicsCollisionAPI", "PhysicsMeshCollisionAPI"])'


def stage_of(
    mesh: trimesh.Trimesh,
    approximation: str = "",
    body: str = "",
    beside: str = "",
    up: str = "Z",
    metres: float = 1.0,
) -> str:
    """Return a stage of a mesh, a collider if an approximation is given; ``beside`` are other parts."""
    points = mesh.vertices / metres if up == "Z" else mesh.vertices[:, [0, 2, 1]] * [1, 1, -1] / metres
    arrays = [3] * len(mesh.faces), mesh.faces.ravel().tolist(), list(map(tuple, points.tolist()))
    says = f'uniform token physics:approximation = "{approximation}"' if approximation else ""
    return STAGE % (up, metres, body, COLLIDER if approximation else "", *arrays, says, beside)
