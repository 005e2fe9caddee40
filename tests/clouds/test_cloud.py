"""Clouds: sampled or as they come, on the ground, in metres, z up."""

import csv
import subprocess
import sys

import numpy as np
import pytest
from checkout import DATA, ROOT
from cloud_files import CLOUD_ENDINGS, MESH_ENDINGS, cloud_bytes, mesh_bytes, mug, pcd_bytes
from scipy.spatial import cKDTree

from spherefunc_bullet.clouds.cloud import MAX_GAP, Cloud, cloud_from_mesh, cloud_from_points, load_cloud
from spherefunc_bullet.clouds.orientation import likely_unit, turned_up
from spherefunc_bullet.errors import InputError

MODELS = DATA / "models"
FLOAT32 = 1e-6  # metres: what coordinates near one metre lose in files of float32


@pytest.fixture
def save(tmp_path):
    def saved(name, data):
        (tmp_path / name).write_bytes(data)
        return tmp_path / name

    return saved


def assert_same_surface(cloud, other):
    """Assert that two clouds cover one another: each samples the other's surface."""
    assert np.allclose(cloud.bounds, other.bounds, atol=FLOAT32)
    for a, b in ((cloud, other), (other, cloud)):
        assert cKDTree(a.points).query(b.points)[0].max() <= MAX_GAP + FLOAT32


@pytest.mark.parametrize("ending", MESH_ENDINGS)
def test_one_mug_gives_one_cloud_from_every_format(save, ending):
    vertices, faces = mug()
    cloud = load_cloud(save(f"mug.{ending}", mesh_bytes(ending, vertices, faces)), up="z")
    assert cloud.name == f"mug.{ending}"
    assert_same_surface(cloud, cloud_from_mesh(vertices, faces))


@pytest.mark.parametrize("ending", CLOUD_ENDINGS)
def test_points_of_a_cloud_are_only_moved(save, ending):
    points = np.random.default_rng(0).normal(size=(40, 3)).astype(np.float32).astype(np.float64)
    cloud = load_cloud(save(f"scan.{ending}", cloud_bytes(ending, points)))
    moved = cloud.points - points
    assert np.allclose(moved, moved[0], atol=1e-15)


def test_a_cloud_stands_on_the_ground_below_the_z_axis():
    cloud = cloud_from_mesh(*mug())
    assert np.allclose(cloud.bounds[:, :2].sum(axis=0), 0, atol=1e-15)
    assert cloud.bounds[0, 2] == 0
    # 16 sides of a circle of radius 4 cm; two of its corners lie on each axis
    assert np.allclose(cloud.size, (0.08, 0.08, 0.1), atol=FLOAT32)


def test_where_a_mesh_stands_does_not_matter():
    vertices, faces = mug()
    cloud = cloud_from_mesh(vertices, faces)
    moved = cloud_from_mesh(vertices + [-2.0, 0.5, 8.0], faces)  # multiples of powers of two: no rounding
    assert len(moved) == len(cloud)
    assert np.allclose(moved.points, cloud.points, atol=1e-12)


def test_unused_vertices_do_not_count():
    vertices, faces = mug()
    stray = cloud_from_mesh(np.concatenate([vertices, [[9.0, 9.0, -9.0]]]), faces)
    assert np.array_equal(stray.points, cloud_from_mesh(vertices, faces).points)


def test_spacing_is_the_lattice_pitch_on_a_panel():
    corners = np.array([[0, 0, 0], [1.0, 0, 0], [1, 1, 0], [0, 1, 0]])
    cloud = cloud_from_mesh(corners, [[0, 1, 2], [0, 2, 3]])
    assert cloud.spacing == pytest.approx(0.00398, abs=1e-5)


@pytest.mark.parametrize("up", ["z", "y", "x"])
def test_axes_turn_without_mirroring(save, up):
    axes = np.eye(3)
    turned = turned_up(axes, up)
    assert np.linalg.det(turned) == pytest.approx(1)
    assert turned["xyz".index(up)].tolist() == [0, 0, 1]
    vertices, faces = mug()
    # the inverse of a turn is its transpose
    path = save("mug.ply", mesh_bytes("ply", vertices @ turned.T, faces))
    assert_same_surface(load_cloud(path, up=up), cloud_from_mesh(vertices, faces))


