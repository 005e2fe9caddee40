"""Every object is simulated once per radius and kept by content; what damages an entry costs only time."""

from __future__ import annotations

import signal
import zipfile

import clouds
import numpy as np
import pytest
import trimesh
from objects_to_scan import slab_on_posts

from spherefunc_bullet.errors import InputError
from spherefunc_bullet.formats.files import cache_home
from spherefunc_bullet.formats.npz import packed, read_entry
from spherefunc_bullet.settling.cached_runs import CachedFile, CloudObject, DropConfig, LoadOptions
from spherefunc_bullet.settling.drops import TO_THE_END, RunLimit
from spherefunc_bullet.settling.records import simulate_by_several, simulate_objects
from spherefunc_bullet.settling.settling import drop_settings, settle
from spherefunc_bullet.simulator import DropSettings, make_simulator

RADII = (0.01, 0.02)


@pytest.fixture(autouse=True)
def empty_cache(tmp_path, monkeypatch):
    monkeypatch.setenv("SPHEREFUNC_CACHE", str(tmp_path / "cache"))


@pytest.fixture
def files(tmp_path):
    paths = []
    for shape in (clouds.mug(), clouds.plate()):
        paths.append(tmp_path / f"{shape.name}.npz")
        np.savez(paths[-1], points=shape.points)
    return paths


def simulated(paths, radii=RADII, **options) -> list:
    drop_config = DropConfig(**{"simulator": "fast", "radii": radii} | options)
    found = dict(simulate_objects(paths, drop_config, jobs=1))
    return [found[i] for i in range(len(paths))]


def entries() -> dict:
    """Return each cache entry's path and when it was written."""
    return {path: path.stat().st_mtime_ns for path in cache_home().rglob("*") if path.is_file()}


def same(first, second) -> bool:
    return all(
        a.drops == b.drops
        and a.seconds == b.seconds
        and np.array_equal(a.size, b.size)
        and np.array_equal(a.voxels, b.voxels)
        and all(np.array_equal(a.centers(radius), b.centers(radius)) for radius in RADII)
        for a, b in zip(first, second, strict=True)
    )


def test_several_simulators_share_what_is_loaded_and_do_as_each_does_alone(files, monkeypatch):
    ways = [DropConfig(simulator="fast", radii=RADII, seed=seed) for seed in (0, 1)]
    loaded, load = [], DropConfig.cloud
    monkeypatch.setattr(DropConfig, "cloud", lambda self, file, **more: loaded.append(file) or load(self, file, **more))
    together = dict(simulate_by_several([(path, ways) for path in files], jobs=1))
    assert sorted(source.path for source in loaded) == sorted(files)
    monkeypatch.setenv("SPHEREFUNC_CACHE", str(cache_home()) + "-alone")
    for way, seed in enumerate((0, 1)):
        alone = simulated(files, seed=seed)
        for i, record in enumerate(alone):
            for radius in RADII:
                assert np.array_equal(together[i][way].centers(radius), record.centers(radius))
    assert not np.array_equal(together[0][0].centers(0.01), together[0][1].centers(0.01))


def test_first_run_settles_spheres(files):
    mug, plate = simulated(files)
    assert set(mug.settled) == set(RADII) and mug.path == files[0]
    assert same(
        [dict(simulate_objects(files[:1], DropConfig(simulator="fast", radii=RADII)))[0]], [mug]
    )  # on all cores
    assert all(len(each.settled[radius]) > 5 and each.drops[radius] > 50 for each in (mug, plate) for radius in RADII)
    # 63 points round the wall miss the widest place by up to r (1 - cos(pi / 63)) = 0.05 mm on either side.
    assert mug.size == pytest.approx([0.08, 0.08, 0.1], abs=1e-4)


def test_second_run_simulates_nothing(files):
    first, before = simulated(files), entries()
    second = simulated(files)
    # Equal seconds say so too: they are those of the run that was kept.
    assert same(first, second) and entries() == before
    assert len(before) == 2 * (2 + len(RADII))  # shape, whether it falls over, and runs


def test_only_what_is_missing_is_computed(files):
    simulated(files, RADII[:1])
    before = entries()
    simulated(files)
    after = entries()
    assert before.items() <= after.items() and len(after) == len(before) + 2


