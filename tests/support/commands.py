"""Commands as the console script runs them, in this process, without the seconds that a new interpreter takes."""

from __future__ import annotations

import io
import subprocess
import sys
from collections.abc import Callable
from contextlib import redirect_stderr, redirect_stdout
from importlib.util import find_spec
from unittest import mock

import pytest

from spherefunc_bullet import console
from spherefunc_bullet.commands.command_line import application


def skip_for_want_of_bullet(error: str):
    """Skip a test whose error is that PyBullet is not installed, as on Pythons that it has no wheel for."""
    if "needs PyBullet, which is not installed" in error and find_spec("pybullet") is None:
        pytest.skip(error)


def ended(call: Callable[[], object], text: str = "") -> subprocess.CompletedProcess:
    """Return what a program prints on stdout and stderr, given a text on stdin, and its exit code."""
    code, out, err = 0, io.StringIO(), io.StringIO()
    with redirect_stdout(out), redirect_stderr(err), mock.patch.object(sys, "stdin", io.StringIO(text)):
        try:
            console.run(call)
        except SystemExit as left:
            code = left.code or 0
    skip_for_want_of_bullet(err.getvalue())
    return subprocess.CompletedProcess([], code, out.getvalue(), err.getvalue())


def spherefunc(*arguments: object, text: str = "") -> subprocess.CompletedProcess:
    """Do as the console script does with these arguments; a bug of ours is raised."""
    words = [str(each) for each in arguments]
    return ended(lambda: application(words[0])(words, prog_name="spherefunc"), text)
