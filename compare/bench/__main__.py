"""``python -m spherefunc_bullet.compare.bench``."""

from spherefunc_bullet.console import run

from .bench import main

if __name__ == "__main__":  # the processes that it starts import this file
    run(main)
