"""How fast a ledger is: ``python tests/support/ledger_speed.py --rows 100000`` fills one and uses it."""

from __future__ import annotations

import argparse
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

from spherefunc_bullet.batch.folder import status
from spherefunc_bullet.batch.ledger import DONE, Ledger, LedgerRow, RunConfig

RADII = (0.005, 0.01, 0.02, 0.03, 0.05)  # metres
SETTINGS = '{"loading": {"units": "m", "up": "z"}, "max_spheres": 20000, "miss_limit": 50, "version": "3"}'


def filled(ledger: Ledger, rows: int) -> list[LedgerRow]:
    """Have a ledger of so many rows, half of them done; return those."""
    objects = [f"shelf_{number % 100:02d}/object_{number:08d}.glb" for number in range(rows // len(RADII))]
    ways = [ledger.number(RunConfig(backend="fast", settings=SETTINGS, radius=radius, seed=0)) for radius in RADII]
    ledger.expect(objects, ways)
    about = {"outcome": DONE, "run": "0" * 64, "content": "1" * 64, "digest": "2" * 64, "source": "123456 " + "7" * 19}
    about |= {"settled": 500, "drops": 1500, "seconds": 0.1, "memory": 2**28, "bytes": 5000, "kept": 7 * 10**18}
    done = [
        LedgerRow(object=name, way=way, finished=1.7e9 + number, **about)
        for number, name in enumerate(objects[: len(objects) // 2])
        for way in ways
    ]
    ledger.write(done)
    return done


def speed(folder: Path, rows: int, clock: Callable[[], float] = time.perf_counter) -> dict[str, float]:
    """Return the seconds, by a clock, of what a batch and its status do with a ledger of so many rows."""
    measured: dict[str, float] = {}

    def timed(name: str, action: Callable[[], object]):
        """Note the seconds of an action."""
        started = clock()
        action()
        measured[name] = clock() - started

    with Ledger(folder / "ledger.sqlite", make=True) as ledger:
        done = []
        timed("fill it", lambda: done.extend(filled(ledger, rows)))
        timed("status", lambda: status(ledger))
        timed("check it", ledger.check)
        timed("read all rows, to go on", lambda: list(ledger.rows([1, 2, 3, 4, 5])))
        timed("write an object's rows, synced", lambda: ledger.write(done[: len(RADII)]))
    return measured


def main():
    """Print the seconds."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rows", type=int, default=100_000)
    rows = parser.parse_args().rows
    with tempfile.TemporaryDirectory() as scratch:
        measured = speed(Path(scratch), rows)
        size = (Path(scratch) / "ledger.sqlite").stat().st_size
    print(f"A ledger of {rows:,} rows, {size >> 20} MiB")
    for name, seconds in measured.items():
        print(f"{name:<32}{seconds:9.3f} s")


if __name__ == "__main__":
    main()
