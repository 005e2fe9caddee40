"""The table top that serves as ground is an object, with its height where the scan's frame tells it."""

from __future__ import annotations

import numpy as np
import pytest
from clouds import level as sheet_at
from clouds import mug
from room_shapes import box, moved, room

from spherefunc_bullet.learning.model_file import load_model, shipped_model
from spherefunc_bullet.scenes.recognition.recognition import Room, recognise
from spherefunc_bullet.scenes.scans.scan import scan_from_points

HIDDEN = 0.06  # metres: half of what a box hides of the top on which it stands


@pytest.fixture(scope="module")
def model():
    return load_model(shipped_model("fast", scans=True))


def top_with_objects() -> np.ndarray:
    """Return a desk's top without floor or legs, a mug and a box on it, metres; under the box nothing is seen."""
    top = sheet_at(1.2, 0.7, 0.0)
    top = top[np.abs(top[:, :2] - [-0.3, 0.1]).max(axis=1) > HIDDEN]
    return np.vstack([top, moved(mug().points, 0.2, 0.1), moved(box(0.12, 0.12, 0.15), -0.3, 0.1)])


def recognised(points: np.ndarray, model) -> Room:
    return recognise(scan_from_points(points, units="m"), model, up="z")


@pytest.mark.parametrize(("lift", "height"), [(0.0, None), (0.74, 0.74), (3.0, None)])
def test_the_top_is_a_table_whose_height_only_a_floor_at_zero_tells(model, lift, height):
    found = recognised(moved(top_with_objects(), 0.0, 0.0, lift), model)
    (top,) = (item for item in found.objects if item.made_from == "table top")
    assert top.functions["table"].member and not top.functions["cup"].member
    assert top.height == (None if height is None else pytest.approx(height, abs=0.01))
    assert np.allclose(top.box.size[:2], [1.2, 0.7], atol=0.03)
    assert top.box.size[2] == pytest.approx(height or 0.0, abs=0.04)
    own = found.labels == top.id
    assert own.sum() > 0.9 * len(sheet_at(1.2, 0.7, 0.0)) * 0.95 and (found.labels == -1).sum() < 0.02 * own.sum()


def test_what_stands_on_the_top_is_found_as_before(model):
    found = recognised(top_with_objects(), model)
    assert sum("cup" in item.members for item in found.objects) == 1


def test_a_floor_is_no_table_top(model):
    found = recognised(room()[0][::3], model)
    assert found.levelling.source == "floor" and all(item.made_from is None for item in found.objects)
