"""Several objects as a picture, spheres coloured by the object that carries them, and as a page with the figures."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw, ImageFont, ImageOps

from spherefunc_bullet.formats.files import write_text
from spherefunc_bullet.viewer.mechanics_pictures import INK, PAPER, STYLE, png_of
from spherefunc_bullet.viewer.page import image_html, page_html, table_html
from spherefunc_bullet.viewer.pictures import CameraView, render_balls

from .falls import united
from .together import ArrangedResult, Together

# Okabe and Ito's: everyone can distinguish them.
COLOURS = np.array([[0, 114, 178], [213, 94, 0], [0, 158, 115], [204, 121, 167], [230, 159, 0], [86, 180, 233]]) / 255
VIEW = CameraView(size=(720, 540))
LINE = 40  # pixels of the legend, an object each
SIZE = 20  # of its letters, at most


def colour_of(number: int) -> np.ndarray:
    """Return the colour (3,) of an object's spheres."""
    return COLOURS[number % len(COLOURS)]


def together_picture(together: Together) -> Image.Image:
    """Return a picture of objects with the spheres of their common drop, and a legend of the spheres' colours."""
    cloud = united([item.placed.cloud for item in together.objects], "together")
    centers = np.concatenate([item.carries for item in together.objects])
    tiles = [np.tile(colour_of(k), (len(item.carries), 1)) for k, item in enumerate(together.objects)]
    colours = np.concatenate(tiles)
    image = render_balls(cloud, centers, together.radius, colours, VIEW)
    canvas = ImageOps.expand(image, (0, 0, 0, LINE * len(together.objects) + 16), PAPER)
    pen = ImageDraw.Draw(canvas)
    for number, item in enumerate(together.objects):
        middle = image.height + LINE * number + LINE / 2
        pen.ellipse((24, middle - 10, 44, middle + 10), fill=tuple(int(255 * c) for c in colour_of(number)))
        words = legend(item)
        wide = pen.textlength(words, ImageFont.load_default(SIZE))
        size = min(SIZE, int(SIZE * (image.width - 2 * LINE) / wide))
        pen.text((60, middle), words, INK, ImageFont.load_default(size), anchor="lm")
    return canvas


def legend(item: ArrangedResult) -> str:
    """Return what an object carries, how much of its level is left, and its functions, in one line."""
    count = len(item.carries)
    words = [f"{item.name}: {count} sphere{'' if count == 1 else 's'}"]
    if item.level is not None:
        words.append(f"{100 * min(1.0, item.level.left):.0f} % of its level left")
    alone, together = (
        ", ".join(name for name, membership in memberships.items() if membership.member) or "none"
        for memberships in (item.alone, item.together)
    )
    return ", ".join([*words, f"for {together}" if alone == together else f"for {together} (alone: {alone})"])


def write_together_page(
    together: Together, picture: Image.Image, head: Sequence[str], rows: Sequence[Sequence[str]], path: Path
) -> Path:
    """Write a page of its own: the picture, a table of the objects, and the notes on how they stand."""
    parts = ["<h1>Several objects together</h1>"]
    parts += [f"<p>{escape(note)}</p>" for note in together.notes]
    parts += [image_html("Spheres coloured by what carries them", png_of(picture)), table_html(head, rows, texts=2)]
    return write_text(path, page_html("Several objects together", parts, style=STYLE))
