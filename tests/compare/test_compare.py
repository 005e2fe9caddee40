"""`spherefunc compare`: the same objects for every simulator, what is said of them, and that it repeats."""

from __future__ import annotations

import json
import os
from dataclasses import dataclass
from pathlib import Path

import clouds
import numpy as np
import pytest
from catalogues import household
from commands import spherefunc
from PIL import Image

import spherefunc_bullet.compare.comparison.experiment as experiments
import spherefunc_bullet.compare.evaluation.features as features
import spherefunc_bullet.compare.evaluation.readings as profiled
import spherefunc_bullet.learning.function_classifier as function_classifier
from spherefunc_bullet.batch.simulated import Simulated
from spherefunc_bullet.compare.commands.compare import compare
from spherefunc_bullet.compare.comparison.agreement import histograms_agree, median_ratio
from spherefunc_bullet.compare.comparison.entries import ComparedRun, evenly, repeated_count
from spherefunc_bullet.compare.comparison.experiment import (
    ComparedSimulator,
    Experiment,
    as_toml,
    candidates,
    parse_radii,
    read_experiment,
)
from spherefunc_bullet.compare.comparison.significance import answer, benefit_sentence, paired_difference
from spherefunc_bullet.compare.comparison.tables import TextTable
from spherefunc_bullet.datasets.catalogue import write_catalogue
from spherefunc_bullet.datasets.dataset import DatasetObject
from spherefunc_bullet.errors import InputError
from spherefunc_bullet.formats.files import cache_home
from spherefunc_bullet.formats.npz import read_entry, write_entry
from spherefunc_bullet.settling.cached_runs import DropConfig
from spherefunc_bullet.settling.drops import resting_drops
from spherefunc_bullet.settling.records import ObjectRecord, simulate_objects
from spherefunc_bullet.simulator import DropResult, Stop, make_simulator, provenance_of

QUALITIES = {"f_measure", "f_measure_std", "f_measure_fair", "precision", "recall", "accuracy", "radius"}


@dataclass(frozen=True, kw_only=True)
class Layer:
    """Puts spheres in one layer on top of an object, at the places that a seed gives."""

    name: str = "layer"
    shape: str = "voxel"
    refuses: str = ""  # objects of such names
    version = "1"

    def options(self) -> dict:
        return {"shape": self.shape}

    def drop(self, cloud, settings, seed=0) -> DropResult:
        if self.refuses and self.refuses in cloud.name:
            raise InputError(f"{cloud.name}: expected another object")
        random = np.random.default_rng([seed, len(self.shape)])
        low, high = cloud.bounds
        count = int(np.prod(cloud.size[:2]) / settings.radius**2 / 8) + 1
        centers = np.column_stack([random.uniform(low[:2], high[:2], (count, 2)), np.full(count, high[2])])
        return DropResult(
            centers=centers,
            on_object=np.ones(count, bool),
            rolled_off=settings.miss_limit,
            rejected=0,
            timed_out=0,
            stop=Stop.MISSES,
            seconds=0.5 if self.shape == "voxel" else 2.0,
            provenance=provenance_of(self, settings, seed),
        )


@pytest.fixture(autouse=True)
def empty_cache(tmp_path, monkeypatch):
    monkeypatch.setenv("SPHEREFUNC_CACHE", str(tmp_path / "cache"))


@pytest.fixture
def data(tmp_path) -> Path:
    """Return a folder of four cups, four tables and four others, as points."""
    folder, rows = tmp_path / "objects", ["file,label"]
    folder.mkdir()
    for i in range(4):
        block = clouds.cloud(clouds.level(0.05, 0.05, 0.1 + 0.02 * i), name="block")
        mug = clouds.mug(radius=0.035 + 0.003 * i, height=0.08 + 0.01 * i)
        for shape, label in ((mug, "cup"), (clouds.plate(0.2 + 0.02 * i, 0.2, 0.2), "table"), (block, "none")):
            np.savez(folder / f"{shape.name}_{i}.npz", points=shape.points)
            rows.append(f"{shape.name}_{i}.npz,{label}")
    (folder / "manifest.csv").write_text("\n".join(rows))
    return folder


