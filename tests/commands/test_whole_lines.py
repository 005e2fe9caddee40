"""What is said on stderr comes in whole lines, since other processes write there too."""

from __future__ import annotations

import socket
import subprocess
import sys

import pytest

SCRIPT = """
from spherefunc_bullet.console import Failures, say
from spherefunc_bullet.errors import InputError

say("a line")
Failures().add(InputError("mug.ply: expected points, got none"))
"""


@pytest.mark.skipif(not hasattr(socket, "AF_UNIX"), reason="needs sockets that keep writes apart")
def test_each_line_is_one_write():
    ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_DGRAM)
    with ours, theirs:
        subprocess.run([sys.executable, "-c", SCRIPT], stderr=theirs, check=True)
        ours.setblocking(False)
        assert ours.recv(1000) == b"a line\n"
        assert ours.recv(1000) == b"spherefunc: mug.ply: expected points, got none\n"
