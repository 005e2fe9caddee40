"""Compiled kernels: say when they are compiled, and never run those of an older source.

Numba keeps compiled kernels beside their source and compiles anew when the kernel's own file changes, but not
when a kernel that it calls has changed in another file.
"""

from __future__ import annotations

import logging
from functools import cache
from pathlib import Path

logger = logging.getLogger("spherefunc")


def prepare(kernel):
    """Make sure that a kernel's cached code is of today's sources, and say so if it has to be compiled.

    Parameters
    ----------
    kernel : numba dispatcher
        With ``cache=True``; everything that it calls lies in files of the same folder.
    """
    sources = Path(kernel.py_func.__code__.co_filename).parent
    if _forget_older(Path(kernel.stats.cache_path), newest(sources), kernel.__name__):
        return
    _announce()


def newest(folder: Path) -> float:
    """Return when the latest Python file of a folder was changed, in seconds since the epoch."""
    return max((path.stat().st_mtime for path in folder.glob("*.py")), default=0.0)


def _forget_older(cached: Path, since: float, name: str) -> bool:
    """Drop cached code older than its sources; return whether some is left."""
    left = False
    for index in cached.glob(f"*{name}-*.nbi"):
        try:
            if index.stat().st_mtime >= since:
                left = True
            else:
                index.unlink(missing_ok=True)
        except OSError:
            left = True  # another process is at work on it, or it may not be written
    return left


@cache
def _announce():
    logger.info("compiling kernels for this machine, once after installation: about 15 seconds ...")