@pytest.fixture
def layers(monkeypatch):
    """Have `layer` be a backend, which refuses objects as it is asked to."""

    def install(**refusing):
        def make(name, **options):
            if name != "layer":
                return make_simulator(name, **options)
            layer = Layer(**options)
            return Layer(shape=layer.shape, refuses=refusing.get(layer.shape, ""))

        monkeypatch.setattr(experiments, "make_simulator", make)

    return install


def compared(capsys, data, **options) -> dict:
    """Return what the command prints as JSON, all in this process; by cubes, which are quickly learnt."""
    compare(str(data), jobs=1, json=True, **{"methods": "cubes"} | options)
    return json.loads(capsys.readouterr().out)


@pytest.mark.slow
def test_json_has_the_contract(data, capsys):
    found = compared(capsys, data, backends="fast", radii=["1cm,2cm"], trials=2)
    assert found["objects"] == 12 and found["agreement"] == [] and list(found["backends"]) == ["fast"]
    fast = found["backends"]["fast"]
    assert set(fast["functions"]) == {"cup", "table"} and QUALITIES <= set(fast["functions"]["cup"])
    assert fast["seconds_per_object_p95"] >= fast["seconds_per_object"] > 0 and fast["failed"] == 0
    assert fast["drops_per_second"] == pytest.approx(fast["drops"] / fast["seconds_total"], rel=0.01)
    # An interpreter with numpy takes more than 20 MB and no test machine has a terabyte.
    assert 2e7 < fast["peak_memory"] < 1e12 and fast["peak_memory_runs"] == 24
    assert {"processor", "system"} <= set(found["machine"])


@pytest.mark.slow
def test_baselines_and_always_no_stand_beside(data, capsys):
    found = compared(capsys, data, backends="fast", radii=["2cm"], trials=2, methods="paper,cubes")
    assert set(found["methods"]["cubes"]) == {"fast", *found["baselines"]}
    assert found["methods"]["paper"]["fast"] == found["backends"]["fast"]["functions"]
    shapes = {"bounding_box", "occupancy", "occupancy_sqrt", "height_map"}
    assert set(found["baselines"]) == {*shapes, "rules", "examiner", "always_no"}
    no = found["baselines"]["always_no"]
    assert no["functions"]["cup"]["f_measure"] == 0 and no["functions"]["cup"]["radius"] is None
    assert no["leave_one_out"]["cup"]["accuracy"] == round(8 / 12, 4)  # a third of the objects are cups


@pytest.mark.slow
def test_two_shapes_are_compared_as_two(data, layers, capsys):
    layers()
    found = compared(capsys, data, backends="layer", shapes="voxel,compound", radii=["2cm,3cm"], trials=3)
    assert list(found["backends"]) == ["layer voxel", "layer compound"] and found["objects_again"] == 12
    [pair] = found["agreement"]
    assert pair["backends"] == ["layer voxel", "layer compound"]
    assert [row["radius"] for row in pair["histograms"]] == [0.02, 0.03]
    # Both draw from the same distribution, so a change of shape is a change of seed: the ratio is near one. It is
    # a median of twelve, each from four distances and two, which stray by a third or so.
    assert all(0.8 < row["ratio"] < 1.25 for row in pair["histograms"])
    assert found["answer"].startswith("Beside layer voxel, ") and "4.0 times the time" in found["answer"]


@pytest.mark.slow
def test_object_that_one_simulator_fails_at_is_left_out_of_all(data, layers, tmp_path, capsys):
    layers(compound="mug_3")
    options = {"backends": "layer", "shapes": "voxel,compound", "trials": 2, "methods": "cubes"}
    options |= {"report": tmp_path / "out"}
    with pytest.raises(SystemExit) as ended:
        compare(str(data), jobs=1, json=True, **options)
    printed = capsys.readouterr()
    found = json.loads(printed.out)
    assert ended.value.code == 2 and found["objects"] == 11 and found["left_out"] == ["mug_3.npz"]
    assert [each["failed"] for each in found["backends"].values()] == [0, 1]
    # Eleven objects at 0.5 s each for three radii: the twelfth, which voxels did well, does not count.
    assert found["backends"]["layer voxel"]["seconds_total"] == pytest.approx(11 * 3 * 0.5)
    said = [line for line in printed.err.splitlines() if "mug_3" in line]
    assert len(said) == 1 and "layer compound; left out of every backend" in said[0]
    assert "mug_3.npz" in (tmp_path / "out" / "report.md").read_text()