def test_runs_to_the_end_begin_as_those_with_a_limit(files, monkeypatch):
    monkeypatch.setattr("spherefunc_bullet.simulator.SPHERE_LIMIT", 12)
    limited, whole = simulated(files, (0.01,)), simulated(files, (0.01,), run_limit=TO_THE_END)
    for few, all_ in zip(limited, whole, strict=True):
        assert len(few.settled[0.01]) == 12 < len(all_.settled[0.01])
        assert np.array_equal(few.centers(0.01), all_.centers(0.01)[:12])


def test_shape_and_checks_of_prepared_clouds_are_not_those_of_unchanged_ones(tmp_path, monkeypatch):
    turn = trimesh.transformations.rotation_matrix(0.1, [1, 0, 0])[:3, :3]
    tilted, path = clouds.mug().points @ turn.T, tmp_path / "tilted.npz"
    np.savez(path, points=tilted)

    def facts(run_limit: RunLimit) -> tuple:
        (record,) = simulated([path], run_limit=run_limit)
        low = record.check("low", lambda cloud: bool(cloud.points[:, 2].max() < 0.1))
        file = CachedFile(path, DropConfig(simulator="fast", radii=RADII, run_limit=run_limit))
        return record.voxels.tolist(), low, file.count("points", lambda cloud: len(np.unique(cloud.points[:, 2])))

    given = RunLimit(drops=50)
    in_turn = [facts(run_limit) for run_limit in (TO_THE_END, given)]
    monkeypatch.setenv("SPHEREFUNC_CACHE", str(tmp_path / "other"))
    turned = [facts(run_limit) for run_limit in (given, TO_THE_END)]
    assert in_turn == turned[::-1] and in_turn[0] != in_turn[1]


def test_a_simulator_keeps_the_limit_that_it_declares():
    assert drop_settings(make_simulator("bullet"), 0.01, TO_THE_END).max_spheres == 1000
    fast = make_simulator("fast")
    assert drop_settings(fast, 0.01).max_spheres == 20_000
    assert drop_settings(fast, 0.01, TO_THE_END) == DropSettings(radius=0.01)


