"""The resting profile: true of piles that are known by thought, whatever the heading and the place."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import ConvexHull, cKDTree
from scipy.special import expit, logit
from sklearn.base import clone

from spherefunc_bullet.learning import function_classifier
from spherefunc_bullet.learning.function_classifier import FunctionClassifier
from spherefunc_bullet.learning.profiles.calibration import (
    COPY_WEIGHT,
    UNCALIBRATED,
    VOTE_MARGIN,
    calibrated,
    fit_calibration,
    group_copies,
    log_odds,
)
from spherefunc_bullet.learning.profiles.columns import columns_of, largest_piece, near_pairs, outline_of, pieces_of
from spherefunc_bullet.learning.profiles.quantities import NAMES, QUANTITIES, Ranks, profiles_over
from spherefunc_bullet.learning.resting_profile import RestingProfile
from spherefunc_bullet.settling.drops import NO_DROPS, Drops, drops_from_rows, resting_drops

RADIUS = 0.02
DIAMETER = 2 * RADIUS


def layer(columns: int, rows: int, height: float, corner=(0.0, 0.0)) -> np.ndarray:
    """Return spheres side by side that rest on a level surface at a height."""
    x, y = np.meshgrid(np.arange(columns) * DIAMETER, np.arange(rows) * DIAMETER)
    return np.column_stack([x.ravel() + corner[0], y.ravel() + corner[1], np.full(x.size, height + RADIUS)])


def filled(layers: int, across: int, floor: float) -> np.ndarray:
    """Return straight stacks of spheres within a round wall, as many across as said."""
    square = layer(across, across, floor)
    middle = square.mean(axis=0)
    disc = square[np.hypot(*(square - middle)[:, :2].T) <= across * RADIUS]
    return np.concatenate([disc + [0, 0, level * DIAMETER] for level in range(layers)])


def chair() -> np.ndarray:
    """Return a seat one sphere deep at 40 cm, and a row of spheres on a back's edge at 80 cm, behind one side."""
    return np.concatenate([layer(8, 8, 0.4), layer(8, 1, 0.8, corner=(0, -DIAMETER))])


def heap(seed: int, count: int = 200) -> np.ndarray:
    """Return spheres in no order, more of them low than high."""
    generator = np.random.default_rng(seed)
    return generator.uniform([-0.3, -0.2, 0], [0.3, 0.2, 0.4], (count, 3)) * [1, 1, 0.6]


def turned(centers: np.ndarray, angle: float) -> np.ndarray:
    cos, sin = np.cos(angle), np.sin(angle)
    return centers @ np.array([[cos, sin, 0], [-sin, cos, 0], [0, 0, 1]])


def dropped(centers: np.ndarray, lost=()) -> Drops:
    """Return drops that settled where they fell, and of columns (L, 2) those that did not, last."""
    settled = np.column_stack([centers[:, :2], centers, np.zeros(len(centers))])
    gone = np.full((len(lost), 6), np.nan)
    gone[:, :2] = np.reshape(lost, (-1, 2))
    return drops_from_rows(RADIUS, np.concatenate([settled, gone]))


def quantities(centers: np.ndarray, radius: float = RADIUS, lost=()) -> dict[str, float]:
    return quantities_of(dropped(centers, lost), radius)


def quantities_of(drops: Drops | np.ndarray, radius: float = RADIUS) -> dict[str, float]:
    return dict(zip(NAMES, RestingProfile(radius).transform([drops])[0].tolist(), strict=True))


def test_one_layer_on_a_square_plate():
    found = quantities(layer(8, 8, 0.4))
    side = 8 * DIAMETER
    rounded = side**2 - (4 - np.pi) * RADIUS**2  # spheres in the corners are round
    assert found["settled"] == 64
    assert (found["level_height"], found["high_bottom"]) == pytest.approx((0.4, 0.4))
    assert found["one_deep"] == found["level_share"] == found["level_piece"] == 1
    assert (found["level_area"], found["area"]) == pytest.approx((rounded, rounded))
    assert (found["level_width"], found["width"]) == pytest.approx((side, side))
    assert found["level_depth"] == pytest.approx(DIAMETER)
    assert found["on_spheres"] == 0


