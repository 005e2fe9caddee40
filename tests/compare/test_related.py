"""Rules and examiners: plain objects are classified by their measures, and not when what serves is taken away."""

from __future__ import annotations

from functools import partial
from pathlib import Path

import numpy as np
import pytest
import trimesh
from objects_to_scan import slab_on_posts

from spherefunc_bullet.clouds.cloud import Cloud, cloud_from_mesh, cloud_from_points
from spherefunc_bullet.compare.evaluation.protocol import Labels, Protocol
from spherefunc_bullet.compare.evaluation.related.examiner import (
    RELATED,
    ball_bottoms,
    fixed,
    functions_by_agents,
    related,
)
from spherefunc_bullet.compare.evaluation.related.rules import (
    NOTHING,
    TopView,
    functions_by_rules,
    top_view,
    water_depths,
)
from spherefunc_bullet.settling.records import VOXEL, ObjectRecord, shape_of

RADIUS, HEIGHT, WALL, FLOOR = 0.04, 0.10, 0.004, 0.008  # of a mug, metres


def record(cloud: Cloud) -> ObjectRecord:
    """Return what the baselines see of a cloud."""
    shape = shape_of(cloud)
    occupied = partial(shape.get, "voxels")
    return ObjectRecord(path=Path("x"), size=shape["size"], occupied=occupied, settled={}, seconds={}, drops={})


def seen(mesh: trimesh.Trimesh) -> ObjectRecord:
    return record(cloud_from_mesh(mesh.vertices, mesh.faces))


def at(part: trimesh.Trimesh, *place: float) -> trimesh.Trimesh:
    """Return a part moved to a place, metres."""
    part.apply_translation(place)
    return part


def mug(hole: float = 0.0) -> trimesh.Trimesh:
    """Return a mug turned on a lathe with a handle to +x, and a hole of some radius in its bottom, metres."""
    inner = RADIUS - WALL
    profile = [(hole, 0), (RADIUS, 0), (RADIUS, HEIGHT), (inner, HEIGHT), (inner, FLOOR), (hole, FLOOR)]
    body = trimesh.creation.revolve(np.array([*profile, profile[0]] if hole else profile), sections=48)
    handle = trimesh.creation.torus(0.025, 0.005)
    handle.apply_transform(trimesh.transformations.rotation_matrix(np.pi / 2, [1, 0, 0]))
    return trimesh.util.concatenate([body, at(handle, RADIUS + 0.018, 0, 0.05)])


def chair(seat: bool = True) -> trimesh.Trimesh:
    """Return a chair with arms and a back to +y; without its seat, the frame and the legs stay."""
    parts = [
        at(trimesh.creation.box((0.5, 0.05, 0.5)), 0, 0.225, 0.7),
        *(at(trimesh.creation.box((0.04, 0.4, 0.2)), x, 0, 0.55) for x in (-0.23, 0.23)),
        *(at(trimesh.creation.box((0.04, 0.04, 0.45)), x, y, 0.225) for x in (-0.23, 0.23) for y in (-0.23, 0.23)),
        *(at(trimesh.creation.box((0.04, 0.5, 0.04)), x, 0, 0.43) for x in (-0.23, 0.23)),
    ]
    parts += [at(trimesh.creation.box((0.5, 0.5, 0.04)), 0, 0, 0.43)] if seat else []
    return trimesh.util.concatenate(parts)


def tilted(mesh: trimesh.Trimesh, degrees: float) -> trimesh.Trimesh:
    """Return a mesh tilted about x, and put on the ground again."""
    mesh.apply_transform(trimesh.transformations.rotation_matrix(np.radians(degrees), [1, 0, 0]))
    return at(mesh, 0, 0, -mesh.bounds[0, 2])


def turned(mesh: trimesh.Trimesh, degrees: float) -> trimesh.Trimesh:
    """Return a mesh turned about the vertical."""
    mesh.apply_transform(trimesh.transformations.rotation_matrix(np.radians(degrees), [0, 0, 1]))
    return mesh


def with_lid() -> trimesh.Trimesh:
    return trimesh.util.concatenate([mug(), at(trimesh.creation.cylinder(RADIUS, 0.004), 0, 0, HEIGHT)])


def spiky_table() -> trimesh.Trimesh:
    """Return a table with cones of 15 cm side by side all over its top."""
    places = [(x, y) for x in np.arange(-0.55, 0.6, 0.1) for y in np.arange(-0.35, 0.4, 0.1)]
    spikes = [at(trimesh.creation.cone(0.05, 0.15, sections=8), x, y, 0.74) for x, y in places]
    return trimesh.util.concatenate([slab_on_posts(1.2, 0.8, 0.74), *spikes])


THINGS = {
    "mug": (mug, {"cup"}),
    "chair": (chair, {"sittable"}),
    "stool": (lambda: slab_on_posts(0.36, 0.36, 0.45), {"sittable"}),
    "table": (lambda: slab_on_posts(1.2, 0.8, 0.74), {"table"}),
    "turned chair": (lambda: turned(chair(), 40), {"sittable"}),
    "turned table": (lambda: turned(slab_on_posts(1.2, 0.8, 0.74), 25), {"table"}),
    "mug with a lid": (with_lid, set()),
    "mug upside down": (lambda: tilted(mug(), 180), set()),
    "mug without a bottom": (lambda: mug(hole=0.03), set()),
    "chair without its seat": (lambda: chair(seat=False), set()),
    "seat that slopes": (lambda: tilted(slab_on_posts(0.4, 0.4, 0.45), 35), set()),
    "table of spikes": (spiky_table, set()),
    "bar stool": (lambda: slab_on_posts(0.3, 0.3, 0.75), set()),
    "shelf": (lambda: slab_on_posts(0.8, 0.25, 0.7), set()),
    "bathtub": (lambda: at(trimesh.creation.annulus(0.4, 0.45, 0.6), 0, 0, 0.3), set()),
}


