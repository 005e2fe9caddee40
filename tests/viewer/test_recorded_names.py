"""Objects of one name in a recording: each is drawn under a name of its own."""

from __future__ import annotations

from pathlib import Path

import pytest

from spherefunc_bullet.commands.view import ViewedObject, record
from spherefunc_bullet.console import Failures


@pytest.mark.parametrize("files", [("lamp/model.obj", "mug/model.obj"), ("mug.ply", "mug.obj")])
def test_objects_of_one_name_are_not_drawn_over_each_other(monkeypatch, files):
    drawn = []
    monkeypatch.setattr("spherefunc_bullet.viewer.recording.write_recording", lambda named, path: drawn.extend(named))
    record([ViewedObject(Path(file), None, ()) for file in files], Path("drops.rrd"), Failures())
    names = [name for name, *_ in drawn]
    assert names == [Path(files[0]).stem, f"{Path(files[0]).stem}_2"]
