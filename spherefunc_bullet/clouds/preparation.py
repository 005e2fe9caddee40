"""Objects as spheres are to meet them: standing level, without gaps between sparse points, turned to their heading.

An object comes to rest on the facet of its hull that its weight acts through; where its feet were not seen, its own
level surfaces say what is level. Either is believed only where it makes the object's heights fall together more than
they do as it stands, so that what is level already stays as it is, bit for bit. The heading lies along the narrowest
rectangle around the footprint, so that turning an object about the vertical does not change
where spheres are dropped.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .cloud import Cloud, Mesh, centre_on_ground, placed
from .outline import convex_outline, corners_of, well_within

if TYPE_CHECKING:
    from scipy.spatial import cKDTree

ASKEW_DEG = 10.0  # at most
LEVEL_DEG = 0.5  # below, it counts as level
SAFE = 0.01  # of the extent: how far its weight acts within its feet
DIRECTIONS = np.arange(64) * 2 * np.pi / 64  # in which feet reach beyond it: a circle's chords are a thousandth short
COLUMNS = 64  # across the footprint, of each of which the lowest point may be a foot
SOME = 4000  # points whose heights are looked at
BINS = 100  # of the largest extent
FEET = (12, 0.002)  # points at least, within so much of the extent: where an object surely rests on what it has
SHARPER = (1.1, 1.3)  # times as much together must heights fall: on feet that are not sure, by its surfaces alone
STEPS = (2.5, 0.5)  # degrees
PITCH = 0.004  # metres between points that fill: as far apart as a mesh's samples
SPARSE = 0.0075  # metres to the sixth neighbour: of a mesh's samples it is 4 to 6 mm away
MANY = 15_000  # points: of more, spheres that are dropped on furniture find no gap, and filling would take seconds
LOOKED_AT = 1_000  # points that tell
NEIGHBORS = 6, 9  # that tell how sparse it is; among which triangles are looked for
REACH = 1.3, 0.02  # radius of a triangle's circle: times the distance of the sixth neighbour, at most, metres
SQUARE = 0.005  # radians off an axis that count as along it: such an object stays as it is, bit for bit
EDGES = 24  # of the outline, the longest: one of them lies along the narrowest rectangle, or it hardly matters which
LONGER = 1.02  # times the other side, so that the longer one is known


def prepare(cloud: Cloud) -> Cloud:
    """Return an object ready for spheres to be dropped on; one that is level and dense, as most are, is itself."""
    return cloud.cached("prepared", lambda: filled(levelled(cloud)))


def levelled(cloud: Cloud) -> Cloud:
    """Return an object that stands level, turned by at most ten degrees, or itself where it does as it is."""
    if stands_on_feet(cloud):
        return cloud
    rotation = upright_rotation(cloud)
    return cloud if rotation is None else rotated_cloud(cloud, rotation)


def stands_on_feet(cloud: Cloud) -> bool:
    """Return whether points within half a degree of the ground surround an object's middle."""
    points, extent = cloud.points, float(cloud.size.max())
    feet = points[points[:, 2] < cloud.bounds[0, 2] + np.tan(np.radians(LEVEL_DEG)) * extent, :2]
    return reach_around(feet, cloud) > SAFE * extent


def reach_around(feet: np.ndarray, cloud: Cloud) -> float:
    """Return how far feet (N, 2) reach beyond an object's middle where they reach least, metres."""
    around = np.stack([np.cos(DIRECTIONS), np.sin(DIRECTIONS)])
    return float(((feet - cloud.points[:, :2].mean(axis=0)) @ around).max(axis=0).min())


