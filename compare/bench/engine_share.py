"""Where `bullet` spends its time: how much of it the engine's own `stepSimulation` takes.

    python -m spherefunc_bullet.compare.bench engine_share

Processor time, so that other work on the machine counts little.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from time import process_time

from spherefunc_bullet.bullet.backend import BulletSimulator
from spherefunc_bullet.bullet.collision.shape import collision_shape
from spherefunc_bullet.bullet.dropping import DropRun
from spherefunc_bullet.bullet.world import World
from spherefunc_bullet.clouds.cloud import load_cloud
from spherefunc_bullet.console import print_table
from spherefunc_bullet.formats.units import format_length, parse_length
from spherefunc_bullet.settling.drops import DROPS
from spherefunc_bullet.settling.settling import warm_up
from spherefunc_bullet.simulator import DropSettings

from .harness import Case, of_household, write_plain_table
from .speed import cases

FEW = {"mug_01": "1cm", "shell_chair_01": "2cm", "dining_table_02": "2cm"}  # as one radius of a label asks for


@dataclass(frozen=True, kw_only=True)
class Shares:
    """Seconds of the processor that one run takes."""

    drops: int
    surface: float  # from the cloud to what spheres collide with
    loading: float  # of that into a new engine, and looking whether it has arrived
    stepping: float  # stepSimulation
    rest: float  # of the drops: states read, spheres placed and frozen, outcomes

    @property
    def row(self) -> list[str]:
        """The numbers as they are printed."""
        parts = (self.surface, self.loading, self.stepping, self.rest)
        of_drops, of_all = self.stepping / (self.stepping + self.rest), self.stepping / sum(parts)
        return [f"{self.drops:,}", *(f"{1000 * part:.1f}" for part in parts), f"{of_drops:.2f}", f"{of_all:.2f}"]


class TimedWorld(World):
    """A world that knows how long its engine has computed."""

    stepping = 0.0

    def step(self):
        started = process_time()
        super().step()
        self.stepping += process_time() - started


def shares_of(path: Path, settings: DropSettings) -> Shares:
    """Return what a run on a file's object spends where; loading the file and compilation are not in it."""
    simulator, cloud = BulletSimulator(), load_cloud(path)
    warm_up(simulator)
    started = process_time()
    shape = collision_shape(cloud, settings.radius, simulator.kind_for(cloud, settings.radius))
    made = process_time()
    with TimedWorld(simulator) as world:
        world.add_object(shape)
        drop_run = DropRun(world, shape, cloud, settings, 0)
        ready = process_time()
        drop_run.until_over()
        rest = process_time() - ready - world.stepping
    drops = len(drop_run.outcomes)
    return Shares(drops=drops, surface=made - started, loading=ready - made, stepping=world.stepping, rest=rest)


def print_engine_share():
    """Print a row for each full run, and for the first drops of one radius as a label asks for them."""
    few = [Case(title=name, path=of_household(name), radius=parse_length(radius)) for name, radius in FEW.items()]
    rows = []
    with TemporaryDirectory() as folder:
        full = cases("bullet", write_plain_table(Path(folder)), quick=False)
        for case, drops in [*((case, None) for case in full), *((case, DROPS) for case in few)]:
            settings = DropSettings(radius=case.radius, max_drops=drops, miss_limit=drops or 50)
            rows.append([case.title, format_length(case.radius), *shares_of(case.path, settings).row])
    head = ["object", "radius", "drops", "surface ms", "loading ms", "stepSimulation ms", "rest of the drops ms"]
    title = "\nWhere bullet's time goes, processor time; stepSimulation's share"
    print_table(title, [*head, "share of the drops", "of all"], rows)
