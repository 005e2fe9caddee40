"""The machine of a measurement: processor, system, versions, and the backends that can run."""

from __future__ import annotations

import os
import platform
from collections.abc import Iterable, Mapping
from contextlib import suppress
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from spherefunc_bullet.console import say
from spherefunc_bullet.errors import InputError
from spherefunc_bullet.simulator import make_simulator

PACKAGES = ("spherefunc-bullet", "numpy", "scipy", "numba", "scikit-learn", "pybullet")


def machine() -> dict[str, str]:
    """Return the machine and the versions in words."""
    return {
        "processor": f"{processor()}, {os.cpu_count()} cores",
        "system": f"{platform.system()} {platform.machine()}, Python {platform.python_version()}",
        "versions": ", ".join(f"{name} {number}" for name, number in versions().items()),
    }


def options_text(options: Mapping[str, object]) -> str:
    """Return a simulator's options as words."""
    return ", ".join(f"{name} = {value}" for name, value in options.items()) or "none"


def processor() -> str:
    """Return the processor's name, on Linux from the kernel, since `platform` does not know it."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8", errors="replace").splitlines()
    except OSError:
        lines = []
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor() or "unknown"


def versions() -> dict[str, str]:
    """Return the versions of the installed packages on which results depend."""
    numbers = {}
    for name in PACKAGES:
        with suppress(PackageNotFoundError):  # PyBullet is optional
            numbers[name] = version(name)
    return numbers


def usable_backends(names: Iterable[str]) -> tuple[str, ...]:
    """Return the backends that can run here, and print why others cannot."""
    usable = []
    for name in names:
        try:
            make_simulator(name)
            usable.append(name)
        except InputError as error:
            say(f"left out: {error}")
    return tuple(usable)
