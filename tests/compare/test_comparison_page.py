"""The comparison's page: the advice, the charts, the objects side by side, and how a browser draws it all."""

from __future__ import annotations

import json
import re
from pathlib import Path

import clouds
import numpy as np
import pytest
from browser import draw, needs_browser

from spherefunc_bullet.compare.commands.compare import compare
from spherefunc_bullet.compare.comparison.agreement import clearest, disagreements
from spherefunc_bullet.compare.comparison.charts import ChartMark, front, marks, median_line
from spherefunc_bullet.compare.comparison.recommendation import (
    prices,
    recommendation_sentence,
    recommendation_table,
    recommendations,
)
from spherefunc_bullet.compare.comparison.significance import about_labels, unseen, verdict_word
from spherefunc_bullet.compare.comparison.tables import label_table

pytestmark = pytest.mark.slow

STEADY, HIGHER, ASTRAY = [0.80, 0.81, 0.79, 0.80, 0.80], [0.90, 0.91, 0.89, 0.90, 0.91], [0.70, 0.92, 0.75, 0.85, 0.80]
BYTES = 8_000_000  # that a report may have
# Complains if laying out and programs took long: the aim is two seconds, a busy machine without a GPU has more.


def backend(seconds: float, **f_measures) -> dict:
    """Return as much of a backend's row as advice looks at."""
    functions = {name: {"f_measure": float(np.mean(each)), "f_measures": each} for name, each in f_measures.items()}
    for row in functions.values():
        row["f_measure_std"] = None
    return {"functions": functions, "seconds_per_object": seconds, "seconds_total": 10 * seconds, "radii": [0.02]}


def report(baseline: float = 0.5, **backends) -> dict:
    own = next(iter(backends.values()))["functions"]
    functions = dict.fromkeys(own, 5)
    rows = {name: {"f_measure": baseline, "f_measures": [baseline] * len(own[name]["f_measures"])} for name in own}
    baselines = {"height_map": {"functions": rows}}
    found = {"backends": backends, "baselines": baselines, "functions": functions, "objects": 10}
    return found | {"train_size": 50, "test_size": 50}


def test_the_cheapest_stands_unless_another_is_better():
    cheap = backend(0.1, cup=STEADY, table=HIGHER, sittable=STEADY)
    dear = backend(3.0, cup=HIGHER, table=STEADY, sittable=ASTRAY)
    found = report(fast=cheap, bullet=dear)
    assert [(each.function, each.backend) for each in recommendations(found)] == [
        ("cup", "bullet"),
        ("table", "fast"),
        ("sittable", "fast"),
    ]
    assert recommendation_sentence(recommendations(found)) == (
        "Use bullet for cup, and fast for table; "
        "for sittable there are too few objects to decide; fast is the cheapest."
    )
    better, worse, level = [each.reason for each in recommendations(found)]
    assert better.startswith("better than fast (+0.102 ±")
    assert worse.startswith("bullet: slower, worse (-0.102 ±")
    assert re.fullmatch(r"bullet: slower, F-measures may differ by 0\.\d\d by chance", level)


def test_advice_for_one_backend_and_for_one_trial():
    assert [each.reason for each in recommendations(report(fast=backend(1, cup=STEADY)))] == ["the only one compared"]
    [one] = recommendations(report(fast=backend(1, cup=[0.5]), bullet=backend(2, cup=[0.7])))
    assert one.backend == "fast" and one.reason.endswith("+0.200 in one trial, too few to tell")


def test_the_sentence_on_top_says_where_spheres_are_beaten():
    found = report(baseline=0.85, fast=backend(0.1, cup=STEADY, table=HIGHER))
    assert recommendation_sentence(recommendations(found)) == (
        "Use fast for table; for cup height map, without spheres, is better (F 0.85 beside 0.80 by fast, "
        "+0.050 ± 0.021)."
    )


