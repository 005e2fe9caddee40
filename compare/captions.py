"""Words on pictures: captions, the colour key, and pictures side by side."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .pictures import CUT_COLOUR, GROUND_COLOUR, sphere_colours

INK, GREY = (25, 25, 30), (90, 90, 100)
BACKGROUND = tuple(int(255 * channel) for channel in GROUND_COLOUR)  # as under the objects


def captioned(image, title: str, detail: str):
    """Return an image with a title and a line below it."""
    from PIL import Image, ImageDraw

    width, height = image.size
    large, small = font(height // 20), font(height // 26)
    canvas = Image.new("RGB", (width, height + height // 7), BACKGROUND)
    canvas.paste(image, (0, 0))
    pen = ImageDraw.Draw(canvas)
    pen.text((width / 2, height + height * 0.02), title, INK, large, anchor="mm")
    pen.text((width / 2, height + height * 0.08), detail, GREY, small, anchor="mm")
    return canvas


def font(size: int):
    """Return Pillow's own typeface at a size in pixels: it is there on every machine."""
    from PIL import ImageFont

    return ImageFont.load_default(size)


def colour_key(size: tuple[int, int]):
    """Return an image that says what the colours mean, as large as a captioned picture of ``size`` pixels."""
    from PIL import Image, ImageDraw

    width, height = size
    canvas = Image.new("RGB", (width, height + height // 7), BACKGROUND)
    pen = ImageDraw.Draw(canvas)
    left, top, bar = int(width * 0.28), int(height * 0.2), (int(width * 0.08), int(height * 0.5))
    ramp = sphere_colours(np.linspace(1, 0, bar[1]))[:, None].repeat(bar[0], axis=1)
    canvas.paste(Image.fromarray((ramp * 255).astype(np.uint8)), (left, top))
    words, beside = font(height // 22), left + bar[0] + width // 30
    pen.text((beside, top), "highest sphere", INK, words, anchor="lt")
    pen.text((beside, top + bar[1]), "lowest sphere", INK, words, anchor="lb")
    below = top + bar[1] + height // 12
    pen.rectangle((left, below, left + bar[0], below + height // 20), tuple(int(255 * c) for c in CUT_COLOUR))
    pen.text((beside, below + height // 40), "cut through the object", INK, words, anchor="lm")
    return canvas


def tiled(images: Sequence, columns: int, width: int):
    """Return images of one size in rows, each ``width`` pixels wide."""
    from PIL import Image

    height = round(images[0].height * width / images[0].width)
    rows = -(-len(images) // columns)
    canvas = Image.new("RGB", (columns * width, rows * height), BACKGROUND)
    for index, image in enumerate(images):
        small = image.resize((width, height), Image.Resampling.LANCZOS)
        canvas.paste(small, (index % columns * width, index // columns * height))
    return canvas
