"""Tests that ask `bullet` are skipped where PyBullet is not installed, as on Pythons that it has no wheel for."""

from __future__ import annotations

from importlib.util import find_spec

import pytest

from spherefunc_bullet.errors import InputError

LACKING = "needs PyBullet, which is not installed"


@pytest.hookimpl(wrapper=True)
def pytest_runtest_call(item):
    try:
        return (yield)
    except InputError as error:
        if LACKING in str(error) and find_spec("pybullet") is None:
            pytest.skip(str(error))
        raise
