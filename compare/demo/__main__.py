"""``python -m spherefunc_bullet.compare.demo``."""

from spherefunc_bullet.console import run

from .demo import main

if __name__ == "__main__":  # the processes that it starts import this file
    run(main)
