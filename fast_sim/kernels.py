"""How the kernels of a drop are compiled: all into one, without counting references.

A drop takes a few hundred calls of small kernels. Their grids are tuples of some twenty arrays, so that a call that is
not inlined hands over more than a hundred numbers, and keeping count of who holds an array is an atomic instruction at
each: together half of a drop's time. Kernels made so allocate nothing and keep no array, so there is nothing to count.
"""

from __future__ import annotations

from spherefunc_bullet.processes.compilation import njit

entry_jit = njit(cache=True, error_model="numpy", nogil=True, _nrt=False)  # called by Python, or seldom
inline_jit = njit(error_model="numpy", _nrt=False, forceinline=True)  # kept as part of others alone
