"""Every hand-set number that recognises objects in scans, by stage, each with its unit and what it stands for.

Stages read them as ``POOL.slab``. ``python -m spherefunc_bullet.compare.rooms.sensitivity`` lists them, and measures
what each one changes. Numbers that nobody chooses are not here (the bits of a cell's index, labels, a camera's axes),
nor those that only compiled kernels read, which stand beside them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any


def number(value: Any, unit: str, meaning: str) -> Any:
    """Return a field of settings, with what its number is of."""
    return field(default=value, metadata={"unit": unit, "meaning": meaning})


@dataclass(frozen=True, kw_only=True)
class ScanNumbers:
    """From points or depth images to a scan that is level: which way is up, and where the floor is."""

    min_points: int = number(100, "points", "what has fewer is refused as empty or cut off")
    largest: float = number(60.0, "m", "what is larger in metres is no room but written in millimetres")
    cell: float = number(0.02, "m", "side of the cells and squares that surfaces are measured in")
    focal: float = number(
        525 / 640, "image widths", "focal length where nobody says it: PrimeSense's, Open3D's default"
    )
    sparse: float = number(
        2.2, "voxels", "to the sixth neighbour, where gaps are filled: 1.4 on a surface that fills its voxels"
    )
    widest_gap: float = number(0.08, "m", "between neighbours: beyond, nothing says that there is a surface")
    half_view_deg: float = number(50.0, "degrees", "depth cameras see less off their axis")
    in_view: float = number(0.995, "of the points", "that the view of a camera in the origin must hold")
    steepest_view_deg: float = number(65.0, "degrees", "the most that a sensor looks down or up")
    fitted_deg: tuple[float, ...] = number(
        (8.0, 5.0, 4.0), "degrees", "within which patches count as level or upright in a fit, from one to the next"
    )
    patch_sides: tuple[float, ...] = number(
        (0.04, 0.12, 0.36), "m", "a table top has hundreds of small ones, noise tilts the large ones less"
    )
    patch_points: int = number(8, "points", "that a patch's plane is fitted to, at least")
    patch_thickness: float = number(
        0.35, "of its width", "most that a patch is thick: noise of 4 cm over 10 cm still passes"
    )
    aligned_deg: float = number(12.0, "degrees", "patches whose normals differ by less face the same way")
    tried: int = number(
        500, "", "directions or planes, of a scan that is a third floor all but certain to hold one of it"
    )
    least_floor: float = number(0.15, "of the largest level plane", "what is smaller is no floor")
    stray: float = number(0.03, "of the points", "that noise and reflections may put below a floor or behind a wall")
    fit: float = number(0.04, "m", "around a plane within which points are fitted")
    largest_top: float = number(1.25, "m2", "no table top is larger")
    on_top: float = number(0.6, "m", "what stands on a table top is not higher")

    @property
    def aligned(self) -> float:
        """What `aligned_deg` is in radians."""
        return math.radians(self.aligned_deg)


@dataclass(frozen=True, kw_only=True)
class SegmentationNumbers:
    """From a level scan to floor, walls and clusters."""

    leaf_size: float = number(0.01, "m", "side of the voxels that thin the scan first")
    cluster_tolerance: float = number(0.02, "m", "between neighbours of one cluster (paper, section IV-C)")
    min_cluster_size: int = number(60, "voxels", "of a cluster, at least")
    large: float = number(0.5, "m", "the least of furniture, and more than holds a drink")
    wall_thickness: float = number(0.05, "m", "off its plane at which a point still belongs to a wall")
    wall_margin: float = number(
        0.5, "m", "along a wall to either side in which nothing may be behind: else it is a cupboard's front"
    )
    wall_area: float = number(0.25, "m2", "the least of a wall, or of a ceiling")
    wall_width: float = number(1.0, "m", "the least of a wall")
    wall_top: float = number(
        0.85, "m", "above the floor, the least of a wall: cameras that look down see no more of its height"
    )
    high: float = number(1.9, "m", "what is higher may be a ceiling, and carries nothing of use")


@dataclass(frozen=True, kw_only=True)
class PoolNumbers:
    """From spheres at rest to the surfaces and vessels that hold them, and what is cut out around these."""

    density: float = number(0.06, "spheres", "of a run on a square of their radius: so few that they do not pile up")
    runs: int = number(5, "runs", "a chair's seat carries twenty large spheres, a mug ten small ones")
    min_spheres: int = number(20, "spheres", "of a run")
    linked: float = number(4.0, "radii", "between spheres at rest of one pool, about twice their mean distance")
    min_rests: int = number(3, "spheres", "that make a pool")
    slab: float = number(
        0.03, "m", "above and below a surface that still belong to it: a cushion's swelling, less than a shelf's lip"
    )
    upright: float = number(
        0.10, "m", "of height that one square of a wall or a back spans, and of a level surface does not"
    )
    neck: float = number(0.12, "m", "what is narrower connects two surfaces, of which each has")
    part_area: float = number(0.10, "m2", "the least of such a part, and of what objects stand on")
    table_area: float = number(0.30, "m2", "from there on a surface of that height is no seat's")
    table_height: float = number(0.60, "m", "from there on a surface of that area is no seat's")
    apart: float = number(0.05, "m", "between squares of one surface: one may lack")
    lowest: float = number(0.15, "m", "of surfaces that are not the floor")
    highest: float = number(1.3, "m", "of surfaces that are not out of reach")
    seen_area: float = number(0.035, "m2", "of a seat's surface that is seen, at least")
    back_reach: float = number(
        0.08, "m", "around a surface's edge in which a back or an arm rises: farther inside it stands on it"
    )
    back_area: float = number(0.45, "of the surface's area", "what rises from a seat and is wider is no back")
    spacing: float = number(0.004, "m", "voxels of small objects, and between points that are added")
    narrowest: float = number(
        0.04, "m", "of an object on a top; a sensor's flying points and the slices it leaves are thinner"
    )
    top_fits: tuple[float, ...] = number(
        (0.025, 0.015, 0.01), "m", "from a plane within which points are fitted, from one fit to the next"
    )
    min_points: int = number(30, "points", "what has fewer is no object")
    vessel_radius: float = number(0.012, "m", "of the spheres that find vessels")
    directions: int = number(24, "", "in which a wall is looked for around a place")
    enclosed: float = number(0.6, "of the directions", "that meet a wall, at least, where a vessel is")
    back_gap: float = number(
        0.25, "m", "above the surface at which a back begins at the latest: it may be held by posts"
    )
    cautious_gap: float = number(0.10, "m", "likewise, where models are taught: by what is cut out cautiously")


@dataclass(frozen=True, kw_only=True)
class RecognitionNumbers:
    """From what is proposed to objects, their functions and places."""

    usual_height: float = number(0.73, "m", "of dining tables and desks (EN 527-1: 0.72 to 0.74), where no floor tells")
    frame_heights: tuple[float, ...] = number(
        (0.3, 1.3), "m", "above z = 0 of a level frame between which that is a floor and the top a table's"
    )
    many: int = number(2_000_000, "points", "what has more is thinned before anything else")
    radius: float = number(0.04, "m", "of the spheres that find seats and tops")
    widest_vessel: float = number(0.14, "m", "what is wider holds more than a vessel, and pools part it")
    same_points: float = number(0.8, "of the points", "that two proposals share, for one to be enough")
    smallest_radii: tuple[tuple[float, float], ...] = number(
        ((1.0, 0.02), (0.5, 0.01)),
        "m",
        "of spheres, by an object's largest side: small ones on large objects take seconds and tell nothing more",
    )
    spacings: tuple[tuple[float, float], ...] = number(
        ((1.0, 0.008), (0.5, 0.005)), "m", "likewise, side of the voxels that are enough for such spheres"
    )
    floats: float = number(0.10, "m", "above its support: what begins higher does not stand")
    smooth_radius: float = number(
        0.02,
        "m",
        "of the neighbourhood that is smoothed, half of a cup's; wider planes cut its bend; who is near counts more",
    )
    smooth_passes: int = number(2, "times", "that points are smoothed")
    lower_part: float = number(0.25, "of its height", "where a hull's sides and rim are looked for")
    closed: float = number(
        0.35, "of the outline", "that has a side below it, and a rim above: one side shows half, legs cover a tenth"
    )
    disagrees: float = number(
        0.6, "of an image's points", "that may have nothing near them for it to be one of the object"
    )
    voxels: tuple[tuple[float, float], ...] = number(
        ((0.5, 0.02), (0.0, 0.01)), "m", "by the largest side of what is asked about"
    )
    square: int = number(2, "voxels", "along the side of the squares that areas are measured in")
    near_level: float = number(0.16, "m", "beyond a level's edge: what is beside it")
    far_level: float = number(0.40, "m", "beyond a level's edge: what is around it")
    rises: float = number(0.10, "m", "above the level: a back, a wall, a neighbour")
    standing_on: float = number(0.25, "m", "above the level: objects that stand on it")
    tucked_reach: float = number(0.35, "m", "outside a top's edge up to which the back of a chair at the table stands")
    tucked_width: tuple[float, ...] = number((0.28, 0.70), "m", "of such a back, the least and most")
    tucked_thickness: float = number(0.24, "m", "of such a back, the most")
    tucked_depth: float = number(0.45, "m", "of a chair, and between the middles of two")
    trust: float = number(0.5, "of the score", "that is kept of a place whose surface was seen in part")
    back_thickness: float = number(0.15, "m", "of a seat's back")
    thighs: float = number(0.12, "m", "of who sits under a table")
    around: float = number(0.6, "m", "about a seat that decide where its back is and whether knees have room")
    same_object: float = number(0.35, "intersection over union", "from which on two claims are of one object")
    within: float = number(
        0.6,
        "of the smaller's points",
        "two claims of a function that lie so far within each other are one object, and a cluster "
        "without a function of which claims hold so much is none",
    )
    nearly: float = number(0.1, "of score", "what differs by less is as sure")


SCAN = ScanNumbers()
SEGMENTATION = SegmentationNumbers()
POOL = PoolNumbers()
RECOGNITION = RecognitionNumbers()
STAGES = {"scan": SCAN, "segmentation": SEGMENTATION, "pool": POOL, "recognition": RECOGNITION}
