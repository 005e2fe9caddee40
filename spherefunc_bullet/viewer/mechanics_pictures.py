"""Pictures of objects in their stable poses and under loads: tiles with captions, and a page of them."""

from __future__ import annotations

import io
import textwrap
from collections.abc import Sequence
from html import escape
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw, ImageFont, ImageOps

from ..clouds.cloud import Cloud
from ..clouds.preparation import rotated_cloud
from ..errors import InputError
from ..formats.files import write_bytes, write_text
from ..learning.any_pose import PoseFunctions, best_poses
from ..simulator.mechanics import CarryResult, StandResult
from .page import image_html, page_html, table_html
from .pictures import GROUND_COLOUR, CameraView, object_picture

TILE = CameraView(size=(360, 300))
CAPTION_HEIGHT = 76  # pixels, below a tile
ABREAST = 5  # tiles in a row
MOST = 10  # number of poses of an object that are drawn
INK, GREY, GOOD = (25, 25, 30), (90, 90, 100), (0, 130, 90)
PAPER = tuple(int(255 * channel) for channel in GROUND_COLOUR)
STYLE = "body{font:15px/1.5 system-ui,sans-serif;margin:2rem auto;max-width:72rem;padding:0 1rem;color:#1a1a1e}\
img{max-width:100%;height:auto}.scroll{overflow-x:auto}table{border-collapse:collapse;margin:.5rem 0 2rem}\
td,th{padding:.2rem .8rem;text-align:left;border-bottom:1px solid #ddd}.number{text-align:right}"
KEPT = (140, 190, 225)  # pale, so that dark words can be read on it and beside it
CARRIES, TIPS = np.array([0.0, 0.45, 0.70]), np.array([0.84, 0.37, 0.0])
NOTHING = "no function"
FRAMED = "Green frame: the best pose for a function that the object has. In %: how often it lies so after a fall."
TILTED = "Bars: share of the spheres that stay when it is tilted so far. Spheres: left in the end. Brown: cut open."
LOADED = "Blue: {load:g} kg can stand there. Orange: that tips it."
NO_SPHERES = np.empty((0, 3))
ObjectPoses = tuple[Cloud, Sequence[PoseFunctions]]  # an object, and its functions in each of its poses


def pose_words(one: PoseFunctions) -> tuple[str, str]:
    """Return the probability of a pose, and the functions of the object in it, as text."""
    members = [f"{name} {answer.score:.2f}" for name, answer in one.functions.items() if answer.member]
    share = one.pose.probability
    return f"{100 * share:.0f} %" if share >= 0.005 else "less than 1 %", ", ".join(members) or NOTHING


def framed_poses(answers: Sequence[PoseFunctions]) -> set[int]:
    """Return the numbers of the poses with a frame: the best pose for each function, if the object has it there."""
    return {number for name, number in best_poses(answers).items() if answers[number].functions[name].member}


def poses_picture(objects: Sequence[ObjectPoses]) -> Image.Image:
    """Return each object in its likeliest poses, below its name, in one or more rows."""
    rows: list[Image.Image] = []
    for cloud, answers in objects:
        framed = framed_poses(answers)
        tiles = [
            tile(rotated_cloud(cloud, answer.pose.rotation), *pose_words(answer), framed=number in framed)
            for number, answer in enumerate(answers[:MOST])
        ]
        rows.append(titled(in_rows(tiles, ABREAST), f"{cloud.name}: how it can lie, and what it is for in each pose"))
    return noted(stacked(rows), FRAMED)


def tile(cloud: Cloud, title: str, detail: str, framed: bool) -> Image.Image:
    """Return a picture of an object with two lines of text below it."""
    return captioned(object_picture(cloud, NO_SPHERES, 0.01, TILE), title, detail, framed=framed)


def captioned(image: Image.Image, title: str, detail: str, framed: bool = False) -> Image.Image:
    """Return an image with two lines of text below it, and a coloured frame if requested."""
    canvas = ImageOps.expand(image, (0, 0, 0, CAPTION_HEIGHT), PAPER)
    pen, middle = ImageDraw.Draw(canvas), image.width / 2
    size = min(24, int(24 * 0.94 * image.width / max(1, pen.textlength(title, ImageFont.load_default(24)))))
    pen.text((middle, image.height + 20), title, INK, ImageFont.load_default(size), anchor="mm")
    pen.text((middle, image.height + 50), detail, GOOD if framed else GREY, ImageFont.load_default(20), anchor="mm")
    if framed:
        pen.rectangle((3, 3, canvas.width - 4, canvas.height - 4), outline=GOOD, width=3)
    return canvas


def titled(image: Image.Image, title: str) -> Image.Image:
    """Return an image with a line of text above it."""
    canvas = ImageOps.expand(image, (0, 50, 0, 0), PAPER)
    ImageDraw.Draw(canvas).text((16, 28), title, INK, ImageFont.load_default(26), anchor="lm")
    return canvas