def test_a_filled_cylinder_is_as_deep_along_its_wall_as_in_its_middle():
    found = quantities(filled(5, 7, 0.01))
    assert found["level_depth"] == pytest.approx(5 * DIAMETER)
    assert found["high_top"] == pytest.approx(0.01 + 5 * DIAMETER)
    assert found["one_deep"] == 0
    assert found["rim_to_middle"] == pytest.approx(1)
    assert found["on_spheres"] == pytest.approx(4 / 5)
    assert found["level_height"] == pytest.approx(0.01)


def test_a_heap_without_walls_is_shallow_along_its_outline():
    heap = np.concatenate([layer(9 - 2 * k, 9 - 2 * k, k * DIAMETER, (k * DIAMETER,) * 2) for k in range(4)])
    assert quantities(heap)["rim_to_middle"] < 0.7


def test_a_back_is_higher_than_the_seat_which_carries_most():
    found = quantities(chair())
    assert (found["level_height"], found["middle_bottom"]) == pytest.approx((0.4, 0.4))
    assert found["high_bottom"] == pytest.approx(0.8)  # the back carries 8 columns of 72, more than a tenth
    assert found["level_share"] == pytest.approx(64 / 72)
    assert found["level_area_share"] < 1


def test_a_slope_is_no_roughness():
    slope = layer(8, 8, 0.4)
    slope[:, 2] += 0.1 * slope[:, 0]
    found = quantities(slope)
    assert found["level_tilt"] == pytest.approx(np.degrees(np.arctan(0.1)))
    assert found["level_roughness"] == pytest.approx(0, abs=1e-12)
    assert quantities(layer(8, 8, 0.4))["level_range"] == pytest.approx(0, abs=1e-12)


@pytest.mark.parametrize("gap", [0.0, 0.05])
def test_large_spheres_that_hang_over_small_ones_show_a_gap(gap):
    small = layer(12, 12, 0.4)
    large = small[::7] + [0, 0, gap + 2 * RADIUS]  # three times the radius, the same underside where the gap is 0
    apart = large[[0, 8, -1]]
    drops = {RADIUS: dropped(small), 3 * RADIUS: dropped(apart)}
    found = dict(zip(NAMES, profiles_over([drops], (RADIUS, 3 * RADIUS))[0, len(NAMES) :].tolist(), strict=True))
    assert (found["gap"], found["middle_gap"]) == pytest.approx((gap, gap), abs=1e-9)
    assert found["over_gaps"] == (gap > 0)


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("make", [heap, lambda seed: chair() + np.random.default_rng(seed).normal(0, 1e-3, (72, 3))])
def test_heading_and_place_change_nothing(make, seed):
    generator, centers = np.random.default_rng(seed), make(seed)
    other = turned(centers, generator.uniform(0, 2 * np.pi)) + [*generator.uniform(-2, 2, 2), 0]
    # Coordinates of a metre have a rounding error of 2e-16, lengths some hundred times that after the sums; no
    # neighbour of a random heap lies so near to a threshold.
    np.testing.assert_allclose(*rows_of(centers, other), rtol=1e-7, atol=1e-9)


def rows_of(*piles: np.ndarray) -> np.ndarray:
    return RestingProfile(RADIUS).transform([dropped(centers) for centers in piles])


def test_what_falls_through_is_counted_where_it_falls():
    whole = quantities(layer(8, 8, 0.4), lost=[(2.0, 2.0)] * 9)  # beside the plate, which tells nothing
    assert whole["stays"] == whole["level_stays"] == 1
    holed = np.delete(layer(8, 8, 0.4), [27, 28, 35, 36], axis=0)
    drops = dropped(holed, lost=layer(8, 8, 0.4)[[27, 28, 35, 36], :2]).rows()
    found = quantities_of(np.concatenate([drops[-4:], drops[:-4]]))  # those through the hole came first
    assert found["stays"] == pytest.approx(60 / 64)
    assert found["middle_stays"] < 0.8 < found["stays_early"] < 1


