"""Tables on pages: they fit a narrow window, and have no rows that say nothing."""

from __future__ import annotations

import re

import clouds
import numpy as np
import pytest
from browser import document, needs_browser

from spherefunc_bullet.commands.classify import print_quantities
from spherefunc_bullet.function_model import Membership
from spherefunc_bullet.learning.any_pose import PoseFunctions
from spherefunc_bullet.simulator.mechanics import Pose
from spherefunc_bullet.viewer.mechanics_pictures import STYLE, write_poses_page
from spherefunc_bullet.viewer.page import page_html, table_html

MEASURE = "document.body.dataset.beyond = document.documentElement.scrollWidth - innerWidth;"


@needs_browser
@pytest.mark.slow
def test_a_wide_table_of_poses_scrolls_within_a_narrow_window(tmp_path):
    table = table_html(["a heading of words"] * 9, [["0.123"] * 9])
    page = tmp_path / "poses.html"
    page.write_text(page_html("Poses", [table], style=STYLE, script=MEASURE))
    shown = document(page, tmp_path, lambda shown: "data-beyond" in shown, size=(420, 900))
    assert int(re.search(r'data-beyond="(-?\d+)"', shown)[1]) <= 0


def test_the_page_of_poses_says_what_the_object_is_for_in_each(tmp_path):
    poses = []
    for tilt, share, score in ((0.0, 0.8, 0.9), (np.pi / 2, 0.2, 0.1)):
        turn = np.array([[1, 0, 0], [0, np.cos(tilt), -np.sin(tilt)], [0, np.sin(tilt), np.cos(tilt)]])
        answer = {"cup": Membership(member=score > 0.5, score=score, radius=0.01)}
        poses.append(PoseFunctions(pose=Pose(rotation=turn, probability=share, statics=share), functions=answer))
    page = write_poses_page([(clouds.mug(), poses)], tmp_path / "poses.html").read_text()
    table = [re.findall(r"<t[hd][^>]*>([^<]*)<", row) for row in page.split("<tr>")[1:]]
    assert table == [
        ["turned by", "probability", "by statics", "for", "cup"],
        ["0°", "0.800", "0.800", "cup", "0.90"],
        ["90°", "0.200", "0.200", "no function", "0.10"],
    ]


def test_quantities_that_change_nothing_are_left_out(capsys):
    quantity = {"quantity": "stays", "meaning": "share that stays", "radius": 0.01, "value": 0.5, "median": 0.4}
    decided = [quantity | {"share": share} for share in (0.31, 0.0049, -0.0049)]
    print_quantities({"shown": "mug.ply", "functions": {"cup": {"score": 0.9}}, "quantities": {"cup": decided}}, "cup")
    printed = capsys.readouterr().out
    assert printed.count("share that stays") == 1 and "-0.31" in printed and "0.00" not in printed
