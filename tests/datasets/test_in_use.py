"""Objects in use and as sensed: askew and sparse clouds are mended, exact ones stay, copies are what they say."""

from __future__ import annotations

import itertools
from types import SimpleNamespace

import clouds
import numpy as np
import pytest
import trimesh
from catalogues import household

from spherefunc_bullet.clouds.cloud import Cloud, cloud_from_mesh, placed
from spherefunc_bullet.clouds.outline import hull_corners
from spherefunc_bullet.clouds.preparation import filled, headed, levelled, prepare, rotation_to_z, turned_cloud
from spherefunc_bullet.compare.evaluation.evaluation import Trial
from spherefunc_bullet.compare.evaluation.protocol import Labels
from spherefunc_bullet.compare.evaluation.robustness.corruptions import rates_of
from spherefunc_bullet.datasets.dataset import DatasetObject, sources_of
from spherefunc_bullet.learning.profiles.calibration import UNCERTAIN_MARGIN, WIDEST_MARGIN, unsure_range
from spherefunc_bullet.learning.profiles.columns import objects_on_table
from spherefunc_bullet.scenes.impairment.specimen import Specimen
from spherefunc_bullet.scenes.impairment.surfaces import ObjectSurface
from spherefunc_bullet.scenes.impairment.use.copies import AS_SENSED, BESIDE, IN_USE, coat_over_back, places_to_sit
from spherefunc_bullet.scenes.impairment.use.placing import upright_box
from spherefunc_bullet.scenes.impairment.use.sensed import CORRUPTIONS, corrupted
from spherefunc_bullet.settling.drops import RunLimit
from spherefunc_bullet.settling.settling import settle

DROPS = RunLimit(drops=200)


@pytest.fixture(scope="module")
def specimens() -> dict[str, Specimen]:
    """Return a mug, a chair and a table of the catalogue."""
    wanted = {"mug": "cup", "dining_chair": "sittable", "dining_table": "table"}
    found = {item.category: item for item in reversed(household()) if item.category in wanted}
    return {
        label: Specimen(cloud_from_mesh(found[kind].mesh.vertices, found[kind].mesh.faces, kind), label)
        for kind, label in wanted.items()
        if kind in found
    }


def tilted(cloud: Cloud, degrees: float) -> Cloud:
    angle = np.radians(degrees)
    rotation = rotation_to_z(np.array([np.sin(angle) * 0.6, np.sin(angle) * 0.8, np.cos(angle)]))
    return Cloud(placed(cloud.points @ rotation.T), cloud.name)


def cloud_of(surface: ObjectSurface) -> Cloud:
    return cloud_from_mesh(*surface.standing().mesh(), "copy")


def test_what_is_level_and_dense_stays_as_it_is(specimens):
    for specimen in specimens.values():
        assert prepare(specimen.cloud) is specimen.cloud


@pytest.mark.parametrize("degrees", [3.0, 6.0, 9.5])
def test_askew_objects_are_levelled(specimens, degrees):
    # Feet decide to the thickness of the layer that counts as the ground: a fifth of a per cent of the extent.
    for specimen in specimens.values():
        found = levelled(tilted(specimen.cloud, degrees))
        assert np.ptp(found.points[:, 2]) == pytest.approx(specimen.cloud.size[2], rel=0.03)


def test_what_lies_over_is_no_tilt(specimens):
    over = tilted(specimens["table"].cloud, 25.0)
    assert levelled(over) is over


