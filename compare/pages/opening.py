"""How soon a report can be looked at: from the browser's first byte to its first picture, by software drawing.

    python -m spherefunc_bullet.compare.pages.opening demo/comparison/report.html
"""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from typing import Annotated

import typer

from spherefunc_bullet.console import print_json, run
from spherefunc_bullet.errors import InputError

FLAGS = ("--headless", "--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader")
FLAGS += ("--enable-logging=stderr", "--no-first-run", "--disable-background-networking", "--window-size=1280,7000")
OPENED = """<script>
const drawn = () => document.querySelector(".display-still") ? setTimeout(drawn, 20)
  : requestAnimationFrame(() => setTimeout(() => console.log(`drawn after ${performance.now()} ms`)));
addEventListener("load", () => setTimeout(() => { console.log(`read after ${performance.now()} ms`); drawn(); }));
</script></body>"""


def opening_ms(browser: str, page: Path) -> tuple[float, float]:
    """Return the milliseconds until a page can be read, and until everything that it draws has been drawn once."""
    with TemporaryDirectory() as folder:
        timed = Path(folder) / page.name
        timed.write_text(page.read_text(encoding="utf-8").replace("</body>", OPENED), encoding="utf-8")
        flags = [*FLAGS, f"--user-data-dir={folder}/profile", f"--screenshot={folder}/page.png"]
        done = subprocess.run([browser, *flags, timed.as_uri()], capture_output=True, text=True, check=False)
    times = re.findall(r"(?:read|drawn) after ([\d.]+) ms", done.stderr)
    if len(times) != 2:
        raise InputError(f"{page}: expected a page that a browser opens, got: {done.stderr.strip()[-200:]}")
    return float(times[0]), float(times[1])


def main(
    pages: Annotated[list[Path], typer.Argument(metavar="PAGE...", help="Reports, as HTML.")],
    repeats: Annotated[int, typer.Option(min=1, help="Each in a fresh browser.")] = 3,
):
    """Print after how many milliseconds each page can be read, and all on it is drawn, medians of some times."""
    browser = shutil.which("chromium") or shutil.which("google-chrome")
    if browser is None:
        raise InputError("opening: expected Chromium; apt-get install chromium")
    for page in pages:
        if not page.is_file():
            raise InputError(f"{page}: expected a page, found no such file")
    times = {page: zip(*(opening_ms(browser, page) for _ in range(repeats)), strict=True) for page in pages}
    print_json({str(page): [round(median(each)) for each in both] for page, both in times.items()})


if __name__ == "__main__":
    run(lambda: typer.run(main))