@pytest.mark.slow
def test_report_repeats_exactly_from_its_experiment(data, layers, tmp_path, capsys):
    layers()
    first, second = tmp_path / "first", tmp_path / "second"
    options = {"backends": "layer,fast", "shapes": "compound", "trials": 2, "methods": "paper", "seed": 5}
    compare(str(data), jobs=1, report=first, radii=["3cm", "layer=2cm,3cm"], repeated=4, **options)
    compare(str(first / "experiment.toml"), jobs=1, report=second)
    assert all((first / each.name).read_bytes() == each.read_bytes() for each in second.iterdir())
    found = json.loads((first / "report.json").read_text())
    assert found["objects_again"] == 4 and set(found["methods"]) == {"paper"}
    assert len(found["per_object"]) == 12 and set(found["per_object"][0]["backends"]) == {"layer", "fast"}
    assert found["backends"]["layer"]["radii"] == [0.02, 0.03] and found["backends"]["fast"]["radii"] == [0.03]
    # On a machine with an empty cache all but costs come out the same.
    os.environ["SPHEREFUNC_CACHE"] += "_of_another"
    capsys.readouterr()
    compare(str(first / "experiment.toml"), jobs=1, json=True)
    again = json.loads(capsys.readouterr().out)
    assert again["agreement"] == found["agreement"] and again["baselines"] == found["baselines"]
    assert all(
        again["backends"][name]["functions"] == found["backends"][name]["functions"] for name in ("layer", "fast")
    )
    assert "| layer |" in (first / "report.md").read_text()


@pytest.mark.slow
def test_run_that_was_cut_off_continues(data, capsys):
    half = sorted(data.glob("*.npz"))[:7]
    list(simulate_objects(half, DropConfig(simulator="fast", radii=(0.02,)), jobs=1))
    before = {path: path.stat().st_mtime_ns for path in cache_home().rglob("*.npz")}
    compared(capsys, data, backends="fast", radii=["2cm"], trials=2)
    after = {path: path.stat().st_mtime_ns for path in cache_home().rglob("*.npz")}
    assert before.items() <= after.items() and len(before) == 3 * 7 and len(after) == 3 * 12


@pytest.mark.slow
def test_older_entries_know_no_memory(data, capsys):
    list(simulate_objects(sorted(data.glob("*.npz")), DropConfig(simulator="fast", radii=(0.02,)), jobs=1))
    for path in (cache_home() / "settled").rglob("*.npz"):
        write_entry(path, {name: each for name, each in read_entry(path).items() if name != "memory"})
    fast = compared(capsys, data, backends="fast", radii=["2cm"], trials=2)["backends"]["fast"]
    assert fast["peak_memory"] is None and fast["peak_memory_runs"] == 0 and fast["drops"] > 0


@pytest.mark.parametrize(
    ("options", "match"),
    [
        ({"backends": "layer,fest"}, "backend 'fest': expected one of"),
        ({"backends": "fast", "shapes": "voxel"}, "none of fast has the option shape"),
        ({"backends": "fast", "radii": ["bullet=2cm"]}, "expected some of fast; got bullet"),
        ({"backends": "fast", "radii": ["2cm", "3cm"]}, "once, got them twice"),
        ({"backends": "fast", "radii": ["round"]}, "length 'round'"),
        ({"backends": ","}, "at least one name"),
        ({"backends": "fast", "methods": "new"}, "method 'new'"),
        ({"backends": "fast", "methods": "profile,cubes"}, "expected profile alone"),
    ],
)
def test_bad_options_are_refused_before_anything_falls(data, layers, options, match):
    layers()
    with pytest.raises(InputError, match=match):
        compare(str(data), jobs=1, **options)
    assert not (cache_home() / "settled").exists()