def noted(image: Image.Image, note: str) -> Image.Image:
    """Return an image with a note below it, wrapped into lines."""
    font = ImageFont.load_default(22)
    letters = int(len(note) * (image.width - 64) / font.getlength(note))  # in a line, on average
    lines = textwrap.wrap(note, letters)
    canvas = ImageOps.expand(image, (0, 0, 0, 28 * len(lines) + 16), PAPER)
    ImageDraw.Draw(canvas).multiline_text((16, image.height + 8), "\n".join(lines), GREY, font)
    return canvas


def side_by_side(images: Sequence[Image.Image]) -> Image.Image:
    """Return images of equal height next to each other."""
    return Image.fromarray(np.hstack(images))


def in_rows(images: Sequence[Image.Image], columns: int) -> Image.Image:
    """Return images of equal size in rows."""
    return stacked([side_by_side(images[first : first + columns]) for first in range(0, len(images), columns)])


def stacked(images: Sequence[Image.Image]) -> Image.Image:
    """Return images below each other."""
    wide = max(image.width for image in images)
    return Image.fromarray(np.vstack([ImageOps.expand(one, (0, 0, wide - one.width, 0), PAPER) for one in images]))


def png_of(picture: Image.Image) -> bytes:
    """Return a picture as a small PNG."""
    buffer = io.BytesIO()
    picture.quantize(192, kmeans=1).save(buffer, "png", optimize=True)
    return buffer.getvalue()


def write_picture(picture: Image.Image, path: Path) -> Path:
    """Write a picture as PNG.

    Raises
    ------
    InputError
        If the file has another ending, or cannot be written.
    """
    require_png(path)
    return write_bytes(path, png_of(picture))


def write_tiles(tiles: Sequence[Image.Image], path: Path | None, note: str):
    """Write objects side by side, with a note below them, as PNG, if there is a path and there are any."""
    if path is not None and tiles:
        write_picture(noted(side_by_side(tiles), note), path)


def require_png(path: Path | None):
    """Raise InputError if the name of a picture does not end in .png."""
    if path is not None and path.suffix.lower() != ".png":
        raise InputError(f"--picture {path}: expected a file that ends in .png")


def write_poses_page(objects: Sequence[ObjectPoses], path: Path) -> Path:
    """Write a self-contained page with the poses of each object as a picture and as a table."""
    parts = ["<h1>How objects can lie, and what they are for in each pose</h1>"]
    for cloud, answers in objects:
        parts.append(f"<h2>{escape(cloud.name)}</h2>")
        parts.append(image_html(f"{cloud.name} in its poses", png_of(poses_picture([(cloud, answers)]))))
        names = list(answers[0].functions) if answers else []
        rows = []
        for answer in answers:
            members = [name for name, answer in answer.functions.items() if answer.member]
            cells = [f"{answer.pose.tilt_deg:.0f}°", f"{answer.pose.probability:.3f}", f"{answer.pose.statics:.3f}"]
            scores = [f"{answer.functions[name].score:.2f}" for name in names]
            rows.append([*cells, ", ".join(members) or NOTHING, *scores])
        parts.append(table_html(["turned by", "probability", "by statics", "for", *names], rows, texts=0))
    return write_text(path, page_html("Poses", parts, style=STYLE))


def stand_tile(cloud: Cloud, result: StandResult, load: float) -> Image.Image:
    """Return an object with a ball at each place: blue where it carries the load, orange where it tips."""
    from .pictures import render_balls

    radius = 0.02 * float(cloud.size.max())
    colours = np.where(result.carries[:, None], CARRIES, TIPS)
    image = render_balls(cloud, result.places + [0, 0, radius], radius, colours, TILE)
    share = "" if result.share is None else f"{100 * result.share:.0f} % of places carry {load:g} kg"
    title = ", ".join(filter(None, [f"{cloud.name}: {result.stance}", result.tipping_words]))
    return captioned(image, title, share)


def carry_tile(cloud: Cloud, result: CarryResult) -> Image.Image:
    """Return a picture of an object with the spheres that it still holds, and the share kept at each angle as bars."""
    image = object_picture(cloud, result.centers, result.radius, TILE)
    canvas = captioned(image, cloud.name, "")
    pen, count = ImageDraw.Draw(canvas), len(result.kept)
    wide = image.width / (count + 1)
    for number, (angle, share) in enumerate(zip(result.angles_deg, result.kept, strict=True)):
        left, top = wide * (number + 0.6), image.height + 42
        pen.rectangle((left, top, left + 0.8 * wide, top + 24), outline=GREY)
        pen.rectangle((left, top, left + 0.8 * wide * share, top + 24), fill=KEPT)
        words = f"{angle:g}°: {100 * share:.0f} %"
        pen.text((left + 0.4 * wide, top + 12), words, INK, ImageFont.load_default(15), anchor="mm")
    return canvas
