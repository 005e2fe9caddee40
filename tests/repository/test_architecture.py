"""A person can follow an answer: it is decided in one file, and runs through few."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import architecture
import pytest
from architecture import DECISION, draw, layers

MOST_FILES = 35  # more, and nobody reads them; with a new one, another has to go

# In a process of its own, since what other tests have loaded and cached is no first answer.
TRACED = "import architecture, json; print(json.dumps(architecture.files_of_classify()))"


@pytest.mark.slow
def test_a_first_answer_runs_through_few_files(tmp_path: Path):
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONSAFEPATH"}  # imports from cwd
    how = {"capture_output": True, "check": True, "cwd": Path(architecture.__file__).parent, "env": environment}
    found = json.loads(subprocess.run([sys.executable, "-c", TRACED], **how).stdout)
    assert len(found) <= MOST_FILES, "\n".join(found)
    assert {place.split(".")[0] for place in found} <= set(layers())
    assert {"classify", "decide", "check_stability", "doubts"} <= set(found[DECISION])
    draw(found, tmp_path / "picture.svg")
    assert (tmp_path / "picture.svg").stat().st_size
