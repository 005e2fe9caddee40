"""Pictures of settled spheres on an object, ray-traced on the CPU without a display (paper, Fig. 1)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

# Viridis, thinned: even in lightness, and readable without colour vision.
HEIGHT_COLOURS = np.array(
    [[68, 1, 84], [65, 68, 135], [42, 120, 142], [34, 168, 132], [122, 209, 81], [253, 231, 37]], float
) / 255
OBJECT_COLOUR = np.array([0.80, 0.77, 0.72])
GROUND_COLOUR = np.array([0.955, 0.955, 0.965])
LIGHT = np.array([-0.45, -0.6, 0.95]) / np.linalg.norm([-0.45, -0.6, 0.95])


@dataclass(frozen=True, kw_only=True)
class View:
    """Where the picture is taken from, and how large it is."""

    azimuth_deg: float = -60.0  # of the camera about z, 0 from +x, -90 from the front
    elevation_deg: float = 25.0
    size: tuple[int, int] = (640, 520)  # pixels
    cut: bool = False  # take away the object's front half, to look inside
    supersample: int = 2


def sphere_colours(heights: np.ndarray) -> np.ndarray:
    """Return colours (S, 3) in 0..1, dark to bright from the lowest height (S,) to the highest."""
    span = np.ptp(heights) or 1.0
    at = (heights - heights.min()) / span * (len(HEIGHT_COLOURS) - 1)
    return np.stack([np.interp(at, range(len(HEIGHT_COLOURS)), channel) for channel in HEIGHT_COLOURS.T], axis=1)


def camera_rays(view: View, low: np.ndarray, high: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return origins and unit directions (H, W, 3) of orthographic rays that frame the box [low, high]."""
    azimuth, elevation = np.radians([view.azimuth_deg, view.elevation_deg])
    toward = np.array(
        [np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation)]
    )
    right = np.array([-np.sin(azimuth), np.cos(azimuth), 0.0])
    up = np.cross(toward, right)
    corners = np.array(np.meshgrid(*zip(low, high, strict=True))).reshape(3, -1).T
    centre = (low + high) / 2
    across, along = (corners - centre) @ right, (corners - centre) @ up
    width, height = (n * view.supersample for n in view.size)
    scale = 1.12 * max(np.ptp(across) / width, np.ptp(along) / height)
    u = (np.arange(width) - width / 2 + 0.5) * scale + (across.max() + across.min()) / 2
    v = -(np.arange(height) - height / 2 + 0.5) * scale + (along.max() + along.min()) / 2
    distance = 4 * np.linalg.norm(high - low)
    origins = centre + toward * distance + u[None, :, None] * right + v[:, None, None] * up
    return origins, np.broadcast_to(-toward, origins.shape)


def raycasting_scene(vertices: np.ndarray, faces: np.ndarray):
    """Return an Open3D scene of one triangle mesh."""
    import open3d as o3d

    scene = o3d.t.geometry.RaycastingScene()
    scene.add_triangles(
        o3d.core.Tensor(np.ascontiguousarray(vertices, dtype=np.float32)),
        o3d.core.Tensor(np.ascontiguousarray(faces, dtype=np.uint32)),
    )
    return scene


def sphere_triangles(centers: np.ndarray, radius: float) -> tuple[np.ndarray, np.ndarray, int]:
    """Return one mesh of all spheres (vertices, faces) and the faces per sphere; coarser the more there are."""
    import trimesh

    ball = trimesh.creation.icosphere(subdivisions=2 if len(centers) < 4000 else 1, radius=radius)
    vertices = (centers[:, None, :] + ball.vertices[None]).reshape(-1, 3)
    faces = (np.arange(len(centers))[:, None, None] * len(ball.vertices) + ball.faces[None]).reshape(-1, 3)
    return vertices, faces, len(ball.faces)


