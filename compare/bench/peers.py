"""The same spheres on the same objects by peers: the naive PyBullet script, MuJoCo, and our backends.

    python -m spherefunc_bullet.compare.bench.peers [--drops 500] [--objects mug,table,chair]

Everybody drops as many spheres, one radius an object, and meets the mesh's own triangles, `fast` its points. What came
of them is measured on the mesh by somebody else (Open3D): how deep spheres lie in each other and in the object, and how
many hang in the air. MuJoCo runs by `examples/mujoco_backend`, as good as we know to do it; it is left out where
`mujoco` or this file's repository is not there.
"""

from __future__ import annotations

import importlib.util
import sys
from dataclasses import dataclass, replace
from importlib.metadata import version
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated

import numpy as np
import typer

from spherefunc_bullet.clouds.cloud import Mesh, load_cloud
from spherefunc_bullet.console import print_table, run, say, show
from spherefunc_bullet.datasets.catalogue import built_catalogue
from spherefunc_bullet.errors import InputError
from spherefunc_bullet.formats.units import format_length, parse_length
from spherefunc_bullet.settling.settling import warm_up
from spherefunc_bullet.simulator import DropSettings, Simulator, make_simulator

from ..machine import machine, usable_backends
from .bench import OBJECTS, PEER_RADIUS, TABLE_RADIUS, apart, use_one_core, write_plain_table
from .peer import peer_mug, run_naively
from .timing import Case

DROPS = 500
NAIVE_SECONDS = 60.0  # an object; where they do not do, its row says how many drops it came to
HANGING = 0.05  # radii to the nearest object beyond which a sphere that came to rest is said to hang in the air
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


def backend_run(case: Case, name: str, drops: int) -> PeerRun | None:
    """Return what came of a backend's spheres, best time of three; None where it is not there."""
    simulator = mujoco_simulator() if name == "mujoco" else make_simulator(name)
    if simulator is None:
        return None
    title = f"MuJoCo {version('mujoco')}" if name == "mujoco" else f"our {name}"
    cloud, settings = load_cloud(case.path), DropSettings(radius=case.radius, max_drops=drops, miss_limit=drops)
    warm_up(simulator)
    runs = [simulator.drop(cloud, settings, 0) for _ in range(3)]
    seconds = min(one.seconds for one in runs)
    return measured(title, case, runs[0].centers, runs[0].drops, seconds)


def naive_run(case: Case, drops: int) -> PeerRun:
    """Return what came of the naive script's spheres."""
    naive = run_naively(case.path, case.radius, NAIVE_SECONDS, drops)
    moved = np.linalg.norm(naive.ends - naive.centers, axis=1).max(initial=0.0) / case.radius
    return replace(measured("naive PyBullet script", case, naive.centers, naive.drops, naive.seconds), moved=moved)


def measured(name: str, case: Case, centers: np.ndarray, drops: int, seconds: float) -> PeerRun:
    """Return a peer's run, its settled centres (S, 3) in metres looked at on the mesh itself."""
    apart_by = spheres_apart(centers) / case.radius - 2
    clear = mesh_distances(load_cloud(case.path).mesh, centers) / case.radius - 1
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


def mesh_distances(mesh: Mesh, centers: np.ndarray) -> np.ndarray:
    """Return each centre's distance (S,) to the nearest place of a mesh, metres."""
    import open3d as o3d

    scene = o3d.t.geometry.RaycastingScene()
    scene.add_triangles(np.asarray(mesh.vertices, np.float32), np.asarray(mesh.faces, np.uint32))
    return scene.compute_distance(np.asarray(centers, np.float32)).numpy()


def cases(names: list[str], folder: Path) -> list[Case]:
    """Return the objects of these names; a file that has to be made goes into a folder.

    Raises
    ------
    InputError
        If there is no such object.
    """
    _, chair, radius = next(each for each in OBJECTS["bullet"] if each[0] == "chair")
    chair_file = built_catalogue("household").parent / f"{chair}.ply"
    known = {
        "mug": Case(title="PyBullet's mug", path=peer_mug(), radius=PEER_RADIUS),
        "table": Case(title="table of 1.2 x 0.8 m", path=write_plain_table(folder), radius=TABLE_RADIUS),
        "chair": Case(title=f"chair ({chair})", path=chair_file, radius=parse_length(radius)),
    }
    for name in names:
        if name not in known:
            raise InputError(f"--objects: expected some of {', '.join(known)}, got {name!r}")
    return [known[name] for name in names]


def print_peers(case: Case, drops: int):
    """Print one row a peer."""
    say(f"{case.title}: the naive PyBullet script runs, up to a minute …")
    runs = [apart(naive_run, case, drops)]
    runs += [apart(backend_run, case, name, drops) for name in ("mujoco", *usable_backends(("bullet", "fast")))]
    naive = runs[0].drops / runs[0].seconds
    head = [f"{case.title}, r = {format_length(case.radius)}", "drops", "seconds", "drops/s", "times naive", "kept"]
    head += ["deepest in a sphere, r", "in the object, r", "moved when frozen, r", "hang in the air"]
    print_table(f"\nThe same {drops} drops by peers", head, [one.row(naive) for one in runs if one is not None])


def main(
    drops: Annotated[int, typer.Option(min=10, help="Spheres that each drops.")] = DROPS,
    objects: Annotated[str, typer.Option(help="Objects, comma-separated.")] = "mug,table,chair",
):
    """Print the tables of docs/speed.md."""
    use_one_core()
    if peer_mug() is None:
        return say("The peers are left out: PyBullet is not installed (pip install spherefunc-bullet[bullet]).")
    with TemporaryDirectory() as folder:
        for case in cases(objects.split(","), Path(folder)):
            print_peers(case, drops)
    show("\n" + "\n".join(f"{name}: {value}" for name, value in machine().items()))


if __name__ == "__main__":  # the processes that it starts import this file
    run(lambda: typer.run(main))