def test_data_that_cannot_be_split_is_refused(data):
    rows = (data / "manifest.csv").read_text().splitlines()
    for kept, match in ((rows[:4], "at least 4 objects"), (rows[:1] + rows[1::3], "at least two labels")):
        (data / "manifest.csv").write_text("\n".join(kept))
        with pytest.raises(InputError, match=match):
            compare(str(data), backends="fast", jobs=1, methods="cubes")


@pytest.mark.parametrize(
    ("toml", "match"),
    [
        ("data = ", "expected an experiment in TOML"),
        ('data = "objects"', "backends missing"),
        ('data = "objects"\nbackends = ["fast"]\nbackend = "fast"', "got backend"),
        ('data = "objects"\nbackends = "fast"', "backends: expected a list of names"),
        ('data = "objects"\nbackends = ["fast"]\ntrials = true', "trials: expected a whole number"),
        ('data = "objects"\nbackends = ["fast"]\nseeds = [1, 1]', "seeds: expected two"),
        ('data = "objects"\nbackends = ["fast"]\nradii = ["far"]', "radii: .*length 'far'"),
        ('data = "objects"\nbackends = ["fast"]\nmethods = ["new"]', "methods: .*one of profile, paper, cubes"),
    ],
)
def test_bad_experiments_are_refused(tmp_path, toml, match):
    (tmp_path / "bad.toml").write_text(toml)
    with pytest.raises(InputError, match=match):
        read_experiment(tmp_path / "bad.toml")


def test_experiment_takes_no_options_beside_it(tmp_path):
    with pytest.raises(InputError, match="expected no --trials"):
        compare(str(tmp_path / "x.toml"), trials=3)


def test_experiment_survives_its_file(tmp_path):
    before = Experiment(
        data=str(tmp_path / 'a "quoted" folder'),
        backends=("fast", "bullet"),
        shapes=("voxel",),
        radii={"bullet voxel": (0.02, 0.03), "fast": (0.0333333333,)},
        options={"bullet": {"in_air": 1, "friction": 0.25}},
        seeds=(3, 9),
        repeated=7,
    )
    (tmp_path / "experiment.toml").write_text(as_toml(before))
    after = read_experiment(tmp_path / "experiment.toml")
    assert after == before


def test_smallest_experiment(tmp_path):
    (tmp_path / "small.toml").write_text('data = "household"\nbackends = ["fast"]\nradii = ["2cm", 0.03]\nseeds = [4]')
    found = read_experiment(tmp_path / "small.toml")
    assert found.data == "household" and found.seeds == (4, 5) and found.radii == {"all": (0.02, 0.03)}
    [fast] = candidates(found)
    assert fast.name == "fast" and fast.radii == (0.02, 0.03)
    assert found.methods == ("profile",) and found.run_limit.drops == 200


def test_radii_are_the_methods_where_nobody_says_otherwise():
    def radii(*methods):
        return candidates(Experiment(data="household", backends=("fast",), methods=methods))[0].radii

    assert radii("profile") == (0.005, 0.01, 0.03) and radii("cubes", "paper") == (0.02, 0.03, 0.05)


@pytest.fixture
def few_trees(monkeypatch):
    """Learn in this process, and quickly: what forests say is not looked at."""
    monkeypatch.setattr(function_classifier, "TREES", 8)
    monkeypatch.setattr(profiled, "WORTH_CORES", 10**6)
    monkeypatch.setattr(features, "MANY", 10**6)