@pytest.mark.parametrize(("count", "said"), [(1, "1 stray point that"), (3, "3 stray points that")])
def test_a_few_points_far_away_are_no_question_of_the_unit(count, said, tmp_path):
    points = np.random.default_rng(0).uniform(0, 0.8, (500, 3))
    points[:count] = 1e6
    np.savetxt(tmp_path / "stray.xyz", points)
    with pytest.raises(InputError, match=said) as caught:
        load_cloud(tmp_path / "stray.xyz")
    assert "millimetres" not in str(caught.value)


@pytest.mark.parametrize(("units", "scale"), [("m", 1), ("cm", 100), ("mm", 1000), ("in", 1 / 0.0254)])
def test_units_are_made_metres(save, units, scale):
    vertices, faces = mug()
    path = save("mug.ply", mesh_bytes("ply", vertices * scale, faces))
    assert_same_surface(load_cloud(path, units=units), cloud_from_mesh(vertices, faces))


def test_a_guessed_unit_is_reported(save):
    vertices, faces = mug()
    lines = []
    cloud = load_cloud(save("mug.stl", mesh_bytes("stl", vertices * 1000, faces)), units="auto", report=lines.append)
    assert_same_surface(cloud, cloud_from_mesh(vertices, faces))
    assert len(lines) == 1 and "mm" in lines[0] and "units=" in lines[0]


def test_metres_win_where_they_are_likely():
    assert [likely_unit(extent) for extent in (0.05, 2.9, 60.0, 800.0, 30_000.0)] == [
        "m",
        "m",
        "mm",
        "mm",
        "mm",
    ]
    assert likely_unit(20.0) == "cm"


def stool():
    """Return a stool 0.5 m high, whose four legs stand wider than its seat is thick."""
    import trimesh

    parts = [trimesh.creation.box((0.4, 0.4, 0.03), trimesh.transformations.translation_matrix((0, 0, 0.485)))]
    for x, y in ((-1, -1), (-1, 1), (1, -1), (1, 1)):
        place = trimesh.transformations.translation_matrix((0.17 * x, 0.17 * y, 0.235))
        parts.append(trimesh.creation.box((0.03, 0.03, 0.47), place))
    mesh = trimesh.util.concatenate(parts)
    return np.array(mesh.vertices), np.array(mesh.faces)


def test_the_guessed_axis_is_the_one_the_object_stands_on(save):
    vertices, faces = stool()
    lines = []
    for name, points in (("z.ply", vertices), ("y.ply", vertices[:, [0, 2, 1]] * [1, 1, -1])):
        cloud = load_cloud(save(name, mesh_bytes("ply", points, faces)), up="auto", report=lines.append)
        assert cloud.size == pytest.approx([0.4, 0.4, 0.5], abs=1e-6)
    assert "took z to be up" in lines[0] and "took y to be up" in lines[1]


def test_gltf_is_y_up_and_remarked_on_when_told_otherwise(save):
    vertices, faces = stool()
    path = save("stool.glb", mesh_bytes("glb", vertices[:, [0, 2, 1]] * [1, 1, -1], faces))
    lines = []
    assert load_cloud(path, up="auto", report=lines.append).size[2] == pytest.approx(0.5)
    assert load_cloud(path, report=lines.append).size[2] == pytest.approx(0.5)
    assert load_cloud(path, up="z", report=lines.append).size[1] == pytest.approx(0.5)
    assert "standard" in lines[0] and 'up="y"' in lines[1]


@pytest.mark.parametrize("ending", ["dae", "usda", "3mf"])
def test_what_a_file_states_of_its_frame_is_not_guessed_and_remarked_on_when_told_otherwise(save, ending):
    vertices, faces = stool()
    vertices = vertices[:, [0, 2, 1]] * [1, 1, -1]  # a guess would turn it
    path, lines = save(f"stool.{ending}", mesh_bytes(ending, vertices * 4, faces)), []
    load_cloud(path, up="z" if ending == "3mf" else "auto", units="auto", report=lines.append)
    assert [line for line in lines if "took" in line] == []
    load_cloud(path, up="y", units="cm", report=lines.append)
    said = [line for line in lines if "in addition to" in line]
    assert [ending != "3mf", True] == [any(word in line for line in said) for word in ('up="y"', 'units="cm"')]


def test_what_a_sensor_did_not_see_is_dropped_and_counted(save):
    points = np.random.default_rng(1).uniform(size=(30, 3))
    points[::3] = np.nan
    lines = []
    cloud = load_cloud(save("scan.pcd", pcd_bytes(points)), report=lines.append)
    assert len(cloud) == 20
    assert lines == ["scan.pcd: dropped 10 of 30 points that are not finite"]


