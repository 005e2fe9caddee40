"""Every hand-set number that recognises objects in scans, by stage, each with its unit and meaning.

Stages read them as ``POOL.slab``. ``python -m spherefunc_bullet.compare.rooms.sensitivity`` lists them, and measures
the effect of each. Numbers without a choice (the bits of a cell's index, labels, a camera's axes) are not here, nor
those that only compiled kernels read, which are next to the kernels.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any


def number(value: Any, unit: str, meaning: str) -> Any:
    """Return a field of settings with the unit and meaning of its number."""
    return field(default=value, metadata={"unit": unit, "meaning": meaning})


@dataclass(frozen=True, kw_only=True)
class ScanNumbers:
    """From points or depth images to a scan that is level: which way is up, and where the floor is."""

    min_points: int = number(100, "points", "scans with fewer are refused as empty or cut off")
    largest: float = number(60.0, "m", "scans that would be larger are in millimetres")
    cell: float = number(0.02, "m", "side of the cells and squares that surfaces are measured in")
    focal: float = number(525 / 640, "image widths", "focal length by default: PrimeSense's, as in Open3D")
    sparse: float = number(2.2, "voxels", "to the sixth neighbour, where gaps are filled; 1.4 on a dense surface")
    widest_gap: float = number(0.08, "m", "between neighbours that is filled")
    half_view_deg: float = number(50.0, "degrees", "off their axis, more than depth cameras see")
    in_view: float = number(0.995, "of the points", "at least, within the view of a camera in the origin")
    steepest_view_deg: float = number(65.0, "degrees", "by which a sensor looks down or up, at most")
    fitted_deg: tuple[float, ...] = number((8.0, 5.0, 4.0), "degrees", "off level or upright of patches in each fit")
    patch_sides: tuple[float, ...] = number((0.04, 0.12, 0.36), "m", "small ones for table tops, large ones for noise")
    patch_points: int = number(8, "points", "of a patch, at least")
    patch_thickness: float = number(0.35, "of its width", "of a patch, at most: 4 cm of noise over 10 cm")
    aligned_deg: float = number(12.0, "degrees", "patches whose normals differ by less face the same way")
    tried: int = number(500, "", "directions or planes: enough where a third of a scan is floor")
    least_floor: float = number(0.15, "of the largest level plane", "of a floor, at least")
    block: float = number(0.1, "m", "side of the cells that show whether points lie on surfaces")
    most_interior: float = number(0.5, "of these cells", "with others on all six sides, at most; real scans: 0.16")
    stray: float = number(0.03, "of the points", "below a floor or behind a wall, by noise and reflections, at most")
    fit: float = number(0.04, "m", "from a plane within which points are fitted")
    largest_top: float = number(1.25, "m2", "of a table top, at most")
    on_top: float = number(0.6, "m", "height of objects on a table top, at most")

    @property
    def aligned(self) -> float:
        """`aligned_deg` in radians."""
        return math.radians(self.aligned_deg)


@dataclass(frozen=True, kw_only=True)
class SegmentationNumbers:
    """From a level scan to floor, walls and clusters."""

    leaf_size: float = number(0.01, "m", "side of the voxels for thinning the scan")
    cluster_tolerance: float = number(0.02, "m", "between neighbours of one cluster (paper, section IV-C)")
    min_cluster_size: int = number(60, "voxels", "of a cluster, at least")
    large: float = number(0.5, "m", "largest side: furniture is larger, vessels are smaller")
    wall_thickness: float = number(0.05, "m", "from its plane to points that belong to a wall, at most")
    wall_margin: float = number(0.5, "m", "on both sides of a wall, behind which nothing is; else it is a cupboard")
    wall_area: float = number(0.25, "m2", "of a wall or a ceiling, at least")
    wall_width: float = number(1.0, "m", "of a wall, at least")
    wall_top: float = number(0.85, "m", "height of a wall, at least: cameras that look down see no more of it")
    high: float = number(1.9, "m", "above which there may be a ceiling, and no use of a surface")


@dataclass(frozen=True, kw_only=True)
class PoolNumbers:
    """From spheres at rest to the surfaces and vessels that hold them, and to the parts cut out around these."""

    density: float = number(0.06, "spheres", "of a run on a square of their radius: too few to pile up")
    runs: int = number(5, "runs", "so that a chair's seat carries twenty large spheres, a mug ten small ones")
    min_spheres: int = number(20, "spheres", "of a run")
    linked: float = number(4.0, "radii", "between neighbours in one pool, about twice their mean distance")
    slab: float = number(0.03, "m", "of a surface above and below its height: a cushion's swelling, less than a lip")
    upright: float = number(0.10, "m", "of height that a square of a wall or a back spans, and of a level surface not")
    neck: float = number(0.12, "m", "width below which two surfaces are only connected by a neck")
    part_area: float = number(0.10, "m2", "of such a surface, and of a support of objects, at least")
    table_area: float = number(0.30, "m2", "from which on a surface as high as a table is no seat")
    table_height: float = number(0.60, "m", "from which on a surface as large as a table is no seat")
    apart: float = number(0.05, "m", "between squares of one surface: one may be missing")
    lowest: float = number(0.15, "m", "height of surfaces other than the floor")
    highest: float = number(1.3, "m", "height of surfaces within reach")
    seen_area: float = number(0.035, "m2", "of a seat's surface that is seen, at least")
    back_reach: float = number(0.08, "m", "from a surface's edge of a back or an arm; farther inside are other objects")
    back_area: float = number(0.45, "of the surface's area", "of a back, at most")
    spacing: float = number(0.004, "m", "side of small objects' voxels, and distance of points that are added")
    narrowest: float = number(0.04, "m", "of an object on a top; stray points and remaining slices are thinner")
    top_fits: tuple[float, ...] = number((0.025, 0.015, 0.01), "m", "from a plane, of the points in each fit")
    min_points: int = number(30, "points", "of an object, at least")
    vessel_radius: float = number(0.012, "m", "of the spheres that find vessels")
    directions: int = number(24, "", "in which a wall is searched around a place")
    enclosed: float = number(0.6, "of the directions", "that meet a wall of a vessel, at least")
    back_gap: float = number(0.25, "m", "between a surface and its back, which posts may hold, at most")
    cautious_gap: float = number(0.10, "m", "likewise, where parts are cut out cautiously for training")

    @property
    def min_rests(self) -> int:
        """Spheres of a pool, at least: one of each run on average."""
        return self.runs


@dataclass(frozen=True, kw_only=True)
class RecognitionNumbers:
    """From proposals to objects, their functions and places."""

    usual_height: float = number(0.73, "m", "of tables whose height is unknown (EN 527-1: 0.72 to 0.74)")
    frame_heights: tuple[float, ...] = number(
        (0.3, 1.3), "m", "of tables over a level frame's z = 0, if that is a floor"
    )
    many: int = number(2_000_000, "points", "above which a scan is thinned first")
    radius: float = number(0.04, "m", "of the spheres that find seats and tops")
    widest_vessel: float = number(0.14, "m", "above which objects on a top are divided by pools")
    same_points: float = number(0.8, "of the points", "that two proposals share, for one to be enough")
    smallest_radii: tuple[tuple[float, float], ...] = number(
        ((1.0, 0.02), (0.5, 0.01)), "m", "of spheres, by an object's largest side: smaller ones only take time"
    )
    spacings: tuple[tuple[float, float], ...] = number(
        ((1.0, 0.008), (0.5, 0.005)), "m", "likewise, side of voxels that are small enough for such spheres"
    )
    floats: float = number(0.10, "m", "above its support, at which an object still stands on it")
    smooth_radius: float = number(0.02, "m", "of a smoothed neighbourhood, half a cup's: wider planes cut its curve")
    smooth_passes: int = number(2, "times", "that points are smoothed")
    lower_part: float = number(0.25, "of its height", "at both ends, where a vessel's sides and rim are searched")
    closed: float = number(
        0.35, "of the outline", "with a side below and a rim above; one view shows half, legs a tenth"
    )
    disagrees: float = number(0.6, "of a mirror image's points", "that may have no other point near them, at most")
    voxels: tuple[tuple[float, float], ...] = number(((0.5, 0.02), (0.0, 0.01)), "m", "by an object's largest side")
    square: int = number(2, "voxels", "along the side of the squares that areas are measured in")
    near_level: float = number(0.16, "m", "beyond a level's edge: next to it")
    far_level: float = number(0.40, "m", "beyond a level's edge: around it")
    rises: float = number(0.10, "m", "above the level: a back, a wall, a neighbour")
    standing_on: float = number(0.25, "m", "above the level: objects that stand on it")
    tucked_reach: float = number(0.35, "m", "from a top's edge to the back of a chair at the table, at most")
    tucked_width: tuple[float, ...] = number((0.28, 0.70), "m", "of such a back, the least and most")
    tucked_thickness: float = number(0.24, "m", "of such a back, the most")
    tucked_depth: float = number(0.45, "m", "of a chair, and between the middles of two")
    trust: float = number(0.5, "of the score", "of a place whose surface was seen in part")
    back_thickness: float = number(0.15, "m", "of a seat's back")
    thighs: float = number(0.12, "m", "of a sitter under a table")
    around: float = number(0.6, "m", "around a seat that decide where its back is and whether knees have room")
    same_object: float = number(0.35, "intersection over union", "from which on two claims are of one object")
    within: float = number(
        0.6,
        "of the smaller's points",
        "shared by two claims of one object, or held by claims of a cluster that is none",
    )
    nearly: float = number(0.1, "of score", "below which a difference is ignored")


SCAN = ScanNumbers()
SEGMENTATION = SegmentationNumbers()
POOL = PoolNumbers()
RECOGNITION = RecognitionNumbers()
STAGES = {"scan": SCAN, "segmentation": SEGMENTATION, "pool": POOL, "recognition": RECOGNITION}
