"""Seats that are inferred from backs at tables: distinguished, with a reason, and only where a back is one."""

from __future__ import annotations

import numpy as np
import pytest
from clouds import sheet
from room_shapes import moved, square_table

from spherefunc_bullet.errors import InputError
from spherefunc_bullet.function_model import Membership
from spherefunc_bullet.learning.model_file import load_model, shipped_model
from spherefunc_bullet.scenes.recognition.inferring import beyond_edge, inferred_seats
from spherefunc_bullet.scenes.recognition.objects import find_objects, find_places
from spherefunc_bullet.scenes.recognition.partial_places import room_places
from spherefunc_bullet.scenes.recognition.recognition import recognise
from spherefunc_bullet.scenes.recognition.room import Room, SceneObject
from spherefunc_bullet.scenes.report.files import room_json, room_page
from spherefunc_bullet.scenes.report.picture import inferred_marks
from spherefunc_bullet.scenes.scans.scan import Scan, scan_from_points
from spherefunc_bullet.scenes.segmentation.clusters import Box, bounding_box

TABLE = square_table(1.4, 0.8, 0.74)[::4]


def back(x: float, y: float, width: float = 0.42, thickness: float = 0.03) -> np.ndarray:
    """Return what shows of a chair's back above a table's top."""
    low, high = sheet([-width / 2, 0, 0.7], [width, 0, 0], [0, 0, 0.22]), np.array([0, thickness, 0])
    return moved(np.vstack([low, low + high]), x, y)


def target(number: int, points: np.ndarray, *functions: str) -> SceneObject:
    answer = {
        name: Membership(member=name in functions, score=0.8 if name in functions else 0.1, radius=0.02)
        for name in ("cup", "sittable", "table")
    }
    box = bounding_box(points).lowered(0.0)
    return SceneObject(id=number, points=points, support=0.0, box=box, fragment=False, functions=answer)


def inferred(*others: np.ndarray, objects: tuple[SceneObject, ...] = ()):
    points = np.vstack([TABLE, *others])
    labels = np.repeat([0, *[-3] * len(others)], [len(TABLE), *map(len, others)])
    return inferred_seats(points, labels, [target(0, TABLE, "table"), *objects])


def test_a_back_at_the_edge_infers_a_seat_below_the_table():
    (seat,) = inferred(back(0.3, 0.5))
    assert seat.function == "sittable"
    assert seat.table == 0
    # The chair reaches from its back 45 cm towards the table's middle, and down to the floor.
    assert seat.box.center[:2] == pytest.approx([0.3, 0.53 - 0.45 / 2], abs=0.03)
    assert seat.box.center[2] - seat.box.size[2] / 2 == pytest.approx(0.0, abs=0.01)
    assert "table 0" in seat.reason and "not seen" in seat.reason


def test_a_back_that_is_one_cluster_with_its_table_infers_a_seat_all_the_same():
    points = np.vstack([TABLE, back(0.3, 0.42)])
    (seat,) = inferred_seats(points, np.zeros(len(points), int), [target(0, points, "table")])
    assert seat.box.center[0] == pytest.approx(0.3, abs=0.03)


def test_a_box_that_stands_on_the_table_near_its_edge_is_no_back():
    points = np.vstack([TABLE, back(0.3, 0.3) + [0.0, 0.0, 0.05]])
    assert not inferred_seats(points, np.zeros(len(points), int), [target(0, points, "table")])


@pytest.mark.slow
def test_what_is_inferred_is_in_the_answer_the_picture_and_the_page():
    """A whole scan: a table on a floor, and a back behind it."""
    floor = sheet([-1.5, -1.5, 0.0], [3, 0, 0], [0, 3, 0])[::4]
    scan = scan_from_points(np.vstack([floor, square_table(1.4, 0.8, 0.74), back(0.3, 0.46)]), "table")
    room = recognise(scan, load_model(shipped_model("fast", scans=True)))
    assert [item.members for item in room.objects if item.members] == [{"table"}]
    (seat,) = room_json(scan, room)["inferred"]
    assert seat["function"] == "sittable"
    (mark,) = inferred_marks(room)
    assert mark.thin and "inferred" in mark.text
    assert seat["reason"] in room_page(scan, room)
    assert_the_place_is_below_the_table(scan, room)


def assert_the_place_is_below_the_table(scan: Scan, room: Room):
    """It faces the table, is as high as a seat, and says that the chair has to be pulled out; with a board, as high."""
    (place,) = [one for one in room_places(scan, room)[None] if one.kind == "sit"]
    assert place.inferred and place.function == "sittable" and "pulled out" in place.note and "not seen" in place.note
    assert place.position[:2] == pytest.approx([0.3, 0.49 - 0.45 / 2], abs=0.03) and not place.knees and place.back
    assert place.heading_deg == pytest.approx(270, abs=5)
    assert place.height == pytest.approx(0.45, abs=0.05) and place.clearance == pytest.approx(0.29, abs=0.05)
    (unseen,) = [one for one in find_objects(scan, inferred=True) if one.inferred]
    assert [one.as_json() for one in unseen.places] == [place.as_json()]
    found = find_places(scan, scan=True)
    assert place.as_json() in [one.as_json() for one in found] and found[0].kind == "put"
    assert find_places(scan, scan=True, up=[0, 0, 9.81])[0].kind == "put"
    in_mm = find_places(scan.points * 1000, scan=True)  # the unit of a scan is guessed, as by `find_objects`
    assert [one.kind for one in in_mm] == [one.kind for one in found]
    with pytest.raises(InputError, match="table: expected one object"):
        find_places(scan, scan=True, prove=True)
    board = scan_from_points(np.vstack([scan.points, sheet([0.1, 0.05, 0.5], [0.4, 0, 0], [0, 0.3, 0])]), "table")
    (place,) = [one for one in room_places(board, room)[None] if one.kind == "sit"]
    assert place.height == pytest.approx(0.5, abs=0.02)


def test_two_backs_are_two_seats():
    assert len(inferred(back(-0.35, 0.5), back(0.35, 0.5))) == 2


@pytest.mark.parametrize(
    "other",
    [
        back(0.0, 1.4),  # far from the table
        back(0.0, 0.5, width=1.3),  # a screen
        back(0.0, 0.5, width=0.1),  # a bottle
        np.vstack([back(0.0, 0.5 + step, thickness=0.0) for step in np.arange(0, 0.36, 0.03)]),  # a box
        back(0.0, 0.5) - [0.0, 0.0, 0.15],  # no higher than the top
    ],
)
def test_what_is_no_chair_s_back_infers_nothing(other):
    assert not inferred(other)


def test_a_chair_that_was_found_is_not_inferred_again():
    seen = back(0.3, 0.4)
    found = target(1, np.vstack([seen, seen - [0, 0.3, 0.5]]), "sittable")
    assert not inferred(back(0.3, 0.5), objects=(found,))


def test_no_table_no_seat():
    points = back(0.0, 0.5)
    assert not inferred_seats(points, np.full(len(points), -3), [])


def test_distances_from_a_box_s_edge():
    box = Box(center=np.zeros(3), size=np.array([2.0, 1.0, 1.0]), yaw=0.0)
    places = np.array([[0.0, 0.0, 0.0], [1.3, 0.0, 0.0], [1.3, 0.9, 0.0]])
    assert beyond_edge(places, box) == pytest.approx([-0.5, 0.3, 0.5])
