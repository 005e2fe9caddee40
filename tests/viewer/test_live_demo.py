"""The live demo: what its controls do, on a real server without a browser."""

from __future__ import annotations

import sys

import numpy as np
import pytest

from spherefunc_bullet.commands.command_line import application
from spherefunc_bullet.errors import InputError


@pytest.fixture(scope="module")
def page():
    pytest.importorskip("viser")
    from spherefunc_bullet.compare.demo.live import start

    page = start(port=0)
    yield page
    page.server.stop()


@pytest.mark.slow
def test_spheres_fall_into_a_mug_and_its_bar_fills(page):
    found = page.update(pause=0.0)
    assert 0 < len(found.rests) <= found.drops == page.drops.value
    assert (found.starts[:, 2] > found.cloud.size[2]).all()
    assert np.allclose(found.at(0.0), found.starts) and np.allclose(found.at(1.0), found.rests)
    assert (
        page.bars["cup"][1].value == pytest.approx(100 * found.answer.scores["cup"]) and "cup" in found.answer.functions
    )


def test_controls_change_what_falls_and_what_is_said(page):
    page.tilt.value, page.radius.value, page.drops.value = 180, 10, 50
    assert page.changed.is_set()  # by the controls' own callbacks
    found = page.update(pause=0.0)
    assert found.drops == 50 and "cup" not in found.answer.functions and page.bars["cup"][1].value < 50
    page.object.value, page.tilt.value = "dining_table_03", 0
    assert page.update(pause=0.0).answer.functions == {"table"}


def test_a_missing_package_is_one_line(monkeypatch):
    monkeypatch.setitem(sys.modules, "viser", None)
    with pytest.raises(InputError, match=r"pip install 'spherefunc-bullet\[viser\]'"):
        application("demo")(["demo", "--live"], standalone_mode=False)
