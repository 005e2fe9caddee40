"""The same spheres on the same objects by peers: the naive PyBullet script, MuJoCo, and our backends.

    python -m spherefunc_bullet.compare.bench peers [--drops 500] [--objects mug,table,chair]

All peers drop the same number of spheres, one radius for each object, on the mesh's triangles, `fast` on its points.
The result is measured on the mesh with Open3D: how deep spheres penetrate each other and the object, and how many hang
in the air. MuJoCo runs by `examples/mujoco_backend`, as well as we know; it is left out without `mujoco` or this file's
repository. The naive script is what one would first write with PyBullet without this package: one rigid body per
sphere, the default 240 Hz, frozen by setting its mass to 0 when it is slow. It is here to be measured, not used.
"""

from __future__ import annotations

import importlib.util
import os
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from importlib.metadata import version
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Annotated

import numpy as np
import typer

from spherefunc_bullet.clouds.cloud import Mesh, load_cloud, placed
from spherefunc_bullet.clouds.raycasting import raycasting_scene
from spherefunc_bullet.console import print_table, say
from spherefunc_bullet.errors import require_known
from spherefunc_bullet.formats.sources import read_geometry
from spherefunc_bullet.formats.units import format_length
from spherefunc_bullet.settling.settling import warm_up
from spherefunc_bullet.simulator import DropSettings, Simulator, make_simulator

from ..machine import usable_backends
from .harness import Case, apart, case_of, peer_mug, plain_table, print_machine, use_one_core
from .speed import OBJECTS

if TYPE_CHECKING:
    from pybullet_utils.bullet_client import BulletClient

DROPS = 500
NAIVE_SECONDS = 60.0  # for each object; the row shows the number of drops made until then
HANGING = 0.05  # radii: a sphere at rest that is farther from everything hangs in the air
EXAMPLE = Path(__file__).parents[2] / "examples" / "mujoco_backend" / "spherefunc_mujoco.py"
GRAVITY = -9.81  # m/s^2
MASS = 0.01  # kg, of a sphere
SLOW = 0.01  # m/s: below this a sphere counts as at rest
SLOW_STEPS = 5  # in succession: one slow step may be the top of a bounce
MAX_STEPS = 1200  # five seconds of simulated time


def naive_run(case: Case, most: int) -> PeerRun:
    """Return the result of the naive script, for `NAIVE_SECONDS` or a number of drops at most.

    It needs a separate process, since it redirects stdout to stderr: PyBullet prints there, which would break JSON.
    """
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())
    import pybullet as p
    from pybullet_utils.bullet_client import BulletClient

    geometry, radius = read_geometry(case.path), case.radius
    vertices = placed(geometry.vertices)  # as for the simulator
    client = BulletClient(connection_mode=p.DIRECT)
    client.setGravity(0, 0, GRAVITY)
    add_object(client, vertices, geometry.faces)
    sphere = client.createCollisionShape(p.GEOM_SPHERE, radius=radius)
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    columns, top = np.random.default_rng(0), high[2]
    drops, centers, settled = 0, [], []
    started, spent = time.perf_counter(), 0.0
    while spent < NAIVE_SECONDS and drops < most:
        x, y = columns.uniform(low[:2], high[:2])
        center = drop_naively(client, sphere, [x, y, top + 2 * radius], radius)
        drops += 1
        if center is not None:
            top = max(top, center[2] + radius)
            centers.append(center)
            settled.append(client.getBodyUniqueId(client.getNumBodies() - 1))
        spent = time.perf_counter() - started
    ends = [client.getBasePositionAndOrientation(body)[0] for body in settled]  # mass 0 alone does not hold them
    client.disconnect()
    centers, ends = (np.array(places, float).reshape(-1, 3) for places in (centers, ends))
    moved = np.linalg.norm(ends - centers, axis=1).max(initial=0.0) / radius
    return replace(measured("naive PyBullet script", case, centers, drops, spent), moved=moved)


def add_object(client: BulletClient, vertices: np.ndarray, faces: np.ndarray):
    """Add a mesh as a static concave body."""
    import pybullet as p
    import trimesh

    with TemporaryDirectory() as folder:
        path = Path(folder) / "object.obj"
        trimesh.Trimesh(vertices, faces, process=False).export(path)
        shape = client.createCollisionShape(p.GEOM_MESH, fileName=str(path), flags=p.GEOM_FORCE_CONCAVE_TRIMESH)
    client.createMultiBody(0, shape)


def drop_naively(
    client: BulletClient, sphere: int, start: Sequence[float], radius: float
) -> tuple[float, float, float] | None:
    """Return the place where one sphere comes to rest, metres; None if it misses or never comes to rest."""
    body = client.createMultiBody(MASS, sphere, basePosition=start)
    slow = 0
    for _ in range(MAX_STEPS):
        client.stepSimulation()
        center = client.getBasePositionAndOrientation(body)[0]
        slow = slow + 1 if np.linalg.norm(client.getBaseVelocity(body)[0]) < SLOW else 0
        if center[2] < radius:
            break
        if slow == SLOW_STEPS:
            client.changeDynamics(body, -1, mass=0)
            return center
    client.removeBody(body)
    return None


