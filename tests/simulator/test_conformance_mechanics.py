"""The installed backends keep the optional part of the contract."""

from spherefunc_bullet.conformance.test_mechanics import *  # noqa: F403