def upright_rotation(cloud: Cloud) -> np.ndarray | None:
    """Return the rotation (3, 3) that makes an object level, None where there is none that does."""
    some = cloud.points[:: max(1, len(cloud) // SOME)]
    extent = float(cloud.size.max())
    before = sharpness(some, np.array([0.0, 0.0, 1.0]), extent)
    foot = resting_direction(cloud)
    if foot is not None and (
        sharpness(some, foot, extent) > SHARPER[0] * before or surely_rests(cloud.points @ foot, cloud, extent)
    ):
        return rotation_to_z(foot)
    best = sharpest(some, extent)
    if best[2] < np.cos(np.radians(ASKEW_DEG - STEPS[1])):  # it leans farther than is looked at
        return None
    return rotation_to_z(best) if sharpness(some, best, extent) > SHARPER[1] * before else None


def resting_direction(cloud: Cloud) -> np.ndarray | None:
    """Return the direction (3,) that points up when an object has come to rest; None beyond ten degrees."""
    from scipy.spatial import ConvexHull, QhullError  # takes longer to load than most answers

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


def surely_rests(heights: np.ndarray, cloud: Cloud, extent: float) -> bool:
    """Return whether enough points lie on the ground by their heights (N,), around an object's middle."""
    feet = cloud.points[heights < heights.min() + FEET[1] * extent, :2]
    return len(feet) >= FEET[0] and reach_around(feet, cloud) > SAFE * extent


def lowest_of_columns(cloud: Cloud) -> np.ndarray:
    """Return the lowest point of each column over the ground, (C, 3)."""
    low, side = cloud.bounds[0, :2], max(float(cloud.size[:2].max()), 1e-9) / COLUMNS
    column = np.floor((cloud.points[:, :2] - low) / side).astype(np.int64) @ [COLUMNS + 1, 1]
    lowest = np.full((COLUMNS + 1) ** 2, np.inf)
    np.minimum.at(lowest, column, cloud.points[:, 2])
    return cloud.points[cloud.points[:, 2] == lowest[column]]


def sharpness(points: np.ndarray, up: np.ndarray, extent: float) -> float:
    """Return how much the heights of points (N, 3) along a direction fall together, as share of pairs."""
    heights = points @ up
    counts = np.bincount(np.floor((heights - heights.min()) / (extent / BINS)).astype(np.int64)) / len(points)
    return float((np.convolve(counts, [1, 1]) ** 2).sum())


def sharpest(points: np.ndarray, extent: float) -> np.ndarray:
    """Return the direction (3,) within ten degrees of z along which heights fall together most."""
    best, reach = np.zeros(2), ASKEW_DEG
    for step in STEPS:
        offsets = np.arange(-reach, reach + step / 2, step)
        trials = best + np.array([(a, b) for a in offsets for b in offsets if np.hypot(a, b) <= reach])
        values = [sharpness(points, direction(trial), extent) for trial in trials]
        best, reach = trials[int(np.argmax(values))], step
    return direction(best)


def direction(tilt_deg: np.ndarray) -> np.ndarray:
    """Return the unit vector (3,) tilted from z by an angle along x and y, degrees."""
    vector = np.array([*np.tan(np.radians(tilt_deg)), 1.0])
    return vector / np.linalg.norm(vector)


def rotation_to_z(up: np.ndarray) -> np.ndarray:
    """Return the least rotation (3, 3) that takes a unit vector (3,) near z to z."""
    x, y, z = up
    share = 1 / (1 + z)
    return np.array([[1 - x * x * share, -x * y * share, -x], [-x * y * share, 1 - y * y * share, -y], [x, y, z]])


def rotated_cloud(cloud: Cloud, rotation: np.ndarray) -> Cloud:
    """Return a cloud and its mesh rotated (3, 3) and put on the ground."""
    points = cloud.points @ rotation.T
    shift = centre_on_ground(points)
    mesh = cloud.mesh and Mesh(cloud.mesh.vertices @ rotation.T - shift, cloud.mesh.faces)
    return Cloud(points - shift, cloud.name, mesh)


def filled(cloud: Cloud) -> Cloud:
    """Return a cloud whose gaps between neighbouring points are filled, itself where it is dense or has a mesh.

    Triangles of neighbours are filled whose circle is small against how far points are apart, and never as large as an
    object's mouth. The order of the points does not matter.
    """
    if cloud.mesh is not None or not NEIGHBORS[1] < len(cloud) <= MANY:
        return cloud
    some = cloud.points[:: max(1, len(cloud) // LOOKED_AT)]
    if np.median(cloud.tree.query(some, NEIGHBORS[0] + 1)[0][:, -1]) < SPARSE:
        return cloud
    from .thinning import one_per_cell  # compiled kernels, which no answer that was kept needs

    triangles = cloud.points[neighbouring(cloud.points, cloud.tree)]
    more = on_triangles(triangles)
    more = one_per_cell(more, PITCH, corners_of(more)) if len(more) else more
    return Cloud(placed(np.concatenate([cloud.points, more])), cloud.name)


def neighbouring(points: np.ndarray, tree: cKDTree) -> np.ndarray:
    """Return the triangles (T, 3) of points (N, 3) with two of their neighbours each whose circles are small."""
    distances, near = tree.query(points, NEIGHBORS[1] + 1)
    first, second = np.triu_indices(NEIGHBORS[1], 1)
    owner = np.repeat(np.arange(len(points)), len(first))
    triangles = np.column_stack([owner, near[:, 1 + first].ravel(), near[:, 1 + second].ravel()])
    reach = np.minimum(REACH[0] * distances[:, NEIGHBORS[0]], REACH[1])
    small = circle_radii(points[triangles]) < np.repeat(reach, len(first))
    return np.unique(np.sort(triangles[small], axis=1), axis=0)


def circle_radii(triangles: np.ndarray) -> np.ndarray:
    """Return the radius of the circle through the corners of triangles (T, 3, 3), (T,); infinite of flat ones."""
    sides = np.linalg.norm(triangles - np.roll(triangles, 1, axis=1), axis=2)
    edges = triangles[:, 1:] - triangles[:, :1]
    areas = np.linalg.norm(np.cross(edges[:, 0], edges[:, 1]), axis=1) / 2
    return np.divide(sides.prod(axis=1), 4 * areas, out=np.full(len(areas), np.inf), where=areas > 1e-12)


def on_triangles(triangles: np.ndarray) -> np.ndarray:
    """Return points (M, 3) on triangles (T, 3, 3), no farther apart than `PITCH` along their sides."""
    longest = np.linalg.norm(triangles - np.roll(triangles, 1, axis=1), axis=2).max(axis=1, initial=0)
    steps, parts = np.ceil(longest / PITCH).astype(int), [np.empty((0, 3))]
    for count in np.unique(steps[steps > 1]).tolist():
        i, j = np.meshgrid(np.arange(count + 1), np.arange(count + 1), indexing="ij")
        inside = i + j <= count
        weights = np.stack([i[inside], j[inside], count - i[inside] - j[inside]], axis=1) / count
        parts.append(np.einsum("wc,tcx->twx", weights, triangles[steps == count]).reshape(-1, 3))
    return np.concatenate(parts)


def heading(cloud: Cloud) -> float:
    """Return the angle, radians, by which a cloud is to be turned about z so that its footprint lies along the axes.

    The longer side comes to lie along x, and of both ways round the one with more of it beyond the middle.
    """
    return cloud.cached("heading", lambda: heading_of(cloud.points[:, :2]))


def heading_of(places: np.ndarray) -> float:
    """Return the angle for places (N, 2), metres; see `heading`."""
    corners = convex_outline(places[~well_within(places)])
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
    """Return points (N, 3), or places on the ground (N, 2), turned about z by an angle, radians."""
    cosine, sine = np.cos(angle), np.sin(angle)
    x, y = points[:, 0], points[:, 1]
    return np.column_stack([cosine * x - sine * y, sine * x + cosine * y, points[:, 2:]])


def headed(cloud: Cloud) -> tuple[Cloud, float]:
    """Return a cloud turned to its heading, and by which angle; the cloud itself where it lies along the axes."""
    angle = heading(cloud)
    if abs(angle) < SQUARE or abs(abs(angle) - np.pi / 2) < SQUARE:
        return cloud, 0.0
    return cloud.cached("headed", lambda: turned_cloud(cloud, angle)), angle


def turned_cloud(cloud: Cloud, angle: float) -> Cloud:
    """Return a cloud, and its mesh, turned about z by an angle, radians."""
    mesh = cloud.mesh and Mesh(turned(cloud.mesh.vertices, angle), cloud.mesh.faces)
    return Cloud(turned(cloud.points, angle), cloud.name, mesh)
