"""Compiled kernels: say when they are compiled, and never run those of an older source.

Numba keeps compiled kernels beside their source and compiles anew when the kernel's own file changes, but not
when a kernel that it calls, or a constant that it uses, has changed in another file.
"""

from __future__ import annotations

import ast
import logging
import pickle
import sys
from collections.abc import Iterator
from contextlib import suppress
from functools import cache
from importlib.util import resolve_name
from pathlib import Path
from typing import Any

logger = logging.getLogger("spherefunc")


def prepare(*kernels: Any):
    """Make sure, once in a process, that kernels' cached code is of today's sources; say so if any is to be compiled.

    Parameters
    ----------
    kernels : numba dispatchers
        With ``cache=True``.
    """
    for kernel in kernels:
        _prepare(kernel)


@cache
def _prepare(kernel: Any):
    """Do as `prepare` for one kernel."""
    for called in kernels_of(kernel):
        forget_stale(called)
    if any(cached_code(kernel)):
        load_alone(kernel)
    else:
        load_compiler()
        _announce()


def load_alone(kernel: Any):
    """Let a kernel's cached code be loaded without all that numba needs to compile one, a quarter of a new process.

    Where there is none for what it is called with, numba loads that when it compiles.
    """
    with suppress(ImportError, AttributeError):  # another version of numba, which loads what it wants
        from numba.core.runtime import rtsys

        code = kernel._cache
        load, guarded = code._load_overload, code._guard_against_spurious_io_errors

        def load_overload(signature: Any, context: Any) -> Any:
            rtsys.initialize(context)
            with guarded():
                return load(signature, context)
            return None

        code.load_overload = load_overload


@cache
def load_compiler():
    """Load numba's functions of arrays, which compiling needs, without SciPy's linear algebra.

    They import that only to know whether it is there, and it takes a fifth of a second of each new process. It is
    there, since this package requires it; a kernel that multiplies matrices imports it itself.
    """
    with suppress(ImportError, AttributeError):  # another version of numba, which loads what it wants
        from numba.np import linalg

        asked, linalg.ensure_blas = linalg.ensure_blas, lambda: None
        try:
            import numba.np.arraymath  # noqa: F401
        finally:
            linalg.ensure_blas = asked


def kernels_of(kernel: Any) -> list[Any]:
    """Return a kernel and all those that it calls, directly or through others."""
    known = [kernel]
    for called in known:
        known += [value for value in globals_of(called).values() if hasattr(value, "py_func") and value not in known]
    return known


def globals_of(kernel: Any) -> dict[str, Any]:
    """Return what a kernel takes from its module, by name: kernels, constants, modules."""
    names = kernel.py_func.__code__.co_names
    return {name: kernel.py_func.__globals__[name] for name in names if name in kernel.py_func.__globals__}


def sources_of(kernel: Any) -> set[Path]:
    """Return the files that decide a kernel's compiled code, constants that come from other files included."""
    files = set()
    for called in kernels_of(kernel):
        module = sys.modules[called.py_func.__module__]
        origins = imported_names(Path(module.__file__), module.__package__)
        files.add(Path(module.__file__))
        modules = (sys.modules.get(origins.get(name, "")) for name in globals_of(called))
        files.update(Path(origin.__file__) for origin in modules if origin and origin.__name__ in ours())
    return files


def ours() -> set[str]:
    """Return the loaded modules of this distribution."""
    return {name for name in sys.modules if name.partition(".")[0] == __name__.partition(".")[0]}


@cache
def imported_names(file: Path, package: str) -> dict[str, str]:
    """Return from which module a file takes each name that it imports from one."""
    tree = ast.parse(file.read_text(encoding="utf-8"))
    imports = [node for node in tree.body if isinstance(node, ast.ImportFrom)]
    return {
        name.asname or name.name: resolve_name("." * node.level + (node.module or ""), package)
        for node in imports
        for name in node.names
    }


def cached_code(kernel: Any) -> Iterator[Path]:
    """Yield the index files of a kernel's cached code, one for each place in the file where it has stood.

    None of one that is compiled into others alone.
    """
    if kernel.stats.cache_path is None:
        return
    file = Path(kernel.py_func.__code__.co_filename)
    yield from Path(kernel.stats.cache_path).glob(f"{file.stem}.{kernel.__name__}-*.nbi")


def forget_stale(kernel: Any):
    """Drop cached code that is older than its sources, or that cannot be loaded since a module was renamed."""
    for index in cached_code(kernel):
        with suppress(OSError):  # another process is at work on it, or it may not be written
            if is_older(index, kernel) or not is_loadable(index):
                index.unlink(missing_ok=True)


def is_older(index: Path, kernel: Any) -> bool:
    """Return whether a kernel's cached code is older than what decides it, asked only if any module loaded is newer."""
    made = index.stat().st_mtime
    modules = [Path(sys.modules[name].__file__ or index) for name in ours()]
    if max(file.stat().st_mtime for file in modules) < made:
        return False
    return made < max(file.stat().st_mtime for file in sources_of(kernel))


def is_loadable(index: Path) -> bool:
    """Return whether numba will be able to load an index of its own: its signatures name modules."""
    try:
        with index.open("rb") as file:
            pickle.load(file)
            pickle.loads(file.read())
    except OSError:
        raise
    except Exception:  # whatever unpickling meets
        return False
    return True


@cache
def _announce():
    logger.info("compiling kernels for this machine, once after installation: about 15 seconds ...")
