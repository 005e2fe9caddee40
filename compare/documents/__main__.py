"""``python -m spherefunc_bullet.compare.documents``, which is ``make tables``."""

import typer

from spherefunc_bullet.console import run

from .main import main

if __name__ == "__main__":
    run(lambda: typer.run(main))
