"""Shapes whose resting places are known by thought: those of the conformance suite, and two more."""

from __future__ import annotations

import numpy as np
import trimesh

from spherefunc_bullet.clouds.cloud import Cloud, cloud_from_mesh
from spherefunc_bullet.conformance import shapes

SPACING = shapes.SPACING
steps, sheet, level, post, cloud = shapes.steps, shapes.sheet, shapes.level, shapes.post, shapes.cloud
plate, table, mug, chair, groove, bin_ = (
    shapes.plate,
    shapes.table,
    shapes.mug,
    shapes.chair,
    shapes.groove,
    shapes.bin_,
)


def incline(angle_deg: float, length: float = 0.3, height: float = 0.3) -> Cloud:
    """Return a sheet that rises towards +y by an angle, its lower edge at a height."""
    slope = np.radians(angle_deg)
    rise = [0, length * np.cos(slope), length * np.sin(slope)]
    corner = [-length / 2, -length / 2 * np.cos(slope), height]
    return cloud(sheet(corner, [length, 0, 0], rise), name=f"incline of {angle_deg:g} degrees")


def stair(count: int = 4, width: float = 0.3, tread: float = 0.12, rise: float = 0.12) -> Cloud:
    """Return steps that rise towards +y, each a tread and the riser below its front edge."""
    parts = []
    for k in range(count):
        y, z = k * tread - count * tread / 2, k * rise
        parts.append(sheet([-width / 2, y, z], [width, 0, 0], [0, 0, rise]))
        parts.append(sheet([-width / 2, y, z + rise], [width, 0, 0], [0, tread, 0]))
    return cloud(*parts, name="stair")


def boxed(extents: tuple[float, float, float] = (0.4, 0.2, 0.1)) -> Cloud:
    """Return a closed box, as a mesh."""
    box = trimesh.creation.box(extents)
    return cloud_from_mesh(box.vertices, box.faces, "box")
