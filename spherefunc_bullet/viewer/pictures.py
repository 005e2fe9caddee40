"""Pictures of settled spheres on an object, ray-traced on the CPU without a display (paper, Fig. 1)."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from PIL.Image import Image, Resampling, fromarray

from ..clouds.cloud import Cloud
from ..clouds.raycasting import raycasting_scene, rays_from
from .colours import FLAT, sphere_colours

if TYPE_CHECKING:
    from open3d.t.geometry import RaycastingScene

OBJECT_COLOUR = np.array([0.80, 0.77, 0.72])
CUT_COLOUR = np.array([0.72, 0.42, 0.30])  # of material that a cut exposes
GROUND_COLOUR = np.array([0.955, 0.955, 0.965])
LIGHT = np.array([-0.45, -0.6, 0.95]) / np.linalg.norm([-0.45, -0.6, 0.95])
CUT_BELOW = 0.5  # metres: smaller objects are cut open
SPHERES_ACROSS = 30  # of a picture: approximate number of radii along an object's largest extent
MAX_POINTS = 60_000  # of a cloud; more are thinned, since a picture has no more pixels for them


@dataclass(frozen=True, kw_only=True)
class CameraView:
    """The view of a picture, and its size."""

    azimuth_deg: float = -120.0  # of the camera about z, 0 from +x; fronts face -y, so this is the front left
    elevation_deg: float = 25.0
    size: tuple[int, int] = (640, 520)  # pixels
    cut: bool = False  # take away the half in front of the vertical plane through the centre, to look inside
    supersample: int = 2

    @property
    def toward(self) -> np.ndarray:
        """Unit vector (3,) from the scene to the camera."""
        azimuth, elevation = np.radians([self.azimuth_deg, self.elevation_deg])
        level = np.cos(elevation)
        return np.array([level * np.cos(azimuth), level * np.sin(azimuth), np.sin(elevation)])

    @property
    def facing(self) -> np.ndarray:
        """Level unit vector (3,) to the camera, the normal of the cut."""
        azimuth = np.radians(self.azimuth_deg)
        return np.array([np.cos(azimuth), np.sin(azimuth), 0.0])


@dataclass(frozen=True, eq=False)
class PicturePart:
    """A part of a picture that rays can hit: a scene of triangles, or of balls made of triangles."""

    scene: RaycastingScene
    colours: np.ndarray  # (1, 3), or (S, 3) of balls
    centers: np.ndarray | None = None  # (S, 3) of balls, metres; their normals come from the centres
    faces_per_ball: int = 1
    solid: bool = False  # closed: a cut shows material where a ray starts inside

    def surface(self, triangle: np.ndarray, normals: np.ndarray, where: np.ndarray):
        """Return colours and normals (..., 3) of the places (..., 3) where rays hit."""
        if self.centers is None:
            return np.broadcast_to(self.colours[0], where.shape), normals
        ball = np.where(triangle < len(self.centers) * self.faces_per_ball, triangle // self.faces_per_ball, 0)
        outward = where - self.centers[ball]
        return self.colours[ball], outward / np.maximum(np.linalg.norm(outward, axis=-1, keepdims=True), 1e-12)


@dataclass(frozen=True, eq=False)
class Rays:
    """One ray through each pixel, orthographic."""

    origins: np.ndarray  # (H, W, 3) metres
    directions: np.ndarray  # (H, W, 3) unit vectors

    def places(self, distance: np.ndarray) -> np.ndarray:
        """Return the places (H, W, 3) that rays reach after a distance (H, W), metres."""
        return self.origins + self.directions * distance[..., None]

    def beyond_cut(self, view: CameraView, centre: np.ndarray) -> Rays:
        """Return the rays, beginning at the plane of the cut through the centre if there is a cut."""
        if not view.cut:
            return self
        travel = ((centre - self.origins) @ view.facing) / (self.directions @ view.facing)
        return replace(self, origins=self.places(travel))

    def first_hits(self, scene: RaycastingScene) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return the distance (inf for none), triangle and unit normal of the first hit of each ray."""
        hit = scene.cast_rays(rays_from(self.origins, self.directions))
        return hit["t_hit"].numpy(), hit["primitive_ids"].numpy(), hit["primitive_normals"].numpy()


