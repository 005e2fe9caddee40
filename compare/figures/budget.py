"""How good a label is after so many drops, and after so much time: one picture for several simulators.

    python -m spherefunc_bullet.compare.figures.budget DATA --out DIR

Times are those of this machine: keep it idle meanwhile. Docs/studies.md has the picture.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from time import perf_counter
from typing import Annotated

import numpy as np
import typer
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import EngFormatter

from spherefunc_bullet.batch.simulated import Simulated, simulate_dataset
from spherefunc_bullet.clouds.cloud import Cloud, load_cloud
from spherefunc_bullet.commands import options
from spherefunc_bullet.console import Failures, print_json, print_table, progress, run, say
from spherefunc_bullet.datasets.dataset import open_dataset
from spherefunc_bullet.learning.method import DROPS, PROFILE, Method
from spherefunc_bullet.settling.drops import RunLimit
from spherefunc_bullet.settling.records import Dropping
from spherefunc_bullet.settling.settling import settle
from spherefunc_bullet.simulator import make_simulator

from ..evaluation.evaluation import Evaluation, evaluate
from ..evaluation.features import sphere_distances
from ..evaluation.profiles import few_drops
from ..evaluation.protocol import Labels, Protocol, labels_of, require_enough
from ..machine import usable_backends
from ..pages.plates import DOUBLE, Plate, look, write_plate

COUNTS = f"10,20,40,80,120,{DROPS}"
TIMED = 40  # objects, evenly chosen
TIMES = 3  # that each is timed, of which the least counts


@dataclass(frozen=True, kw_only=True)
class Budget:
    """What so many drops at each radius give and cost."""

    backend: str
    drops: int
    milliseconds: float  # that they take on the median object, all radii together
    function: str
    f_measure: float  # across sources


def budgets(simulated: Simulated, timed: Sequence[Cloud], backend: str, counts: Sequence[int]) -> list[Budget]:
    """Return what each number of drops gives across the sources of a data set, and what it costs on some clouds."""
    radii = tuple(simulated.records[0].settled)
    splits = Protocol(groups=True).splits(labels_of(simulated))
    shares = few_drops(simulated, radii, counts, splits)
    times = {count: 1000 * median_seconds(timed, backend, radii, count) for count in counts}
    return [
        Budget(backend=backend, drops=count, milliseconds=round(times[count], 2), function=name, f_measure=f_measure)
        for count in counts
        for name, f_measure in shares[count].items()
    ]


def median_seconds(timed: Sequence[Cloud], backend: str, radii: tuple[float, ...], count: int) -> float:
    """Return the seconds that drops take on the median of some clouds, all radii together."""
    simulator, taken = make_simulator(backend), []
    settle(timed[0], simulator, radii, 0, RunLimit(drops=count))  # compiles and loads what is to be timed
    for cloud in progress(timed, len(timed), f"{backend}, {count} drops"):
        laps = []
        for _ in range(TIMES):
            fresh = Cloud(cloud.points, cloud.name, cloud.mesh)  # nothing of an earlier lap is kept with it
            start = perf_counter()
            settle(fresh, simulator, radii, 0, RunLimit(drops=count))
            laps.append(perf_counter() - start)
        taken.append(min(laps))
    return float(np.median(taken))


def budget_plate(rows: Sequence[Budget], data: str) -> Plate:
    """Return the figure: F-measures against drops on the left, against milliseconds on the right."""
    return Plate(
        stem="budget",
        caption=f"F-measure across the sources of {data} when only the first so many drops at each radius are read, in "
        "learning and in asking: against their number, and against the time that they take on the median object.",
        size=(DOUBLE, 3.0),
        draw=lambda figure: draw_budget(figure, rows),
        rows=[asdict(row) for row in rows],
    )


def draw_budget(figure: Figure, rows: Sequence[Budget]):
    """Draw both panels."""
    by_drops, by_time = figure.subplots(1, 2, sharey=True)
    draw_lines(by_drops, rows, "drops")
    draw_lines(by_time, rows, "milliseconds")
    by_drops.set(xlabel="drops at each radius", ylabel="F-measure across sources")
    counts = sorted({row.drops for row in rows})
    by_drops.set_xticks(counts, map(str, counts))
    by_drops.minorticks_off()
    by_time.set(xlabel="time of the drops on the median object (logarithmic)")
    by_time.xaxis.set_major_formatter(EngFormatter(unit="s"))
    figure.legend(*by_drops.get_legend_handles_labels(), loc="outside upper center", ncols=3, handlelength=3.2)


def draw_lines(axes: Axes, rows: Sequence[Budget], across: str):
    """Draw a line for each function and backend: a colour for the function, a dash and a marker for the backend."""
    functions, backends = (list(dict.fromkeys(getattr(row, key) for row in rows)) for key in ("function", "backend"))
    for place, backend in enumerate(backends):
        for colour, function in enumerate(functions):
            own = [row for row in rows if (row.backend, row.function) == (backend, function)]
            style = look(place) | {"color": look(colour)["color"]}
            values = [getattr(row, across) / (1000 if across == "milliseconds" else 1) for row in own]
            axes.plot(values, [row.f_measure for row in own], **style, markersize=4, label=f"{function}, {backend}")
    axes.set_xscale("log")
    axes.grid(axis="y", linewidth=0.3, color="#dddddd")


def main(
    data: Annotated[str, typer.Argument(metavar="DATA", help="A folder with manifest.csv that names sources.")],
    out: Annotated[Path, typer.Option(help="Folder of budget.png, .svg and .csv.")],
    backends: Annotated[str, typer.Option(help="Whose drops; those that are installed.")] = "fast,bullet",
    counts: Annotated[str, typer.Option(help="Drops at each radius.")] = COUNTS,
    jobs: options.Jobs = -1,
    json: options.Json = False,
):
    """Print and draw how good labels are after so many drops, and after so much time."""
    failures, dataset, rows = Failures(), open_dataset(data), []
    chosen = [dataset.objects[k].path for k in np.linspace(0, len(dataset.objects) - 1, TIMED).astype(int)]
    clouds = [load_cloud(path) for path in chosen]
    for backend in usable_backends(backends.split(",")):
        dropping = options.dropping(backend, None, None, 0, "z", "m", PROFILE)
        simulated = simulate_dataset(dataset, dropping, jobs=jobs, failed=failures.add)
        rows += budgets(simulated, clouds, backend, [int(count) for count in counts.split(",")])
    out.mkdir(parents=True, exist_ok=True)
    for path in write_plate(budget_plate(rows, dataset.name), out):
        say(f"wrote {path}")
    print_json([asdict(row) for row in rows]) if json else print_rows(rows)
    failures.exit()


def print_rows(rows: Sequence[Budget]):
    """Print a row for each backend and number of drops."""
    table: dict[tuple[str, int], list[str]] = {}
    for row in rows:
        begin = [row.backend, str(row.drops), f"{row.milliseconds:.1f}"]
        table.setdefault((row.backend, row.drops), begin).append(f"{row.f_measure:.3f}")
    functions = list(dict.fromkeys(row.function for row in rows))
    print_table("across sources", ["backend", "drops", "ms", *(f"F {name}" for name in functions)], [*table.values()])


LADDER = (5, 10, 20, 30, 45, 65, 85, 125, 175, 250, 350, 500, 700, 1000)  # training sizes, the paper's among them
APART = 0.9  # of the last rung: one nearer to it would only crowd the figure


@dataclass(frozen=True, kw_only=True)
class EvaluatedData:
    """A data set's objects, and what was said of them when they were not learnt."""

    simulated: Simulated
    dropping: Dropping
    protocol: Protocol  # its training sizes are those of the confusion matrices
    evaluation: Evaluation  # at the training sizes of the learning curve

    @property
    def name(self) -> str:
        return self.simulated.name

    @property
    def radii(self) -> tuple[float, ...]:
        """Metres, ascending."""
        return self.dropping.radii

    @property
    def labels(self) -> Labels:
        return self.evaluation.labels

    @property
    def half(self) -> int:
        """The largest number of training examples."""
        return self.evaluation.halves[0]

    def cloud(self, index: int) -> Cloud:
        """Return an object's cloud, as it was when the spheres fell."""
        return self.dropping.cloud(self.simulated.objects[index].path)