def test_a_full_cup_lets_spheres_go_late_and_not_early():
    heap = filled(5, 7, 0.01)
    found = quantities(heap, lost=np.tile(heap[:, :2].mean(axis=0), (300, 1)))
    assert found["stays"] < 0.4 and found["stays_early"] == found["middle_stays"] == 1


def test_early_is_until_half_of_all_that_settled_had_settled():
    """What is lost between the first half and the second counts as late, and before the first half as early."""
    drops = dropped(layer(8, 8, 0.4), lost=np.full((36, 2), 3.5 * DIAMETER)).rows()  # over the middle of the plate
    first, second, lost = drops[:32], drops[32:64], drops[64:]
    between = quantities_of(np.concatenate([first, second[:1], lost, second[1:]]))
    assert between["stays_early"] == between["middle_stays"] == between["level_stays"] == 1
    assert between["stays"] == pytest.approx(64 / 100)
    before = quantities_of(np.concatenate([lost, drops[:64]]))
    assert before["stays_early"] == pytest.approx(33 / 69) and before["stays"] == between["stays"]


@pytest.mark.parametrize(("steep_deg", "rests"), [(10, 0), (20, 1), (45, 1), (90, 1)])
def test_a_sphere_rests_on_one_that_it_touches_a_quarter_lower(steep_deg, rests):
    """Side by side on a floor that is not quite even is not one on the other; leaning on it, as in a pile, is."""
    steep = np.radians(steep_deg)
    pair = np.array([[0, 0, 0.4], [DIAMETER * np.cos(steep), 0, 0.4 + DIAMETER * np.sin(steep)]])
    assert quantities(pair)["on_spheres"] == rests / 2
    apart = pair + [[0, 0, 0], [0, 0.1 * DIAMETER + DIAMETER, 0]]  # which touch nothing
    assert quantities(apart)["on_spheres"] == 0


def test_a_sphere_in_the_dip_between_four_rests_on_them():
    dip = np.array([[RADIUS, RADIUS, 0.4 + RADIUS + np.sqrt(2) * RADIUS]])
    assert quantities(np.concatenate([layer(2, 2, 0.4), dip]))["on_spheres"] == pytest.approx(1 / 5)


def test_of_two_levels_that_carry_as_much_the_upper_one_is_the_level():
    shelves = np.concatenate([layer(4, 4, 0.4), layer(4, 4, 0.8, corner=(0.5, 0)), layer(3, 3, 1.2, corner=(1, 0))])
    assert quantities(shelves)["level_height"] == pytest.approx(0.8)


def test_a_level_is_what_begins_within_a_radius_of_it():
    for above, share in ((0.9, 1.0), (1.5, 25 / 29)):
        other = layer(2, 2, 0.4 + above * RADIUS, corner=(0.5, 0))
        assert quantities(np.concatenate([layer(5, 5, 0.4), other]))["level_share"] == pytest.approx(share)


def test_the_way_from_fall_to_rest_is_in_radii():
    drops = dropped(layer(8, 8, 0.4))
    begun = drops.places + [3 * RADIUS, 0]
    assert quantities_of(replace(drops, places=begun))["rolled"] == pytest.approx(3)


ODD = {
    "none": np.empty((0, 3)),
    "one": np.array([[0.1, 0.2, 0.3]]),
    "two": np.array([[0.1, 0.2, 0.3], [0.2, 0.2, 0.3]]),
    "one column": np.array([[0, 0, RADIUS + k * DIAMETER] for k in range(6)]),
    "one row": layer(9, 1, 0.4),
    "the same place": np.zeros((5, 3)),
    "float32": heap(1).astype(np.float32),
}


@pytest.mark.parametrize("name", ODD)
def test_every_quantity_is_finite(name):
    row = RestingProfile(RADIUS).transform([dropped(ODD[name])])
    assert row.shape == (1, len(NAMES)) and np.isfinite(row).all()


