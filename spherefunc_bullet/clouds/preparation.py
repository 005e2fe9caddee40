"""Preparation of objects for drops: levelled, with gaps between sparse points filled, and rotated to their heading.

An object comes to rest on the facet of its hull through which its weight acts; if its feet were not seen, its own level
surfaces define what is level. Either is used only if it concentrates the object's heights more than its given
orientation does, so that an object that is already level stays unchanged, bit for bit. The heading is that of the
narrowest rectangle around the footprint, so that rotating an object about the vertical does not change where spheres
are dropped.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .cloud import Cloud, Mesh, centre_on_ground, corners_of, placed

if TYPE_CHECKING:
    from scipy.spatial import cKDTree

ASKEW_DEG = 10.0  # largest tilt that is corrected
LEVEL_DEG = 0.5  # a smaller tilt counts as level
SAFE = 0.01  # of the extent: how far inside its feet the weight of a standing object acts
DIRECTIONS = np.arange(64) * 2 * np.pi / 64  # in which the reach of feet is measured, to a thousandth of a circle
SOME_FEET = 500
COLUMNS = 64  # across the footprint; the lowest point of each may be a foot
SOME = 4000  # points whose heights are compared
BINS = 100  # of heights, over the largest extent
FEET = (12, 0.002)  # number of points, and range of their heights relative to the extent, of reliable feet
SHARPER = (1.1, 1.3)  # required gain in concentration of heights: with unreliable feet, and by surfaces only
STEPS = (2.5, 0.5)  # degrees
PITCH = 0.004  # metres between filling points, as between the samples of a mesh
SPARSE = 0.0075  # metres to the sixth neighbour; for the samples of a mesh it is 4 to 6 mm
MANY = 15_000  # points: denser clouds of furniture have no gaps for spheres, and filling would take seconds
LOOKED_AT = 1_000  # points by which sparseness is measured
NEIGHBORS = 6, 9  # neighbour by which sparseness is measured; number of neighbours for triangles
REACH = 1.3, 0.02  # largest circumradius of a triangle: in distances of the sixth neighbour, and in metres
SQUARE = 0.005  # radians: an object so near to an axis stays unchanged, bit for bit
EDGES = 24  # longest edges of the outline; the narrowest rectangle lies along one of them, or nearly so
LONGER = 1.02  # ratio of the sides of a footprint from which on one is the longer


def prepare(cloud: Cloud) -> Cloud:
    """Return an object ready for drops; an object that is level and dense, as most are, is returned unchanged."""
    return cloud.cached("prepared", lambda: filled(levelled(cloud)))


def levelled(cloud: Cloud) -> Cloud:
    """Return an object rotated by at most ten degrees so that it stands level, or unchanged if it already does."""
    points, near_ground = cloud.points, np.tan(np.radians(LEVEL_DEG)) * cloud.size.max()
    if surround_centre(points[points[:, 2] < cloud.bounds[0, 2] + near_ground, :2], cloud):
        return cloud
    rotation = upright_rotation(cloud)
    return cloud if rotation is None else rotated_cloud(cloud, rotation)


def surround_centre(feet: np.ndarray, cloud: Cloud) -> bool:
    """Return whether feet (N, 2), metres, reach beyond the centre of an object in all directions."""
    around, center = np.stack([np.cos(DIRECTIONS), np.sin(DIRECTIONS)]), [axis.mean() for axis in cloud.points.T[:2]]
    # A few of the feet usually suffice.
    trials = (feet[:: max(1, len(feet) // SOME_FEET)], feet)
    return any(((some - center) @ around).max(axis=0).min() > SAFE * cloud.size.max() for some in trials)


def upright_rotation(cloud: Cloud) -> np.ndarray | None:
    """Return the rotation (3, 3) that makes an object level; None if there is none."""
    some, extent = cloud.points[:: max(1, len(cloud) // SOME)], float(cloud.size.max())
    before = sharpness(some, np.array([0.0, 0.0, 1.0]), extent)
    foot = resting_direction(cloud)
    if foot is not None:
        sharper = sharpness(some, foot, extent) > SHARPER[0] * before
        if sharper or surely_rests(cloud.points @ foot, cloud):
            return rotation_to_z(foot)
    best = sharpest(some, extent)
    if best[2] < np.cos(np.radians(ASKEW_DEG - STEPS[1])):  # at the limit of the search
        return None
    return rotation_to_z(best) if sharpness(some, best, extent) > SHARPER[1] * before else None


def resting_direction(cloud: Cloud) -> np.ndarray | None:
    """Return the direction (3,) that points up when an object has come to rest; None beyond ten degrees."""
    from scipy.spatial import ConvexHull, QhullError  # loading it takes longer than most classifications

    low = lowest_of_columns(cloud)
    middle = cloud.points[:: max(1, len(cloud) // SOME)].mean(axis=0)
    try:
        hull = ConvexHull(np.vstack([low, middle + [0, 0, cloud.size[2]]]))
    except QhullError:
        return None
    normals, heights = hull.equations[:, :3], -(hull.equations[:, :3] @ middle + hull.equations[:, 3])
    down = np.array([0.0, 0.0, -1.0])
    for _ in range(20):
        toward = normals @ down
        facet = int(np.where(toward > 1e-9, heights / np.maximum(toward, 1e-9), np.inf).argmin())
        if normals[facet] @ down > 1 - 1e-9:
            break
        down = normals[facet]
    return -down if -down[2] > np.cos(np.radians(ASKEW_DEG + LEVEL_DEG)) else None


def surely_rests(heights: np.ndarray, cloud: Cloud) -> bool:
    """Return whether enough points, by their heights (N,), are on the ground around the centre of an object."""
    feet = cloud.points[heights < heights.min() + FEET[1] * cloud.size.max(), :2]
    return len(feet) >= FEET[0] and surround_centre(feet, cloud)


def lowest_of_columns(cloud: Cloud) -> np.ndarray:
    """Return the lowest points of each column above the ground, (C, 3)."""
    low, side = cloud.bounds[0, :2], max(float(cloud.size[:2].max()), 1e-9) / COLUMNS
    column = np.floor((cloud.points[:, :2] - low) / side).astype(np.int64) @ [COLUMNS + 1, 1]
    lowest = np.full((COLUMNS + 1) ** 2, np.inf)
    np.minimum.at(lowest, column, cloud.points[:, 2])
    return cloud.points[cloud.points[:, 2] == lowest[column]]


def sharpness(points: np.ndarray, up: np.ndarray, extent: float) -> float:
    """Return how concentrated the heights of points (N, 3) along a direction are, as a share of pairs."""
    heights = points @ up
    counts = np.bincount(np.floor((heights - heights.min()) / (extent / BINS)).astype(np.int64)) / len(points)
    return float((np.convolve(counts, [1, 1]) ** 2).sum())


def sharpest(points: np.ndarray, extent: float) -> np.ndarray:
    """Return the direction (3,) within ten degrees of z along which heights are most concentrated."""
    best, reach = np.zeros(2), ASKEW_DEG
    for step in STEPS:
        offsets = np.arange(-reach, reach + step / 2, step)
        trials = best + np.array([(a, b) for a in offsets for b in offsets if np.hypot(a, b) <= reach])
        values = [sharpness(points, direction(trial), extent) for trial in trials]
        best, reach = trials[int(np.argmax(values))], step
    return direction(best)


def direction(tilt_deg: np.ndarray) -> np.ndarray:
    """Return the unit vector (3,) tilted from z by angles towards x and y, degrees."""
    vector = np.array([*np.tan(np.radians(tilt_deg)), 1.0])
    return vector / np.linalg.norm(vector)


def rotation_to_z(up: np.ndarray) -> np.ndarray:
    """Return the smallest rotation (3, 3) that takes a unit vector (3,) near z to z."""
    x, y, z = up
    share = 1 / (1 + z)
    return np.array([[1 - x * x * share, -x * y * share, -x], [-x * y * share, 1 - y * y * share, -y], [x, y, z]])


def rotated_cloud(cloud: Cloud, rotation: np.ndarray) -> Cloud:
    """Return a cloud, with its mesh, rotated by (3, 3) and moved to the ground."""
    points = cloud.points @ rotation.T
    shift = centre_on_ground(points)
    mesh = cloud.mesh and Mesh(cloud.mesh.vertices @ rotation.T - shift, cloud.mesh.faces)
    return Cloud(points - shift, cloud.name, mesh)


def filled(cloud: Cloud) -> Cloud:
    """Return a cloud with the gaps between neighbouring points filled, unchanged if it is dense or has a mesh.

    Triangles of neighbours are filled if their circumcircle is small compared to the distances between points, and
    smaller than the opening of a vessel. The order of the points does not matter.
    """
    if cloud.mesh is not None or not NEIGHBORS[1] < len(cloud) <= MANY:
        return cloud
    some = cloud.points[:: max(1, len(cloud) // LOOKED_AT)]
    apart = float(np.median(cloud.tree.query(some, NEIGHBORS[0] + 1)[0][:, -1]))
    if apart < SPARSE:
        return cloud
    from .thinning import one_per_cell  # compiled kernels, which cached results do not need

    triangles = cloud.points[neighbouring(cloud.points, cloud.tree)]
    more = on_triangles(triangles)
    more = one_per_cell(more, PITCH, corners_of(more)) if len(more) else more
    return Cloud(placed(np.concatenate([cloud.points, more])), cloud.name, unfilled=apart)


def neighbouring(points: np.ndarray, tree: cKDTree) -> np.ndarray:
    """Return the triangles (T, 3) of points (N, 3) and two of their neighbours with small circumcircles."""
    distances, near = tree.query(points, NEIGHBORS[1] + 1)
    first, second = np.triu_indices(NEIGHBORS[1], 1)
    owner = np.repeat(np.arange(len(points)), len(first))
    triangles = np.column_stack([owner, near[:, 1 + first].ravel(), near[:, 1 + second].ravel()])
    reach = np.minimum(REACH[0] * distances[:, NEIGHBORS[0]], REACH[1])
    small = circle_radii(points[triangles]) < np.repeat(reach, len(first))
    return np.unique(np.sort(triangles[small], axis=1), axis=0)


def circle_radii(triangles: np.ndarray) -> np.ndarray:
    """Return the circumradii (T,) of triangles (T, 3, 3), infinite for degenerate ones."""
    sides = np.linalg.norm(triangles - np.roll(triangles, 1, axis=1), axis=2)
    edges = triangles[:, 1:] - triangles[:, :1]
    areas = np.linalg.norm(np.cross(edges[:, 0], edges[:, 1]), axis=1) / 2
    return np.divide(sides.prod(axis=1), 4 * areas, out=np.full(len(areas), np.inf), where=areas > 1e-12)


def on_triangles(triangles: np.ndarray) -> np.ndarray:
    """Return points (M, 3) on triangles (T, 3, 3), at most `PITCH` apart along their sides."""
    longest = np.linalg.norm(triangles - np.roll(triangles, 1, axis=1), axis=2).max(axis=1, initial=0)
    steps, parts = np.ceil(longest / PITCH).astype(int), [np.empty((0, 3))]
    for count in np.unique(steps[steps > 1]).tolist():
        i, j = np.meshgrid(np.arange(count + 1), np.arange(count + 1), indexing="ij")
        inside = i + j <= count
        weights = np.stack([i[inside], j[inside], count - i[inside] - j[inside]], axis=1) / count
        parts.append(np.einsum("wc,tcx->twx", weights, triangles[steps == count]).reshape(-1, 3))
    return np.concatenate(parts)


def heading(cloud: Cloud) -> float:
    """Return the angle, radians, by which a cloud must be rotated about z so that its footprint lies along the axes.

    The longer side then lies along x.
    """
    return cloud.cached("heading", lambda: heading_of(cloud.points[:, :2]))


def heading_of(places: np.ndarray) -> float:
    """Return the heading of points on the ground (N, 2), metres; see `heading`."""
    from .outline import hull_corners  # compiled kernels, which cached results do not need

    corners = hull_corners(places)
    if len(corners) < 3:  # a line or a point
        return 0.0
    edges = np.roll(corners, -1, axis=0) - corners
    edges = edges[np.argsort(-np.hypot(*edges.T), kind="stable")[:EDGES]]
    angles = np.unique(np.round(np.arctan2(edges[:, 1], edges[:, 0]) % (np.pi / 2), 6))
    axes = np.column_stack([np.cos(angles), np.sin(angles)])
    along, across = corners @ axes.T, corners @ np.column_stack([-axes[:, 1], axes[:, 0]]).T
    areas = np.ptp(along, axis=0) * np.ptp(across, axis=0)
    best = int(np.flatnonzero(areas <= areas.min() * (1 + 1e-6))[0])
    if np.ptp(along[:, best]) * LONGER < np.ptp(across[:, best]):
        return float(np.pi / 2 - angles[best])
    return float(-angles[best])


def turned(points: np.ndarray, angle: float) -> np.ndarray:
    """Return points (N, 3), or points on the ground (N, 2), rotated about z by an angle, radians."""
    cosine, sine = np.cos(angle), np.sin(angle)
    x, y = points[:, 0], points[:, 1]
    return np.column_stack([cosine * x - sine * y, sine * x + cosine * y, points[:, 2:]])


def headed(cloud: Cloud) -> tuple[Cloud, float]:
    """Return a cloud rotated to its heading, and the angle; the same cloud and 0 if it already lies along the axes."""
    angle = heading(cloud)
    if abs(angle) < SQUARE or abs(abs(angle) - np.pi / 2) < SQUARE:
        return cloud, 0.0
    return cloud.cached("headed", lambda: turned_cloud(cloud, angle)), angle


def turned_cloud(cloud: Cloud, angle: float) -> Cloud:
    """Return a cloud, with its mesh, rotated about z by an angle, radians."""
    mesh = cloud.mesh and Mesh(turned(cloud.mesh.vertices, angle), cloud.mesh.faces)
    return Cloud(turned(cloud.points, angle), cloud.name, mesh)
