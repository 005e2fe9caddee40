"""Solids from which catalogue objects are built: lofts, sweeps, lathes, prisms and thick sheets.

Everything is in metres, z up. Every solid is closed and faces outward, and is made of its own vertices, so
that solids joined into one object may overlap and the object still counts as watertight. No solid needs a
boolean backend or a polygon library.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np
import trimesh
from numpy.typing import ArrayLike

from spherefunc_bullet.formats.sources import joined_meshes

from .outlines import at_height, circle, rectangle, rounded_rectangle


def loft(rings: ArrayLike, *, loop: bool = False, capped: bool = True) -> trimesh.Trimesh:
    """Return the surface through rings of equally many points.

    Parameters
    ----------
    rings : array_like (K, N, 3)
        Closed rings, metres. A ring that ends the loft must be star-shaped about its centroid, where its cap
        has its middle.
    loop : bool
        Joins the last ring to the first instead of capping both.
    capped : bool
        False leaves both ends open: a single-sided shell.
    """
    rings = np.asarray(rings, dtype=float)
    count, size = rings.shape[:2]
    vertices, faces = [rings.reshape(-1, 3)], [_walls(count, size, loop)]
    if capped and not loop:
        here, there = np.arange(size), (np.arange(size) + 1) % size
        top = (count - 1) * size
        vertices.append(np.stack([rings[0].mean(axis=0), rings[-1].mean(axis=0)]))
        faces.append(np.stack([there, here, np.full(size, count * size)], axis=1))
        faces.append(np.stack([top + here, top + there, np.full(size, count * size + 1)], axis=1))
    return _outward(np.concatenate(vertices), np.concatenate(faces))


def _walls(count: int, size: int, loop: bool = False) -> np.ndarray:
    """Return the triangles (F, 3) between each ring of ``size`` points and the next."""
    lower = np.arange(count if loop else count - 1)[:, None] * size
    upper = (lower + size) % (count * size)
    here, there = np.arange(size), (np.arange(size) + 1) % size
    a, b, c, d = lower + here, lower + there, upper + there, upper + here
    halves = [np.stack([a, b, c], axis=-1), np.stack([a, c, d], axis=-1)]
    return np.concatenate([half.reshape(-1, 3) for half in halves])


def _outward(vertices: np.ndarray, faces: np.ndarray) -> trimesh.Trimesh:
    mesh = trimesh.Trimesh(vertices, faces, process=False)
    corners = mesh.triangles
    signed_volume = np.einsum("ij,ij->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2]))
    return mesh if signed_volume >= 0 else trimesh.Trimesh(vertices, faces[:, ::-1], process=False)


def prism(outline: np.ndarray, height: float, z: float = 0.0) -> trimesh.Trimesh:
    """Return an upright prism on z over an outline (N, 2)."""
    return loft([at_height(outline, z), at_height(outline, z + height)])


def stacked(outline: np.ndarray, steps: Iterable[tuple[float, ...]]) -> trimesh.Trimesh:
    """Return the loft through an outline (N, 2) at several heights.

    Parameters
    ----------
    steps : iterable of (scale, z) or (x scale, y scale, z)
        Factors of the outline, and its height, metres.
    """
    return loft([at_height(outline * scale, z) for *scale, z in steps])


def box(width: float, depth: float, height: float, x: float = 0, y: float = 0, z: float = 0) -> trimesh.Trimesh:
    """Return a box whose bottom face is centred on (x, y, z)."""
    return prism(rectangle(width, depth) + [x, y], height, z)


def cushion(
    width: float, depth: float, height: float, x: float = 0, y: float = 0, z: float = 0,
    *, rounding: float = 0.03, corner: float = 0.06, crown: float = 0.0,
) -> trimesh.Trimesh:
    """Return a box with rounded edges whose bottom is centred on (x, y, z); ``crown`` domes its top."""
    rounding = min(rounding, 0.45 * height, 0.3 * width, 0.3 * depth)
    angles = np.linspace(0, np.pi / 2, 4)
    insets, rises, body = rounding * (1 - np.sin(angles)), rounding * (1 - np.cos(angles)), height - crown

    def outline(inset: float) -> np.ndarray:
        return rounded_rectangle(width - 2 * inset, depth - 2 * inset, max(corner - inset, 0.002)) + [x, y]

    rings = [at_height(outline(i), z + r) for i, r in zip(insets, rises, strict=True)]
    rings += [at_height(outline(i), z + body - r) for i, r in zip(insets[::-1], rises[::-1], strict=True)]
    edge = outline(rounding) - [x, y]
    domes = [(s, 1 - s**2) for s in (0.75, 0.5, 0.25)] if crown else []
    rings += [at_height(edge * s + [x, y], z + body + crown * rise) for s, rise in domes]
    return loft(rings)


def lathe(profile: ArrayLike, *, sections: int = 32, loop: bool = False, capped: bool = True) -> trimesh.Trimesh:
    """Return a solid of revolution about the z axis.

    Parameters
    ----------
    profile : array_like (K, 2)
        Radius and height in metres along the outline, from the middle of the bottom, over the outside, to the
        middle of the top; a vessel's profile goes back down its inside to the middle of its floor.
    loop : bool
        The profile closes on itself, away from the axis.
    capped : bool
        False leaves both ends open.
    """
    return loft([at_height(circle(max(radius, 1e-4), sections), z) for radius, z in profile], loop=loop, capped=capped)


def ellipsoid(
    width: float, depth: float, height: float, x: float = 0, y: float = 0, z: float = 0, *, sections: int = 20
) -> trimesh.Trimesh:
    """Return an ellipsoid centred on (x, y, z)."""
    angles = np.linspace(0.08, np.pi - 0.08, sections // 2 + 1)
    ball = lathe(np.stack([np.sin(angles), -np.cos(angles)], axis=1), sections=sections)
    ball.apply_scale([width / 2, depth / 2, height / 2])
    return shift(ball, x, y, z)


def sweep(path: ArrayLike, section: ArrayLike, *, scale: ArrayLike = 1.0, loop: bool = False) -> trimesh.Trimesh:
    """Return a section carried along a path without twist.

    Parameters
    ----------
    path : array_like (K, 3)
        Metres.
    section : array_like (N, 2)
        The first axis stays level if the path is level; on an upright path the two axes are x and y.
    scale : float or array_like (K,)
        Of the section at each point of the path.
    loop : bool
        The path closes on itself; its first point is not repeated.
    """
    path, section = np.asarray(path, dtype=float), np.asarray(section, dtype=float)
    scale = np.broadcast_to(scale, len(path))
    tangents = _tangents(path, loop)
    side = _unit(np.cross([0.0, 1.0, 0.0] if abs(tangents[0, 2]) > 0.7 else [0.0, 0.0, 1.0], tangents[0]))
    rings = []
    for point, tangent, size in zip(path, tangents, scale, strict=True):
        side = _unit(side - tangent * (side @ tangent))
        rings.append(point + size * section @ np.stack([side, np.cross(tangent, side)]))
    return loft(rings, loop=loop)


def _tangents(path: np.ndarray, loop: bool) -> np.ndarray:
    """Return unit tangents (K, 3): at each point the mean of the directions before and after it."""
    steps = np.diff(np.concatenate([path, path[:1]]) if loop else path, axis=0)
    steps /= np.linalg.norm(steps, axis=1, keepdims=True)
    before = np.concatenate([steps[-1:], steps[:-1]]) if loop else np.concatenate([steps[:1], steps])
    after = steps if loop else np.concatenate([steps, steps[-1:]])
    mean = before + after
    return mean / np.linalg.norm(mean, axis=1, keepdims=True)


def _unit(vector: np.ndarray) -> np.ndarray:
    return vector / np.linalg.norm(vector)


def tube(
    path: ArrayLike, radius: float, *, sections: int = 10, scale: ArrayLike = 1.0, loop: bool = False
) -> trimesh.Trimesh:
    """Return a round bar along a path (K, 3), metres."""
    return sweep(path, circle(radius, sections), scale=scale, loop=loop)


def hoop(outline: np.ndarray, z: float, radius: float) -> trimesh.Trimesh:
    """Return a round bar bent to an outline (N, 2) at a height, metres."""
    return tube(at_height(outline, z), radius, sections=6, loop=True)


def beam(start: ArrayLike, end: ArrayLike, width: float, depth: float, *, taper: float = 1.0) -> trimesh.Trimesh:
    """Return a rectangular bar between two points; the section at its end is ``taper`` of the first."""
    return sweep([start, end], rectangle(width, depth), scale=[1.0, taper])


def crossbar(length: float, y: float, z: float, width: float, depth: float) -> trimesh.Trimesh:
    """Return a level beam of the given length along x, its middle above x = 0, metres."""
    return beam([-length / 2, y, z], [length / 2, y, z], width, depth)


def rod(start: ArrayLike, end: ArrayLike, radius: float, sections: int = 6) -> trimesh.Trimesh:
    """Return a straight round bar."""
    return tube([start, end], radius, sections=sections)


def rail(length: float, y: float, z: float, radius: float, sections: int = 6) -> trimesh.Trimesh:
    """Return a level round bar from left to right."""
    return rod([-length / 2, y, z], [length / 2, y, z], radius, sections)


def sheet(grid: ArrayLike, thickness: float) -> trimesh.Trimesh:
    """Return a closed solid of even thickness below a grid of surface points (K, N, 3), metres."""
    grid = np.asarray(grid, dtype=float)
    normals = np.cross(np.gradient(grid, axis=0), np.gradient(grid, axis=1))
    normals /= np.linalg.norm(normals, axis=2, keepdims=True)
    normals *= np.sign(normals[..., 2].sum()) or 1.0
    # Each ring runs along a row of the grid and back beneath it; the ends are closed by strips, not fans,
    # because a curved row is not star-shaped.
    rings = np.concatenate([grid, (grid - thickness * normals)[:, ::-1]], axis=1)
    count, size = rings.shape[:2]
    near = np.arange(size // 2 - 1)
    strip = [[near + 1, near, size - 1 - near], [near + 1, size - 1 - near, size - 2 - near]]
    end = np.concatenate([np.stack(triangle, axis=1) for triangle in strip])
    faces = [_walls(count, size), end, end[:, ::-1] + size * (count - 1)]
    return _outward(rings.reshape(-1, 3), np.concatenate(faces))


def shift(mesh: trimesh.Trimesh, x: float = 0, y: float = 0, z: float = 0) -> trimesh.Trimesh:
    """Return a copy moved by (x, y, z) metres."""
    return trimesh.Trimesh(mesh.vertices + [x, y, z], mesh.faces, process=False)


def turn(mesh: trimesh.Trimesh, axis: str, angle_deg: float) -> trimesh.Trimesh:
    """Return a copy turned about the origin's x, y or z axis."""
    angle = np.radians(angle_deg)
    first, second = {"x": (1, 2), "y": (2, 0), "z": (0, 1)}[axis]
    vertices = np.array(mesh.vertices)
    a, b = vertices[:, first].copy(), vertices[:, second].copy()
    vertices[:, first] = np.cos(angle) * a - np.sin(angle) * b
    vertices[:, second] = np.sin(angle) * a + np.cos(angle) * b
    return trimesh.Trimesh(vertices, mesh.faces, process=False)


def join(*parts) -> trimesh.Trimesh:
    """Return one mesh of all parts; a part is a mesh or a list of parts."""
    vertices, faces = joined_meshes([(mesh.vertices, mesh.faces) for mesh in _flat(parts)])
    return trimesh.Trimesh(vertices, faces, process=False)


def _flat(parts: Iterable) -> Iterator[trimesh.Trimesh]:
    for part in parts:
        if isinstance(part, trimesh.Trimesh):
            yield part
        else:
            yield from _flat(part)


def stand(mesh: trimesh.Trimesh) -> trimesh.Trimesh:
    """Return a copy whose bounding box is centred on the z axis and rests on z = 0."""
    low, high = mesh.bounds
    middle = (low + high) / 2
    return shift(mesh, -middle[0], -middle[1], -low[2])