def test_sparse_cups_hold_spheres_again():
    mug, rng = clouds.mug(), np.random.default_rng(0)
    few = Cloud(placed(mug.points[rng.choice(len(mug), len(mug) // 6, replace=False)]), "few")
    whole, gaps, mended = (settle(one, "fast", (0.005,), 0, DROPS)[0.005] for one in (mug, few, filled(few)))
    assert abs(len(mended.rests) - len(whole.rests)) < 0.35 * len(whole.rests)
    assert abs(len(mended.rests) - len(whole.rests)) <= abs(len(gaps.rests) - len(whole.rests))


def test_filling_adds_nothing_away_from_the_surface():
    plate = clouds.plate()
    few = Cloud(plate.points[np.random.default_rng(1).choice(len(plate), len(plate) // 8, replace=False)], "few")
    more = filled(few)
    assert len(more) > 2 * len(few)
    assert plate.tree.query(more.points - more.points.min(axis=0) + few.points.min(axis=0))[0].max() < 0.006


def test_outlines_are_qhull_s(specimens):
    from scipy.spatial import ConvexHull

    rng = np.random.default_rng(0)
    random = [rng.normal(size=(500, 2)), rng.integers(0, 9, (400, 2)) / 7, rng.integers(0, 2, (9, 2)).astype(float)]
    for points in [*random, *(one.cloud.points[:, :2] for one in specimens.values())]:
        own = {tuple(corner) for corner in hull_corners(points).round(9)}
        assert own == {tuple(corner) for corner in points[ConvexHull(points).vertices].round(9)}
    line = np.column_stack([np.linspace(0, 1, 7)] * 2)
    assert len(hull_corners(line)) == 2 and len(hull_corners(line[:1])) == 1  # no outline, and no error


@pytest.mark.parametrize("degrees", [20, 45, 77])
def test_headings_are_one(specimens, degrees):
    table = specimens["table"].cloud
    back, angle = headed(turned_cloud(table, np.radians(degrees)))
    assert np.sort(back.size) == pytest.approx(np.sort(table.size), rel=0.01)
    assert headed(table) == (table, 0.0)
    # Drops are given where the object is, not where it was turned to.
    drops = settle(turned_cloud(table, np.radians(degrees)), "fast", (0.03,), 0, DROPS)[0.03]
    tree = turned_cloud(table, np.radians(degrees)).tree
    assert tree.query(drops.rests[drops.rests[:, 2] > 0.5])[0].max() < 0.035


def armchair(heading_deg: float) -> trimesh.Trimesh:
    """Return a chair with arms as long as the seat is deep, and a back that leans away from it by 22 degrees."""
    back = trimesh.creation.box((0.6, 0.05, 0.55))
    back.apply_transform(trimesh.transformations.rotation_matrix(np.radians(-22), [1, 0, 0]))
    back.apply_translation((0, 0.38, 0.72))
    bounds = [((-0.3, -0.3, 0.0), (0.3, 0.3, 0.45))]
    bounds += [((x, -0.3, 0.0), (x + 0.1, 0.3, 0.68)) for x in (-0.4, 0.3)]
    parts = [back, *(trimesh.creation.box(bounds=one) for one in bounds)]
    turn = trimesh.transformations.rotation_matrix(np.radians(heading_deg), [0, 0, 1])
    return trimesh.util.concatenate(parts).apply_transform(turn)


@pytest.mark.slow
@pytest.mark.parametrize("heading_deg", [0, 90, 180, 270])
def test_a_coat_hangs_over_the_back_and_leaves_the_seat_free(heading_deg):
    mesh = armchair(heading_deg)
    chair = Specimen(cloud_from_mesh(mesh.vertices, mesh.faces, "armchair"), "sittable")
    for seed in range(4):
        coat = coat_over_back(chair, chair.level, np.random.default_rng(seed))
        cloth = trimesh.Trimesh(**trimesh.triangles.to_kwargs(coat)).subdivide_to_size(0.02).vertices
        # The back begins 0.56 m behind the front of the seat; a coat is at most 4 cm thick.
        front = (chair.cloud.points[:, :2] @ chair.back).min()
        assert (cloth[:, :2] @ chair.back > front + 0.56 - 0.04).all()
        # Three thicknesses at most: its own, off at a corner, and as much as the back leans within a strip (2 cm).
        assert chair.cloud.tree.query(cloth)[0].max() < 0.12
        assert np.ptp(cloth[:, 2]) > 0.3


@pytest.mark.slow
def test_every_kind_of_use_is_made(specimens):
    for impairment in (*IN_USE, *AS_SENSED):
        for label in set(impairment.functions) & specimens.keys():
            copy = impairment.applied(specimens[label], "some", 0)
            again = impairment.applied(specimens[label], "some", 0)
            if copy is None:  # a cloth that is larger than what is left of the table
                assert again is None and impairment.kind == "cloth"
                continue
            assert np.array_equal(copy.vertices, again.vertices), impairment.kind
            assert copy.bounds[0, 2] == pytest.approx(0, abs=1e-9)


@pytest.mark.parametrize(("width", "count"), [(0.45, 1), (1.6, 3), (2.6, 5)])
def test_a_seat_is_taken_when_nobody_else_has_room(width, count):
    """One on a chair, and on a bench one every half a metre, in one row."""
    bench = trimesh.creation.box((width, 0.4, 0.45))
    seat = Specimen(cloud_from_mesh(bench.vertices, bench.faces, "bench"), "sittable").level
    places = np.array(places_to_sit(seat, np.array([0.0, 1.0])))
    assert len(places) == count and np.abs(places[:, 1]).max() < 0.06  # cells are up to 5.4 cm wide
    apart = np.linalg.norm(seat.grid.places(seat.flat)[:, None] - places, axis=2).min(axis=1)
    assert apart.max() <= BESIDE


def test_laid_tables_keep_their_top_and_count_what_stands_on_it(specimens):
    table, height = specimens["table"], specimens["table"].level.height
    boxes = [upright_box(np.array([0.15, 0.2, 0.05 + 0.1 * k])) + [0.4 * k - 0.4, 0, height] for k in range(3)]
    for count in (0, 1, 3):
        surface = table.surface.joined(ObjectSurface(np.concatenate(boxes[:count]))) if count else table.surface
        cloud = cloud_of(surface)
        assert objects_on_table(cloud, settle(cloud, "fast", (0.01, 0.03), 0, DROPS)) == count


@pytest.mark.parametrize("seen", ["noise", "stray points"])
@pytest.mark.parametrize("count", [0, 2])
def test_noise_and_stray_points_on_a_table_are_no_objects(specimens, seen, count):
    table, rng = specimens["table"], np.random.default_rng(0)
    height = table.level.height
    boxes = [upright_box(np.array([0.15, 0.2, tall])) + [x, 0, height] for x, tall in ((-0.3, 0.1), (0.2, 0.2))]
    points = (
        cloud_of(table.surface.joined(ObjectSurface(np.concatenate(boxes)))).points if count else table.cloud.points
    )
    if seen == "noise":
        points = points + rng.normal(0, 0.005, points.shape)
    else:
        low, high = points.min(axis=0), points.max(axis=0) + [0, 0, 0.3]
        points = np.concatenate([points, rng.uniform(low, high, (len(points) // 200, 3))])
    cloud = Cloud(points, "as a sensor sees it")
    assert objects_on_table(cloud, settle(cloud, "fast", (0.01, 0.03), 0, DROPS)) == count


@pytest.mark.parametrize("kind", CORRUPTIONS)
def test_corruptions_are_the_same_again(kind):
    flat = clouds.plate(0.3, 0.2, 0.002).points  # of which nothing is higher than a crumb
    for points, severity in itertools.product((clouds.mug().points, flat), (1, 3, 5)):
        once, again = (corrupted(points, kind, severity, np.random.default_rng(7)) for _ in range(2))
        assert np.array_equal(once, again)
        assert once[:, 2].min() == pytest.approx(0) and len(once) >= 50


def test_an_unsure_band_keeps_the_wrong_inside():
    members = np.arange(1000) < 500
    scores = np.where(members, 0.95, 0.05)
    assert unsure_range(scores, members) == pytest.approx((0.5 - UNCERTAIN_MARGIN, 0.5 + UNCERTAIN_MARGIN))
    wrong = scores.copy()
    wrong[:20], wrong[-20:] = 0.2, 0.8  # two per cent either way: more than may be wrong and sure
    low, high = unsure_range(wrong, members)
    assert low <= 0.2 and high >= 0.8
    assert unsure_range(1 - scores, members) == pytest.approx((0.5 - WIDEST_MARGIN, 0.5 + WIDEST_MARGIN))


def test_rates_are_counted_by_kind_and_severity():
    members = np.array([[True], [False]] * 2)
    labels = Labels(("cup",), members, np.zeros_like(members), np.array(["a"] * 4))
    asked = SimpleNamespace(whole=0, kinds=[("noise", "1")] * 2 + [("noise", "2")] * 2)
    scores = np.array([[0.9], [0.1], [0.2], [0.45]])
    rates = rates_of(asked, labels, [Trial(learnt=1, rows=np.arange(4), scores=scores, weights=())])
    assert rates["noise"]["1"] == {"told": 1.0, "unsure": 0.0, "wrong_and_sure": 0.0}
    assert rates["noise"]["2"] == {"told": 0.0, "unsure": 0.5, "wrong_and_sure": 0.5}


def test_sources_are_those_that_state_a_licence(tmp_path):
    objects = [
        DatasetObject(path=tmp_path, functions=frozenset(), group="lab", source="A lab", license="BSD-3-Clause"),
        DatasetObject(path=tmp_path, functions=frozenset(), group="household"),
    ]
    assert sources_of(objects) == ["lab", ""]