def evaluate_data(simulated: Simulated, dropping: Dropping, method: Method, protocol: Protocol) -> EvaluatedData:
    """Return a data set with its evaluation, at more training sizes than the protocol has, and each object left out.

    Raises
    ------
    InputError
        If all objects have one label, or there are too few.
    """
    labels = labels_of(simulated)
    require_enough(simulated.name, len(labels))
    distances, trials = sphere_distances(simulated, dropping.radii, method), {}
    sizes = ladder(len(labels), protocol.train_sizes)
    for size in progress(sizes, len(sizes), "learning and testing"):
        splits = replace(protocol, train_sizes=(size,)).splits(labels)
        trials |= evaluate(distances, labels, method, splits).trials
    alone = replace(protocol, train_sizes=(), leave_one_out=True).splits(labels)
    evaluation = replace(evaluate(distances, labels, method, alone), trials=trials)
    return EvaluatedData(simulated=simulated, dropping=dropping, protocol=protocol, evaluation=evaluation)


def ladder(count: int, sizes: tuple[int, ...]) -> list[int]:
    """Return the training sizes of the learning curve: up to half of the objects, ``sizes`` among them."""
    half = count // 2
    return sorted({half, *sizes, *(size for size in LADDER if size < APART * half)})


if __name__ == "__main__":
    run(lambda: typer.run(main))
