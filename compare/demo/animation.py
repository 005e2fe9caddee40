"""The picture that opens README: spheres fall on a mug, a chair and a table, and the scores follow.

A sphere is drawn falling straight down to where it came to rest. The scores are those of the package's model, after a
number of drops at each of its radii.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path

import numpy as np
from joblib import Parallel, delayed
from PIL import Image, ImageDraw, ImageFont, ImageOps

from spherefunc_bullet.clouds.cloud import Cloud, cloud_from_mesh
from spherefunc_bullet.console import progress
from spherefunc_bullet.datasets.catalogue import make_catalogue
from spherefunc_bullet.formats.files import write_bytes
from spherefunc_bullet.formats.units import parse_length
from spherefunc_bullet.function_model import FunctionModel
from spherefunc_bullet.learning.model_file import inference_model
from spherefunc_bullet.settling.drops import RunLimit
from spherefunc_bullet.settling.settling import settle
from spherefunc_bullet.simulator import DropSettings, Outcome, make_simulator
from spherefunc_bullet.viewer.colours import FLAT, sphere_colours
from spherefunc_bullet.viewer.mechanics_pictures import GREY, INK, PAPER
from spherefunc_bullet.viewer.pictures import CameraView, drawn_box, render

SIZE = (300, 270)  # of each object's picture, pixels
BARS = 100  # pixels below it
FRAMES, HELD = 40, 14  # number of frames with falling spheres, and with the last picture
AIRBORNE = 3  # frames in which a falling sphere is seen
MILLISECONDS = 100  # of a frame
COUNTED = (0, 2, 4, 8, 12, 16, 20, 25, 30, 35, 40)  # drops after which the model classifies
COLOURS = 96  # of the file
BAR, EMPTY = (62, 105, 178), (222, 222, 228)


@dataclass(frozen=True, kw_only=True)
class AnimatedObject:
    """One object of the animation."""

    name: str  # in the catalogue
    radius: float  # of the spheres that are drawn, metres
    drops: int  # that are drawn
    cut: bool = False


PARTS = (
    AnimatedObject(name="mug_01", radius=parse_length("6mm"), drops=420, cut=True),
    AnimatedObject(name="shell_chair_01", radius=parse_length("2cm"), drops=900),
    AnimatedObject(name="dining_table_02", radius=parse_length("3cm"), drops=500),
)


def fall_picture(part: AnimatedObject, cloud: Cloud, rests: np.ndarray, early: np.ndarray) -> Image.Image:
    """Return one picture: spheres at rest (S, 3), metres, and those in the air, by the frames (S,) until they rest."""
    mesh, early = cloud.mesh, np.clip(early, 0, AIRBORNE)
    low, high = drawn_box(mesh.vertices, rests, part.radius)
    high = high + [0, 0, 0.25 * (high[2] - low[2])]  # to fall through
    centers = rests + np.outer(early / AIRBORNE * (high[2] - low[2]), [0, 0, 1])
    seen = (centers[:, 2] < high[2] - part.radius) & (early < AIRBORNE)
    colours = sphere_colours(rests[:, 2], FLAT * part.radius)[seen]
    view = CameraView(size=SIZE, cut=part.cut)
    return render(mesh.vertices, mesh.faces, centers[seen], part.radius, view, colours, (low, high))


def scores_after(cloud: Cloud, model: FunctionModel) -> np.ndarray:
    """Return the scores (C, F) of one object after each of `COUNTED` drops; 0 before the first."""
    counts = [count for count in COUNTED if count]
    settled = [settle(cloud, model.simulator, model.chosen_radii(), model.seed, RunLimit(drops=n)) for n in counts]
    return np.vstack([np.zeros(len(model.functions_)), model.score_settled(settled)])


def with_bars(image: Image.Image, functions: Sequence[str], scores: np.ndarray, label: str) -> Image.Image:
    """Return a picture with a bar of each score (F,) below it."""
    width, height = image.size
    canvas = ImageOps.expand(image, (0, 0, 0, BARS), PAPER)
    pen, words = ImageDraw.Draw(canvas), ImageFont.load_default(15)
    pen.text((width - 16, height + BARS - 12), label, GREY, ImageFont.load_default(12), anchor="rm")
    for row, (name, score) in enumerate(zip(functions, scores, strict=True)):
        middle, left, right = height + 12 + 24 * row, 84, width - 56
        pen.text((left - 10, middle), name, INK, words, anchor="rm")
        pen.rounded_rectangle((left, middle - 7, right, middle + 7), 4, EMPTY)
        if score > 0.02:
            pen.rounded_rectangle((left, middle - 7, left + (right - left) * score, middle + 7), 4, BAR)
        pen.text((right + 8, middle), f"{score:.2f}", INK, words, anchor="lm")
    return canvas


def drawn_part(part: AnimatedObject, cloud: Cloud, model: FunctionModel) -> list[Image.Image]:
    """Return the frames of one object: the same number of drops in each, and the scores after some drops."""
    settings = DropSettings(radius=part.radius, miss_limit=part.drops, max_drops=part.drops)
    result = make_simulator("fast").drop(cloud, settings, 0)
    landed = np.flatnonzero(result.outcomes == Outcome.SETTLED) / part.drops * (FRAMES - AIRBORNE) + 1
    scores, frames = scores_after(cloud, model), []
    for number in range(FRAMES + 1):
        at = min(number * len(COUNTED) // FRAMES, len(COUNTED) - 1)
        label = f"scores after {COUNTED[at]} drops at each radius"
        picture = fall_picture(part, cloud, result.centers, landed - number)
        frames.append(with_bars(picture, model.functions_, scores[at], label))
    return frames


def animation_bytes(columns: Sequence[Sequence[Image.Image]]) -> bytes:
    """Return the frames of all objects side by side as a GIF that repeats."""
    joined = [Image.fromarray(np.hstack([np.asarray(image) for image in row])) for row in zip(*columns, strict=True)]
    palette = joined[-1].quantize(COLOURS, Image.Quantize.MEDIANCUT)
    frames = [image.quantize(palette=palette, dither=Image.Dither.NONE) for image in joined]
    times = [MILLISECONDS] * (len(frames) - 1) + [MILLISECONDS * HELD]
    memory = BytesIO()
    frames[0].save(memory, "GIF", save_all=True, append_images=frames[1:], duration=times, loop=0, optimize=False)
    return memory.getvalue()


def write_animation(out: Path) -> Path:
    """Write ``drops.gif``, and return its path."""
    model = inference_model(None, None)
    meshes = {item.name: item.mesh for item in make_catalogue("household")}
    clouds = [cloud_from_mesh(meshes[part.name].vertices, meshes[part.name].faces, part.name) for part in PARTS]
    work = (delayed(drawn_part)(part, cloud, model) for part, cloud in zip(PARTS, clouds, strict=True))
    columns = list(progress(Parallel(n_jobs=-1, return_as="generator")(work), len(PARTS), "drawing"))
    return write_bytes(out / "drops.gif", animation_bytes(columns))
