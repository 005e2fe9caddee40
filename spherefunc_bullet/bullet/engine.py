"""PyBullet, which may be missing and which says on stderr when it was built; and what its spheres are made of.

Its calls hold Python's lock, so engines in several threads take turns, and each is its own.
"""

from __future__ import annotations

import os
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from importlib.metadata import PackageNotFoundError, version

import numpy as np

from ..errors import InputError, explaining
from ..simulator.mechanics import CheckedSettings, amount

CLONE_FILES = 0x400  # of Linux's sched.h
CLOSE_RANGE_UNSHARE, NONE = 2, 2**32 - 1  # of its close_range.h, and where no descriptor is
LARGEST_REUSED_BLOCK = 2**25 - 2**13  # bytes
MISSING = (
    "backend 'bullet' needs PyBullet, which is not installed: pip install 'pybullet>=3.2.7' "
    "(ready-made for CPython up to 3.11 on Linux; for others pip builds it with a C++ compiler)"
)


@cache  # each look reads the package's metadata, and every run asks
def engine_version() -> str:
    """Return the version of the PyBullet that is installed.

    Raises
    ------
    InputError
        If there is none.
    """
    with explaining(MISSING, PackageNotFoundError):
        return version("pybullet")


@cache
def pybullet():
    """Return the PyBullet module; imported when it is first needed.

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
    keep_memory()
    return pybullet


class Engine:
    """One engine in this process, in DIRECT mode; to be closed, best by ``with``."""

    def __init__(self, **parameters: float):
        p = pybullet()
        self.client = p.connect(p.DIRECT)
        self.engine = {"physicsClientId": self.client}
        p.setPhysicsEngineParameter(deterministicOverlappingPairs=1, **parameters, **self.engine)
        # The default visual shape would be tessellated for every body, and read from its file with a warning.
        self.visual = p.createVisualShape(p.GEOM_BOX, halfExtents=[0.01] * 3, **self.engine)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def close(self):
        """Give the engine back."""
        if self.client is not None:
            pybullet().disconnect(self.client)
            self.client = None


def import_silently():
    """Import PyBullet in a thread that is at its end then, so that nobody reads when it was built.

    Standard error is turned off for this thread alone, which Linux can do; elsewhere the line is seen once.
    """
    with suppress(OSError, AttributeError):
        own_descriptors()
        os.dup2(os.open(os.devnull, os.O_WRONLY), 2)
    import pybullet  # noqa: F401


def own_descriptors():
    """Give this thread file descriptors that are its own: what it does to them no other thread sees.

    Raises
    ------
    OSError, AttributeError
        If the system cannot.
    """
    import ctypes

    libc = ctypes.CDLL(None)
    # In containers the first is often forbidden; the second, of no descriptor at all, does the same.
    if libc.unshare(CLONE_FILES) and libc.close_range(ctypes.c_uint(NONE), ctypes.c_uint(NONE), CLOSE_RANGE_UNSHARE):
        raise OSError("descriptors stay those of the process")


def keep_memory():
    """Have the memory of one engine serve the next, instead of going back to the system and being fetched anew.

    The C library of Linux keeps blocks as large as the largest that was ever freed, up to 32 MiB, so that some engines
    later it would do so anyhow. The block below is never written to.
    """
    np.empty(LARGEST_REUSED_BLOCK, np.uint8)


@dataclass(frozen=True, kw_only=True)
class Physics(CheckedSettings):
    """Material, time step, and what counts as rest: how finely motion is computed.

    Everything is in the sphere's own units: lengths in radii, times in sqrt(radius / g), which is the time in which
    a sphere falls half its radius, and masses in spheres. Every radius is then the same problem to the engine, whose
    tolerances are made for bodies of about one unit.
    """

    friction: float = amount(0.5)  # wood on wood, plastic on plastic
    rolling_friction: float = amount(0.14)  # tangent of the steepest slope that holds a sphere: 8 degrees, as of seats
    # Spheres start at the surface, and the paper's do not bounce; at this time step the engine gives energy to what
    # bounces back completely.
    restitution: float = amount(0.0, most=0.9)
    # 2 ms at a radius of 5 mm; half of it moves no result by more than a seed does.
    time_step: float = amount(0.1, above=0.0, most=0.5)
    sub_steps: int = amount(8, above=0.0)  # time steps between two looks at the spheres
    # Of the engine's solver; a sphere has few contacts, and at 20 nothing that tests hold differs.
    iterations: int = amount(10, above=0.0)
    # Length of a radius in the engine: at 1, spheres at rest overlap by 2 % instead of 0.5 %.
    scale: float = amount(10.0, above=0.0)
    # 3 mm/s at a radius of 1 cm; below it for rest_time a sphere is at rest.
    rest_speed: float = amount(0.01, above=0.0)
    # In which a sphere on a slope of one degree more than holds it gains twice that speed.
    rest_time: float = amount(1.6, above=0.0)
    time_limit: float = amount(100.0, above=0.0)  # after which a sphere is given up: 3 s at a radius of 1 cm
    in_air: int = amount(16, above=0.0)  # spheres at once, where there is room for this many

    def __post_init__(self):
        with explaining("backend 'bullet'", InputError, why=": "):
            super().__post_init__()

    @property
    def look(self) -> float:
        """Time between two looks at the spheres."""
        return self.time_step * self.sub_steps

    @property
    def terminal_speed(self) -> float:
        """Speed at which a sphere moves 0.4 radii in a step; what falls is held to it, so that it cannot tunnel."""
        return 0.4 / self.time_step
