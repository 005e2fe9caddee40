"""The commands behind the tables, what each depends on, and the blocks that show what a program printed."""

from __future__ import annotations

from collections.abc import Sequence

from ..bench.__main__ import BENCHES
from .saved import Measurement
from .tables import Table, fenced

MODELS, CUBES = "../shared/data/models", "--method cubes"
SIX = "household build/impaired build/household-{1,2,3,4,5}"

EVALUATION = ("compare/evaluation/tables.py", "spherefunc_bullet/formats/ply.py")
COPIES = ("compare/evaluation/impaired.py",)
HOUSEHOLD = ("scenes/household/household.py",)
BACKENDS = {"fast": "fast_sim/backend.py", "bullet": "spherefunc_bullet/bullet/backend.py"}
WITHOUT_BODIES = ("spherefunc_bullet/bullet/bodies/",)  # objects that are free to move: of mechanics, not of labels


def labels(name: str, command: str, *modules: str, backend: str = "fast") -> Measurement:
    """Return the measurement of one `spherefunc evaluate`."""
    return Measurement(
        name=f"{name}-{backend}",
        command=f"spherefunc evaluate {command}" + ("" if backend == "fast" else f" --backend {backend}"),
        modules=(*EVALUATION, BACKENDS[backend], *modules),
        without=WITHOUT_BODIES,
    )


def of_both(name: str, command: str, *modules: str) -> dict[str, Measurement]:
    """Return the measurements of one `spherefunc evaluate` by either backend."""
    return {backend: labels(name, command, *modules, backend=backend) for backend in BACKENDS}


ON_MODELS = of_both("models", f"{MODELS} --groups --impaired --copied 14 --train-sizes 20,45,100,half", *COPIES)
FROM_HOUSEHOLD = of_both("household-to-models", f"household --test {MODELS}", *HOUSEHOLD)
FROM_SIX = of_both("six-to-models", f"{SIX} --test {MODELS}", *HOUSEHOLD, "scenes/impairment/folder.py")
CUBES_ON_MODELS = labels("models-cubes", f"{MODELS} {CUBES} --train-sizes 100,half --leave-one-out --groups")
CUBES_FROM_HOUSEHOLD = labels("household-to-models-cubes", f"household {CUBES} --test {MODELS}", *HOUSEHOLD)
CUBES_ON_HOUSEHOLD = labels("household-cubes", f"household {CUBES} --leave-one-out", *HOUSEHOLD)
PAPER = "--method paper --train-sizes 20,45,85"
PAPER_ON_HOUSEHOLD = labels("household-paper", f"household {PAPER},half --leave-one-out --confusion", *HOUSEHOLD)
PAPER_ON_MODELS = labels("models-paper", f"{MODELS} {PAPER},100,half --leave-one-out --groups --confusion")
def script(
    name: str,
    module: str,
    arguments: str,
    *modules: str,
    backend: str = "fast",
    files: tuple[str, ...] = (),
    json: bool = True,
    timed: bool = False,
) -> Measurement:
    """Return the measurement of one module that is run as a program, or of ``bench NAME``."""
    place = f"bench.{BENCHES[module.split()[1]][0]}" if module.startswith("bench ") else module
    path = f"compare/{place.replace('.', '/')}.py"
    return Measurement(
        name=name,
        command=f"python -m spherefunc_bullet.compare.{module} {arguments}".strip(),
        modules=(path, *EVALUATION, BACKENDS[backend], *modules),
        without=WITHOUT_BODIES,
        files=files,
        json=json,
        timed=timed,
    )


Printed = Sequence[str]  # the lines that a program printed


def whole(*printed: Printed) -> list[str]:
    """Return all that programs printed, an empty line between two."""
    blocks = ["\n".join(lines).strip("\n") for lines in printed]
    return fenced("\n\n".join(blocks).split("\n"))


SPEED, ROOMS, MECHANICS = (f"docs/{name}.md" for name in ("speed", "rooms", "mechanics"))
COMPARISON = "docs/comparison.md"
LIBRARY = "spherefunc_bullet/learning/models"
SHIPPED = tuple(f"{LIBRARY}/household-{name}.npz" for name in BACKENDS)
FOR_SCANS = f"{LIBRARY}/household-scans-fast.npz"
BOTH = tuple(BACKENDS.values())


def timed(name: str, arguments: str = "", files: tuple[str, ...] = ()) -> Measurement:
    """Return one of the programs of ``compare/bench``, which take times."""
    modules = (*BOTH, *HOUSEHOLD)
    return script(f"bench-{name}", f"bench {name}", arguments, *modules, files=files, json=False, timed=True)


BENCH = {
    backend: Measurement(
        name=f"bench-{backend}",
        command=f"python -m spherefunc_bullet.compare.bench --backends {backend}",
        modules=("compare/bench/speed.py", path, *HOUSEHOLD),
        without=("spherefunc_bullet/bullet/bodies/",),
        json=False,
        timed=True,
    )
    for backend, path in BACKENDS.items()
}
LABELS = timed("labels", MODELS, files=SHIPPED)
IN_ROOMS = (
    "compare/rooms/trials.py",
    "compare/rooms/matching.py",
    BACKENDS["fast"],
    "spherefunc_bullet/formats/ply.py",
)


def rooms(name: str, options: str) -> Measurement:
    """Return the measurement of virtual rooms of the real models, by the model for scans."""
    return Measurement(
        name=name,
        command=f"spherefunc rooms {MODELS} --model {FOR_SCANS} {options}",
        modules=IN_ROOMS,
        files=(FOR_SCANS,),
        json=False,
    )


VIEWS = rooms("rooms-views", "--rooms 24 --views whole,1,2,3,5 --cut-out")
NOISE = rooms("rooms-noise", "--rooms 24 --views 3 --noise 0,2")
COMPARED = Measurement(
    name="compare-cubes",
    command=f"spherefunc compare {MODELS} --method cubes --radii 5mm,1cm,2cm,3cm,5cm --report build/comparison",
    modules=("compare/comparison/comparison.py", *EVALUATION, *BOTH),
    without=("compare/mechanics/", "spherefunc_bullet/bullet/bodies/", "compare/evaluation/impaired.py"),
    json=False,
    timed=True,
)
TASKS = Measurement(
    name="mechanics",
    command=f"spherefunc mechanics {MODELS}",
    modules=("compare/mechanics/measures.py", "spherefunc_bullet/formats/ply.py", *BOTH),
    files=(SHIPPED[0],),
    json=False,
    timed=True,
)


def shown(name: str, document: str, *measurements: Measurement) -> Table:
    """Return the block of what programs printed."""
    return Table(name=name, document=document, measurements=measurements, render=whole)


SHOWN = (
    shown("bench", SPEED, *BENCH.values()),
    shown("peers", SPEED, timed("peers", "--drops 870")),
    shown("labels", SPEED, LABELS),
    shown("answers", SPEED, timed("answers", files=SHIPPED[:1])),
    shown("rooms-views", ROOMS, VIEWS),
    shown("rooms-noise", ROOMS, NOISE),
    shown("compared", COMPARISON, COMPARED),
    shown("mechanics", MECHANICS, TASKS),
)
