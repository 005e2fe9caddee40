"""Programs that are interrupted, or run where the system refuses something."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from spherefunc_bullet.processes.tasks import run_tasks

SCRIPT = Path(sys.executable).with_name("spherefunc")
RUN = "from spherefunc_bullet.console import run, show\n"
# As trimesh does while it is imported, and as callbacks from C do.
SWALLOWING = """
import time

try:
    print("asleep", flush=True)
    time.sleep({})
except BaseException:
    pass
print("done", flush=True)
"""


def python(folder: Path, text: str, **environment: str) -> subprocess.Popen:
    """Start a program from which Ctrl-C is not kept, as a shell does in the background."""
    return subprocess.Popen(
        [sys.executable, "-c", text],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        cwd=folder,
        env=os.environ | environment,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )


@pytest.mark.skipif(sys.platform == "win32", reason="needs signals")
@pytest.mark.parametrize("how", ["import slow", "exec(open('slow.py').read())"], ids=["import", "call"])
def test_ctrl_c_that_a_library_swallows_ends_the_program_with_one_line(tmp_path, how):
    """An import comes to its end first, or half of a library would be used."""
    imports = how.startswith("import")
    (tmp_path / "slow.py").write_text(SWALLOWING.format(1 if imports else 60))
    process = python(tmp_path, f"{RUN}def main():\n    {how}\n    import time; time.sleep(60)\nrun(main)")
    assert process.stdout.readline() == "asleep\n"
    process.send_signal(signal.SIGINT)
    assert process.communicate() == ("done\n", "spherefunc: interrupted\n") and process.returncode == 130


def blocked(_: int) -> bool:
    """Return whether Ctrl-C waits in this process."""
    return signal.SIGINT in signal.pthread_sigmask(signal.SIG_BLOCK, [])


@pytest.mark.skipif(sys.platform == "win32", reason="needs signals")
def test_ctrl_c_does_not_reach_processes_that_are_starting():
    """It is sent to all processes of a terminal, and would print tracebacks of imports."""
    assert [outcome for _, outcome in run_tasks(blocked, [(0,)], ["task"], isolate=True)] == [True]
    assert not blocked(0)


def test_letters_that_the_locale_lacks_are_written_out(tmp_path):
    process = python(tmp_path, f"{RUN}run(lambda: show('43 cm\N{SUPERSCRIPT TWO}'))", PYTHONIOENCODING="ascii")
    assert process.communicate() == ("43 cm\\xb2\n", "") and process.returncode == 0


@pytest.mark.parametrize(
    "words", [("together", "{}@0,0"), ("scene", "--frames", "{}"), ("shapes", "{}"), ("scene", "{}.bag")]
)
def test_a_name_that_is_too_long_is_one_line(words):
    command = [SCRIPT, *(word.format(300 * "a") for word in words)]
    ended = subprocess.run(command, capture_output=True, text=True)
    assert ended.returncode == 2 and ended.stderr.startswith("spherefunc: ") and ended.stderr.count("\n") == 1
    assert "File name too long" in ended.stderr
