"""The objects of a scan and what each is for, in one call."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache, cached_property, partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from spherefunc_bullet.clouds.cloud import Cloud
from spherefunc_bullet.clouds.conversion import Anything, geometry_of, warn
from spherefunc_bullet.errors import InputError, one_line
from spherefunc_bullet.formats.units import BY_FILE
from spherefunc_bullet.learning.model_file import inference_model, shipped_model
from spherefunc_bullet.places.finding import cloud_and_frame, places_of, proven
from spherefunc_bullet.places.place import Place, Similarity
from spherefunc_bullet.simulator import make_simulator
from spherefunc_bullet.simulator.mechanics import require_ability
from spherefunc_bullet.simulator.proofs import ProofSettings

from ..scans.camera import Intrinsics
from ..scans.depth_image import is_image_file, load_depth_image, require_depth_image
from ..scans.scan import Scan, load_scan, scan_from_points, surface_points
from ..segmentation.clusters import Box
from ..segmentation.segmentation import Segmentation
from .partial_places import room_places
from .recognition import recognise
from .room import InferredObject, Room, SceneObject

if TYPE_CHECKING:
    from spherefunc_bullet.learning.classifier import CloudClassifier


@dataclass(frozen=True, kw_only=True, eq=False)
class FoundObject:
    """One object of a scan."""

    functions: frozenset[str]  # that it has; empty if it has none
    scores: dict[str, float]  # of each function, 0 to 1
    box: Box  # upright; in the scan's frame, if that is level
    corners: np.ndarray = field(repr=False)  # (8, 3) of the box, metres, the scan's frame, level or not
    points: np.ndarray = field(repr=False)  # (N, 3) float64, metres, the scan's frame
    unsure: bool = False  # the last reasons say why
    reasons: tuple[str, ...] = ()  # sentences
    inferred: bool = False  # not seen, but inferred: without points and scores
    find: Callable[[], Sequence[Place]] = field(default=tuple, repr=False)

    @cached_property
    def places(self) -> tuple[Place, ...]:
        """Where and how it can be used, in the scan's frame, metres; computed on first access."""
        return tuple(self.find())

    def __getstate__(self) -> dict[str, object]:
        """Return the state to pickle: with the places, without the scan."""
        return {**self.__dict__, "places": self.places, "find": tuple}


def find_objects(
    scan: Anything,
    *,
    units: str = "auto",
    up: str | ArrayLike = "auto",
    model: str | Path | CloudClassifier | None = None,
    backend: str | None = None,
    settings: Segmentation | None = None,
    intrinsics: str | Path | Intrinsics | ArrayLike | None = None,
    color: str | Path | ArrayLike | None = None,
    depth_scale: float | None = None,
    inferred: bool = False,
) -> list[FoundObject]:
    """Find the objects of a scanned room or table top, and classify each (paper, §IV-C).

    Parameters
    ----------
    scan : path, (N, 3) array_like, Open3D or trimesh object, Scan
    units : {"m", "cm", "mm", "in", "auto"}
        ``auto`` takes metres, or millimetres where a scan of metres would be larger than 60 m, and warns of that.
    up : str or (3,) array_like
        ``auto`` (by the floor), an axis (``z``, ``-y``), numbers ``x,y,z``, or a vector.
    model : path or CloudClassifier, optional
        By default the one for scans that ships with the package.
    backend : str, optional
        The simulator that the model must be for; by default ``fast`` where no model is given.
    settings : Segmentation, optional
    intrinsics : path, Intrinsics, Open3D's PinholeCameraIntrinsic, or (3, 3) or (9,) array_like in pixels, optional
        The camera of a depth image, which ``scan`` then is: a path (PNG, TIFF, NPY), or an array (H, W).
    color : path or (H, W, 3) uint8 array_like, optional
        The colour image of a depth image.
    depth_scale : float, optional
        Depth values per metre, for depth images of integers; by default 1000.
    inferred : bool
        Whether to append objects that are inferred and not seen, such as a chair pushed under a table.

    Returns
    -------
    list of FoundObject
        Including those without a function.

    Raises
    ------
    InputError
        If the scan or the model cannot be used.
    """
    shipped = shipped_model(backend or "fast", scans=True) if model is None else model
    came = "a scan without intrinsics" if intrinsics is None else one_line(scan)
    given = {"intrinsics=": intrinsics, "color=": color, "depth_scale=": depth_scale}
    require_depth_image(is_depth_image(scan, intrinsics), came, given)
    whole = scan_or_image(scan, units, intrinsics, color, depth_scale)
    room = recognise(whole, inference_model(shipped, backend), up=up, settings=settings)
    places = cache(partial(room_places, whole, room))
    found = [found_object(item, room, whole, lambda own=item.id: places().get(own, ())) for item in room.objects]
    if not inferred:
        return found

    def seat(number: int) -> list[Place]:
        return [place for place in places()[None] if place.kind == "sit"][number:][:1]

    return found + [inferred_object(item, room, partial(seat, number)) for number, item in enumerate(room.inferred)]