@dataclass(frozen=True, kw_only=True)
class PeerRun:
    """The result of one peer; lengths in radii."""

    name: str
    drops: int
    seconds: float
    settled: int
    in_spheres: float  # the deepest overlap of two spheres
    in_object: float  # the deepest overlap with the mesh
    moved: float  # the largest displacement of a sphere after it was frozen
    hanging: int  # number of spheres at rest that touch nothing

    def row(self, naive: float) -> list[str]:
        """Return the row of the table; ``naive`` is the drops per second of the naive script."""
        rate = self.drops / self.seconds
        speeds = [f"{self.drops}", f"{self.seconds:.3f}", f"{rate:,.0f}", f"{rate / naive:,.1f}"]
        depths = [f"{depth:.3f}" for depth in (self.in_spheres, self.in_object, self.moved)]
        return [self.name, *speeds, f"{self.settled}", *depths, f"{self.hanging}"]


def mujoco_simulator() -> Simulator | None:
    """Return the example's simulator; None, with a printed reason, if it cannot run."""
    if importlib.util.find_spec("mujoco") is None or not EXAMPLE.is_file():
        say("MuJoCo is left out: it wants `pip install mujoco` and this repository's examples/mujoco_backend.")
        return None
    spec = importlib.util.spec_from_file_location(EXAMPLE.stem, EXAMPLE)
    sys.modules[EXAMPLE.stem] = module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module.MujocoSimulator()


def backend_run(case: Case, name: str, drops: int) -> PeerRun | None:
    """Return the result of a backend with the best time of three runs; None if it cannot run."""
    simulator = mujoco_simulator() if name == "mujoco" else make_simulator(name)
    if simulator is None:
        return None
    title = f"MuJoCo {version('mujoco')}" if name == "mujoco" else f"our {name}"
    cloud, settings = load_cloud(case.path), DropSettings(radius=case.radius, max_drops=drops, miss_limit=drops)
    warm_up(simulator)
    runs = [simulator.drop(cloud, settings, 0) for _ in range(3)]
    seconds = min(run.seconds for run in runs)
    return measured(title, case, runs[0].centers, runs[0].drops, seconds)


def measured(name: str, case: Case, centers: np.ndarray, drops: int, seconds: float) -> PeerRun:
    """Return the result of a peer, with its settled centres (S, 3), metres, measured against the mesh itself."""
    from scipy.spatial import cKDTree

    apart_by = np.full(len(centers), np.inf)
    if len(centers) > 1:
        apart_by = cKDTree(centers).query(centers, k=2)[0][:, 1] / case.radius - 2
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


def mesh_distances(mesh: Mesh, centers: np.ndarray) -> np.ndarray:
    """Return each centre's distance (S,) to the nearest place of a mesh, metres."""
    scene = raycasting_scene((mesh.vertices, mesh.faces))
    return scene.compute_distance(np.asarray(centers, np.float32)).numpy()


def cases(names: list[str], folder: Path) -> list[Case]:
    """Return objects by name; a file that has to be made is written into a folder.

    Raises
    ------
    InputError
        If a name is unknown.
    """
    chair = next(each for each in OBJECTS["bullet"] if each[0] == "chair")
    known = {"mug": peer_mug("PyBullet's mug"), "table": plain_table(folder), "chair": case_of(*chair)}
    require_known("--objects", names, known)
    return [known[name] for name in names]


def print_peers(case: Case, drops: int):
    """Print one row for each peer."""
    say(f"{case.title}: the naive PyBullet script runs, up to a minute …")
    runs = [apart(naive_run, case, drops)]
    runs += [apart(backend_run, case, name, drops) for name in ("mujoco", *usable_backends(("bullet", "fast")))]
    naive = runs[0].drops / runs[0].seconds
    head = [f"{case.title}, r = {format_length(case.radius)}", "drops", "seconds", "drops/s", "times naive", "kept"]
    head += ["deepest in a sphere, r", "in the object, r", "moved when frozen, r", "hang in the air"]
    print_table(f"\nThe same {drops} drops by peers", head, [run.row(naive) for run in runs if run is not None])


def compare_peers(
    drops: Annotated[int, typer.Option(min=10, help="Number of spheres that each drops.")] = DROPS,
    objects: Annotated[str, typer.Option(help="Objects, separated by commas.")] = "mug,table,chair",
):
    """Print the tables of docs/speed.md."""
    use_one_core()
    if peer_mug("") is None:
        return say("The peers are left out: PyBullet is not installed (pip install spherefunc-bullet[bullet]).")
    with TemporaryDirectory() as folder:
        for case in cases(objects.split(","), Path(folder)):
            print_peers(case, drops)
    print_machine()
