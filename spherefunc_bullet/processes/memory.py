"""How much memory this process has had at most, and how much it may have."""

from __future__ import annotations

import sys
from contextlib import suppress
from pathlib import Path

STATUS, RESET = Path("/proc/self/status"), Path("/proc/self/clear_refs")  # Linux
FIRST_TO_GO = Path("/proc/self/oom_score_adj")


def reset_peak():
    """Begin to measure anew, where the system can: on Linux. Elsewhere the peak is since the process began."""
    with suppress(OSError):
        RESET.write_text("5", encoding="ascii")


def peak_bytes() -> int | None:
    """Return the most memory that this process has had, interpreter and libraries included; None if unknown."""
    with suppress(OSError):
        for line in STATUS.read_text(encoding="ascii", errors="replace").splitlines():
            if line.startswith("VmHWM:"):
                return int(line.split()[1]) * 1024
    try:
        import resource
    except ImportError:  # Windows
        return None
    unit = 1 if sys.platform == "darwin" else 1024  # macOS counts bytes, others kibibytes
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit


def cap_memory(limit: int | None):
    """Let the system refuse this process more than so many bytes of data, where it can: on Linux.

    With a limit or without, a system that runs short of memory ends this process before its parent.
    """
    with suppress(OSError):
        FIRST_TO_GO.write_text("1000", encoding="ascii")
    if limit is not None:
        import resource

        resource.setrlimit(resource.RLIMIT_DATA, (limit, limit))