def is_depth_image(anything: Anything, intrinsics: object) -> bool:
    """Return whether a scan is a depth image: an image file, or an array (H, W) that comes with its camera."""
    if isinstance(anything, str | Path):
        return is_image_file(Path(anything).expanduser())
    return intrinsics is not None


def scan_or_image(
    anything: Anything,
    units: str,
    intrinsics: str | Path | Intrinsics | ArrayLike | None = None,
    color: str | Path | ArrayLike | None = None,
    depth_scale: float | None = None,
) -> Scan:
    """Return a scan, also that of a depth image; see `find_objects`."""
    is_image = is_depth_image(anything, intrinsics)
    if units not in ("m", "auto") and (is_image or isinstance(anything, Scan)):
        raise InputError(f"units={units!r}: expected with points or a mesh, got a depth image or a Scan, in metres")
    if not is_image:
        return as_scan(anything, units)
    image, camera, colors = (
        Path(one).expanduser() if isinstance(one, str) else one for one in (anything, intrinsics, color)
    )
    return load_depth_image(image, intrinsics=camera, color=colors, depth_scale=depth_scale, report=warn)


def as_scan(anything: Anything, units: str = "auto") -> Scan:
    """Return the scan of a path, an array (N, 3), an Open3D or a trimesh object; meshes are sampled."""
    if isinstance(anything, Scan):
        return anything
    if isinstance(anything, str | Path):
        return load_scan(anything, units=units, report=warn)
    geometry = geometry_of(anything, "scan")
    points = surface_points(geometry) if len(geometry.faces) else geometry.vertices
    return scan_from_points(points, units=units, report=warn)


def inferred_object(item: InferredObject, room: Room, find: Callable[[], Sequence[Place]]) -> FoundObject:
    """Return an inferred object in the frame of the scan."""
    return FoundObject(
        functions=frozenset([item.function]),
        scores={},
        box=room.box_in_scan(item.box),
        corners=room.levelling.to_scan(item.box.corners),
        points=np.empty((0, 3)),
        unsure=True,
        reasons=(item.reason,),
        inferred=True,
        find=find,
    )


def found_object(item: SceneObject, room: Room, scan: Scan, find: Callable[[], Sequence[Place]]) -> FoundObject:
    """Return one object in the frame of the scan."""
    doubts = room.doubts(item)
    return FoundObject(
        functions=item.members,
        scores={name: membership.score for name, membership in item.functions.items()},
        box=room.box_in_scan(item.box),
        corners=room.levelling.to_scan(item.box.corners),
        points=scan.points[room.point_indices[item.id]],
        unsure=bool(doubts),
        reasons=(*room.reasons(item), *doubts),
        find=find,
    )