@pytest.mark.parametrize("baseline", [0.5, 0.80, 0.81, 0.85])
@pytest.mark.parametrize("cup", [STEADY, HIGHER, ASTRAY])
def test_the_sentence_and_the_table_recommend_the_same(baseline, cup):
    found = report(baseline, fast=backend(0.1, cup=STEADY), bullet=backend(3.0, cup=cup))
    chosen = recommendations(found)
    sentence, table = recommendation_sentence(chosen), recommendation_table(found, chosen)
    used = re.search(r">cup</t[dh]><td[^>]*>([^<]*)<", table)[1]
    assert used in ("fast", "bullet", "height map", "fast (undecided)")
    assert ("height map" in sentence) == (used == "height map")
    assert ("too few objects to decide" in sentence) == used.endswith("(undecided)")
    assert sentence.startswith(f"Use {used} for cup") == (used in ("fast", "bullet"))


def test_a_lead_within_chance_is_none():
    """By the rule for two simulators: 0.81 against trials around 0.80 that spread by 0.02."""
    [one] = recommendations(report(baseline=0.81, fast=backend(0.1, cup=STEADY)))
    assert one.use == "fast" and not one.beaten


def test_a_margin_wider_than_anything_said_with_it_is_said_in_words():
    found = report(fast=backend(0.1, cup=STEADY), bullet=backend(3.0, cup=ASTRAY))
    assert "±" not in about_labels(found) and "by chance" in about_labels(found)


def test_what_may_differ_is_not_called_equal():
    wide, narrow = ({"verdict": "equal", "difference": 0.0, "margin": margin} for margin in (0.57, 0.02))
    assert [verdict_word(each) for each in (wide, narrow)] == ["undecided", "equal"]
    pair = {"backends": ["fast", "bullet"], "labels": {"cup": {"same": 1.0, "right_alone": {"fast": 0, "bullet": 0}}}}
    pair |= {"labels_of_two_seeds": {name: {"cup": 1.0} for name in pair["backends"]}, "f_measures": {"cup": wide}}
    assert label_table({"agreement": [pair]}).rows[0][-1] == "undecided"


def test_a_margin_wider_than_all_f_measures_is_no_number():
    assert unseen(0.25) == "F-measures may differ by 0.25 by chance" and "2.87" not in unseen(2.87)


def test_the_sentence_on_top_says_where_the_data_do_not_decide():
    found = report(fast=backend(0.1, cup=STEADY), bullet=backend(3.0, cup=ASTRAY))
    assert recommendation_sentence(recommendations(found)) == (
        "For cup there are too few objects to decide; fast is the cheapest."
    )


def test_price_of_a_thousand_objects():
    # Ten objects took 1 s and 30 s, so a thousand take 100 s and 3,000 s.
    found = report(fast=backend(0.1, cup=STEADY), bullet=backend(3.0, cup=HIGHER))
    assert prices(found) == {"fast": "1 min 40 s", "bullet": "50 min 0 s"}


def test_front_keeps_what_nothing_beats():
    def mark(seconds, f_measure):
        return ChartMark(backend=0, label="", seconds=seconds, f_measure=f_measure, spread=None)

    quick, good, beaten, level = mark(1, 0.5), mark(3, 0.9), mark(2, 0.4), mark(4, 0.9)
    assert front([level, good, beaten, quick]) == [quick, good]


def test_a_radius_dropped_on_few_objects_has_no_mark():
    functions = {"cup": {"f_measure": 0.9, "f_measure_std": 0.1}}
    few, most = ({"radius": radius, "seconds_per_object": seconds} for radius, seconds in ((0.005, 0.0), (0.01, 0.2)))
    alone = [row | {"functions": functions} for row in (few, most)]
    compared = {"backends": {"fast": {"by_radius": alone, "seconds_per_object": 0.3, "functions": functions}}}
    assert [mark.label for mark in marks(compared, "cup")] == ["1", ""]


def test_median_line_has_no_point_of_few_runs():
    drops = np.array([60.0] * 5 + [5000.0] * 4)
    assert median_line(drops, drops / 10) == ([60.0], [6.0])


def item(**scores) -> dict:
    return {"backends": {name: {"scores": each} for name, each in scores.items()}}


