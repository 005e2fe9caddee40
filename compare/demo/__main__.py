"""``python -m spherefunc_bullet.compare.demo --out docs/images``: the pictures of the documents (``make figures``)."""

from pathlib import Path
from typing import Annotated

import typer

from spherefunc_bullet.console import run, say

from .animation import write_animation
from .gallery import write_gallery, write_side_by_side
from .laid_table import write_laid_table


def main(out: Annotated[Path, typer.Option(help="Folder for the pictures.")] = Path("docs/images")):
    """Draw the pictures and print their paths and sizes."""
    paths = [write_side_by_side(out, ["fast", "bullet"]), *write_gallery(out, "fast")]
    for path in [*paths, write_laid_table(out), write_animation(out)]:
        say(f"{path}  {path.stat().st_size / 1000:.0f} kB")


if __name__ == "__main__":
    run(lambda: typer.run(main))
