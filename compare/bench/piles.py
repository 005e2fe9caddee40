"""Piles of spheres: how deep they lie, and what strips buy.

    python -m spherefunc_bullet.compare.bench depth DATA [--backends fast,bullet] [--radii 5mm,1cm,2cm] [--count 2]
    python -m spherefunc_bullet.compare.bench strips [--seeds 12]

Depth: the meshes of DATA are the truth; what spheres meet is their points alone, except with the shape `mesh`. Each
row changes one step. Samples 0.3 radii apart instead of 5 mm show what sampling adds, all samples kept what voxels
leave out, and runs of few drops what `fast` leaves out of a cloud for them. The depth of a sphere that touches the
object is the share of its radius by which its centre is nearer to the mesh than that.
Strips: the three take turns, and the best of three turns counts; how many settle is of so many seeds each way.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import numpy as np
import typer

from spherefunc_bullet.clouds.cloud import MAX_GAP, Cloud, load_cloud
from spherefunc_bullet.console import print_table, progress
from spherefunc_bullet.datasets.dataset import DatasetObject, open_dataset
from spherefunc_bullet.errors import InputError
from spherefunc_bullet.formats.units import format_length, parse_length
from spherefunc_bullet.settling.drops import DROPS
from spherefunc_bullet.simulator import DropResult, DropSettings, make_simulator

from ..machine import usable_backends
from .harness import Backends, Count, Data, of_household
from .peers import mesh_distances

DEEP = 0.1  # radii
FINE = 0.3  # radii between a surface and its nearest sample, between which a sphere sinks by 5 % at most
SPHERES = 300  # on each object, at most
KINDS = "plate,tray,mug,glass,cup,bowl,chair,table,desk"
HEAD = ["what spheres meet", "radius", "spheres", "median", "95 %", "deepest", "deeper than 0.1"]


@dataclass(frozen=True, kw_only=True)
class Variant:
    """One way from a mesh to settled spheres."""

    title: str
    shape: str | None = None  # of `bullet`
    voxel_size: float | None = None  # metres
    fine: bool = False  # with samples 0.3 radii apart
    drops: int | None = None

    def options(self) -> dict[str, object]:
        """Return the simulator's options."""
        return {} if self.shape is None else {"shape": self.shape, "voxel_size": self.voxel_size}


WAYS = {
    "fast": (
        Variant(title="fast: samples"),
        Variant(title="fast: samples 0.3 r apart", fine=True),
        Variant(title="fast: samples, few drops", drops=DROPS),
        Variant(title="fast: samples 0.3 r apart, few drops", fine=True, drops=DROPS),
    ),
    "bullet": (
        Variant(title="bullet: voxel", shape="voxel"),
        Variant(title="bullet: voxel, all samples kept", shape="voxel", voxel_size=1e-5),
        Variant(title="bullet: voxel, samples 0.3 r apart", shape="voxel", fine=True),
        Variant(title="bullet: compound", shape="compound"),
        Variant(title="bullet: mesh", shape="mesh"),
    ),
}


def settled_depths(path: Path, backend: str, way: Variant, radius: float) -> np.ndarray:
    """Return how deep the settled spheres that touch an object lie in its mesh, (S,) radii; none if it is too small."""
    cloud = load_cloud(path, max_gap=min(MAX_GAP, FINE * radius) if way.fine else MAX_GAP)
    misses = {} if way.drops is None else {"max_drops": way.drops, "miss_limit": way.drops}
    settings = DropSettings(radius=radius, max_spheres=SPHERES, **misses)
    try:
        result = make_simulator(backend, **way.options()).drop(cloud, settings, 0)
    except InputError:
        return np.empty(0)
    return 1 - mesh_distances(cloud.mesh, result.centers[result.on_object]) / radius


def depth_row(title: str, radius: float, depths: np.ndarray) -> list[str]:
    """Return the printed numbers of depths (S,) in radii."""
    shares = [np.median(depths), np.quantile(depths, 0.95), depths.max()] if len(depths) else [np.nan] * 3
    deep = f"{np.mean(depths > DEEP):.3f}" if len(depths) else ""
    return [title, format_length(radius), f"{len(depths):,}", *(f"{max(share, 0):.3f}" for share in shares), deep]


