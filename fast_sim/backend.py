"""The fast backend as a simulator: the paper's low-fidelity roller (§III-A)."""

from __future__ import annotations

import os
import time
from dataclasses import dataclass, fields

import numpy as np

from spherefunc_bullet.clouds.cloud import Cloud
from spherefunc_bullet.errors import CheckedSettings, InputError, amount, explaining, require_kind
from spherefunc_bullet.simulator import DropResult, DropSettings, provenance_of, require_fitting
from spherefunc_bullet.simulator.mechanics import PoseResult, PoseSettings, StandResult, StandSettings

VERSION = "5"  # of the algorithm; raised when the centres of spheres that become features change
SHORT = 100  # drops: a shorter run is stored with the cloud, since it may be continued if more drops are needed


@dataclass(frozen=True, kw_only=True)
class FastSimulator(CheckedSettings):
    """Rolls spheres over a point cloud, one at a time, without forces or time.

    A cloud needs no mesh, no normals and no order. Cost: a few microseconds per sphere. A run without a limit of drops
    fills a large object strip by strip, on up to ``cores`` cores, unless spheres must fall ``as_drawn``.
    """

    name = "fast"
    version = VERSION
    # For the drops on a large object; the result is the same, bit for bit, for any number.
    cores: int = amount(1, least=1, most=os.cpu_count() or 1)
    as_drawn: bool = False  # drop one sphere after another, as in the paper, also on large objects
    flat_angle_deg: float = amount(5.0, most=90)  # steepest slope that counts as flat: more than noise, less than ramps

    def __post_init__(self):
        with explaining("backend 'fast'", InputError, why=": "):
            super().__post_init__()

    def options(self) -> dict:
        """Return the options that differ from their defaults, by name (see `Simulator.options`)."""
        return {"flat_angle_deg": self.flat_angle_deg} | {
            field.name: getattr(self, field.name)
            for field in fields(self)
            if field.name != "cores" and getattr(self, field.name) != field.default
        }

    def drop(self, cloud: Cloud, settings: DropSettings, seed: int = 0) -> DropResult:
        """Drop spheres on a cloud until the miss limit (see `Simulator.drop`).

        Raises
        ------
        InputError
            If the sphere is larger than the object.
        """
        from .drop_run import DropRun

        require_kind("settings", settings, DropSettings)
        require_fitting(cloud, settings.radius)
        started = time.perf_counter()
        short_runs = cloud.cached("the short run of each radius by fast", dict[float, DropRun])
        run = short_runs.pop(settings.radius, None)  # removed, so that no other thread continues it
        if run is None or not run.is_prefix_of(settings, self, seed):
            run = DropRun(cloud, settings, self, seed)
            started += run.prepare_strips()
        run.continue_run(settings)
        run.seconds += time.perf_counter() - started
        if settings.max_drops is not None and settings.max_drops <= SHORT:
            short_runs[settings.radius] = run
        return run.result(provenance_of(self, settings, seed))

    def poses(self, cloud: Cloud, settings: PoseSettings, seed: int = 0) -> PoseResult:
        """Return the stable poses of an object by statics (see `SupportsPoses.poses`); nothing is dropped."""
        from spherefunc_bullet.simulator.statics.body import body_of
        from spherefunc_bullet.simulator.statics.facets import facets_of, stable_poses

        started = time.perf_counter()
        body = body_of(cloud, settings.matter)
        return PoseResult(
            poses=stable_poses(facets_of(body), settings),
            drops=0,
            timed_out=0,
            notes=body.notes,
            seconds=time.perf_counter() - started,
            provenance=provenance_of(self, settings, seed),
        )

    def stands(self, cloud: Cloud, settings: StandSettings, places: np.ndarray, seed: int = 0) -> StandResult:
        """Return by statics whether an object stands (see `SupportsStance.stands`)."""
        from spherefunc_bullet.simulator.statics.body import body_of
        from spherefunc_bullet.simulator.statics.standing import loaded_stances

        body, provenance = body_of(cloud, settings.matter), provenance_of(self, settings, seed)
        return loaded_stances(body, places, settings, provenance)
