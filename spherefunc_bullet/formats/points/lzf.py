"""Decompression of LZF, which PCD files use."""

from __future__ import annotations

from numba import njit


@njit(cache=True, nogil=True)
def unpack(packed, out):
    """Unpack LZF bytes and return the number of unpacked bytes, or -1 if the input is damaged.

    Parameters
    ----------
    packed : (P,) uint8
    out : (N,) uint8, written
    """
    source, target = 0, 0
    while source < len(packed):
        control = int(packed[source])
        source += 1
        if control < 32:  # a run of control + 1 literal bytes
            length = control + 1
            if source + length > len(packed) or target + length > len(out):
                return -1
            out[target : target + length] = packed[source : source + length]
            source += length
            target += length
            continue
        length = control >> 5
        if source + (2 if length == 7 else 1) > len(packed):
            return -1
        if length == 7:
            length += int(packed[source])
            source += 1
        length += 2
        origin = target - ((control & 31) << 8) - int(packed[source]) - 1
        source += 1
        if origin < 0 or target + length > len(out):
            return -1
        for step in range(length):  # byte by byte: a run may overlap with its own output
            out[target + step] = out[origin + step]
        target += length
    return target