def render(
    vertices: np.ndarray,
    faces: np.ndarray | None,
    centers: np.ndarray,
    radius: float,
    view: CameraView,
    colours: np.ndarray | None = None,
    shown: tuple[np.ndarray, np.ndarray] | None = None,
) -> Image:
    """Draw an object and the spheres that settled on it.

    Parameters
    ----------
    vertices, faces : (N, 3) float, (M, 3) int
        The object, metres, z up. Without faces it is a cloud, and its points are drawn as little balls.
    centers : (S, 3) float
        Settled spheres, metres.
    radius : float
        Of the spheres, metres.
    view : CameraView
    colours : (S, 3) float, optional
        Of the spheres, 0 to 1; by default they are coloured by height.
    shown : two (3,) float, optional
        Lowest and highest corner of the box that the picture frames, metres; by default it frames all that is drawn.
    """
    vertices = np.asarray(vertices, float)
    centers = np.asarray(centers, float).reshape(-1, 3)
    low, high = drawn_box(vertices, centers, radius) if shown is None else shown
    rays = camera_rays(view, low, high)
    parts = [object_part(vertices, faces)]
    behind = np.full(len(centers), not view.cut) | ((centers - (low + high) / 2) @ view.facing <= 0)  # the cut's plane
    if behind.any():
        colours = sphere_colours(centers[:, 2], FLAT * radius) if colours is None else colours
        parts.append(ball_part(centers[behind], radius, colours[behind]))
    image, nearest = ground_image(rays, parts, view, (low, high)), np.full(rays.origins.shape[:2], np.inf)
    for part in parts:
        # Balls are drawn whole, since none is cut; of the object only the part behind the plane is drawn.
        begun = rays if part.centers is not None else rays.beyond_cut(view, (low + high) / 2)
        skipped = np.linalg.norm(begun.origins - rays.origins, axis=-1)
        distance, triangle, normals = begun.first_hits(part.scene)
        inside = part.solid & view.cut & ((normals * rays.directions).sum(-1) > 0)
        distance = np.where(inside, 0.0, distance) + skipped
        seen = np.isfinite(distance) & (distance < nearest)
        where = rays.places(np.where(seen, distance, 0))
        tints, normals = part.surface(triangle, normals, where)
        tints = np.where(inside[..., None], CUT_COLOUR, tints)
        normals = np.where(inside[..., None], view.facing, normals)
        lit = ~shadowed(parts, where, normals, view)
        image[seen] = shade(tints, normals, rays.directions, lit)[seen]
        nearest[seen] = distance[seen]
    picture = fromarray((np.clip(image, 0, 1) * 255).astype(np.uint8))
    return picture.resize(view.size, Resampling.LANCZOS)


def render_balls(cloud: Cloud, centers: np.ndarray, radius: float, colours: np.ndarray, view: CameraView) -> Image:
    """Draw an object and balls on it, each of its own colour (S, 3)."""
    vertices, faces = (cloud.points, None) if cloud.mesh is None else (cloud.mesh.vertices, cloud.mesh.faces)
    return render(vertices, faces, centers, radius, view, colours)


def object_picture(cloud: Cloud, centers: np.ndarray, radius: float, view: CameraView) -> Image:
    """Draw an object as `render` does; a small one is cut open to show the spheres inside.

    A cloud has no surface to cut, so its points in front of the plane are left out, and the spheres among them.
    """
    view = replace(view, cut=view.cut or is_cut(cloud))
    if cloud.mesh is not None:
        return render(cloud.mesh.vertices, cloud.mesh.faces, centers, radius, view)
    points = cloud.points
    if view.cut:
        points, centers = (places[places @ view.facing <= 0] for places in (points, centers))
    return render(points, None, centers, radius, replace(view, cut=False))


def is_cut(cloud: Cloud) -> bool:
    """Return whether an object is so small that it is cut open."""
    return bool(cloud.size.max() < CUT_BELOW)


def fitting_radius(radii: Iterable[float], size: np.ndarray, across: float) -> float:
    """Return the radius of which about ``across`` make the largest extent of an object of a size (3,), metres."""
    return min(radii, key=lambda radius: abs(radius * across - size.max()))