def test_entry_cut_short_is_computed_again(files):
    first, whole = simulated(files), {path: path.read_bytes() for path in entries()}
    for path, content in whole.items():
        for length in (0, 10, len(content) // 2, len(content) - 1):
            path.write_bytes(content[:length])
            again = simulated(files)
            assert all(
                np.array_equal(a.centers(radius), b.centers(radius))
                for a, b in zip(first, again, strict=True)
                for radius in RADII
            )
            assert read_entry(path) is not None


def test_changed_content_is_another_object(files):
    first, before = simulated(files), entries()
    np.savez(files[0], points=clouds.mug(height=0.06).points)
    second = simulated(files)
    assert len(entries()) == len(before) + 2 + len(RADII)
    assert second[0].size[2] == pytest.approx(0.06) and same(first[1:], second[1:])


def test_same_content_under_another_name_is_the_same(files, tmp_path):
    simulated(files)
    before = entries()
    (tmp_path / "copy.npz").write_bytes(files[0].read_bytes())
    simulated([tmp_path / "copy.npz"])
    assert entries() == before


@pytest.mark.parametrize(
    "options",
    [
        {"seed": 1},
        {"loading": LoadOptions(up="y")},
        {"simulator": make_simulator("fast", flat_angle_deg=2.0)},
        {"radii": (0.015,)},
    ],
    ids=lambda options: ",".join(options),
)
def test_whatever_decides_the_result_is_in_the_name(files, options):
    simulated(files)
    before = entries()
    outcomes = simulated(files, **options)
    assert len(entries()) > len(before) and not any(isinstance(each, InputError) for each in outcomes)


def test_file_that_cannot_be_used_yields_its_error_and_the_rest_goes_on(files, tmp_path):
    (tmp_path / "broken.ply").write_bytes(b"ply\nnot a model\n")
    outcomes = simulated([files[0], tmp_path / "broken.ply", tmp_path / "gone.stl", files[1]])
    assert [type(each).__name__ for each in outcomes] == [
        "ObjectRecord",
        "InputError",
        "InputError",
        "ObjectRecord",
    ]
    assert "broken.ply" in str(outcomes[1]) and "gone.stl" in str(outcomes[2])


def test_cache_is_what_settle_returns(files):
    settled = settle(clouds.plate(), "fast", RADII)
    again = simulated(files)[1].settled
    # The plate's file is moved to the ground; the cloud itself hangs 40 cm above it.
    for radius in RADII:
        assert len(again[radius]) > 0 and settled[radius].rests.dtype == again[radius].rests.dtype == np.float32


def test_sphere_larger_than_the_object_settles_nowhere(files):
    record = simulated(files[:1], (0.02, 0.5))[0]
    assert record.centers(0.5).shape == (0, 3) and record.drops[0.5] == 0 and len(record.settled[0.02]) > 0


def test_two_processes_give_what_one_gives(files):
    in_two = dict(simulate_objects(files, DropConfig(simulator="fast", radii=RADII), jobs=2))
    assert same([in_two[0], in_two[1]], simulated(files))


def test_cache_that_cannot_be_written_costs_only_the_cache(files, tmp_path, monkeypatch):
    (tmp_path / "file").write_text("in the way")
    monkeypatch.setenv("SPHEREFUNC_CACHE", str(tmp_path / "file"))
    assert len(simulated(files)[0].settled[0.02]) > 5


def test_an_interruption_while_an_entry_is_packed_stays_an_interruption(monkeypatch):
    whole, opened, handler = zipfile.ZipFile.open, [], signal.default_int_handler
    before = signal.signal(signal.SIGINT, handler)  # a shell starts what runs in the background without one

    def interrupted(archive, name, *more, **options):
        opened.append(name)
        signal.raise_signal(signal.SIGINT)
        return whole(archive, name, *more, **options)

    monkeypatch.setattr(zipfile.ZipFile, "open", interrupted)
    try:
        with pytest.raises(KeyboardInterrupt):
            packed({"centers": np.zeros((3, 3)), "seconds": np.zeros(1)})
        assert opened == ["centers.npy", "seconds.npy"] and signal.getsignal(signal.SIGINT) is handler
    finally:
        signal.signal(signal.SIGINT, before)


def test_a_record_says_what_its_runs_took_and_made_them(files):
    mug, _ = simulated(files)
    assert set(mug.memory) == set(mug.seconds) == set(mug.drops) == set(RADII) and min(mug.memory.values()) > 1e6
    assert min(mug.seconds.values()) > 0 and not mug.falls_over
    for radius, drops in mug.settled.items():
        assert drops.radius == radius and drops.provenance["settings"]["radius"] == radius
        assert np.array_equal(mug.centers(radius), drops.rests) and drops.provenance["seed"] == 0
    assert LoadOptions().to_dict() == {"up": "z", "units": "m"} == LoadOptions(up="z").to_dict()
    assert DropConfig(simulator="fast", radii=[0.01]).settings(0.01) == {
        name: value for name, value in vars(drop_settings(make_simulator("fast"), 0.01)).items() if value
    }
    askew = trimesh.transformations.rotation_matrix(np.radians(25), [0, 1, 0])
    slab_on_posts(1.2, 0.8, 0.74).apply_transform(askew).export(files[0].with_name("askew.stl"))
    assert simulated([files[0].with_name("askew.stl")], (0.02,))[0].falls_over


def test_a_cloud_s_drops_are_kept_where_that_is_asked_for_and_a_file_s_answers_always(files):
    mug, drop_config, asked = clouds.mug(), DropConfig(simulator="fast", radii=(0.02,)), []
    length = RunLimit(drops=20)
    drops = [
        CloudObject(raw_cloud=mug, drop_config=drop_config, **how).drops(length)[0.02] for how in ({}, {"cache": True})
    ]
    assert np.array_equal(drops[0].rests, drops[1].rests) and len(entries()) == 1
    for item, times in (
        (CloudObject(raw_cloud=mug, drop_config=drop_config), 2),
        (CachedFile(files[0], drop_config), 1),
    ):
        asked.clear()
        for _ in range(2):
            assert item.count("parts", lambda cloud: asked.append(cloud) or 7) == 7
            assert not item.check("stands", lambda cloud: bool(asked.append(cloud)))
        assert len(asked) == 2 * times and all(np.allclose(cloud.size, mug.size, atol=1e-3) for cloud in asked)
    first, again = (CachedFile(path, drop_config).drops(length)[0.02] for path in files[:1] * 2)
    assert len(first) == 20 and np.array_equal(first.rests, again.rests)
