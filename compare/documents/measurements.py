"""The commands behind the tables of labels, and what each depends on."""

from __future__ import annotations

from ..bench.__main__ import BENCHES
from .saved import Measurement

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