@pytest.mark.slow
def test_profiles_and_copies_are_compared(few_trees, tmp_path, capsys):
    kinds = ("mug_01", "mug_02", "vase_01", "vase_02")  # of tables there are copies below
    made = [item for item in household() if item.name in kinds]
    write_catalogue(made, tmp_path / "objects", "four")
    options = {"backends": "fast", "radii": ["1cm"], "trials": 2, "copied": 1, "report": tmp_path / "out"}
    compare(str(tmp_path / "objects"), jobs=1, json=True, **options)
    found = json.loads(capsys.readouterr().out)
    assert found["answer"].startswith("Spheres ") and "fast was compared with no other" in found["answer"]
    assert found["backends"]["fast"]["drops"] == 200 * 4 and {"points", "rules"} <= set(found["baselines"])
    cup = found["impaired"]["cup"]
    assert not cup["hole"]["works"] and cup["no_handle"]["works"]
    assert {"fast", "fast, copies learnt", "points, copies learnt", "examiner"} <= set(cup["hole"]["share"])
    assert Image.open(tmp_path / "out" / "impaired.png").width > 1000
    page = (tmp_path / "out" / "report.html").read_text()
    assert "Does it still work?" in page and "hole" in (tmp_path / "out" / "report.md").read_text()


@pytest.mark.slow
def test_copies_that_a_shape_cannot_take_are_left_out_of_all(few_trees, tmp_path, capsys):
    """A copy as a sensor gives it has no mesh."""
    pytest.importorskip("pybullet")
    kinds = ("mug_01", "mug_02", "vase_01", "vase_02")
    write_catalogue([item for item in household() if item.name in kinds], tmp_path / "objects", "four")
    options = {"backends": "fast,bullet:mesh", "radii": ["3cm"], "trials": 1, "copied": 1, "repeated": 1}
    compare(str(tmp_path / "objects"), jobs=1, json=True, **options)
    said = capsys.readouterr()
    cup = json.loads(said.out)["impaired"]["cup"]
    assert {"fast", "bullet:mesh"} <= set(cup["hole"]["share"]) and "sensor" not in cup
    assert "left out" in said.err


@pytest.mark.slow
def test_second_seed_is_asked_of_who_has_not_learnt_the_object(few_trees, data, layers, capsys):
    layers()
    options = {"backends": "layer", "shapes": "voxel,compound", "radii": ["3cm"], "trials": 1, "copied": 0}
    [pair] = compared(capsys, data, methods="profile", **options)["agreement"]
    assert pair["objects_again"] == 12
    # Plates, mugs and blocks differ in size alone, and either seed shows it.
    assert all(share == 1 for shares in pair["labels_of_two_seeds"].values() for share in shares.values())


def test_what_spheres_buy_is_said_first():
    def row(works: bool, fast: float, points: float) -> dict:
        return {"works": works, "copies": 1, "share": {"fast": fast, "fast, copies learnt": 0, "points": points}}

    kinds = {"lid": row(False, 0.1, 0.6), "turned": row(True, 0.9, 0.8)}
    report = {"backends": {"fast": {}}, "impaired": {"cup": kinds}}
    assert benefit_sentence(report) == (
        "Spheres distinguish copies that work from copies that only look alike: of copies that no longer work, 10% by "
        "fast and 60% by points, the best baseline without spheres, are still classified by their function; of "
        "harmlessly changed copies, 90% and 80% are."
    )
    kinds["lid"]["share"]["points"] = 0.0
    assert benefit_sentence(report).startswith("Spheres do not better distinguish copies that work")


def test_radii_for_one_and_for_all():
    assert parse_radii(["fast=1cm,5mm", "2cm"]) == {"fast": (0.005, 0.01), "all": (0.02,)}


def test_a_backend_that_is_none_is_one_line(data):
    done = spherefunc("compare", data, "--backends", "fast,nothing")
    assert done.returncode == 2 and done.stdout == "" and len(done.stderr.splitlines()) == 1


def entry(name: str, settled, again) -> ComparedRun:
    """Return what one simulator did on objects, given as settled centres of either seed at 2 cm."""

    def simulated(all_centers) -> Simulated:
        paths = [Path(f"{i}.ply") for i in range(len(all_centers))]
        records = [
            ObjectRecord(
                path=path,
                size=np.ones(3),
                occupied=lambda: np.zeros((1, 3), np.int16),
                settled={0.02: resting_drops(0.02, np.array(centers, float).reshape(-1, 3))},
                seconds={0.02: 1.0},
                drops={0.02: 9},
            )
            for path, centers in zip(paths, all_centers, strict=True)
        ]
        objects = tuple(DatasetObject(path=path, functions=frozenset()) for path in paths)
        return Simulated("set", objects, tuple(records))

    candidate = ComparedSimulator(name=name, backend=name, simulator=Layer(), radii=(0.02,))
    return ComparedRun(candidate=candidate, simulated=simulated(settled), again=simulated(again), failed=())


