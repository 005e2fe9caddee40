"""Everything that can happen to a process, by the stem of a file's name; and a backend to which it happens."""

from __future__ import annotations

import ctypes
import logging
import os
import signal
import sys
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from spherefunc_bullet.errors import InputError
from spherefunc_bullet.simulator import DropResult, DropSettings, Stop


def happen(name) -> str:
    """Do as the file is called, or return its name and the process in which this ran."""
    match Path(name).stem:
        case "segfault":
            ctypes.string_at(0)
        case "killed":
            os.kill(os.getpid(), signal.SIGKILL)
        case "aborted":
            os.abort()
        case "left":
            os._exit(3)
        case "left_quietly":
            os._exit(0)
        case "sys_exit":
            sys.exit(4)
        case "sleeper":
            os.write(2, b"asleep\n")
            time.sleep(60)
        case "dozer":
            time.sleep(0.5)
        case "refused":
            raise InputError(f"{name}: expected something else")
        case "bug":
            raise ValueError("a bug of ours")
        case "unpicklable":
            raise Unpicklable("first", "second")
        case "once" if not Path(name).with_suffix(".seen").exists():
            Path(name).with_suffix(".seen").touch()
            os.abort()
        case "hungry":
            hoard = []
            while True:
                hoard.append(np.ones(2**24))
        case "printer":
            logging.getLogger("spherefunc").info("this takes long")
            os.write(1, b"printed by a C library\n")
            os.write(2, b"complained by a C library\n")
    return f"{Path(name).stem} {os.getpid()}"


class Unpicklable(Exception):
    """An error that needs two arguments, of which only one gets through."""

    def __init__(self, one, two):
        super().__init__(one)


def surroundings(variable: str) -> tuple:
    """Return what a task finds around it."""
    return os.getcwd(), os.environ.get(variable), os.environ["OMP_NUM_THREADS"], os.getppid()


@dataclass(frozen=True)
class MishapSimulator:
    """Puts one sphere on the object, where nothing happens."""

    isolate = True
    name = "mishap"
    version = "1"

    def options(self) -> dict:
        return {}

    def drop(self, cloud, settings: DropSettings, seed: int = 0) -> DropResult:
        happen(cloud.name)
        provenance = {"backend": "mishap", "version": "1", "settings": {"radius": settings.radius}, "seed": seed}
        return DropResult(
            centers=np.array([[0, 0, cloud.size[2] + settings.radius]]),
            on_object=np.array([True]),
            rolled_off=settings.miss_limit,
            rejected=0,
            timed_out=0,
            stop=Stop.MISSES,
            seconds=0.0,
            provenance=provenance | {"process": os.getpid()},
        )


@dataclass(frozen=True)
class MishapPoser(MishapSimulator):
    """The same, asked how an object lies."""

    def poses(self, cloud, settings, seed=0):
        """Do as the cloud is called, and answer as `fast` does."""
        from spherefunc_bullet.simulator import make_simulator

        happen(cloud.name)
        return make_simulator("fast").poses(cloud, settings, seed)
