"""A place: where and how one function of an object can be used."""

from __future__ import annotations

from dataclasses import dataclass, field, fields, replace
from typing import Any

import numpy as np

KINDS = ("sit", "put", "pour")
SHOWN = 0.05  # least score of a place that is shown; it is lower on an object without the function
POSE_DIGITS = 12  # decimals of poses for JSON: with 5, an object at UTM coordinates would be put down metres aside
FUNCTION = {"sit": "sittable", "put": "table", "pour": "cup"}  # the function that a kind of place belongs to


@dataclass(frozen=True, kw_only=True)
class Proof:
    """The result of using a place in a backend."""

    backend: str
    trials: int
    held: int  # number of trials that held
    why: tuple[str, ...]  # the others failed, see `simulator.proofs.REASONS`

    @property
    def holds(self) -> bool:
        """Whether most trials held."""
        return 2 * self.held > self.trials

    def __str__(self) -> str:
        return f"held {self.held} of {self.trials}" + (f" ({', '.join(self.why)})" if self.why else "")


@dataclass(frozen=True, kw_only=True, eq=False)
class Place:
    """One place, in the coordinates and units of the input; optional fields are None where they say nothing."""

    kind: str  # sit, put or pour
    function: str  # sittable, table or cup
    position: np.ndarray  # (3,) middle of the seat or of the free region; for pour, above the opening
    normal: np.ndarray = field(default_factory=lambda: np.array([0.0, 0.0, 1.0]))  # (3,) of the surface, length 1
    heading_deg: float | None = None  # counter-clockwise from +x: the way a sitter faces, the side it is poured from
    region: tuple[np.ndarray, ...]  # rings (K, 3): the outline, then holes
    area: float  # of the region
    height: float  # of the surface above the ground that the object stands on; of the brim for pour
    clearance: float | None = None  # free height above the surface; None: open
    score: float  # 0 to 1
    proven: Proof | None = None
    # sit
    depth: float | None = None  # of the seat, front to back
    back: bool | None = None
    arms: bool | None = None
    knees: bool | None = None  # whether there is room for knees and feet in front of the seat
    # put
    radius: float | None = None  # of the largest disc that fits around the position
    poses: tuple[np.ndarray, ...] = ()  # (4, 4), from the frame of the object that is put to the input's, best first
    margins: tuple[float, ...] = ()  # of each pose: from an edge or from what stands there
    # pour
    capacity_ml: float | None = None  # to the brim
    filled_ml: float | None = None  # nine tenths of that
    levels: tuple[tuple[float, float], ...] = ()  # (millilitres, height of the surface)
    spill_tilt_deg: float | None = None  # filled to nine tenths, it begins to spill when tilted so far
    spill_heading_deg: float | None = None  # towards this side
    inside: tuple[np.ndarray, ...] = ()  # (3,) opposite corners of the upright box about what it holds, the lower first
    inferred: bool = False  # the surface itself was not seen
    note: str = ""

    def moved(self, to_input: Similarity) -> Place:
        """Return the place in the frame from which an object came."""
        return replace(
            self,
            position=to_input.points(self.position),
            normal=to_input.rotation @ self.normal,
            heading_deg=to_input.heading(self.heading_deg),
            spill_heading_deg=to_input.heading(self.spill_heading_deg),
            region=tuple(to_input.points(ring) for ring in self.region),
            area=self.area * to_input.scale**2,
            inside=tuple(to_input.points(corner) for corner in self.inside),
            poses=tuple(to_input.pose(pose) for pose in self.poses),
            margins=tuple(margin * to_input.scale for margin in self.margins),
            levels=tuple((millilitres, to_input.scale * level) for millilitres, level in self.levels),
            **{
                name: None if getattr(self, name) is None else to_input.scale * getattr(self, name)
                for name in ("height", "clearance", "depth", "radius")
            },
        )

    def moved_back(self, to_input: Similarity) -> Place:
        """Return the place in the frame from which `moved` took it, where z is up: headings count about that axis."""
        turn = to_input.heading(0.0)
        names = ("heading_deg", "spill_heading_deg")
        known = {name: heading for name in names if (heading := getattr(self, name)) is not None}
        headings = {name: (heading - turn) % 360 for name, heading in known.items()}
        return replace(self.moved(to_input.inverse()), **headings)

    def as_json(self) -> dict[str, Any]:
        """Return the JSON entry of a place, without fields that are None or empty."""
        row = {part.name: getattr(self, part.name) for part in fields(self)}
        always = ("heading_deg", "clearance", "proven")
        empty = {name for name, value in row.items() if value is None or (isinstance(value, str | tuple) and not value)}
        entry = {name: plain(value) for name, value in row.items() if name in always or name not in empty}
        return entry | {"poses": [pose.round(POSE_DIGITS).tolist() for pose in self.poses]} if self.poses else entry


def plain(value: Any) -> Any:
    """Return a value for JSON, with numbers rounded to five decimals."""
    if isinstance(value, Proof):
        return {part.name: plain(getattr(value, part.name)) for part in fields(value)}
    if isinstance(value, np.ndarray):
        return np.round(value, 5).tolist()
    if isinstance(value, tuple):
        return [plain(item) for item in value]
    if isinstance(value, np.bool_):
        return bool(value)
    return round(float(value), 5) if isinstance(value, float | np.floating) else value


@dataclass(frozen=True, eq=False)
class Similarity:
    """A transformation from one frame to another: scaling, rotation and translation."""

    rotation: np.ndarray  # (3, 3)
    scale: float
    shift: np.ndarray  # (3,)

    def points(self, points: np.ndarray) -> np.ndarray:
        """Return points (..., 3) in the other frame."""
        return self.scale * points @ self.rotation.T + self.shift

    def heading(self, heading_deg: float | None) -> float | None:
        """Return a heading in the other frame, about its upward direction: from its x axis, or from y if x is up."""
        if heading_deg is None:
            return None
        angle, up = np.radians(heading_deg), self.rotation[:, 2]
        ahead = self.rotation @ [np.cos(angle), np.sin(angle), 0.0]
        axis = np.eye(3)[0 if abs(up[0]) < 0.9 else 1]
        level = axis - (axis @ up) * up
        return float(np.degrees(np.arctan2(up @ np.cross(level, ahead), level @ ahead)) % 360)

    def inverse(self) -> Similarity:
        """Return the transformation from the other frame to this one."""
        back = self.rotation.T
        return Similarity(back, 1 / self.scale, -back @ self.shift / self.scale)

    def pose(self, pose: np.ndarray) -> np.ndarray:
        """Return a rigid pose (4, 4) in the other frame, its translation in the units of that frame."""
        moved = np.eye(4)
        moved[:3, :3] = self.rotation @ pose[:3, :3]
        moved[:3, 3] = self.points(pose[:3, 3])
        return moved


IDENTITY = Similarity(np.eye(3), 1.0, np.zeros(3))


def similarity_between(points: np.ndarray, others: np.ndarray) -> Similarity:
    """Return the similarity from points (N, 3) to others (N, 3), the same ones scaled, turned along axes and moved."""
    ours, theirs = points - points.mean(axis=0), others - others.mean(axis=0)
    scale = float(np.sqrt((theirs**2).sum() / (ours**2).sum()))
    u, _, vt = np.linalg.svd(theirs.T @ ours)
    rotation = u @ np.diag([1.0, 1.0, np.linalg.det(u @ vt)]) @ vt
    whole = np.round(rotation)
    if np.abs(rotation - whole).max() < 1e-3:
        rotation = whole + 0.0
    return Similarity(rotation, scale, others.mean(axis=0) - scale * rotation @ points.mean(axis=0))