@pytest.mark.filterwarnings("error")
def test_of_resting_places_alone_all_but_two_quantities_are_known():
    """Nobody looked whether walls are around them, nor where they were dropped."""
    row = RestingProfile(RADIUS).transform([resting_drops(RADIUS, heap(1))])[0]
    assert {name for name, value in zip(NAMES, row, strict=True) if np.isnan(value)} == {"walled_in", "rolled"}


def test_where_nothing_settled_every_quantity_is_none():
    rows = RestingProfile(RADIUS).transform([dropped(np.empty((0, 3)), lost=[(0, 0), (1, 1)]), NO_DROPS])
    assert not rows.any() and rows.shape == (2, len(NAMES))


def test_no_objects_have_no_rows():
    assert RestingProfile().transform([]).shape == (0, len(NAMES))


def test_quantities_are_named_and_said_once():
    assert len(set(NAMES)) == len(QUANTITIES)
    assert RestingProfile().get_feature_names_out().tolist() == list(NAMES)
    assert {quantity.unit for quantity in QUANTITIES} <= {"m", "m2", "share", "spheres", "ratio", "radii", "degrees"}


def test_shares_are_shares():
    rows = rows_of(*(heap(seed) for seed in range(4)), chair())
    for quantity, column in zip(QUANTITIES, rows.T, strict=True):
        if quantity.unit == "share":
            assert (column >= 0).all() and (column <= 1 + 1e-9).all(), quantity.name


def test_transformer_keeps_sklearns_contract():
    profile, objects = RestingProfile(0.03), [dropped(heap(0))]
    assert clone(profile).get_params()["radius"] == 0.03
    assert profile.fit_transform(objects).tolist() == profile.transform(objects).tolist()


@pytest.mark.parametrize("width", [2, 3])
@pytest.mark.parametrize("decimals", [2, 15])  # in a grid many distances are as long as what is asked for
def test_pairs_and_pieces_are_those_of_scipy(width, decimals):
    for seed in range(20):
        points = np.random.default_rng(seed).random((10 * seed + 1, width)).round(decimals) * 0.2
        first, second = near_pairs(points, 0.02)
        asked = cKDTree(points).query_pairs(0.02)
        assert {tuple(sorted(pair)) for pair in zip(first.tolist(), second.tolist(), strict=True)} == asked
        assert len(first) == len(asked)
        graph = coo_matrix((np.ones(len(first)), (first, second)), shape=(len(points), len(points)))
        assert np.array_equal(pieces_of(len(points), first, second), connected_components(graph, directed=False)[1])


def test_outline_is_that_of_scipy():
    points = np.random.default_rng(3).random((200, 2))
    hull = ConvexHull(points)
    corners = outline_of(points, 0.0).corners
    assert {tuple(corner) for corner in corners} == {tuple(corner) for corner in points[hull.vertices]}
    assert outline_of(points, 0.0).area == pytest.approx(hull.volume, rel=1e-12)  # of 20 corners, rounded


def test_probabilities_are_those_of_scipy():
    votes = np.linspace(0, 1, 1001)
    # Two units in the last place are what logarithms and exponentials of two libraries may differ by.
    assert np.allclose(log_odds(votes), logit(np.clip(votes, VOTE_MARGIN, 1 - VOTE_MARGIN)), rtol=4e-16, atol=0)
    assert np.allclose(calibrated(votes, (2.5, -0.7)), expit(2.5 * log_odds(votes) - 0.7), rtol=4e-16, atol=0)
    assert calibrated(votes[:1], (1e9, 0.0)) == pytest.approx([0], abs=1e-300)


def test_outline_of_a_turned_rectangle():
    corners = np.array([[0, 0, 0], [0.6, 0, 0], [0.6, 0.2, 0], [0, 0.2, 0], [0.3, 0.1, 0]])
    outline = outline_of(turned(corners, 0.7)[:, :2], 0.0)
    assert (outline.area, outline.width) == pytest.approx((0.12, 0.2))


def test_pieces_of_a_level_are_told_apart():
    apart = np.concatenate([layer(6, 6, 0.4), layer(3, 3, 0.4, corner=(1.5, 0))])
    assert len(largest_piece(columns_of(apart, RADIUS))) == 36


