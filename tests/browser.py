"""A real browser for the pages that the program writes."""

from __future__ import annotations

import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

CHROMIUM = shutil.which("chromium") or shutil.which("google-chrome")
needs_browser = pytest.mark.skipif(CHROMIUM is None, reason="no Chromium to draw pages with")
FLAGS = [
    *("--headless", "--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"),
    *("--hide-scrollbars", "--enable-logging=stderr", "--no-first-run", "--disable-background-networking"),
    "--disable-extensions",
]


@dataclass(frozen=True)
class Drawn:
    """What a browser made of a page."""

    pixels: np.ndarray  # (H, W, 3) float, 0 to 255
    console: list[str]  # what the page's program complained of


def draw(page: Path, folder: Path, *, size=(1280, 900), budget: int = 1500) -> Drawn:
    """Draw a page in a window of a size, after so many milliseconds of the page's own time."""
    from PIL import Image

    picture = folder / "page.png"
    flags = [*FLAGS, f"--window-size={size[0]},{size[1]}", f"--virtual-time-budget={budget}"]
    command = [CHROMIUM, *flags, f"--user-data-dir={folder}/profile", f"--screenshot={picture}", page.as_uri()]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    console = [line for line in done.stderr.splitlines() if "CONSOLE" in line]
    return Drawn(np.asarray(Image.open(picture).convert("RGB"), float), console)
