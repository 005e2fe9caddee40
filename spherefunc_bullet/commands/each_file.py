"""What commands ask of one file after another, in a process of its own where the simulator wants that."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..console import Failures

if TYPE_CHECKING:
    from ..simulator import Simulator


def run_on_files(
    function: Callable, files: Sequence[Path], simulator: Simulator, how: tuple, doing: str, failures: Failures
) -> list[tuple[Path, Any]]:
    """Return each file with the function's result; a file that fails is reported, and left out.

    Parameters
    ----------
    tell : callable
        Takes a file, the simulator, and the rest, ``how``.
    doing : str
        What the progress bar says.
    """
    from ..processes.tasks import run_tasks
    from ..simulator import isolated

    tasks = [(file, simulator, *how) for file in files]
    outcomes = run_tasks(function, tasks, files, isolate=isolated(simulator))
    return [(files[index], outcome) for index, outcome in failures.passed(outcomes, len(files), doing)]
