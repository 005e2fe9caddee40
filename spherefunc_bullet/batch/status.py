"""How far a run is, read from its ledger while the run goes on."""

from __future__ import annotations

import socket
import time
from typing import Any

from ..errors import FAILURES
from .folder import is_alive
from .ledger import DONE, WAITING, Ledger

# Of an object, from the outcomes of its rows.
STATE = f"CASE WHEN max(outcome = '{WAITING}') THEN 'waiting' WHEN min(outcome = '{DONE}') THEN 'done'"
STATE += " ELSE 'failed' END"
REASONS = 20  # failures that are listed


def status(ledger: Ledger) -> dict[str, Any]:
    """Return a run's progress, rate, failures and time left.

    Returns
    -------
    dict
        ``objects``, ``done``, ``failed`` and ``waiting`` count objects, ``runs`` their rows by outcome;
        ``seconds`` of simulation and ``bytes`` of centres so far; ``rate`` in runs per second since the last call
        began; ``seconds_left`` at that rate, None while it is unknown or nothing runs; ``running`` whether a call is at
        work, None where only another machine could tell.
    """
    by_object = f"SELECT {STATE} AS state FROM runs GROUP BY object"
    states = dict(ledger.query(f"SELECT state, count(*) FROM ({by_object}) GROUP BY state"))
    totals = ledger.query("SELECT outcome, count(*), sum(seconds), sum(bytes) FROM runs GROUP BY outcome")
    runs = {outcome: count for outcome, count, *_ in totals}
    running = is_running(ledger)
    rate = rate_of(ledger, running)
    waiting = runs.get(WAITING, 0)
    left = round(waiting / rate) if rate and running is not False else None
    return {
        "objects": sum(states.values()),
        "done": states.get("done", 0),
        "failed": states.get("failed", 0),
        "waiting": states.get("waiting", 0),
        "runs": runs,
        "seconds": round(sum(seconds or 0.0 for _, _, seconds, _ in totals), 3),
        "bytes": sum(size or 0 for *_, size in totals),
        "rate": rate and round(rate, 4),
        "seconds_left": left if waiting else 0,
        "running": running,
        "failures": failures(ledger),
    }


def is_running(ledger: Ledger) -> bool | None:
    """Return whether some call is at work: one that has not ended and whose process lives; None: on another machine."""
    answers = {
        is_alive(process) if host == socket.gethostname() else None
        for host, process in ledger.query("SELECT host, process FROM calls WHERE ended IS NULL")
    }
    return True if True in answers else None if None in answers else False


def rate_of(ledger: Ledger, running: bool | None) -> float | None:
    """Return the runs per second of the last call, until now or until it ended; None if there are none yet."""
    last = ledger.query("SELECT started, ended FROM calls ORDER BY rowid DESC LIMIT 1")
    if not last:
        return None
    started, ended = last[0]
    outcomes = ", ".join(f"'{outcome}'" for outcome in (DONE, *FAILURES))
    sql = f"SELECT count(*), max(finished) FROM runs WHERE outcome IN ({outcomes}) AND finished >= ?"
    ((count, newest),) = ledger.query(sql, (started,))
    if not count:
        return None
    until = ended or (newest if running is False else max(time.time(), newest))
    return count / max(until - started, 1e-3)


def failures(ledger: Ledger) -> list[dict[str, str]]:
    """Return the first objects that failed, and why."""
    sql = f"SELECT object, outcome, min(error) FROM runs WHERE outcome IN ({', '.join('?' * len(FAILURES))})"
    rows = ledger.query(f"{sql} GROUP BY object, outcome ORDER BY object LIMIT {REASONS}", FAILURES)
    return [dict(zip(("object", "outcome", "error"), row, strict=True)) for row in rows]