RADII = (0.02, 0.03)


@pytest.fixture(autouse=True)
def small_forests(monkeypatch):
    """A tenth of the trees tells a layer from a chair, in a tenth of the time."""
    monkeypatch.setattr(function_classifier, "TREES", 30)


def toy(count: int, seed: int = 0) -> tuple[list[dict[float, np.ndarray]], list[str]]:
    """Return flat layers, which are tables, and chairs, of random sizes and headings."""
    generator, objects, labels = np.random.default_rng(seed), [], []
    for index in range(count):
        flat = index % 2 == 0
        size = generator.uniform(0.8, 1.2)
        centers = turned((layer(8, 8, 0.7) if flat else chair()) * size, generator.uniform(0, 6))
        objects.append({radius: dropped(centers) for radius in RADII})
        labels.append("table" if flat else "sittable")
    return objects, labels


def learnt(objects, labels, **options) -> FunctionClassifier:
    return FunctionClassifier(radii=RADII, **options).fit_settled(objects, labels, [str(k) for k in range(len(labels))])


def test_a_table_is_told_from_a_chair():
    classifier = learnt(*toy(24))
    objects, labels = toy(10, seed=1)
    answer = classifier.memberships_of(objects, any_heading=True)
    assert [[name for name, found in row.items() if found.member] for row in answer] == [[label] for label in labels]
    assert {row["table"].radius for row in answer} <= set(RADII)
    assert classifier.score_settled([]).shape == (0, 2)


def test_shuffled_labels_fall_to_chance():
    objects, labels = toy(60)
    shuffled = np.random.default_rng(0).permutation(labels).tolist()
    asked, truth = toy(60, seed=1)
    scores = learnt(objects, shuffled).score_settled(asked)[:, 1]
    right = np.mean((scores > 0.5) == [label == "table" for label in truth])
    assert abs(right - 0.5) < 0.3  # 60 coins have a standard deviation of 0.065; alike objects fall the same way


def test_same_seed_same_bits():
    objects, labels = toy(20)
    first, second, other = (learnt(objects, labels, random_state=seed).score_settled(objects) for seed in (0, 0, 1))
    assert first.tobytes() == second.tobytes() != other.tobytes()


def test_a_function_that_all_or_none_have_is_certain():
    objects, _ = toy(4)
    assert learnt(objects, ["table"] * 4).score_settled(objects).tolist() == [[1.0]] * 4


def test_lengths_must_agree():
    with pytest.raises(ValueError, match="2 objects, 1 labels and 2 names"):
        FunctionClassifier(radii=RADII).fit_settled(toy(2)[0], ["table"], ["a", "b"])


def test_columns_of_a_profile_are_named():
    objects, labels = toy(4)
    classifier = learnt(objects, labels)
    names = classifier.quantity_names()
    assert len(names) == classifier.profiles_.shape[1]
    assert "level_height at 3 cm" in names


def test_votes_that_lean_are_straightened():
    """Votes that stand for a probability in other odds are brought to it; with few examples they hardly move."""
    generator = np.random.default_rng(0)
    truth = generator.uniform(0.02, 0.98, 4000)
    members = generator.uniform(size=4000) < truth
    votes = 1 / (1 + np.exp(-0.5 * np.log(truth / (1 - truth)) + 1))
    line = fit_calibration(votes, members)
    # The slope's standard error with 4,000 examples is about 0.04, and an error of 0.1 in log odds is 0.025 at most.
    assert np.abs(calibrated(votes, line) - truth).max() < 0.05
    few = fit_calibration(votes[:4], members[:4])
    assert np.abs(np.subtract(few, UNCALIBRATED)).max() < 0.5


def test_growth_is_learning_everything():
    objects, labels = toy(20)
    names = [str(k) for k in range(20)]
    grown = FunctionClassifier(radii=RADII).fit_settled(objects[:12], labels[:12], names[:12])
    grown.add_settled(objects[12:], labels[12:], names[12:])
    whole = FunctionClassifier(radii=RADII).fit_settled(objects, labels, names)
    assert grown.score_settled(objects).tobytes() == whole.score_settled(objects).tobytes()


