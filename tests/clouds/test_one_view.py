"""A cloud that is one view of an object: completed, and classified by the model for scans, as in a scene."""

from __future__ import annotations

import json
from types import SimpleNamespace

import numpy as np
import pytest
from clouds import mug
from commands import spherefunc
from room_shapes import box, square_table

import spherefunc_bullet as sf
from spherefunc_bullet import classification
from spherefunc_bullet.classification import COMPLETED, NOTHING_SETTLED, Decision, nothing_settled
from spherefunc_bullet.clouds.cloud import Cloud, Mesh
from spherefunc_bullet.clouds.one_view import looks_like_one_view
from spherefunc_bullet.function_model import Membership, Reading
from spherefunc_bullet.settling.drops import drops_from_rows


@pytest.fixture(scope="module")
def seen_mug() -> np.ndarray:
    """A mug's wall as a camera in front of it and above sees it: outside nearer, inside farther, no bottom."""
    points = mug().points
    wall = points[points[:, 2] > 0.012]
    radius = np.linalg.norm(wall[:, :2], axis=1)
    return wall[(radius > 0.9 * radius.max()) & ((wall[:, 1] < 0) | (wall[:, 2] > 0.03))]


def test_a_mug_s_view_is_told_as_in_a_scene_and_unsure(seen_mug):
    answer = sf.classify(seen_mug)
    assert answer.functions == {"cup"}
    assert answer.unsure
    assert answer.reasons[-1] == COMPLETED


def test_hardly_a_sphere_is_as_good_as_none():
    lost, held = np.full((200, 6), np.nan, np.float32), np.zeros((200, 6), np.float32)
    few = np.vstack([lost[:197], held[:3]])
    for rows, nothing in ((few, True), (held, False)):
        drops = {0.01: drops_from_rows(0.01, lost), 0.03: drops_from_rows(0.03, rows)}
        assert nothing_settled(Reading(drops=drops, scores=np.zeros(1), model=None)) == nothing


@pytest.mark.parametrize(("score", "doubtful"), [(0.3, True), (0.1, False)])
def test_a_view_that_may_have_a_function_when_completed_is_unsure(monkeypatch, score, doubtful):
    held = {0.01: drops_from_rows(0.01, np.zeros((200, 6), np.float32))}
    has_none = SimpleNamespace(functions_=("cup",), memberships_by=lambda scores: [{}])
    first = Decision(model=has_none, reading=Reading(drops=held, scores=np.zeros(1), model=None))
    completed = SimpleNamespace(
        functions=frozenset(),
        memberships={"cup": Membership(member=False, score=score, radius=0.01)},
        reading=first.reading,
    )
    monkeypatch.setattr(classification, "completed_clouds", lambda cloud: [cloud])
    monkeypatch.setattr(classification, "decide", lambda item, model: completed)
    view, model = SimpleNamespace(cloud=mug), SimpleNamespace(drop_config=lambda: None)
    found = classification.reclassify_completed(view, first, model)
    assert bool(found.more_doubts) == doubtful and all("cup" in doubt for doubt in found.more_doubts)


def test_whole_objects_are_told_as_before():
    for points in (mug().points, box(0.3, 0.3, 0.3), square_table(1.2, 0.8, 0.72)[::4]):
        reasons = sf.classify(points).reasons
        assert COMPLETED not in reasons and NOTHING_SETTLED not in reasons


def test_what_has_an_underside_is_no_view(seen_mug):
    assert looks_like_one_view(Cloud(seen_mug))
    assert not looks_like_one_view(Cloud(mug().points))


def test_the_command_says_the_same(seen_mug, tmp_path):
    np.savetxt(tmp_path / "view.xyz", seen_mug)
    (row,) = json.loads(spherefunc("classify", tmp_path / "view.xyz", "--json").stdout)
    assert row["functions"]["cup"]["member"]
    assert row["unsure"]
    assert row["reasons"][-1] == COMPLETED


def square(side: float, height: float) -> np.ndarray:
    """Return points 2 mm apart on a level square, in the middle of the squares of 5 mm that are counted, or not."""
    steps = np.arange(0.001, side, 0.002)
    return np.array([[x - side / 2, y - side / 2, height] for x in steps for y in steps])


@pytest.mark.parametrize(("share", "is_view"), [(0.4, True), (0.6, False)])
@pytest.mark.parametrize(("size", "low"), [(0.2, 0.0), (0.2, 0.017), (0.05, 0.013)])
def test_half_of_the_ground_below_is_an_underside(share, is_view, size, low):
    """Within a tenth of the height, or 15 mm, above the lowest point; what lies higher is not of it."""
    foot = np.array([[0.0, 0.0, 0.0]])
    top = square(0.2, size)
    points = np.concatenate([foot, top, square(0.2 * share**0.5, low)])
    assert looks_like_one_view(Cloud(points)) == looks_like_one_view(Cloud(points + [0, 0, 0.7])) == is_view
    assert looks_like_one_view(Cloud(np.concatenate([foot, top, square(0.2 * share**0.5, max(0.15 * size, 0.02))])))


def test_the_foot_of_a_wall_is_no_underside():
    """However many of its points lie one above another."""
    angle, z = np.meshgrid(np.linspace(0, 2 * np.pi, 120), np.arange(0, 0.1, 0.002))
    wall = np.column_stack([0.03 * np.cos(angle).ravel(), 0.03 * np.sin(angle).ravel(), z.ravel()])
    assert looks_like_one_view(Cloud(wall)) and looks_like_one_view(Cloud(wall[abs(wall[:, 1]) < 1e-9]))
    disc = square(0.06, 0.0)
    assert not looks_like_one_view(Cloud(np.concatenate([wall, disc[np.hypot(*disc[:, :2].T) < 0.03]])))


def test_what_came_with_its_surface_is_no_view():
    points = np.concatenate([square(0.2, 0.3), [[0.0, 0.0, 0.0]]])
    surface = Mesh(points, np.array([[0, 1, 2]]))
    assert looks_like_one_view(Cloud(points)) and not looks_like_one_view(Cloud(points, "it", surface))
