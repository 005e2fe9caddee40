"""Pinhole cameras of depth images, and the files that describe them."""

from __future__ import annotations

import json
import math
from dataclasses import MISSING, dataclass
from pathlib import Path

import numpy as np

from spherefunc_bullet.errors import CheckedSettings, InputError, amount, explaining, one_line
from spherefunc_bullet.formats.files import require_file

from ..settings import SCAN


@dataclass(frozen=True, kw_only=True)
class Intrinsics(CheckedSettings):
    """A pinhole camera."""

    width: int = amount(MISSING, least=1)
    height: int = amount(MISSING, least=1)
    fx: float = amount(MISSING, above=0.0)  # pixels
    fy: float = amount(MISSING, above=0.0)
    cx: float = amount(MISSING, least=-math.inf)  # outside the image if that was cut out of a larger one
    cy: float = amount(MISSING, least=-math.inf)

    def rays(self) -> np.ndarray:
        """Return the point (H, W, 3) at depth one that each pixel sees."""
        u, v = np.meshgrid(np.arange(self.width), np.arange(self.height))
        return np.stack([(u - self.cx) / self.fx, (v - self.cy) / self.fy, np.ones_like(u, float)], axis=-1)


def read_intrinsics(path: Path, size: tuple[int, int]) -> Intrinsics:
    """Return the camera of a file: JSON as Open3D writes it, or a text of a matrix of 3 x 3 numbers, in pixels.

    The JSON is that of PinholeCameraIntrinsic or PinholeCameraParameters. A matrix is for images of a width and height.

    Raises
    ------
    InputError
        If it is no such file.
    """
    if path.suffix.lower() != ".json":
        K = numbers_of(path, (3, 3), "a camera's JSON, as Open3D writes it, or its matrix of 3 x 3 numbers")
        return camera_of_matrix(K, size, path.name)
    require_file(path)
    try:
        data = json.loads(path.read_text(encoding="utf-8"))
        data = data.get("intrinsic", data)
        matrix = np.array(data["intrinsic_matrix"], float).reshape(3, 3, order="F")  # Open3D writes column by column
        width, height = int(data["width"]), int(data["height"])
    except OSError as error:
        raise InputError(f"{path}: expected a camera's JSON that can be read; {error.strerror}") from error
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        wanted = "width, height and intrinsic_matrix, as Open3D writes it"
        raise InputError(f"{path}: expected a camera's JSON with {wanted}; could not read it") from error
    return camera_of_matrix(matrix, (width, height), str(path))


def camera_of_matrix(K: np.ndarray, size: tuple[int, int], name: str) -> Intrinsics:
    """Return the camera of a matrix (3, 3) in pixels and of images of a width and a height.

    Raises
    ------
    InputError
        If it is no camera matrix, in a line that begins with the name.
    """
    if not np.allclose(K[[1, 2, 2, 2], [0, 0, 1, 2]], [0, 0, 0, 1]):
        raise InputError(f"{name}: expected a camera matrix with rows fx s cx, 0 fy cy, 0 0 1; is it transposed?")
    with explaining(name, InputError, why=": "):
        return Intrinsics(width=size[0], height=size[1], fx=K[0, 0], fy=K[1, 1], cx=K[0, 2], cy=K[1, 2])


def kinect_like(width: int, height: int) -> Intrinsics:
    """Return the intrinsics of a Kinect of the first generation for an image of any size, in pixels."""
    focal = SCAN.focal * width
    return Intrinsics(width=width, height=height, fx=focal, fy=focal, cx=(width - 1) / 2, cy=(height - 1) / 2)


def numbers_of(path: Path, shape: tuple[int, int], what: str = "a pose of 4 x 4 numbers") -> np.ndarray:
    """Return a matrix from a text file, or raise InputError that says what is expected."""
    words = [as_number(word) for line in lines_of(path) for word in line.split()]
    if len(words) != shape[0] * shape[1] or None in words:
        raise InputError(f"{path.name}: expected {what}, found {len(words)} words")
    return np.array(words, float).reshape(shape)


def lines_of(path: Path) -> list[str]:
    """Return the lines of a text file without comments and empty ones, words divided by spaces."""
    require_file(path)
    with explaining(f"{one_line(path.name)}: expected a text that can be read", OSError, UnicodeDecodeError):
        text = path.read_text(encoding="utf-8-sig")  # Windows may write a mark before it
    lines = (line.partition("#")[0].replace(",", " ").strip() for line in text.splitlines())
    return [line for line in lines if line]


def as_number(word: str) -> float | None:
    """Return a word as a number, None if it is none.

    Examples
    --------
    >>> as_number("1305031102.16"), as_number("depth")
    (1305031102.16, None)
    """
    try:
        return float(word)
    except ValueError:
        return None
