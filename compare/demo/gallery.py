"""The paper's Fig. 1, settled spheres on a cup, a table, a chair and a sofa; and two backends side by side."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from joblib import Parallel, delayed
from PIL import Image, ImageDraw, ImageFont, ImageOps
from trimesh import Trimesh

from spherefunc_bullet.clouds.cloud import cloud_from_mesh
from spherefunc_bullet.console import progress
from spherefunc_bullet.datasets.catalogue import make_catalogue
from spherefunc_bullet.formats.units import format_length, parse_length
from spherefunc_bullet.simulator import DropSettings, Simulator, make_simulator
from spherefunc_bullet.viewer.colours import sphere_colours
from spherefunc_bullet.viewer.mechanics_pictures import CAPTION_HEIGHT, INK, PAPER, captioned, in_rows, write_picture
from spherefunc_bullet.viewer.pictures import CUT_COLOUR, CameraView, object_picture


@dataclass(frozen=True, kw_only=True)
class GalleryPicture:
    """One picture: an object of the catalogue, the radius of the spheres, and the camera."""

    title: str
    name: str  # in the catalogue
    radius: float  # metres
    view: CameraView


SIDE = CameraView(azimuth_deg=180.0, elevation_deg=10.0, cut=True)
EXHIBITS = {
    "cup": GalleryPicture(title="Cup, cut open", name="mug_01", radius=parse_length("4mm"), view=CameraView(cut=True)),
    "table": GalleryPicture(title="Table", name="dining_table_02", radius=parse_length("2cm"), view=CameraView()),
    "chair": GalleryPicture(title="Chair", name="shell_chair_01", radius=parse_length("15mm"), view=CameraView()),
    "chair_side": GalleryPicture(
        title="Chair from the side, cut open", name="shell_chair_01", radius=parse_length("15mm"), view=SIDE
    ),
    "sofa": GalleryPicture(title="Sofa", name="sofa_02", radius=parse_length("2cm"), view=CameraView()),
}
SIDE_BY_SIDE = ("cup", "chair_side", "sofa")  # where the backends differ most
COLUMNS, SCALE = 3, 0.75  # of pictures that stand together


def draw_exhibits(names: Iterable[str], simulator: Simulator, caption: str = "") -> dict[str, Image.Image]:
    """Return pictures of catalogue objects with settled spheres; captions begin with the simulator's name, if given."""
    meshes = {item.name: item.mesh for item in make_catalogue("household")}
    exhibits = {name: EXHIBITS[name] for name in names}
    work = (delayed(drawn)(exhibit, meshes[exhibit.name], simulator, caption) for exhibit in exhibits.values())
    images = Parallel(n_jobs=-1, return_as="generator")(work)
    return dict(zip(exhibits, progress(images, len(exhibits), f"drawing {caption}".strip()), strict=True))


def drawn(exhibit: GalleryPicture, mesh: Trimesh, simulator: Simulator, caption: str) -> Image.Image:
    """Return one object with the spheres that settle on it, captioned."""
    cloud = cloud_from_mesh(mesh.vertices, mesh.faces, exhibit.name)
    result = simulator.drop(cloud, DropSettings(radius=exhibit.radius), 0)
    image = object_picture(cloud, result.centers, exhibit.radius, exhibit.view)
    detail = f"r = {format_length(exhibit.radius)}, {result.settled:,} spheres settled"
    return captioned(image, f"{caption}: {exhibit.title.lower()}" if caption else exhibit.title, detail)


def write_gallery(out: Path, backend: str) -> list[Path]:
    """Write one PNG for each exhibit, and ``settling.png`` with all of them; return their paths.

    Raises
    ------
    InputError
        If there is no such backend, or the folder cannot be written.
    """
    images = draw_exhibits(EXHIBITS, make_simulator(backend))
    images["settling"] = tiled([*images.values(), colour_key(CameraView().size)])
    return [write_picture(image, out / f"{name}.png") for name, image in images.items()]


def write_side_by_side(out: Path, backends: Sequence[str]) -> Path:
    """Write ``backends.png``, a row of the same objects for each backend; return its path.

    Raises
    ------
    InputError
        If a backend is missing, or the folder cannot be written.
    """
    simulators = [make_simulator(name) for name in backends]
    rows = [draw_exhibits(SIDE_BY_SIDE, *pair) for pair in zip(simulators, backends, strict=True)]
    images = [image for row in rows for image in row.values()]
    return write_picture(tiled(images), out / "backends.png")


def colour_key(size: tuple[int, int]) -> Image.Image:
    """Return an image with the meaning of the colours, as large as a captioned picture of ``size`` pixels."""
    width, height = size
    canvas = Image.new("RGB", (width, height + CAPTION_HEIGHT), PAPER)
    pen = ImageDraw.Draw(canvas)
    left, top, bar = int(width * 0.28), int(height * 0.2), (int(width * 0.08), int(height * 0.5))
    ramp = sphere_colours(np.linspace(1, 0, bar[1]))[:, None].repeat(bar[0], axis=1)
    canvas.paste(Image.fromarray((ramp * 255).astype(np.uint8)), (left, top))
    words, beside = ImageFont.load_default(height // 22), left + bar[0] + width // 30
    pen.text((beside, top), "highest sphere", INK, words, anchor="lt")
    pen.text((beside, top + bar[1]), "lowest sphere", INK, words, anchor="lb")
    below = top + bar[1] + height // 12
    pen.rectangle((left, below, left + bar[0], below + height // 20), tuple(int(255 * c) for c in CUT_COLOUR))
    pen.text((beside, below + height // 40), "cut through the object", INK, words, anchor="lm")
    return canvas


def tiled(images: Sequence[Image.Image]) -> Image.Image:
    """Return images of one size in rows, smaller."""
    return ImageOps.scale(in_rows(images, COLUMNS), SCALE, Image.Resampling.LANCZOS)
