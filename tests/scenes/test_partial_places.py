"""Places on objects that were seen in part: the middle of a level, and where small spheres stay in a hollow."""

import numpy as np
import pytest

from spherefunc_bullet.places.words import details
from spherefunc_bullet.scenes.recognition.partial_places import hollow_places, level_place
from spherefunc_bullet.scenes.recognition.room import SceneObject
from spherefunc_bullet.scenes.segmentation.clusters import bounding_box

SPACING = 0.004  # metres


def item_of(points: np.ndarray) -> SceneObject:
    return SceneObject(id=0, points=points, support=0.0, box=bounding_box(points), fragment=False, functions={})


def sheet(size: float, height: float) -> np.ndarray:
    """Return a level square about the origin."""
    across = np.arange(-size / 2, size / 2, SPACING)
    return np.stack(np.meshgrid(across, across, [height]), axis=-1).reshape(-1, 3)


def half_a_cup(radius: float, height: float, share: float) -> np.ndarray:
    """Return a share of a cylinder's side, about the x axis, without its bottom."""
    angles = np.arange(-np.pi * share, np.pi * share, SPACING / radius)
    angle, z = (grid.ravel() for grid in np.meshgrid(angles, np.arange(0.004, height, SPACING)))
    return np.column_stack([radius * np.cos(angle), radius * np.sin(angle), z])


@pytest.mark.parametrize(("kind", "height"), [("sit", 0.45), ("put", 0.72)])
def test_a_level_has_its_place_in_the_middle(kind, height):
    top = sheet(0.4, height)
    place = level_place(item_of(top), kind, top)
    assert np.allclose(place.position, [0, 0, height], atol=0.03)  # a square and a half of its outline
    assert place.area == pytest.approx(0.16, rel=0.25) and place.inferred


def test_what_is_higher_than_a_seat_is_none_to_sit_on():
    top = sheet(1.0, 0.72)
    assert level_place(item_of(top), "sit", top) is None


def test_nothing_is_put_below_what_stands_on_a_top():
    top, box = sheet(0.6, 0.72), sheet(0.3, 0.8)
    place = level_place(item_of(top), "put", np.vstack([top, box]))
    assert np.abs(place.position[:2]).max() > 0.15 + place.radius - 0.03
    assert level_place(item_of(top), "put", np.vstack([top, sheet(0.6, 0.8)])) is None


def test_a_ledge_has_no_room():
    ledge = sheet(0.4, 0.45) * [1, 0.1, 1]
    assert level_place(item_of(ledge), "sit", ledge) is None


def test_three_quarters_of_a_wall_hold_spheres_and_a_third_does_not():
    (place,) = hollow_places(item_of(half_a_cup(0.04, 0.09, 0.75)), "fast")
    assert np.hypot(*place.position[:2]) < 0.02 and place.height == pytest.approx(0.09, abs=0.01)
    assert place.capacity_ml == pytest.approx(np.pi * 4 * 4 * 9, rel=0.35)  # of a prism through the middle of the wall
    assert hollow_places(item_of(half_a_cup(0.04, 0.09, 0.33)), "fast") == []


def test_what_was_seen_in_part_is_printed_without_what_nobody_knows():
    seat, cup = sheet(0.4, 0.45), half_a_cup(0.04, 0.09, 0.75)
    places = [level_place(item_of(seat), "sit", seat), *hollow_places(item_of(cup), "fast")]
    words = [details(place.as_json()) for place in places]
    assert words[0] == "" and words[1].startswith("holds ") and "spills" not in words[1]
