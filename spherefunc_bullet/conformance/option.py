"""The option ``--backend`` of pytest, for runs of this suite alone.

A plugin, since pytest looks for no ``conftest.py`` in what ``--pyargs`` names before it reads its options. Other runs
are left alone: they may have a ``--backend`` of their own.
"""

from __future__ import annotations

from collections.abc import Sequence

import pytest

SUITE = __package__


def pytest_load_initial_conftests(parser: pytest.Parser, args: Sequence[str]):
    """Add ``--backend NAME`` where this suite is asked for."""
    if any(SUITE in argument for argument in args):
        parser.addoption("--backend", help="the registered name of the backend under test; without it, all")
