"""The same spheres on the same mug by peers: the naive PyBullet script, MuJoCo, and our backends.

    python -m spherefunc_bullet.compare.bench.peers [--drops 500]

Everybody drops as many spheres, one radius, and meets the mesh's own triangles, `fast` its points. What came of them is
measured on the mesh by somebody else (Open3D): how deep spheres lie in each other and in the mug, and how many hang in
the air. MuJoCo runs by `examples/mujoco_backend`, as good as we know to do it; it is left out where `mujoco` or this
file's repository is not there.
"""

from __future__ import annotations

import importlib.util
import sys
from dataclasses import dataclass, replace
from importlib.metadata import version
from pathlib import Path
from typing import Annotated

import numpy as np
import typer

from spherefunc_bullet.clouds.cloud import load_cloud
from spherefunc_bullet.console import print_table, run, say
from spherefunc_bullet.formats.units import parse_length
from spherefunc_bullet.settling.settling import warm_up
from spherefunc_bullet.simulator import DropSettings, Simulator, make_simulator

from ..machine import machine, usable_backends
from .bench import apart, use_one_core
from .peer import peer_mug, run_naively

RADIUS = parse_length("5mm")
DROPS = 500
NAIVE_SECONDS = 60.0
HANGING = 0.05  # radii to the nearest thing beyond which a sphere that came to rest is said to hang in the air
EXAMPLE = Path(__file__).parents[2] / "examples" / "mujoco_backend" / "spherefunc_mujoco.py"


@dataclass(frozen=True, kw_only=True)
class PeerRun:
    """What came of one peer's spheres; lengths in radii."""

    name: str
    drops: int
    seconds: float
    settled: int
    in_spheres: float  # the deepest overlap of two spheres
    in_object: float  # the deepest overlap with the mesh
    moved: float  # the farthest that a sphere has moved since it was frozen
    hanging: int  # spheres at rest that touch nothing

    def row(self, naive: float) -> list[str]:
        """Return the printed numbers; ``naive`` is the drops per second of the naive script."""
        rate = self.drops / self.seconds
        speeds = [f"{self.drops}", f"{self.seconds:.3f}", f"{rate:,.0f}", f"{rate / naive:,.1f}"]
        depths = [f"{depth:.3f}" for depth in (self.in_spheres, self.in_object, self.moved)]
        return [self.name, *speeds, f"{self.settled}", *depths, f"{self.hanging}"]


def mujoco_simulator() -> Simulator | None:
    """Return the example's simulator, or None and a line why not."""
    if importlib.util.find_spec("mujoco") is None or not EXAMPLE.is_file():
        say("MuJoCo is left out: it wants `pip install mujoco` and this repository's examples/mujoco_backend.")
        return None
    spec = importlib.util.spec_from_file_location(EXAMPLE.stem, EXAMPLE)
    sys.modules[EXAMPLE.stem] = module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module.MujocoSimulator()


def backend_run(path: Path, name: str, drops: int) -> PeerRun | None:
    """Return what came of a backend's spheres, best time of three; None where it is not there."""
    simulator = mujoco_simulator() if name == "mujoco" else make_simulator(name)
    if simulator is None:
        return None
    title = f"MuJoCo {version('mujoco')}" if name == "mujoco" else f"our {name}"
    cloud, settings = load_cloud(path), DropSettings(radius=RADIUS, max_drops=drops, miss_limit=drops)
    warm_up(simulator)
    runs = [simulator.drop(cloud, settings, 0) for _ in range(3)]
    seconds = min(one.seconds for one in runs)
    return measured(title, path, runs[0].centers, runs[0].drops, seconds)


def naive_run(path: Path, drops: int) -> PeerRun:
    """Return what came of the naive script's spheres."""
    naive = run_naively(path, RADIUS, NAIVE_SECONDS, drops)
    moved = np.linalg.norm(naive.ends - naive.centers, axis=1).max(initial=0.0) / RADIUS
    return replace(measured("naive PyBullet script", path, naive.centers, naive.drops, naive.seconds), moved=moved)


def measured(name: str, path: Path, centers: np.ndarray, drops: int, seconds: float) -> PeerRun:
    """Return a peer's run, its settled centres (S, 3) in metres looked at on the mesh itself."""
    apart_by = spheres_apart(centers) / RADIUS - 2
    clear = mesh_distances(path, centers) / RADIUS - 1
    return PeerRun(
        name=name,
        drops=drops,
        seconds=seconds,
        settled=len(centers),
        in_spheres=max(0.0, -apart_by.min(initial=0.0)),
        in_object=max(0.0, -clear.min(initial=0.0)),
        moved=0.0,
        hanging=int((np.minimum(apart_by, clear) > HANGING).sum()),
    )


def spheres_apart(centers: np.ndarray) -> np.ndarray:
    """Return each centre's distance (S,) to the nearest other one."""
    from scipy.spatial import cKDTree

    return cKDTree(centers).query(centers, k=2)[0][:, 1] if len(centers) > 1 else np.full(len(centers), np.inf)


def mesh_distances(path: Path, centers: np.ndarray) -> np.ndarray:
    """Return each centre's distance (S,) to the nearest place of a file's mesh, metres."""
    import open3d as o3d

    mesh = load_cloud(path).mesh
    scene = o3d.t.geometry.RaycastingScene()
    scene.add_triangles(np.asarray(mesh.vertices, np.float32), np.asarray(mesh.faces, np.uint32))
    return scene.compute_distance(np.asarray(centers, np.float32)).numpy()


def print_peers(drops: int):
    """Print one row a peer."""
    path = peer_mug()
    if path is None:
        say("The peers are left out: PyBullet is not installed (pip install spherefunc-bullet[bullet]).")
        return
    say("Running the naive PyBullet script, about half a minute …")
    runs = [apart(naive_run, path, drops)]
    runs += [apart(backend_run, path, name, drops) for name in ("mujoco", *usable_backends(("bullet", "fast")))]
    naive = runs[0].drops / runs[0].seconds
    head = ["PyBullet's mug, r = 5 mm", "drops", "seconds", "drops/s", "times naive", "kept"]
    head += ["deepest in a sphere, r", "in the mug, r", "moved when frozen, r", "hang in the air"]
    print_table(f"\nThe same {drops} drops by peers", head, [one.row(naive) for one in runs if one is not None])


def main(drops: Annotated[int, typer.Option(min=10, help="Spheres that each drops.")] = DROPS):
    """Print the table of docs/speed.md."""
    use_one_core()
    print_peers(drops)
    print("\n" + "\n".join(f"{name}: {value}" for name, value in machine().items()))


if __name__ == "__main__":  # the processes that it starts import this file
    run(lambda: typer.run(main))
