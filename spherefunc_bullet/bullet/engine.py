"""PyBullet, which may be missing and prints its build time on stderr when it is imported; and the physics of spheres.

Its calls hold Python's global lock, so engines in several threads take turns; each engine is independent.
"""

from __future__ import annotations

import os
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from importlib.metadata import PackageNotFoundError, version

import numpy as np

from ..errors import CheckedSettings, InputError, amount, explaining

CLONE_FILES = 0x400  # Linux, sched.h
CLOSE_RANGE_UNSHARE, NONE = 2, 2**32 - 1  # Linux, close_range.h; and a number that is no descriptor
LARGEST_REUSED_BLOCK = 2**25 - 2**13  # bytes
MISSING = (
    "backend 'bullet' needs PyBullet, which is not installed: pip install 'pybullet>=3.2.7' "
    "(ready-made for CPython up to 3.11 on Linux; for others pip builds it with a C++ compiler)"
)


@cache  # reads the package's metadata, and every run needs it
def engine_version() -> str:
    """Return the version of the installed PyBullet.

    Raises
    ------
    InputError
        If it is not installed.
    """
    with explaining(MISSING, PackageNotFoundError):
        return version("pybullet")


@cache
def pybullet():
    """Return the module pybullet, imported when it is first needed.

    Raises
    ------
    InputError
        If it is missing or broken.
    """
    engine_version()
    with explaining("backend 'bullet': PyBullet is installed but cannot be imported", ImportError, why=": "):
        with ThreadPoolExecutor(1) as apart:
            apart.submit(import_silently).result()
        import pybullet
    # On Linux the C library keeps blocks as large as the largest that was ever freed, up to 32 MiB. Freeing one at the
    # start, which is never written to, makes it keep the memory of a closed engine for the next one.
    np.empty(LARGEST_REUSED_BLOCK, np.uint8)
    return pybullet


class Engine:
    """One engine in this process, in DIRECT mode; it must be closed, preferably by ``with``."""

    def __init__(self, **parameters: float):
        p = pybullet()
        self.client = p.connect(p.DIRECT)
        self.engine = {"physicsClientId": self.client}
        p.setPhysicsEngineParameter(deterministicOverlappingPairs=1, **parameters, **self.engine)
        # The default visual shape would be tessellated for every body, and loaded from its file with a warning.
        self.visual = p.createVisualShape(p.GEOM_BOX, halfExtents=[0.01] * 3, **self.engine)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def close(self):
        """Disconnect the engine."""
        if self.client is not None:
            pybullet().disconnect(self.client)
            self.client = None


def import_silently():
    """Import PyBullet in a thread that then ends, without printing its build time.

    Linux can redirect standard error for this thread only; on other systems the line is printed once.
    """
    with suppress(OSError, AttributeError):
        own_descriptors()
        os.dup2(os.open(os.devnull, os.O_WRONLY), 2)
    import pybullet  # noqa: F401


def own_descriptors():
    """Give this thread its own file descriptors, so that redirecting them does not affect other threads.

    Raises
    ------
    OSError, AttributeError
        If the system cannot do that.
    """
    import ctypes

    libc = ctypes.CDLL(None)
    # The first call is often forbidden in containers; the second, which closes nothing, has the same effect.
    if libc.unshare(CLONE_FILES) and libc.close_range(ctypes.c_uint(NONE), ctypes.c_uint(NONE), CLOSE_RANGE_UNSHARE):
        raise OSError("descriptors stay those of the process")


@dataclass(frozen=True, kw_only=True)
class Physics(CheckedSettings):
    """Material, time step and the criterion of rest.

    All quantities are in units of the sphere: lengths in radii, times in sqrt(radius / g), the time in which a sphere
    falls half its radius, and masses in spheres. Every radius is then the same problem for the engine, whose tolerances
    are made for bodies of about one unit.
    """

    friction: float = amount(0.5)  # wood on wood, plastic on plastic
    rolling_friction: float = amount(0.14)  # tangent of the steepest slope that holds a sphere: 8 degrees, as on seats
    # Spheres start at the surface, and the paper's do not bounce; at this time step, the engine adds energy to fully
    # elastic bounces.
    restitution: float = amount(0.0, most=0.9)
    # 2 ms at a radius of 5 mm; half of it changes no result by more than another seed does.
    time_step: float = amount(0.1, above=0.0, most=0.5)
    sub_steps: int = amount(8, above=0.0)  # time steps between two checks of the spheres
    # Of the engine's solver; a sphere has few contacts, and 20 iterations change nothing that the tests check.
    iterations: int = amount(10, above=0.0)
    # Length of a radius in the engine: with 1, spheres at rest overlap by 2 % instead of 0.5 %.
    scale: float = amount(10.0, above=0.0)
    # 3 mm/s at a radius of 1 cm; a sphere that is slower for rest_time is at rest.
    rest_speed: float = amount(0.01, above=0.0)
    # In this time, a sphere on a slope one degree too steep to hold it gains twice that speed.
    rest_time: float = amount(1.6, above=0.0)
    time_limit: float = amount(100.0, above=0.0)  # after which a sphere has timed out: 3 s at a radius of 1 cm
    in_air: int = amount(16, above=0.0)  # largest number of spheres in the air at once

    def __post_init__(self):
        with explaining("backend 'bullet'", InputError, why=": "):
            super().__post_init__()

    @property
    def check_interval(self) -> float:
        """Time between two checks of the spheres."""
        return self.time_step * self.sub_steps

    @property
    def terminal_speed(self) -> float:
        """Speed at which a sphere moves 0.4 radii per step; falling spheres are limited to it to prevent tunnelling."""
        return 0.4 / self.time_step