def find_places(
    anything: Anything,
    put: Anything | None = None,
    prove: bool = False,
    person: float = 1.75,
    *,
    backend: str | None = None,
    scores: Mapping[str, float] | None = None,
    units: str | None = None,
    up: str | ArrayLike = BY_FILE,
    seed: int = 0,
    scan: bool = False,
) -> list[Place]:
    """Return where and how an object or a scan can be used: places to sit, to put and to pour, the best first.

    Proposals need no engine and take some ten milliseconds; a proof takes some tenths of a second.

    Parameters
    ----------
    anything : path, (N, 3) array_like, Open3D or trimesh object, Cloud
        An object, or a room or a table top with ``scan``.
    put : the same, optional
        An object for which poses are computed; it stands as it is in its file, z up, in metres.
    prove : bool
        Whether the places are tested by rigid bodies; the result changes their scores.
    person : float, metres
        Height of a sitter.
    backend : str, optional
        The simulator that tests places; by default ``bullet``.
    scores : mapping, optional
        Of each function, as `classify` returns them; by default those of the model that ships.
    units, up
        See `classify`, in metres by default; of a scan, both are as in `find_objects`.
    seed : int
        Of the stream that is poured.
    scan : bool
        Whether it is a scan of several objects, read as by `find_objects`: places on visible surfaces. They are
        proposed, not proven; `find_objects` assigns them to objects.

    Returns
    -------
    list of Place
        In the coordinates and units of the input; of a scan in its frame, metres.

    Raises
    ------
    InputError
        If an object cannot be used, the backend cannot prove, or a scan's places are to be proven.
    """
    settings = ProofSettings(person=person)
    if backend is not None and not prove:
        raise InputError(f"backend={backend!r}: expected with prove=True, since proposals need no simulator")
    if scan and scores is not None:
        raise InputError("scores=: expected of one object, got scan=True, of several")
    if scan:
        return places_in_scan(anything, put, prove, person, units or "auto", up)
    prover = require_ability(make_simulator(backend or "bullet"), "prove") if prove else None
    cloud, to_input = cloud_and_frame(anything, units=units or "m", up=up)
    put_cloud, own_frame = (None, None) if put is None else cloud_and_frame(put)
    known = scores_of(cloud) if scores is None else scores
    found = places_of(cloud, put=put_cloud, scores=known, person=person)
    if prover is not None:
        found = proven(cloud, found, prover, settings, put_cloud, seed)
    if own_frame is not None:
        found = [with_poses_of(place, own_frame) for place in found]
    return [place.moved(to_input) for place in found]


def places_in_scan(
    anything: Anything, put: Anything | None, prove: bool, person: float, units: str, up: str | ArrayLike
) -> list[Place]:
    """Return all places of a scan, the best first."""
    whole, to_put = scan_or_image(anything, units), None if put is None else cloud_and_frame(put)
    if prove:
        raise InputError(f"{whole.name}: expected one object to prove places of, got a scan of several")
    upward = "auto" if isinstance(up, str) and up == BY_FILE else up
    room = recognise(whole, inference_model(shipped_model(scans=True), None), up=upward)
    found = [place for places in places_in_room(whole, room, to_put, person).values() for place in places]
    return sorted(found, key=lambda place: -place.score)


def places_in_room(
    scan: Scan, room: Room, put: tuple[Cloud, Similarity] | None = None, person: float = 1.75
) -> dict[int | None, list[Place]]:
    """Return the places of each object of a room by its id, and under None those that are on none.

    Poses are relative to the frame of the put object's file, in metres; ``put`` is of `cloud_and_frame`.
    """
    put_cloud, frame = put or (None, None)
    found = room_places(scan, room, put_cloud, person)
    if frame is None:
        return found
    return {owner: [with_poses_of(place, frame) for place in places] for owner, places in found.items()}


def scores_of(cloud: Cloud) -> dict[str, float]:
    """Return the scores of an object by the model that ships."""
    from spherefunc_bullet.answer import classify

    return classify(cloud, explain=False).scores


def with_poses_of(place: Place, frame: Similarity) -> Place:
    """Return a place whose poses are relative to the frame of the put object's file, in metres."""
    undo = np.eye(4)
    undo[:3, :3] = frame.rotation.T
    undo[:3, 3] = -frame.rotation.T @ frame.shift / frame.scale
    return replace(place, poses=tuple(pose @ undo for pose in place.poses))
