"""A real browser for the pages that the program writes."""

from __future__ import annotations

import re
import shutil
import subprocess
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

CHROMIUM = shutil.which("chromium") or shutil.which("google-chrome")
needs_browser = pytest.mark.skipif(CHROMIUM is None, reason="no Chromium to draw pages with")
# WebGL alone is drawn as by a graphics card. Where a card is imitated for text and layout as well, which Debian's
# Chromium asks for, a page takes twice as long, and now and then is never finished.
FLAGS = [
    *("--headless", "--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"),
    *("--disable-gpu-rasterization", "--disable-gpu-compositing"),
    *("--hide-scrollbars", "--enable-logging=stderr", "--no-first-run", "--disable-background-networking"),
    *("--disable-extensions", "--disable-gpu-watchdog"),
]
OWN_HINT = "GPU stall due to ReadPixels"  # what the browser says of its own speed where it draws in software
HUNG = 30  # seconds after which a browser that has not ended will not
PATIENCE = (1, 4, 16)  # how many times the page's own time is given, until what is looked for is there


@dataclass(frozen=True)
class Drawn:
    """What a browser made of a page."""

    pixels: np.ndarray  # (H, W, 3) float, 0 to 255
    console: list[str]  # what the page's program complained of


def draw(
    page: Path, folder: Path, shows: Callable[[np.ndarray], bool], *, size=(1280, 900), budget: int = 1500
) -> Drawn:
    """Draw a page in a window of a size, until the pixels show what is looked for or patience ends.

    The page's own clock runs ahead of the graphics where the machine is busy, so a picture may be taken before the
    first frame is drawn: then it is taken again after more milliseconds (budget) of that clock.
    """
    for turn, patience in enumerate(PATIENCE):
        drawn = drawn_once(page, folder / f"browser_{turn}", size, budget * patience)
        if shows(drawn.pixels):
            break
    return drawn


def drawn_once(page: Path, folder: Path, size: tuple[int, int], budget: int) -> Drawn:
    """Draw a page after so many milliseconds of its own time; a blank picture where the browser gave none."""
    from PIL import Image

    picture = folder / "page.png"
    folder.mkdir()
    said = run_browser(
        page, folder, budget, *FLAGS, f"--window-size={size[0]},{size[1]}", f"--screenshot={picture}"
    ).stderr
    console = [line for line in said.splitlines() if "CONSOLE" in line and OWN_HINT not in line]
    image = Image.open(picture).convert("RGB") if picture.exists() else Image.new("RGB", size, "white")
    return Drawn(np.asarray(image, float), console)


def document(
    page: Path, folder: Path, shows: Callable[[str], object], flags: Sequence[str] = FLAGS, *, size=(900, 700)
) -> str:
    """Return the HTML of a page after its scripts ran, without these; tried again as by `draw`."""
    for turn, patience in enumerate(PATIENCE):
        ran = run_browser(
            page,
            folder / f"browser_{turn}",
            3000 * patience,
            *flags,
            f"--window-size={size[0]},{size[1]}",
            "--dump-dom",
        )
        became = re.sub(r"<script.*?</script>", "", ran.stdout, flags=re.DOTALL)
        if shows(became):
            break
    return became


def run_browser(page: Path, folder: Path, budget: int, *flags: str) -> subprocess.CompletedProcess:
    """Open a page for so many milliseconds of its own time; the output of a browser that hangs is empty.

    It hangs now and then on a busy machine; callers try again.
    """
    options = [*flags, f"--virtual-time-budget={budget}", f"--user-data-dir={folder}/profile"]
    command = [CHROMIUM, *options, page.as_uri()]
    try:
        return subprocess.run(command, capture_output=True, text=True, check=False, timeout=HUNG)
    except subprocess.TimeoutExpired:
        return subprocess.CompletedProcess(command, 1, "", "")