def test_histograms_by_hand():
    # Cubes of 14 cm: `here` and `there` are two of them. A has 3 spheres here, then 5; B has 4 there, both times.
    here, there = [[0, 0, 0.01]], [[0.2, 0, 0.01]]
    a, b = entry("A", [here * 3], [here * 5]), entry("B", [there * 4], [there * 4])
    found = histograms_agree(a, b, 0.02)
    assert found["within"] == {"A": 2, "B": 0}
    assert found["between"] == pytest.approx(np.sqrt((9 + 16 + 25 + 16) / 2), abs=1e-4)
    assert found["ratio"] == pytest.approx(np.sqrt(33) / np.sqrt(2), abs=1e-4)
    assert found["ratio_to"]["B"] is None and found["ratio_to"]["A"] == pytest.approx(np.sqrt(33) / 2, abs=1e-4)
    assert found["norm"] == pytest.approx(np.sqrt((9 + 25 + 16 + 16) / 4), abs=1e-4) and found["objects"] == 1


def test_objects_without_spheres_say_nothing():
    here = [[0, 0, 0.01]]
    empty = entry("A", [[], here * 2], [[], here * 4])
    found = histograms_agree(empty, empty, 0.02)
    assert found["objects"] == 1 and found["ratio"] == pytest.approx(np.sqrt(0.5), abs=1e-4)
    assert median_ratio(np.zeros(3), np.zeros(3)) is None


def test_histograms_medians_are_over_the_same_objects():
    """A norm of 0 beside a ratio would be of other objects: most hold no sphere, and say nothing."""
    here, empty = [[0, 0, 0.01]], []
    a = entry("A", [empty, empty, empty, here * 2], [empty, empty, empty, here * 4])
    found = histograms_agree(a, a, 0.02)
    assert found["objects"] == 1 and found["norm"] == pytest.approx(np.sqrt(10), abs=1e-4)
    assert found["within"] == {"A": 2} and found["between"] == pytest.approx(np.sqrt(2), abs=1e-4)
    nothing = histograms_agree(entry("A", [empty], [empty]), entry("B", [empty], [empty]), 0.02)
    assert (nothing["objects"], nothing["ratio"], nothing["norm"]) == (0, None, None)


def test_second_seed_is_for_all_where_it_is_cheap():
    cheap = [entry("A", [[]] * 90, [[]]).simulated]  # one second each
    assert repeated_count(cheap, None) == 90 and repeated_count(cheap, 7) == 7 and repeated_count(cheap, 700) == 90
    assert repeated_count([entry("A", [[]] * 130, [[]]).simulated], None) == 40
    chosen = [int(each.path.stem) for each in evenly(cheap[0].objects, 4)]
    assert chosen[0] == 0 and chosen[-1] == 89 and len(chosen) == 4


def backend(seconds: float, radii=(0.02,), **f_measures) -> dict:
    """Return as much of a backend's row as the answer looks at."""
    functions = {name: {"f_measure": np.mean(each), "f_measures": each} for name, each in f_measures.items()}
    return {"functions": functions, "seconds_per_object": seconds, "radii": list(radii)}


def answered(**backends) -> str:
    return answer({"backends": backends, "train_size": 50, "test_size": 50})


STEADY = [0.80, 0.81, 0.79, 0.80, 0.80]
HIGHER = [0.90, 0.91, 0.89, 0.90, 0.91]
ASTRAY = [0.70, 0.92, 0.75, 0.85, 0.80]


