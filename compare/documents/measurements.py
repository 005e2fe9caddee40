"""The commands behind the tables, their dependencies, and the blocks that show the output of programs."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from .tables import DocumentTable, Measurement

MODELS, CUBES = "../shared/data/models", "--method cubes"
SIX = "household build/impaired build/household-{1,2,3,4,5}"

SHARED = (
    *("spherefunc_bullet/classification.py", "spherefunc_bullet/function_model.py", "spherefunc_bullet/formats/ply.py"),
    *(f"spherefunc_bullet/{name}/**/*.py" for name in ("clouds", "datasets", "learning", "settling", "simulator")),
)
EVALUATION = (*SHARED, "compare/evaluation/**/*.py")
COPIES = ("scenes/impairment/**/*.py",)
HOUSEHOLD = ("scenes/household/**/*.py",)
BULLET = "spherefunc_bullet/bullet"
# Without its bodies, objects that are free to move: mechanics depends on them, labels do not.
BACKENDS = {"fast": ("fast_sim/**/*.py",), "bullet": (f"{BULLET}/*.py", f"{BULLET}/collision/*.py")}
BOTH = (*BACKENDS["fast"], *BACKENDS["bullet"])


def measured(name: str, command: str, *modules: str, **how: Any) -> Measurement:
    """Return the measurement of one command."""
    return Measurement(name=name, command=command, modules=modules, **how)


def labels(name: str, arguments: str, *modules: str, backend: str = "fast") -> Measurement:
    """Return the measurement of one `spherefunc evaluate`."""
    command = f"spherefunc evaluate {arguments}" + ("" if backend == "fast" else f" --backend {backend}")
    return measured(f"{name}-{backend}", command, *EVALUATION, *BACKENDS[backend], *modules)


def of_both(name: str, command: str, *modules: str) -> dict[str, Measurement]:
    """Return the measurements of one `spherefunc evaluate` by either backend."""
    return {backend: labels(name, command, *modules, backend=backend) for backend in BACKENDS}


ON_MODELS = of_both("models", f"{MODELS} --groups --impaired --copied 14 --train-sizes 20,45,100,half", *COPIES)
FROM_HOUSEHOLD = of_both("household-to-models", f"household --test {MODELS}", *HOUSEHOLD)
FROM_SIX = of_both("six-to-models", f"{SIX} --test {MODELS}", *HOUSEHOLD, *COPIES)
CUBES_ON_MODELS = labels("models-cubes", f"{MODELS} {CUBES} --train-sizes 100,half --leave-one-out --groups")
CUBES_FROM_HOUSEHOLD = labels("household-to-models-cubes", f"household {CUBES} --test {MODELS}", *HOUSEHOLD)
PAPER = "--method paper --train-sizes 20,45,85"
PAPER_ON_HOUSEHOLD = labels("household-paper", f"household {PAPER},half --leave-one-out --confusion", *HOUSEHOLD)
PAPER_ON_MODELS = labels("models-paper", f"{MODELS} {PAPER},100,half --leave-one-out --groups --confusion")


def whole(*printed: Sequence[str]) -> list[str]:
    """Return the output of programs as a block of code, separated by empty lines."""
    blocks = ["\n".join(lines).strip("\n") for lines in printed]
    return ["```", *"\n\n".join(blocks).split("\n"), "```"]


SPEED, ROOMS, MECHANICS = (f"docs/{name}.md" for name in ("speed", "rooms", "mechanics"))
COMPARISON = "docs/comparison.md"
LIBRARY = "spherefunc_bullet/learning/models"
SHIPPED = tuple(f"{LIBRARY}/household-{name}.npz" for name in BACKENDS)
FOR_SCANS = f"{LIBRARY}/household-scans-fast.npz"
# All of `scenes` but what is printed and drawn, depth images over time, and bags of ROS.
SCENES = ("scenes/*.py", "scenes/[!cfr]*/**/*.py", "scenes/recognition/*.py")
# And of the programs in rooms, those that neither train the model nor see real scans.
IN_ROOMS = (*SHARED, *BACKENDS["fast"], "compare/rooms/[!rs]*.py", *SCENES)
PRINTED = {"json": False}
TIMED = PRINTED | {"timed": True}


def timed(name: str, arguments: str = "", files: tuple[str, ...] = ()) -> Measurement:
    """Return the measurement of one of the programs of ``compare/bench``."""
    command = f"python -m spherefunc_bullet.compare.bench {name} {arguments}".strip()
    modules = ("compare/bench/*.py", *SHARED, *BOTH, *HOUSEHOLD)
    return measured(f"bench-{name}", command, *modules, files=files, **TIMED)


def speed(backend: str) -> Measurement:
    """Return the measurement of the speed of one simulator."""
    command = f"python -m spherefunc_bullet.compare.bench --backends {backend}"
    return measured(f"bench-{backend}", command, "compare/bench/*.py", *SHARED, *BACKENDS[backend], *HOUSEHOLD, **TIMED)


def rooms(name: str, options: str) -> Measurement:
    """Return the measurement of virtual rooms of the real models, by the model for scans."""
    command = f"spherefunc rooms {MODELS} --model {FOR_SCANS} {options}"
    return measured(name, command, *IN_ROOMS, files=(FOR_SCANS,), **PRINTED)


def fused(name: str, program: str, seed: int, options: str = "", **how: Any) -> tuple[Measurement, ...]:
    """Return the measurements of depth images fused in virtual rooms by one of the programs of ``compare/rooms``.

    Both data sets furnish rooms, each with a seed of its own, and stand in the name in place of ``{}``.
    """
    modules, done = (*IN_ROOMS, "scenes/fusion/*.py"), []
    for turn, (short, data) in enumerate({"models": MODELS, "household": "household"}.items()):
        command = f"python -m spherefunc_bullet.compare.rooms.{program} {data} --seed {seed + turn}{options}"
        done.append(measured(name.format(short), command, *modules, files=(FOR_SCANS,), **how))
    return tuple(done)


FRAMES = fused("fused-{}", "fused_frames", 31, **PRINTED)
ONE_CM = fused("poses-{}-10mm", "fused_frames", 31, " --pose-error 0.01", **PRINTED)
TWO_CM = fused("poses-{}-20mm", "fused_frames", 31, " --pose-error 0.02", **PRINTED)
POSES = (ONE_CM[0], TWO_CM[0], ONE_CM[1], TWO_CM[1])
UPDATES = fused("updates-{}", "fused_updates", 51, **TIMED)
COMPARED = measured(
    "compare-cubes",
    f"spherefunc compare {MODELS} --method cubes --radii 5mm,1cm,2cm,3cm,5cm --report build/comparison",
    *("compare/comparison/*.py", *EVALUATION, *BOTH),
    **TIMED,
)
MECHANICAL = ("compare/mechanics/*.py", *SHARED, *BOTH, *COPIES, f"{BULLET}/bodies/*.py")
TASKS = measured("mechanics", f"spherefunc mechanics {MODELS}", *MECHANICAL, files=SHIPPED[:1], **TIMED)


def shown(name: str, document: str, *measurements: Measurement) -> DocumentTable:
    """Return the block with the output of programs."""
    return DocumentTable(name=name, document=document, measurements=measurements, render=whole)


SHOWN = (
    shown("bench", SPEED, *map(speed, BACKENDS)),
    shown("peers", SPEED, timed("peers", "--drops 870")),
    shown("labels", SPEED, timed("labels", MODELS, files=SHIPPED)),
    shown("answers", SPEED, timed("answers", files=SHIPPED[:1])),
    shown("rooms-views", ROOMS, rooms("rooms-views", "--rooms 24 --views whole,1,2,3,5 --cut-out")),
    shown("rooms-noise", ROOMS, rooms("rooms-noise", "--rooms 24 --views 3 --noise 0,2")),
    shown("fused-frames", "docs/scenes.md", *FRAMES),
    shown("fused-poses", "docs/scenes.md", *POSES),
    shown("fused-updates", "docs/scenes.md", *UPDATES),
    shown("compared", COMPARISON, COMPARED),
    shown("mechanics", MECHANICS, TASKS),
)