def chosen(objects: Iterable[DatasetObject], kinds: Sequence[str], count: int) -> list[Path]:
    """Return the files of the first so many objects of each kind that came as meshes."""
    of_kind: dict[str, list[Path]] = {kind: [] for kind in kinds}
    for one in objects:
        for kind in of_kind.keys() & set(one.category.split("_")):
            if len(of_kind[kind]) < count and load_cloud(one.path).mesh is not None:
                of_kind[kind].append(one.path)
                break
    return [path for paths in of_kind.values() for path in paths]


def measure_depths(
    data: Data,
    backends: Backends = "fast,bullet",
    radii: Annotated[str, typer.Option(help="Of the spheres.")] = "5mm,1cm,2cm",
    kinds: Annotated[str, typer.Option(help="Words of objects' categories.")] = KINDS,
    count: Count = 2,
):
    """Print how deep spheres lie, of all objects together."""
    paths = chosen(open_dataset(data).objects, kinds.split(","), count)
    if not paths:
        raise InputError(f"{data}: expected meshes of one of the categories {kinds}, got none")
    for backend in usable_backends(backends.split(",")):
        ways = [(way, parse_length(radius)) for way in WAYS[backend] for radius in radii.split(",")]
        rows = []
        for way, radius in progress(ways, len(ways), f"dropping by {backend}"):
            depths = np.concatenate([settled_depths(path, backend, way, radius) for path in paths])
            rows.append(depth_row(way.title, radius, depths))
        print_table(f"\nHow deep spheres lie in {len(paths)} meshes of {data}, radii", HEAD, rows)


OBJECTS = [("shell_chair_01", "5mm", 12), ("dining_table_02", "1cm", 12), ("sofa_02", "5mm", 3)]  # and seeds
TURNS = 3


def dropped(cloud: Cloud, radius: float, seed: int, **options: object) -> DropResult:
    """Return a run by `fast` to the end."""
    return make_simulator("fast", **options).drop(cloud, DropSettings(radius=radius), seed)


def seconds(cloud: Cloud, radius: float, ways: Sequence[dict]) -> tuple[list[float], bool]:
    """Return the least seconds of each way to drop, and whether the last two gave the same bits."""
    runs = [[dropped(cloud, radius, 0, **way) for way in ways] for _ in range(TURNS + 1)][1:]  # after one to warm up
    one, other = runs[0][-2:]
    same = np.array_equal(one.centers, other.centers) and np.array_equal(one.outcomes, other.outcomes)
    return [min(run.seconds for run in turns) for turns in zip(*runs, strict=True)], same


def spread(counts: Sequence[int]) -> str:
    """Return the mean and the standard deviation of some counts, as people write them."""
    return f"{np.mean(counts):,.0f} ± {np.std(counts, ddof=1):,.0f}"


def measure_strips(
    seeds: Annotated[int | None, typer.Option(min=2, help="Piles of an object; by default 12, of the sofa 3.")] = None,
):
    """Measure and print."""
    ways = [{"as_drawn": True}, {"cores": 1}, {"cores": min(2, os.cpu_count() or 1)}]
    rows = []
    for name, length, few in progress(OBJECTS, len(OBJECTS), "filling"):
        cloud, radius = load_cloud(of_household(name)), parse_length(length)
        (drawn, one, two), same = seconds(cloud, radius, ways)
        piles = [[dropped(cloud, radius, seed, **way).settled for seed in range(seeds or few)] for way in ways[:2]]
        rows.append(
            [
                name,
                format_length(radius),
                *(f"{value:.3f}" for value in (drawn, one, two)),
                f"{one / two:.2f}",
                "same" if same else "OTHER",
                *map(spread, piles),
            ]
        )
    times = ["as drawn s", "in strips s", "on 2 cores s", "times", "bits"]
    head = ["object", "radius", *times, "settled, as drawn", "in strips"]
    print_table("A large object by fast, best of three turns, compilation and loading excluded", head, rows)