def test_copies_count_less_and_belong_to_their_original():
    copy_groups = group_copies(["a", "b", "a, holed", "b, holed", "other"], ["", "", "a", "b", "not learnt"])
    assert copy_groups.weights.tolist() == [1, 1, COPY_WEIGHT, COPY_WEIGHT, COPY_WEIGHT]
    assert (
        copy_groups.groups[2] == copy_groups.groups[0]
        and copy_groups.groups[3] == copy_groups.groups[1]
        and len(set(copy_groups.groups)) == 3
    )


def test_useless_copies_teach_what_is_missing():
    """Chairs whose every other sphere falls through are no seats to who has learnt some of them."""
    objects, labels = toy(24)
    broken = [{radius: letting_through(drops) for radius, drops in item.items()} for item in objects]
    names = [str(k) for k in range(24)]
    copies = [f"{name}, broken" for name in names]
    model = FunctionClassifier(radii=RADII).fit_settled(
        objects + broken, labels + ["none"] * 24, names + copies, [""] * 24 + names
    )
    asked, truth = toy(10, seed=1)
    column = [model.functions_.index(label) for label in truth]
    assert (model.score_settled(asked)[np.arange(10), column] > 0.5).all()
    useless = [{radius: letting_through(drops) for radius, drops in item.items()} for item in asked]
    assert (model.score_settled(useless) < 0.5).all()


def letting_through(drops: Drops) -> Drops:
    """Return drops of which every other one is lost."""
    rows = drops.rows()
    rows[::2, 2:] = np.nan
    return drops_from_rows(drops.radius, rows)


def test_rank_distances_know_no_units():
    learnt = np.random.default_rng(0).uniform(size=(30, 4))
    asked = learnt[:3] * 1.01
    scales = np.array([1, 100, 1e-3, 7])
    assert np.allclose(Ranks(learnt).distances(asked), Ranks(learnt * scales).distances(asked * scales))
    assert Ranks(learnt).distances(learnt).diagonal().tolist() == [0] * 30


def test_ranks_run_from_none_to_one():
    """Above all of ten is 1 and below all 0; of one of the ten half of itself is below it."""
    learnt = np.arange(10.0)[:, None]
    ranks = (np.arange(10) + 0.5) / 10
    assert Ranks(learnt).distances(np.array([[99.0], [-99.0]])) == pytest.approx(np.array([1 - ranks, ranks]))


def test_short_thresholds_change_no_vote():
    from sklearn.ensemble import ExtraTreesClassifier

    from spherefunc_bullet.learning.profiles.forest import forest_from_sklearn

    X = np.random.default_rng(0).uniform(size=(200, 4))
    grown = forest_from_sklearn(ExtraTreesClassifier(20, random_state=0).fit(X, X[:, 0] > X[:, 1]))
    short = grown.to_float32()
    assert (short.threshold == short.threshold.astype(np.float32)).all()
    # What trees compare are 32-bit numbers: those at a threshold, and their neighbours, are the ones that could differ.
    near = np.nextafter(grown.threshold[:, None].astype(np.float32), np.array([-np.inf, np.inf], np.float32))
    asked = np.vstack([X, np.repeat(near.ravel(), 4).reshape(-1, 4)])
    assert np.array_equal(grown.votes(asked), short.votes(asked))


def test_an_object_asked_again_is_told_by_what_was_learnt_since():
    objects, labels = toy(12)
    model = learnt(objects, labels)
    before = model.score_settled(objects[:1])
    assert np.array_equal(model.score_settled(objects[:1]), before)
    assert np.array_equal(model.score_settled(objects)[:1], before)
    swapped = ["sittable" if label == "table" else "table" for label in labels]
    names = [str(k) for k in range(12)]
    model.fit_settled(objects, swapped, names)
    assert np.abs(model.score_settled(objects[:1]) - before).max() > 0.5
