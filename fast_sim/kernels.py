"""Compilation of the kernels of a drop: all are inlined into one, without reference counts.

A drop takes a few hundred calls of small kernels. Their grids are tuples of some twenty arrays, so a call that is not
inlined passes more than a hundred numbers, and reference counting takes an atomic instruction for each array: together
half of the time of a drop. These kernels allocate nothing and keep no array, so they need no reference counts.
"""

from __future__ import annotations

from spherefunc_bullet.processes.compilation import njit

entry_jit = njit(cache=True, error_model="numpy", nogil=True, _nrt=False)  # called by Python, or rarely
inline_jit = njit(error_model="numpy", _nrt=False, forceinline=True)  # exist only as parts of others
