"""The Bullet backend as a simulator: rigid spheres that fall, slide and roll until they are at rest."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass

import numpy as np

from ..clouds.cloud import Cloud
from ..errors import InputError
from ..simulator import DropResult, DropSettings, provenance_of, require_fitting
from ..simulator.mechanics import (
    CarryResult,
    CarrySettings,
    PoseResult,
    PoseSettings,
    StandResult,
    StandSettings,
    carry_radius,
)
from ..simulator.proofs import ProofResult, ProofSettings, Use
from .engine import Physics, engine_version

VERSION = "6"  # of the method: another number, other centres
SHAPES = ("auto", "voxel", "compound", "mesh")
FINEST = 3e-4  # square radii: the mean area of a mesh's faces from which on a sphere meets too many of them at once


@dataclass(frozen=True, kw_only=True)
class BulletSimulator(Physics):
    """Drops rigid spheres on a collision shape made of the cloud, with PyBullet in DIRECT mode.

    Cost: about a millisecond a sphere, and a second or two for the shape of a large object.

    Raises
    ------
    InputError
        If PyBullet is not installed, or a setting is out of its range.
    """

    shape: str = "auto"  # the mesh that an object came as, unless its faces are minute; else voxel. Or one of SHAPES
    voxel_size: float | None = None  # metres; by default a third of the radius, and no less than the cloud resolves

    name = "bullet"
    isolate = True  # C++ that may crash
    sphere_limit = 1000  # of a run for features; docs/paper.md measures what the others would tell

    def __post_init__(self):
        super().__post_init__()
        engine_version()
        if self.shape not in SHAPES:
            raise InputError(f"backend 'bullet': shape {self.shape!r}: expected one of {', '.join(SHAPES)}")
        if self.voxel_size is not None and not self.voxel_size > 0:
            raise InputError(f"backend 'bullet': voxel_size: expected more than 0 metres, got {self.voxel_size}")

    @property
    def version(self) -> str:
        return f"{VERSION}, PyBullet {engine_version()}"

    def options(self) -> dict:
        return asdict(self)

    def kind_for(self, cloud: Cloud, radius: float) -> str:
        """Return the kind of collision shape of a cloud for spheres of a radius, metres.

        A surface that there is already is exact and costs nothing, but a sphere on one of minute faces, as scanners and
        photogrammetry make them, would be held against thousands at each step.
        """
        from ..clouds.sampling import surface_area

        if self.shape != "auto":
            return self.shape
        if cloud.mesh is None:
            return "voxel"
        area = surface_area(cloud.mesh.vertices, cloud.mesh.faces) / len(cloud.mesh.faces)
        return "mesh" if area > FINEST * radius**2 else "voxel"

    def drop(self, cloud: Cloud, settings: DropSettings, seed: int = 0) -> DropResult:
        """Drop spheres on a cloud until the miss limit (see `Simulator.drop`).

        Raises
        ------
        InputError
            If the sphere is larger than the object, or no collision shape can be made of it.
        """
        from .collision.shape import collision_shape
        from .dropping import DropRun
        from .world import World

        kind = self.kind_for(cloud, settings.radius)
        require_fitting(cloud, settings.radius)
        started = time.perf_counter()
        shape = collision_shape(cloud, settings.radius, kind, self.voxel_size)
        with World(self) as world:
            world.add_object(shape)
            run = DropRun(world, shape, cloud, settings, seed)
            run.until_over()
        provenance = provenance_of(self, settings, seed) | {"shape": shape.facts(settings.radius)}
        return run.result(time.perf_counter() - started, provenance)

    def poses(self, cloud: Cloud, settings: PoseSettings, seed: int = 0) -> PoseResult:
        """Drop a cloud's object itself, from many directions (see `SupportsPoses.poses`)."""
        from ..simulator.statics.body import body_of
        from .bodies.falling import fallen_poses

        started = time.perf_counter()
        body = body_of(cloud, settings.matter)
        found, timed_out = fallen_poses(body, settings, seed)
        return PoseResult(
            poses=found,
            drops=settings.drops,
            timed_out=timed_out,
            notes=body.notes,
            seconds=time.perf_counter() - started,
            provenance=provenance_of(self, settings, seed),
        )

    def stands(self, cloud: Cloud, settings: StandSettings, places: np.ndarray, seed: int = 0) -> StandResult:
        """Return by statics whether an object stands; release it if that is not exact, see `SupportsStance.stands`."""
        from ..simulator.statics.body import body_of
        from ..simulator.statics.standing import loaded_stances
        from .bodies.falling import release

        body, provenance = body_of(cloud, settings.matter), provenance_of(self, settings, seed)
        return loaded_stances(body, places, settings, provenance, lambda bodies: release(bodies, settings))

    def carry(self, cloud: Cloud, settings: CarrySettings, seed: int = 0) -> CarryResult:
        """Fill a cloud's object with spheres and carry it about (see `Carries.carry`)."""
        from ..clouds.flooding import basin_of
        from .bodies.carrying import carry_filled, carry_result, filling_of
        from .collision.shape import collision_shape

        started = time.perf_counter()
        radius = carry_radius(cloud) if settings.radius is None else settings.radius
        result = self.drop(cloud, DropSettings(radius=radius, max_spheres=settings.spheres), seed)
        shape = collision_shape(cloud, radius, self.kind_for(cloud, radius), self.voxel_size)
        basin = basin_of(shape.vertices, shape.faces, 1.0)
        filling, kept = filling_of(result, radius, basin, settings.fill), None
        if len(filling.centers):
            kept = carry_filled(self, shape, basin, filling, settings, radius)
        seconds = time.perf_counter() - started
        return carry_result(kept, filling, basin, radius, settings, seconds, provenance_of(self, settings, seed))

    def prove(self, cloud: Cloud, uses: Sequence[Use], settings: ProofSettings, seed: int = 0) -> list[ProofResult]:
        """Use places of a cloud's object: sit down, put down, pour (see `ProvesPlaces.prove`)."""
        from .proofs import proved

        return proved(cloud, uses, settings, seed)