@pytest.mark.parametrize("tell", RELATED.values(), ids=RELATED)
@pytest.mark.parametrize("item", THINGS)
def test_plain_things_are_told(item, tell):
    make, functions = THINGS[item]
    assert tell(seen(make())) == functions


def test_knees_tell_a_table_from_a_chest_and_rules_do_not():
    chest = seen(at(trimesh.creation.box((1.2, 0.8, 0.74)), 0, 0, 0.37))
    assert functions_by_rules(chest) == {"table"} and functions_by_agents(chest) == set()


def test_feet_need_ground_before_a_seat():
    # A level place at seat height behind a ledge as deep on all sides: a person's feet would stand in it.
    ledge = trimesh.util.concatenate(
        [at(trimesh.creation.box((1.4, 1.4, 0.3)), 0, 0, 0.15), at(trimesh.creation.box((0.4, 0.4, 0.15)), 0, 0, 0.375)]
    )
    assert functions_by_rules(seen(ledge)) == {"sittable"} and functions_by_agents(seen(ledge)) == set()


def test_water_stands_to_the_brim_and_no_higher():
    depths = water_depths(top_view(seen(mug())))
    assert depths.max() == pytest.approx(HEIGHT - FLOOR, abs=2 * VOXEL)  # a voxel at the floor and at the brim each
    # The wall takes all cells that it meets: up to a voxel on each side.
    volume = depths.sum() * VOXEL**2
    assert np.pi * (RADIUS - WALL - VOXEL) ** 2 * 0.082 <= volume <= np.pi * RADIUS**2 * HEIGHT


def test_a_ball_rests_on_points_and_reaches_into_holes_that_are_larger():
    heights = np.full((21, 21), NOTHING)
    heights[10, 10] = 0.1
    bottoms = ball_bottoms(TopView(heights=heights, cell=VOXEL), 0.015)
    assert bottoms[10, 10] == pytest.approx(0.1)
    assert bottoms[12, 10] == pytest.approx(0.1 - 0.015 + np.sqrt(0.015**2 - 0.01**2))
    assert bottoms[14, 10] == NOTHING


def test_the_top_view_is_the_highest_place_and_turns_with_the_object():
    bar = [[x, 0, z] for x in np.arange(-0.1, 0.1, 0.004) for z in (0, 0.3)]
    seen_bar = record(cloud_from_points(np.array(bar)))
    view = top_view(seen_bar)
    assert np.isfinite(view.heights).sum() == 40  # 20 cm
    assert np.allclose(view.heights[np.isfinite(view.heights)], 0.3, atol=VOXEL)  # nothing of what lies below
    assert top_view(seen_bar, below=0.1).heights.max() < 0.1
    assert top_view(seen_bar, below=0.1).heights.shape == view.heights.shape  # over the same ground
    # Turned by 60 degrees, it reaches over half as much ground in x, and the margin is free.
    wide = view.turned(60, 0.02, margin=0.1)
    x, y = np.nonzero(np.isfinite(wide.heights))
    assert np.ptp(x) + 1 == pytest.approx(10 * 0.5, abs=1) and np.ptp(y) + 1 == pytest.approx(10 * 0.87, abs=1)
    assert min(x.min(), y.min()) >= 5 and wide.heights.shape[0] - x.max() > 5


def test_scores_are_what_is_told_and_nothing_for_other_functions():
    labels = Labels(("bed", "table"), np.array([[0, 1], [1, 0]], bool), np.zeros((2, 2), bool), np.array(["a", "b"]))
    records = [seen(slab_on_posts(1.2, 0.8, 0.74)), seen(mug())]
    for read in related(records, labels).values():
        assert read.scores.tolist() == [[0, 1], [0, 0]]


def test_quality_is_that_of_the_tested_objects_only():
    # Four tables and four others; every second is classified wrongly, all of source b.
    members = np.array([[True], [False]] * 4)
    labels = Labels(("table",), members, np.zeros_like(members), np.array(["a", "a", "b", "b"] * 2))
    records = [seen(slab_on_posts(0.3, 0.3, 0.2))] * 8
    answers = iter([{"table"}, set(), set(), {"table"}] * 2)
    read = fixed(lambda record: frozenset(next(answers)), records, labels)
    splits = Protocol(train_sizes=(4,), trials=3, groups=True).splits(labels)
    evaluation = read.evaluation(splits)
    assert [trial.rows.tolist() for trial in evaluation.trials[4]] == [s.test.tolist() for s in splits.halves[4]]
    row = evaluation.left_out_quality("leave_one_group_out")["table"]
    assert (row["precision"], row["recall"], row["radius"]) == (0.5, 0.5, None)
    (only_a,) = read.trials([[split for split in splits.left_out["leave_one_group_out"] if 0 in split.test]])
    assert only_a.quality(labels, 0)[0].f_measure == 1