def drawn_box(vertices: np.ndarray, centers: np.ndarray, radius: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the lowest and highest corner (3,) of object and spheres, down to the ground, metres."""
    corners = np.concatenate([vertices, centers - radius, centers + radius])
    return np.minimum(corners.min(axis=0), [np.inf, np.inf, 0.0]), corners.max(axis=0)


def camera_rays(view: CameraView, low: np.ndarray, high: np.ndarray) -> Rays:
    """Return rays that frame the box [low, high]."""
    toward = view.toward
    right = np.array([-view.facing[1], view.facing[0], 0.0])
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
    return Rays(origins, np.broadcast_to(-toward, origins.shape))


def object_part(vertices: np.ndarray, faces: np.ndarray | None) -> PicturePart:
    """Return an object as a part: its mesh, or the points of a cloud as balls that touch their neighbours."""
    import trimesh

    if faces is None or len(faces) == 0:
        from scipy.spatial import cKDTree

        points = vertices[:: -(-len(vertices) // MAX_POINTS)]
        distances, _ = cKDTree(points).query(points, k=2)
        colours = np.broadcast_to(OBJECT_COLOUR, points.shape)
        return ball_part(points, 0.9 * float(np.median(distances[:, 1])), colours)
    mesh = trimesh.Trimesh(vertices, faces)  # merges equal vertices, without which nothing is closed
    return PicturePart(raycasting_scene((vertices, faces)), OBJECT_COLOUR[None], solid=mesh.is_watertight)


def ball_part(centers: np.ndarray, radius: float, colours: np.ndarray) -> PicturePart:
    """Return balls as a part, coarser the more there are."""
    import trimesh

    subdivisions = 3 if len(centers) < 2000 else 2 if len(centers) < 8000 else 1 if len(centers) < 30_000 else 0
    ball = trimesh.creation.icosphere(subdivisions=subdivisions, radius=radius)
    vertices = (centers[:, None, :] + ball.vertices[None]).reshape(-1, 3)
    faces = (np.arange(len(centers))[:, None, None] * len(ball.vertices) + ball.faces[None]).reshape(-1, 3)
    return PicturePart(raycasting_scene((vertices, faces)), colours, centers, len(ball.faces))


def shade(colours: np.ndarray, normals: np.ndarray, directions: np.ndarray, lit: np.ndarray) -> np.ndarray:
    """Return Lambert-shaded colours, two-sided, darker where ``lit`` is False."""
    facing = np.where((normals * directions).sum(-1, keepdims=True) > 0, -normals, normals)
    diffuse = np.clip(facing @ LIGHT, 0, 1) * np.where(lit, 1.0, 0.35)
    return colours * (0.42 + 0.58 * diffuse[..., None])


def shadowed(parts: list[PicturePart], where: np.ndarray, normals: np.ndarray, view: CameraView) -> np.ndarray:
    """Return which places the light does not reach, (H, W) bool; the inside of a cut object is lit."""
    offset = 1e-3 * np.linalg.norm(np.ptp(where.reshape(-1, 3), axis=0))  # off the surface, or it shades itself
    start = where + LIGHT * offset + np.where((normals @ LIGHT)[..., None] > 0, normals, -normals) * offset
    rays, blocked = rays_from(start, LIGHT), np.zeros(where.shape[:2], bool)
    for part in parts[1:] if view.cut else parts:
        blocked |= part.scene.test_occlusions(rays).numpy()
    return blocked


def ground_image(
    rays: Rays, parts: list[PicturePart], view: CameraView, shown: tuple[np.ndarray, np.ndarray]
) -> np.ndarray:
    """Return the ground plane with the shadows on it as an image (H, W, 3).

    They fade within half of the largest extent of the box that is shown, so that none ends at the edge of the picture.
    """
    where = rays.places(-rays.origins[..., 2] / rays.directions[..., 2])
    upward = np.broadcast_to([0.0, 0.0, 1.0], where.shape)
    dark = shadowed(parts, where, upward, replace(view, cut=False))
    low, high = shown
    beside = np.maximum(np.maximum(low - where, where - high), 0)[..., :2]
    left = np.clip(1 - 2 * np.linalg.norm(beside, axis=-1) / (high - low).max(), 0, 1)
    return GROUND_COLOUR * (1 - 0.18 * (dark * left)[..., None])