def test_answer_in_every_direction():
    dear = answered(fast=backend(0.02, cup=STEADY), bullet=backend(2.0, cup=HIGHER))
    assert dear.startswith("Beside fast, bullet is better at cup (F +0.102 ±")
    assert dear.endswith("at 100 times the time (2.0 s against 20 ms an object).")
    worse = answered(fast=backend(0.02, cup=HIGHER), bullet=backend(2.0, cup=STEADY))
    assert "bullet is worse at cup (F -0.102 ±" in worse
    level = answered(fast=backend(0.02, cup=STEADY), bullet=backend(0.05, cup=ASTRAY))
    assert "bullet is not measurably better or worse, with so few objects, at cup (F-measures may differ by" in level
    assert "2.5 times the time" in level
    same = answered(fast=backend(0.02, cup=STEADY), bullet=backend(0.05, cup=[*STEADY[1:], STEADY[0]]))
    assert "bullet is as good at cup (F-measures differ by 0.000 at most, within the spread" in same


def test_answer_with_all_directions_at_once_is_one_sentence():
    one = backend(1.0, cup=STEADY, sittable=HIGHER, table=STEADY)
    two = backend(3.0, radii=(0.03,), cup=HIGHER, sittable=STEADY, table=ASTRAY)
    said = answered(slow=two, quick=one)
    assert said.startswith("Beside quick, slow is better at cup (") and ", worse at sittable (" in said
    assert " objects, at table (" in said and "each with radii of its own" in said and "\n" not in said


def test_answer_for_three_backends_for_one_and_for_one_trial():
    three = answered(a=backend(1, cup=STEADY), b=backend(2, cup=HIGHER), c=backend(3, cup=STEADY))
    assert "b is better" in three and "; c is as good" in three and three.count(".") >= 1
    assert "compared with no other" in answered(a=backend(1, cup=STEADY))
    assert "too few to tell" in answered(a=backend(1, cup=[0.5]), b=backend(2, cup=[0.7]))
    assert "at 2.0 s against 0 ms an object" in answered(a=backend(0, cup=STEADY), b=backend(2, cup=STEADY))


def test_margin_by_hand():
    # Differences 0.1 and 0.3: mean 0.2, variance 0.02; two trials with as many tested as learnt count it 1.5 times;
    # Student's t for one degree of freedom at 97.5 % is 12.706.
    found = paired_difference([0, 0], [0.1, 0.3], 10, 10)
    assert found["difference"] == pytest.approx(0.2) and found["verdict"] == "equal"
    assert found["margin"] == pytest.approx(12.706 * np.sqrt(1.5 * 0.02), abs=1e-3)
    assert paired_difference([0.5, 0.5], [0.5, 0.5], 10, 10)["verdict"] == "equal"
    assert paired_difference([0.5, 0.5], [0.4, 0.4], 10, 10)["verdict"] == "worse"


def test_table_in_markdown():
    table = TextTable(title="Cost", columns=["backend", "s"], rows=[["fast", "1"]])
    assert table.markdown().splitlines() == ["## Cost", "", "| backend | s |", "| --- | ---: |", "| fast | 1 |"]


def test_code_is_warm_before_the_first_run_is_timed(data):
    dropped = []

    class Recorder(Layer):
        def drop(self, cloud, settings, seed=0) -> DropResult:
            dropped.append(cloud.name)
            return super().drop(cloud, settings, seed)

    files = sorted(data.glob("mug*.npz"))[:2]
    list(simulate_objects(files, DropConfig(simulator=Recorder(name="recorder"), radii=(0.02,)), jobs=1))
    assert dropped == ["plate", "mug_0.npz", "mug_1.npz"]


def test_a_backend_with_a_shape_is_a_candidate_of_its_own():
    pytest.importorskip("pybullet")
    found = candidates(Experiment(data="household", backends=("fast", "bullet:mesh", "bullet:voxel")))
    assert [one.name for one in found] == ["fast", "bullet:mesh", "bullet:voxel"]
    assert [one.simulator.options()["shape"] for one in found[1:]] == ["mesh", "voxel"]
    with pytest.raises(InputError, match="expected one of"):
        candidates(Experiment(data="household", backends=("bullet:foam",)))