@pytest.mark.parametrize(("scale", "said"), [(1500, "units="), (0.03, "is the unit right"), (300, "odd"), (0.1, "odd")])
def test_sizes_are_doubted(save, scale, said):
    vertices, faces = mug()
    path = save("mug.ply", cloud_bytes("ply", vertices * scale))
    lines = []
    if said == "odd":
        load_cloud(path, report=lines.append)
        assert len(lines) == 1 and said in lines[0]
    else:
        with pytest.raises(InputError, match=said):
            load_cloud(path)


@pytest.mark.parametrize("scale", [1e200, 1e-9])
def test_no_unit_is_proposed_where_none_helps(save, scale):
    vertices, _ = mug()
    with pytest.raises(InputError, match="which no unit explains$"):
        load_cloud(save("mug.xyz", "\n".join(" ".join(map(repr, row)) for row in (vertices * scale).tolist()).encode()))


def refusals():
    vertices, faces = mug()
    flat = np.zeros((3, 3))
    return {
        "fewer": lambda: cloud_from_points(vertices[:9]),
        "shape": lambda: cloud_from_points(vertices[:, :2]),
        "finite": lambda: Cloud(np.full((20, 3), np.inf)),
        "numbers": lambda: Cloud([["a"] * 3] * 20),
        "area": lambda: cloud_from_mesh(flat, [[0, 1, 2]]),
        "faces": lambda: cloud_from_mesh(vertices, faces + 5),
        "samples": lambda: cloud_from_mesh(vertices * 400, faces),
        "max_gap": lambda: cloud_from_mesh(vertices, faces, max_gap=0.0),
    }


@pytest.mark.parametrize("what", refusals())
def test_arrays_that_make_no_cloud_are_refused_in_one_line(what):
    with pytest.raises(InputError) as refusal:
        refusals()[what]()
    assert "\n" not in str(refusal.value) and "expected" in str(refusal.value)


@pytest.mark.parametrize("option", [{"up": "w"}, {"units": "ft"}])
def test_unknown_choices_are_named_with_the_known_ones(save, option):
    with pytest.raises(InputError, match="expected one of"):
        load_cloud(save("mug.ply", mesh_bytes("ply", *mug())), **option)


def test_importing_clouds_loads_no_heavy_module():
    code = "import sys, spherefunc_bullet.clouds.cloud; print([m for m in sys.modules if '.' not in m])"
    root = ROOT
    modules = subprocess.run([sys.executable, "-c", code], cwd=root, capture_output=True, text=True, check=True).stdout
    assert not {"trimesh", "open3d", "assimp_py", "numba", "scipy"} & set(eval(modules))


@pytest.mark.slow
@pytest.mark.skipif(not MODELS.is_dir(), reason="the development set of models is not beside the repository")
def test_real_models_load_with_their_size_and_their_coverage():
    with open(MODELS / "manifest.csv") as file:
        names = [row["file"] for row in csv.DictReader(file)]
    rng = np.random.default_rng(2)
    for name in names[::40]:
        lines = []
        cloud = load_cloud(MODELS / name, report=lines.append)
        assert cloud.bounds[0, 2] == 0
        # On panels 2.7 to 4 mm; both sides of a wall that is thinner have samples of their own, side by side.
        assert 0.0005 < cloud.spacing < 0.0044
        assert covers_random_locations(cloud, MODELS / name, rng)


def covers_random_locations(cloud, path, rng):
    """Return whether random locations of a file's surface, put where the cloud stands, have near samples."""
    import trimesh

    mesh = trimesh.load(path, process=False)
    locations, _ = trimesh.sample.sample_surface(mesh, 20_000, seed=rng)
    used = mesh.vertices[np.unique(mesh.faces)]
    locations = np.asarray(locations) - [*(used.min(axis=0) + used.max(axis=0))[:2] / 2, used[:, 2].min()]
    # the sampled points are placed anew: their box may be smaller than the mesh's by the gap
    return cKDTree(cloud.points).query(locations)[0].max() <= 2 * MAX_GAP


def test_coordinates_too_coarse_for_their_shape_are_said():
    said, far = [], mug()[0] + [500_000, 5_400_000, 300]
    for points in (mug()[0].astype(np.float32), far, far.astype(np.float32)):
        cloud_from_points(points, "mug", report=said.append)
    assert [line for line in said if "32-bit" in line] == [
        "mug: 32-bit coordinates this far from the origin are 0.5 m apart; subtract an offset first"
    ]
