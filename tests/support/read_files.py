"""What becomes of a file: the extent of what is read, or the line that refuses it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from spherefunc_bullet.errors import InputError
from spherefunc_bullet.formats.sources import read_geometry


def extent(path: Path) -> list[float]:
    """Return the extent of what is read, rounded to a micrometre."""
    return np.ptp(read_geometry(path).vertices, axis=0).round(6).tolist()


def refused(path: Path) -> str:
    """Return the one line with which a file is refused; it begins with the file's name."""
    with pytest.raises(InputError) as error:
        read_geometry(path)
    assert "\n" not in str(error.value) and str(error.value).startswith(path.name)
    return str(error.value)