def first_hits(scene, origins: np.ndarray, directions: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return distance (inf for none), triangle and unit normal of what each ray hits first."""
    import open3d as o3d

    rays = np.concatenate([origins, directions], axis=-1).astype(np.float32)
    hit = scene.cast_rays(o3d.core.Tensor(rays))
    return hit["t_hit"].numpy(), hit["primitive_ids"].numpy(), hit["primitive_normals"].numpy()


def shade(colours: np.ndarray, normals: np.ndarray, directions: np.ndarray, lit: np.ndarray) -> np.ndarray:
    """Return Lambert-shaded colours, two-sided, darker where ``lit`` is False."""
    facing = np.where((normals * directions).sum(-1, keepdims=True) > 0, -normals, normals)
    diffuse = np.clip(facing @ LIGHT, 0, 1) * np.where(lit, 1.0, 0.35)
    return colours * (0.42 + 0.58 * diffuse[..., None])


def render(vertices, faces, centers, radius: float, view: View | None = None):
    """Draw a mesh and the spheres that settled on it.

    Parameters
    ----------
    vertices, faces : (N, 3) float, (M, 3) int
        The object, metres, z up.
    centers : (S, 3) float
        Settled spheres, metres; coloured by height.
    radius : float
        Of the spheres, metres.
    view : View

    Returns
    -------
    PIL.Image.Image
    """
    from PIL import Image

    view = view or View()
    ball_vertices, ball_faces, per_ball = sphere_triangles(centers, radius)
    everything = np.concatenate([vertices, ball_vertices])
    low, high = everything.min(axis=0), everything.max(axis=0)
    low[2] = 0.0
    origins, directions = camera_rays(view, low, high)
    scenes = [raycasting_scene(vertices, faces)]
    if len(centers):
        scenes.append(raycasting_scene(ball_vertices, ball_faces))
    starts = [clipped(origins, directions, view, (low + high) / 2), origins]

    image = ground_image(origins, directions, scenes, low, high)
    nearest = np.full(origins.shape[:2], np.inf, np.float32)
    for index, (scene, start) in enumerate(zip(scenes, starts, strict=False)):
        distance, triangle, normals = first_hits(scene, start, directions)
        distance = distance + np.linalg.norm(start - origins, axis=-1)
        seen = np.isfinite(distance) & (distance < nearest)
        where = origins + directions * np.where(seen, distance, 0)[..., None]
        colours = np.broadcast_to(OBJECT_COLOUR, origins.shape)
        if index == 1:
            ball = np.where(seen, triangle // per_ball, 0)
            colours, normals = sphere_colours(centers[:, 2])[ball], (where - centers[ball]) / radius
        lit = ~shadowed(scenes, where, radius, view)
        image[seen] = shade(colours, normals, directions, lit)[seen]
        nearest[seen] = distance[seen]
    picture = Image.fromarray((np.clip(image, 0, 1) * 255).astype(np.uint8))
    return picture.resize(view.size, Image.Resampling.LANCZOS)


def clipped(origins: np.ndarray, directions: np.ndarray, view: View, centre: np.ndarray) -> np.ndarray:
    """Return origins moved past a vertical plane through the centre that faces the camera, if it is cut."""
    if not view.cut:
        return origins
    azimuth = np.radians(view.azimuth_deg)
    normal = np.array([np.cos(azimuth), np.sin(azimuth), 0.0])
    travel = ((centre - origins) @ normal) / (directions @ normal)
    return origins + directions * travel[..., None]


def shadowed(scenes, where: np.ndarray, radius: float, view: View) -> np.ndarray:
    """Tell which places the light does not reach; inside a cut object the light comes in."""
    toward = np.broadcast_to(LIGHT, where.shape)
    start = where + LIGHT * 0.02 * radius
    blocked = np.zeros(where.shape[:2], bool)
    for scene in scenes[1:] if view.cut else scenes:
        blocked |= np.isfinite(first_hits(scene, start, toward)[0])
    return blocked


def ground_image(origins, directions, scenes, low, high) -> np.ndarray:
    """Return the ground plane with the object's shadow as an image (H, W, 3)."""
    travel = -origins[..., 2] / directions[..., 2]
    where = origins + directions * travel[..., None]
    dark = shadowed(scenes, where + [0, 0, 1e-4], 1e-3, View())
    return np.where(dark[..., None], GROUND_COLOUR * 0.82, GROUND_COLOUR)