def test_different_labels_come_before_different_scores():
    same = item(a={"cup": 0.9, "table": 0.1}, b={"cup": 0.6, "table": 0.1})
    cup = item(a={"cup": 0.51, "table": 0.1}, b={"cup": 0.5, "table": 0.3})
    table = item(a={"cup": 0.1, "table": 0.1}, b={"cup": 0.1, "table": 0.6})
    found = disagreements([same, cup, table])
    assert [(each.row, each.function, each.labels_differ) for each in found] == [
        (2, "table", True),
        (1, "cup", True),  # a score of exactly one half is no, the larger difference for tables changes no label
        (0, "cup", False),
    ]


def test_functions_take_turns():
    cups = [item(a={"cup": 0.9 - i / 100}, b={"cup": 0.1}) for i in range(5)]
    tables = [item(a={"table": 0.6}, b={"table": 0.4})]
    rows = [each.row for each in clearest(disagreements(cups + tables))[:3]]
    assert rows == [0, 5, 1]


@pytest.fixture(scope="module")
def written(tmp_path_factory) -> Path:
    """Return the folder of a report on cups, tables and blocks, by both simulators."""
    pytest.importorskip("pybullet")
    home = tmp_path_factory.mktemp("comparison")
    folder, rows = home / "objects", ["file,label"]
    folder.mkdir()
    for i in range(3):
        for cloud, label in (
            (clouds.mug(radius=0.035 + 0.003 * i, height=0.08), "cup & <b>"),
            (clouds.plate(0.2 + 0.02 * i, 0.2, 0.2), "table"),
            (clouds.cloud(clouds.level(0.05, 0.05, 0.1 + 0.02 * i), name="block"), "none"),
        ):
            name = f"{cloud.name}_{i}.npz"
            np.savez(folder / name, points=cloud.points)
            rows.append(f"{name},{label}")
    (folder / "manifest.csv").write_text("\n".join(rows))
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("SPHEREFUNC_CACHE", str(home / "cache"))
        compare(str(folder), radii=["2cm,3cm"], trials=3, methods="cubes", repeated=2, jobs=1, report=home / "out")
    return home / "out"


def test_the_page_stands_alone_and_has_the_report_s_numbers(written):
    page, found = (written / "report.html").read_text(), json.loads((written / "report.json").read_text())
    assert len(page) < BYTES
    assert not re.search(r"""(src|href)=["'](?!data:)|https?://|@import""", page)
    for name in ("fast", "bullet"):
        for function, row in found["backends"][name]["functions"].items():
            assert f"{row['f_measure']:.3f} ± {row['f_measure_std']:.3f}" in page, (name, function)
    assert found["machine"]["processor"] in page and "spherefunc compare experiment.toml" in page
    assert "the paper, its 200 models" in page and "always no" in page
    assert "cup &amp; &lt;b&gt;" in page and "cup & <b>" not in page  # a label of the user's is no markup
    lead = re.search(r'<p class="lead">(.*?)</p>', page, re.DOTALL)[1]
    assert len(lead) < 300 and "A thousand such objects take" in lead and found["answer"] not in page
    places = ("a baseline without spheres", "Accuracy against time", "Where they disagree")
    assert sorted(map(page.index, places)) == [page.index(place) for place in places]
    assert 1 <= page.count('<div class="display">') <= 6


@needs_browser
@pytest.mark.parametrize("width", [1280, 800])
def test_a_browser_opens_it_without_errors(written, tmp_path, width):
    drawn = draw(written / "report.html", tmp_path, shows_spheres, size=(width, 7000), budget=8000)
    assert not drawn.console, drawn.console
    inked = drawn.pixels[:, -8:].min(axis=-1) < 200
    assert not inked.any(), "something runs out of the window on the right"
    assert shows_spheres(drawn.pixels)


def shows_spheres(pixels: np.ndarray) -> bool:
    """Return whether pixels (H, W, 3) are coloured below their first fifth, where the charts are."""
    below = pixels[len(pixels) // 5 :: 2, ::2]  # every fourth pixel tells
    return (below.max(axis=-1) - below.min(axis=-1) > 60).sum() > 500
