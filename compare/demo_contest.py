"""The demo's comparison: some of the built-in catalogue's objects by every simulator that can run here."""

from __future__ import annotations

from pathlib import Path

from spherefunc_bullet.catalogue import make_catalogue, write_catalogue
from spherefunc_bullet.console import Failures
from spherefunc_bullet.dataset import open_dataset

from .compare_command import BACKENDS, settled_experiment, write_report
from .comparison import compare_entries
from .contest import evenly, hold
from .experiment import Experiment, contestants
from .machine import usable_backends

OBJECTS = 40  # evenly spread over the catalogue, so in its proportions
AGAIN = 8  # of them dropped on with a second seed
RADII = (0.03, 0.05)  # metres: the quick ones


def compare_some(data: str, out: Path, jobs: int) -> dict:
    """Write objects of a catalogue and the report of a comparison on them, and return the report.

    Raises
    ------
    InputError
        If the folder cannot be written.
    """
    folder = out / "objects"
    write_catalogue(evenly(make_catalogue(data), OBJECTS), folder, f"{OBJECTS} of {data}")
    experiment = Experiment(
        data=str(folder), backends=usable_backends(BACKENDS), radii={"all": RADII}, repeated=AGAIN
    )
    contest = hold(open_dataset(folder), contestants(experiment), experiment, jobs, Failures())
    experiment = settled_experiment(experiment, contest)
    found = compare_entries(contest, experiment)
    write_report(out, found, contest, experiment)
    return found
