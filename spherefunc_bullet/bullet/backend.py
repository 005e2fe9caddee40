"""The Bullet backend as a simulator: rigid spheres that fall, slide and roll until they are at rest."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass

import numpy as np

from ..clouds.cloud import Cloud
from ..errors import InputError, amount, require_kind
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

VERSION = "6"  # of the method; raised when the resulting centres change
SHAPES = ("auto", "voxel", "compound", "mesh")
FINEST = 3e-4  # square radii: a mesh with a smaller mean face area puts too many faces in contact with a sphere


@dataclass(frozen=True, kw_only=True)
class BulletSimulator(Physics):
    """Drops rigid spheres on a collision shape of the cloud, with PyBullet in DIRECT mode.

    Cost: about a millisecond per sphere, and one or two seconds for the shape of a large object.

    Raises
    ------
    InputError
        If PyBullet is not installed, or a setting is out of range.
    """

    shape: str = "auto"  # one of SHAPES; auto: the mesh of the object, or voxel if there is none or its faces are tiny
    # Metres; default: a third of the radius, not finer than the cloud's resolution.
    voxel_size: float | None = amount(None, above=0.0)

    name = "bullet"
    isolate = True  # native code that may crash
    sphere_limit = 1000  # of a run for features; docs/paper.md measures what more spheres would add

    def __post_init__(self):
        super().__post_init__()
        engine_version()
        if self.shape not in SHAPES:
            raise InputError(f"backend 'bullet': shape {self.shape!r}: expected one of {', '.join(SHAPES)}")

    @property
    def version(self) -> str:
        return f"{VERSION}, PyBullet {engine_version()}"

    def options(self) -> dict:
        return asdict(self)

    def kind_for(self, cloud: Cloud, radius: float) -> str:
        """Return the kind of collision shape of a cloud for spheres of a radius in metres.

        The mesh of an object is exact and costs nothing to build. If its faces are tiny, as those of scanners and
        photogrammetry, each sphere would be tested against thousands of them at every step.
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
            If the sphere is larger than the object, or no collision shape can be built.
        """
        from .collision.shape import collision_shape
        from .dropping import DropRun
        from .world import World

        require_kind("settings", settings, DropSettings)
        require_fitting(cloud, settings.radius)
        kind = self.kind_for(cloud, settings.radius)
        started = time.perf_counter()
        shape = collision_shape(cloud, settings.radius, kind, self.voxel_size)
        with World(self) as world:
            world.add_object(shape)
            run = DropRun(world, shape, cloud, settings, seed)
            run.until_over()
        provenance = provenance_of(self, settings, seed) | {"shape": shape.facts(settings.radius)}
        return run.result(time.perf_counter() - started, provenance)

    def poses(self, cloud: Cloud, settings: PoseSettings, seed: int = 0) -> PoseResult:
        """Return the stable poses of an object that is dropped in many orientations (see `SupportsPoses.poses`)."""
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
        """Return whether an object stands: by statics, and by simulation where statics is not exact.

        See `SupportsStance.stands`.
        """
        from ..simulator.statics.body import body_of
        from ..simulator.statics.standing import loaded_stances
        from .bodies.falling import release

        body, provenance = body_of(cloud, settings.matter), provenance_of(self, settings, seed)
        return loaded_stances(body, places, settings, provenance, lambda bodies: release(bodies, settings))

    def carry(self, cloud: Cloud, settings: CarrySettings, seed: int = 0) -> CarryResult:
        """Fill an object with spheres, carry it, and return what it keeps (see `SupportsCarrying.carry`)."""
        from ..clouds.flooding import basin_of
        from .bodies.carrying import carry_filled, carry_result, filling_of
        from .collision.shape import collision_shape

        started = time.perf_counter()
        radius = carry_radius(cloud) if settings.radius is None else settings.radius
        result = self.drop(cloud, DropSettings(radius=radius, max_spheres=settings.spheres), seed)
        shape = collision_shape(cloud, radius, self.kind_for(cloud, radius), self.voxel_size)
        basin = basin_of(shape.vertices, shape.faces, 1.0)
        filling = filling_of(result, radius, basin, settings.fill)
        kept = carry_filled(self, shape, basin, filling, settings, radius)
        seconds = time.perf_counter() - started
        return carry_result(kept, filling, basin, radius, settings, seconds, provenance_of(self, settings, seed))

    def prove(self, cloud: Cloud, uses: Sequence[Use], settings: ProofSettings, seed: int = 0) -> list[ProofResult]:
        """Test places of an object: sit down, put down, pour (see `ProvesPlaces.prove`)."""
        from .proofs import Stage, prove_use

        with Stage(cloud, settings.friction) as stage:
            return [prove_use(stage, use, settings, seed) for use in uses]
