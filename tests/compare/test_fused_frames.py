"""The study of fused depth images, in one room: its objects are found, and the one that is taken out is gone."""

from __future__ import annotations

import json

import pytest

from spherefunc_bullet.compare.rooms import fused_frames


@pytest.mark.slow
def test_objects_of_a_fused_room_are_found_and_a_removed_one_is_gone(monkeypatch, capsys):
    monkeypatch.setattr(fused_frames, "COUNTS", (1, 4))
    monkeypatch.setattr(fused_frames, "REMOVED_AFTER", 4)
    fused_frames.main("household", rooms=1, noise=1.0, pose_error=0.01, seed=0, json=True)
    report = json.loads(capsys.readouterr().out)
    assert [(row["images"], row["way"]) for row in report["f_measure"]] == [
        (images, way) for images in (1, 4) for way in fused_frames.WAYS
    ]
    after = next(row for row in report["f_measure"] if (row["images"], row["way"]) == (4, "fused"))
    assert min(after[name] for name in ("cup", "sittable", "table")) > 0.5
    aligned, as_given = report["agreement"]
    assert aligned > as_given
    ids = report["ids"]
    assert 0 < ids["kept"] <= ids["again"]
    assert (ids["removed"], ids["noticed"], ids["lost"]) == (1, 1, 0) and ids["stayed"] > 3
