"""Seats that are inferred in fused images name their table by the id that it keeps, as the other objects do."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from clouds import sheet
from room_shapes import moved, square_table

from spherefunc_bullet.learning.model_file import inference_model, shipped_model
from spherefunc_bullet.scenes.commands.scene_frames import fused_json, print_fused
from spherefunc_bullet.scenes.recognition.partial_places import room_places
from spherefunc_bullet.scenes.recognition.recognition import recognise
from spherefunc_bullet.scenes.scans.scan import scan_from_points

LATER = 7  # the id of the first object, which is label 0 in the room


@pytest.fixture(scope="module")
def fused():
    """Return what a fusion holds of a table on a floor with a back behind it."""
    floor = sheet([-1.5, -1.5, 0.0], [3, 0, 0], [0, 3, 0])[::4]
    low, high = sheet([-0.21, 0, 0.7], [0.42, 0, 0], [0, 0, 0.22]), np.array([0, 0.03, 0])
    back = moved(np.vstack([low, low + high]), 0.3, 0.46)
    scan = scan_from_points(np.vstack([floor, square_table(1.4, 0.8, 0.74), back]), "table")
    room = recognise(scan, inference_model(shipped_model("fast", scans=True), None))
    ids = {item.id: LATER + item.id for item in room.objects}
    return SimpleNamespace(
        scan=scan, room=room, ids=ids, count=1, map=SimpleNamespace(agreement=1.0), gone=[], stages={"fusing": 0.1}
    )


def objects_of(fused) -> list:
    values = {"moved": None, "seen": 1, "functions": frozenset()}
    return [SimpleNamespace(id=fused.ids[item.id], label=item.id, **values) for item in fused.room.objects]


def test_json_names_the_table_by_its_id(fused):
    used = room_places(fused.scan, fused.room)
    about = fused_json(fused, SimpleNamespace(frames=[None], posed=True), objects_of(fused), used)
    (seat,), (place,) = about["inferred"], (place for place in about["places"] if place["kind"] == "sit")
    (table,) = (row for row in about["objects"] if row["functions"]["table"]["member"])
    assert seat["table"] == table["id"] != table["label"]
    assert f"table {table['id']};" in seat["reason"] and seat["reason"] in place["note"]


def test_the_text_says_what_is_inferred_as_that_of_a_single_scan_does(fused, capsys):
    print_fused(fused, objects_of(fused))
    assert "inferred, not counted: sittable, since an upright back" in (said := capsys.readouterr().out)
    assert f"table {LATER}" in said
