"""The demo's page: it has the computed numbers, and needs nothing beside itself."""

from __future__ import annotations

import re

import numpy as np
import pytest
from PIL import Image

from spherefunc_bullet.compare.demo.page import ClassifiedObject, Summary, page, rank_sentence
from spherefunc_bullet.compare.evaluation.evaluation import Trial, count_confusion
from spherefunc_bullet.compare.evaluation.protocol import Labels

PICTURE = Image.linear_gradient("L").convert("RGB")
LARGEST = 3_000_000  # bytes


def figures(f_measure: float) -> dict:
    return {"f_measure": f_measure, "f_measure_std": 0.0123, "radius": 0.01}


def result(train_size: int, spheres: float, baseline: float) -> dict:
    return {
        "protocol": "random_splits",
        "train_size": train_size,
        "trials": 10,
        "functions": {"cup": figures(spheres)},
        "baselines": {"bounding_box": {"cup": figures(baseline)}},
    }


def classified(name: str, functions=(), also=(), predicted=()) -> ClassifiedObject:
    return ClassifiedObject(
        name=name,
        functions=frozenset(functions),
        also=frozenset(also),
        scores={"cup": 0.6172},
        predicted=frozenset(predicted),
        nearest="mug_05.ply",
        reason="cup 0.62: a level 1 cm above the ground",
        picture=PICTURE,
        radius=0.01,
        settled=1234,
    )


def comparison() -> dict:
    """Return as much of a comparison as the page looks at."""
    rows = [{"f_measure": f, "f_measure_std": 0.01, "f_measures": [f - 0.01, f, f + 0.01]} for f in (0.81, 0.5)]
    backends = {
        name: {"functions": {"cup": rows[0]}, "seconds_per_object": seconds, "radii": [0.03]}
        for name, seconds in (("fast", 0.1), ("bullet", 4.0))
    }
    baselines = {"height_map": {"functions": {"cup": rows[1]}}}
    found = {"answer": "Level.", "objects": 40, "backends": backends, "baselines": baselines}
    return found | {"functions": {"cup": 8}, "train_size": 20, "test_size": 20}


LABELS = Labels(
    ("cup", "table"),
    np.array([[1, 0], [1, 0], [0, 1], [0, 0]], bool),
    np.zeros((4, 2), bool),
    np.array(["", "", "", ""]),
)
SCORES = np.array([[0.9, 0.1], [0.2, 0.1], [0.7, 0.8], [0.1, 0.2]])


@pytest.fixture(scope="module")
def html() -> str:
    summary = Summary(
        data="household",
        objects=200,
        results=[result(20, 0.7311, 0.61), result(100, 0.8457, 0.7923)],
        confusion=count_confusion(LABELS, Trial(learnt=3, rows=np.arange(4), scores=SCORES, weights=())),
        classified=[classified("mug <02>", ["cup"], predicted=["cup"]), classified("vase", predicted=["cup"])] * 4,
        figure=PICTURE,
        impaired=PICTURE,
        laid=PICTURE,
        comparison=comparison(),
        configuration={"backend": "fast, version 1"},
        seconds={"drawing": 12.34},
    )
    return page(summary)


NUMBERS = ["0.731 ± 0.012", "0.846 ± 0.012", "0.792 ± 0.012", "0.62", "1,234", "12.3 s", "4.0 s"]


@pytest.mark.parametrize("number", NUMBERS)
@pytest.mark.slow
def test_the_page_has_the_numbers_it_was_given(html, number):
    assert number in html


def test_bars_are_as_long_as_the_numbers(html):
    assert re.findall(r"width:([\d.]+)%", html) == ["84.6", "79.2"]


def test_the_page_needs_no_network(html):
    assert not re.search(r'https?:|<link(?! rel="icon" href="data:,")|<script|@import|url\(', html)
    assert all(source.startswith("data:image/png;base64,") for source in re.findall(r'src="([^"]*)"', html))
    assert len(html.encode()) < LARGEST


def test_names_are_escaped(html):
    assert "mug &lt;02&gt;" in html and "<02>" not in html


def test_verdicts_are_words(html):
    assert html.count(">right<") == 4 and html.count(">wrong<") == 4
    assert "4 of 8 right" in html


@pytest.mark.parametrize(
    ("functions", "also", "predicted", "verdict"),
    [
        (["table"], ["sittable"], ["table"], "right"),
        (["table"], ["sittable"], ["table", "sittable"], "right"),
        (["table"], ["sittable"], ["sittable"], "wrong"),
        (["table"], [], ["table", "sittable"], "wrong"),
        ([], [], [], "right"),
    ],
)
def test_what_is_true_as_well_may_be_said_or_not(functions, also, predicted, verdict):
    assert classified("object", functions, also, predicted).correctness == verdict


def test_confusion_counts_every_function_said():
    confusion = count_confusion(LABELS, Trial(learnt=3, rows=np.arange(4), scores=SCORES, weights=()))
    assert confusion.labels == ("cup", "table", "none")
    assert confusion.objects.tolist() == [2, 1, 1]
    assert confusion.counts.tolist() == [[1, 0, 1], [1, 1, 0], [0, 0, 1]]


def test_the_page_sets_the_best_baseline_beside_the_spheres_and_leaves_the_verdict_to_the_comparison():
    said = rank_sentence({"spheres": {"cup": figures(0.5)}, "bounding_box": {"cup": figures(0.7)}})
    assert "for cup 0.50 beside 0.70 (bounding box)" in said
