"""The page of a room says what each object is for, legibly, and what its score had to pass."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest
from browser import document, needs_browser

from spherefunc_bullet.function_model import Membership
from spherefunc_bullet.scenes.recognition.room import THRESHOLDS, Room, SceneObject
from spherefunc_bullet.scenes.report.files import room_json, room_page
from spherefunc_bullet.scenes.scans.levelling import Levelling
from spherefunc_bullet.scenes.scans.scan import Scan
from spherefunc_bullet.scenes.segmentation.clusters import bounding_box

# Keeps where each text is written, without a look at how the page chooses that.
RECORD = """<script>
const written = new Map();
const write = CanvasRenderingContext2D.prototype.fillText;
CanvasRenderingContext2D.prototype.fillText = function (text, x, y) {
  written.set(text, [x, y, this.measureText(text).width, parseInt(this.font.match(/[0-9]+px/))]);
  document.body.dataset.written = JSON.stringify([...written]);
  write.call(this, text, x, y);
};
</script></head>"""


def crowded() -> tuple[Scan, Room]:
    """Return a scan with boxes of cups that lie within each other, each with a score of its own."""
    rng = np.random.default_rng(0)
    objects = []
    for number in range(12):
        points = rng.random((200, 3)) * [0.08, 0.08, 0.1] + [0.04 * (number % 4), 0.04 * (number // 4), 0]
        answer = {"cup": Membership(member=True, score=0.6 + number / 100, radius=0.01)}
        answer |= {"sittable": Membership(member=False, score=0.1, radius=0.03)}
        by = "pools" if number % 2 else "clusters"
        objects.append(
            SceneObject(
                id=number,
                points=points,
                support=0.0,
                box=bounding_box(points),
                fragment=False,
                functions=answer,
                proposed_by=by,
            )  # fmt: skip
        )
    points = np.vstack([item.points for item in objects])
    labels = np.repeat(np.arange(12, dtype=np.int32), 200)
    levelling = Levelling(T_level_scan=np.eye(4), source="floor", floor_seen=True, noise=0.001)
    return Scan(name="shelf", points=points), Room(
        levelling=levelling, labels=labels, objects=objects, thresholds=THRESHOLDS
    )


def written(shown: str) -> list[tuple[str, str]]:
    """Return each name that was written, and the numbers that `RECORD` kept of it."""
    return re.findall(r"&quot;(cup [\d.]+)&quot;,\[([\d.,-]+)\]", shown)


@needs_browser
@pytest.mark.slow
def test_no_name_in_the_page_lies_over_another(tmp_path):
    page = tmp_path / "room.html"
    page.write_text(room_page(*crowded()).replace("</head>", RECORD, 1))
    shown = document(page, tmp_path, lambda shown: len(written(shown)) == 12)
    places = [tuple(float(number) for number in numbers.split(",")) for _, numbers in written(shown)]
    assert len(places) == 12
    for k, (x, y, width, size) in enumerate(places):
        for other_x, other_y, other_width, _ in places[:k]:
            assert abs(x - other_x) >= (width + other_width) / 2 or abs(y - other_y) >= size


def test_the_bar_of_each_function_stands_beside_its_score():
    scan, room = crowded()
    first, second = room_json(scan, room)["objects"][:2]
    assert [one["functions"]["sittable"]["bar"] for one in (first, second)] == [
        THRESHOLDS[by].of("sittable") for by in ("clusters", "pools")
    ]
    assert first["functions"]["cup"] == {"member": True, "score": 0.6, "radius": 0.01, "bar": 0.55}
    page = room_page(scan, room)
    assert "0.60 (0.55)" in page and "0.10 (0.40)" in page and "0.10 (0.50)" in page


def test_a_score_that_leaves_it_open_is_unsure():
    scan, room = crowded()
    assert not any(row["unsure"] for row in room_json(scan, room)["objects"])  # no range is known
    room = replace(room, unsure_ranges={"cup": (0.2, 0.65), "sittable": (0.2, 0.65)})
    rows, page = room_json(scan, room)["objects"], room_page(scan, room)
    assert [row["unsure"] for row in rows] == [True] * 5 + [False] * 7  # 0.60, 0.61, ...
    assert rows[3]["reasons"][-1] == "cup is uncertain: its score 0.63 is between 0.20 and 0.65"
    assert page.count("<td>cup, unsure</td>") == 5 and page.count("<td>cup</td>") == 7


def test_objects_without_a_function_are_folded():
    scan, room = crowded()
    empty = {name: replace(one, member=False) for name, one in room.objects[0].functions.items()}
    objects = [replace(item, functions=empty) if item.id > 3 else item for item in room.objects]
    page = room_page(scan, replace(room, objects=objects))
    shown, folded = page.split("<details>")
    assert "8 others without a function</summary>" in folded
    assert [table.count("<tr>") for table in (shown, folded)] == [1 + 4, 1 + 8]  # a row of headings each


def test_the_page_says_which_score_counts_as_yes():
    page = room_page(*crowded())
    assert "<details>" not in page
    assert "cup 0.55, sittable 0.40 of separate clusters of points; cup 0.55, sittable 0.50 of parts on which" in page
