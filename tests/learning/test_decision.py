"""What is decided of an object, given what a model says and what is asked about the object: without a sphere."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from cloud_files import mug
from test_doubts import shelf

from spherefunc_bullet import classification
from spherefunc_bullet.classification import (
    COMPLETED,
    FALLS_OVER,
    LEAKS,
    NO_PLACE,
    NOTHING_SETTLED,
    ON_TOP,
    PARTLY_SEEN,
    POSSIBLE,
    WRONG_UP_AXIS,
    classify,
    classify_by_all,
    nothing_settled,
    stands_with_y_up,
)
from spherefunc_bullet.clouds.cloud import Cloud, cloud_from_mesh
from spherefunc_bullet.function_model import THRESHOLD, FunctionModel, Reading
from spherefunc_bullet.learning.cube_classifier import CubeClassifier
from spherefunc_bullet.settling.drops import FEW, RunLimit

RADIUS = 0.02
REASON, DOUBT = "it is so", "it may be otherwise"
A_LITTLE = 1e-3
CUP_CHECKS = ("leaks", "points_leak")
SEAT_CHECKS = ("nowhere_to_sit", "spikes", "level_nowhere")


class Model(FunctionModel):
    """A model that gives every object the same scores, on which so many spheres stay."""

    simulator, radii, seed, run_limit = "fast", (RADIUS,), 0, RunLimit(drops=40)

    def __init__(self, *, stays: int = 40, checks: bool = True, on_top: int = 0, **scores: float):
        self.functions_, self.given = tuple(scores), np.array([*scores.values()])
        self.radius_, self.checks_stability = dict.fromkeys(scores, RADIUS), checks
        self.stays, self.on_top = stays, on_top

    def read(self, drop) -> Reading:
        return Reading(drops={RADIUS: shelf(0.4, RADIUS, stays=self.stays)}, scores=self.given, model=self)

    def score_settled(self, settled, *, any_heading=False):
        return np.tile(self.given, (len(settled), 1))

    def chosen_radii(self):
        return [RADIUS]

    def only(self, name):
        return self

    def sentences(self, reading):
        return [REASON]

    def doubts(self, reading):
        return [DOUBT]

    def objects_on_table(self, cloud, reading):
        return self.on_top


class Item:
    """An object of which some checks are true; it notes what is asked about it."""

    def __init__(self, *true: str):
        self.true, self.asked = true, []

    def cloud(self) -> Cloud:
        return Cloud(np.random.default_rng(0).uniform(size=(200, 3)))

    def drops(self, length):
        raise AssertionError("the model knows without")

    def check(self, name, check) -> bool:
        self.asked.append(name)
        return name in self.true

    def count(self, name, count) -> int:
        self.asked.append("count")
        return count(self.cloud())


def decided(model: Model, *true: str, views: Model | None = None):
    """Return the decision about an object of which some checks are true, and what was asked to make it."""
    item = Item(*true)
    return classify(item, model, lambda: views), item.asked


@pytest.mark.parametrize(("true", "said"), [(["lies"], True), ([], False), (["one_view", "lies"], False)])
def test_what_would_stand_with_y_up_is_said_of_what_has_no_function(true, said):
    decision, _ = decided(Model(cup=0.1), *true, views=Model(cup=0.1))
    assert (WRONG_UP_AXIS in decision.reasons(explain=False)) == said and WRONG_UP_AXIS not in decision.doubts()
    assert WRONG_UP_AXIS not in decided(Model(cup=0.9), *true)[0].reasons()


def test_a_mesh_with_y_up_is_seen_to_lie_and_points_are_not_asked():
    vertices, faces = mug()
    lying = cloud_from_mesh(vertices[:, [0, 2, 1]] * [1, 1, -1], faces)
    assert stands_with_y_up(lying) and not stands_with_y_up(cloud_from_mesh(vertices, faces))
    assert not stands_with_y_up(Cloud(lying.points))


@pytest.mark.parametrize(
    ("scores", "true", "functions", "asked"),
    [
        ({"cup": 0.9, "seat": 0.9}, [], {"cup", "seat"}, ["falls_over", *CUP_CHECKS]),
        ({"cup": 0.9, "seat": 0.9}, ["leaks"], {"seat"}, ["falls_over", *CUP_CHECKS]),
        ({"cup": 0.9}, ["points_leak"], {"cup"}, ["falls_over", *CUP_CHECKS, "hole_seen"]),
        ({"cup": 0.9, "seat": 0.9}, ["points_leak", "hole_seen"], {"seat"}, ["falls_over", *CUP_CHECKS, "hole_seen"]),
        ({"cup": 0.9, "seat": 0.9}, ["falls_over", "leaks"], set(), ["falls_over", "one_view", "lies"]),
        ({"cup": 0.1, "seat": 0.9}, ["leaks"], {"seat"}, ["falls_over"]),
        ({"cup": THRESHOLD, "seat": THRESHOLD}, ["falls_over"], set(), ["one_view", "points", "lies"]),
        ({"cup": POSSIBLE, "seat": POSSIBLE}, ["falls_over"], set(), ["one_view", "lies"]),
        ({"cup": THRESHOLD + A_LITTLE}, [], {"cup"}, ["falls_over", *CUP_CHECKS]),
        ({"cup": 0.9, "sittable": 0.9}, [], {"cup", "sittable"}, ["falls_over", *CUP_CHECKS, "nowhere_to_sit"]),
        ({"cup": 0.1, "sittable": 0.9}, ["nowhere_to_sit"], {"sittable"}, ["falls_over", *SEAT_CHECKS]),
        ({"sittable": 0.9}, SEAT_CHECKS, set(), ["falls_over", *SEAT_CHECKS, "one_view", "lies"]),
        ({"sittable": 0.9}, ["spikes"], {"sittable"}, ["falls_over", "nowhere_to_sit"]),
        ({"sittable": 0.9}, ["falls_over"], set(), ["falls_over", "one_view", "lies"]),
        ({"table": 0.9}, [], {"table"}, ["falls_over", "count"]),
        ({"table": THRESHOLD}, [], set(), ["one_view", "points", "lies"]),
    ],
)
def test_what_an_object_must_not_do_is_asked_where_it_has_a_function_alone(scores, true, functions, asked):
    decision, noted = decided(Model(**scores), *true)
    assert decision.functions == functions and noted == asked
    for (name, found), score in zip(decision.memberships.items(), decision.scores, strict=True):
        denied = name not in functions and scores[name] > THRESHOLD
        assert found.score == score == (0 if denied else scores[name]) and found.member == (name in functions)


@pytest.mark.parametrize(
    ("second", "true", "disagreed"),
    [
        ({"cup": 0.9, "table": 0.4}, [], []),
        ({"cup": 0.2, "table": 0.4}, [], ["cup: fast 0.80, bullet 0.20"]),
        ({"cup": 0.2, "table": 0.6}, [], ["cup: fast 0.80, bullet 0.20", "table: fast 0.30, bullet 0.60"]),
        ({"cup": 0.2, "table": 0.4}, ["falls_over"], []),  # then it has no function by either
    ],
)
def test_the_first_of_several_backends_answers_and_is_unsure_where_another_disagrees(second, true, disagreed):
    first, other = Model(cup=0.8, table=0.3), Model(**second)
    other.simulator = "bullet"
    asked = [(model, lambda: Model(cup=0.0, table=0.0)) for model in (first, other)]
    decision = classify_by_all(lambda model: Item(*true), asked)
    assert decision.functions == classify_by_all(lambda model: Item(*true), asked[:1]).functions
    assert [one.partition("about ")[2] for one in decision.doubts() if "disagree" in one] == disagreed
    assert set(decision.row("mug.ply", 0.0)["backends"]) == {"fast", "bullet"}
    assert "backends" not in classify_by_all(lambda model: Item(*true), asked[:1]).row("mug.ply", 0.0)


@pytest.mark.parametrize("columns", [None, ("a", "b")])
def test_an_estimator_calls_no_half_a_membership_either(columns):
    model = CubeClassifier()
    model.functions_, model.columns_ = ("a", "b"), columns
    model.predict_proba = lambda X: np.array([[THRESHOLD, THRESHOLD + A_LITTLE], [0, THRESHOLD], [1, 1]])
    labels = [set(), {"a"}, {"b"}] if columns is None else [[0, 0], [1, 0], [0, 1]]
    right = [{"b"}, set(), {"a", "b"}] if columns is None else [[0, 1], [0, 0], [1, 1]]
    assert (model.predict([]) if columns is None else model.predict([]).tolist()) == right
    assert model.score([], right) == 1 and model.score([], labels) == 0
    assert model.score([], [right[0], *labels[1:]], [2, 1, 1]) == 0.5


def test_scores_are_given_to_four_places():
    model = Model(cup=0.123456, seat=2 / 3)
    reading = model.read(None)
    found = [one.score for one in model.memberships_by(np.array([[0.123456, 2 / 3]]))[0].values()]
    assert found == reading.rounded == [0.1235, 0.6667]


def test_a_model_that_reads_as_the_paper_does_asks_nothing_of_it():
    decision, asked = decided(Model(checks=False, cup=0.9), "falls_over", "leaks")
    assert decision.functions == {"cup"} and not asked


def test_what_falls_over_has_that_as_its_reason_and_no_doubt():
    falls, leaks, fine = (decided(Model(cup=0.9, seat=0.9), *true)[0] for true in (["falls_over"], ["leaks"], []))
    assert (falls.reasons(), falls.doubts()) == ([FALLS_OVER, REASON], [])
    assert (leaks.reasons(), leaks.doubts()) == ([REASON], [DOUBT, LEAKS])
    assert (fine.reasons(), fine.doubts()) == ([REASON], [DOUBT])
    assert decided(Model(sittable=0.9), "nowhere_to_sit")[0].doubts() == [DOUBT, NO_PLACE]
    assert (falls.reasons(explain=False), fine.reasons(explain=False)) == ([FALLS_OVER], [])
    for decision in (falls, leaks, fine):
        row = decision.row("a.ply", 0.25)
        assert row["unsure"] == bool(decision.doubts()) and row["reasons"] == [*decision.reasons(), *decision.doubts()]
        assert (row["file"], row["seconds"]) == ("a.ply", 0.25)
        assert {name for name, one in row["functions"].items() if one["member"]} == decision.functions
        assert decision.row("a.ply", 0.25, explain=False)["reasons"] == [*decision.reasons(False), *decision.doubts()]


@pytest.mark.parametrize(("count", "said"), [(0, []), (1, ["1 object"]), (3, ["3 objects"])])
def test_how_many_objects_stand_on_a_table_is_said_with_reasons(count, said):
    decision, _ = decided(Model(table=0.9, on_top=count))
    assert decision.reasons() == [REASON, *(ON_TOP.format(objects=objects) for objects in said)]
    assert decision.objects_on_top == count and not decision.reasons(explain=False)


@pytest.mark.parametrize(
    ("first", "views", "functions", "doubt"),
    [
        (Model(cup=0.4), [Model(cup=0.9)], {"cup"}, COMPLETED),
        (Model(cup=0.4), [Model(cup=0.4), Model(cup=0.9)], {"cup"}, COMPLETED),
        (Model(cup=POSSIBLE), [Model(cup=POSSIBLE)], set(), None),
        (Model(cup=POSSIBLE + A_LITTLE), [Model(cup=POSSIBLE)], set(), "cup"),
        (Model(cup=POSSIBLE), [Model(cup=POSSIBLE + A_LITTLE)], set(), "cup"),
        (Model(cup=0.4), [Model(cup=0.9, stays=0)], set(), "cup"),  # by spheres of which none stays
        (Model(cup=0.4, stays=0), [Model(cup=0.4)], set(), COMPLETED),
        (Model(cup=0.4, stays=0), [Model(cup=0.9, stays=0)], set(), NOTHING_SETTLED),
        (Model(cup=0.4, stays=0), [], set(), NOTHING_SETTLED),
        (Model(cup=POSSIBLE), [], set(), None),
        (Model(cup=0.4), [], set(), "cup"),
    ],
)
def test_a_single_view_is_completed_and_asked_about_again(monkeypatch, first, views, functions, doubt):
    """By what first has a function, or on what something settles at last; else it may be what completions may be."""
    asked = iter(views)
    monkeypatch.setattr(classification, "completed_clouds", lambda cloud: [cloud] * len(views))
    together = SimpleNamespace(
        drop_config=lambda: None, checks_stability=False, read=lambda drop: next(asked).read(drop), functions_=("cup",)
    )
    together.memberships_by = first.memberships_by
    decision, noted = decided(first, "one_view", views=together)
    assert noted == ["one_view", *CUP_CHECKS * bool(functions)] and decision.functions == functions
    (more,) = decision.more_doubts or [None]
    assert more == doubt if doubt != "cup" else "cup" in more
    assert decision.doubts()[1:] == ([] if more is None else [more])


@pytest.mark.parametrize(("true", "is_seat"), [((), True), (SEAT_CHECKS[:1], True), (SEAT_CHECKS, False)])
def test_what_was_seen_of_a_completed_view_is_checked_too(monkeypatch, true, is_seat):
    """A completion may add what is level, to a view of which nothing is."""
    monkeypatch.setattr(classification, "completed_clouds", lambda cloud: [cloud])
    views = Model(checks=False, sittable=0.9)
    views.drop_config = lambda: None
    decision, noted = decided(Model(sittable=0.4), "one_view", *true, views=views)
    assert decision.functions == ({"sittable"} if is_seat else set())
    assert noted == ["one_view", *SEAT_CHECKS[: 3 if true else 1]]
    assert (NO_PLACE in decision.doubts()) == bool(true) and COMPLETED in decision.doubts()


@pytest.mark.parametrize(
    ("score", "true", "doubtful"),
    [(0.3, ["points"], True), (POSSIBLE, ["points"], False), (0.3, [], False), (0.9, ["points"], False)],
)
def test_points_that_may_have_a_function_are_unsure_and_meshes_are_not(score, true, doubtful):
    decision, _ = decided(Model(cup=score), *true)
    assert decision.doubts() == [DOUBT, *[PARTLY_SEEN.format(functions="cup")] * doubtful]


@pytest.mark.parametrize(("stay", "nothing"), [(FEW // 2, True), (FEW // 2 + 1, False)])
def test_spheres_of_all_radii_together_are_few_or_not(stay, nothing):
    drops = {radius: shelf(0.4, radius, stays=stay if radius > 0.01 else FEW - FEW // 2 - 1) for radius in (0.01, 0.02)}
    assert nothing_settled(Reading(drops=drops, scores=np.zeros(1), model=None)) == nothing
