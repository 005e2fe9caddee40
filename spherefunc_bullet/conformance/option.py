"""The pytest option ``--backend``, for runs of this suite only.

It is a plugin, since pytest does not look for a ``conftest.py`` in the packages of ``--pyargs`` before it parses its
options. Other runs are not affected: they may have their own ``--backend``.
"""

from __future__ import annotations

from collections.abc import Sequence

import pytest


def pytest_load_initial_conftests(parser: pytest.Parser, args: Sequence[str]):
    """Add ``--backend NAME`` if this suite is run."""
    if any(__package__ in argument for argument in args):
        parser.addoption("--backend", help="the registered name of the backend under test; without it, all")
