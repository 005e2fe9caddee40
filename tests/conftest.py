"""Tests that ask `bullet` are skipped where PyBullet is not installed, as on Pythons that it has no wheel for."""

from __future__ import annotations

import pytest
from commands import skip_for_want_of_bullet

from spherefunc_bullet.errors import InputError


@pytest.hookimpl(wrapper=True)
def pytest_runtest_call(item):
    try:
        return (yield)
    except InputError as error:
        skip_for_want_of_bullet(str(error))
        raise
