"""Every format gives back the geometry that was written."""

import json
import struct

import numpy as np
import pytest
import trimesh
from cloud_files import USD_ENDINGS, cloud_bytes, mesh_bytes, mug, npz_bytes, pcd_bytes, require_reader

from spherefunc_bullet.errors import InputError
from spherefunc_bullet.formats.sources import as_source, read_geometry


def read(folder, name, data):
    path = folder / name
    path.write_bytes(data if isinstance(data, bytes) else data.encode())
    return read_geometry(path)


def sorted_corners(geometry):
    """Return the faces' corners as coordinates, in an order that does not depend on the file's."""
    corners = geometry.vertices[geometry.faces].reshape(len(geometry.faces), 9)
    return corners[np.lexsort(corners.round(6).T)]


MESHES = ["ply", "ply ascii", "obj", "stl", "stl ascii", "off", "glb", "3ds", "npz", "dae", "3mf", *USD_ENDINGS]
CLOUDS = ["ply", "pcd ascii", "pcd binary", "pcd binary_compressed", "xyz", "npz", "npy", "csv", "txt"]


@pytest.mark.parametrize("kind", MESHES)
def test_a_mesh_comes_back_from_every_format(tmp_path, kind):
    vertices, faces = mug()
    geometry = read(tmp_path, f"mug.{kind.split()[0]}", mesh_bytes(kind, vertices, faces))
    written = vertices[faces].reshape(len(faces), 9)
    written = written[np.lexsort(written.round(6).T)]
    assert geometry.vertices.dtype == np.float64 and geometry.faces.dtype == np.int64
    # ASCII formats are written with eight digits
    assert np.allclose(sorted_corners(geometry), written, atol=1e-7)


@pytest.mark.parametrize("kind", CLOUDS)
def test_a_cloud_keeps_its_points_and_their_order(tmp_path, kind):
    points = np.random.default_rng(0).normal(size=(50, 3)).astype(np.float32).astype(np.float64)
    geometry = read(tmp_path, f"scan.{kind.split()[0]}", cloud_bytes(kind, points))
    assert len(geometry.faces) == 0
    assert np.array_equal(geometry.vertices, points)


@pytest.mark.parametrize("kind", ["las", "laz"])
def test_a_survey_keeps_its_points(tmp_path, kind):
    points = 4e5 + np.random.default_rng(0).normal(size=(50, 3))
    geometry = read(tmp_path, f"scan.{kind}", cloud_bytes(kind, points))
    assert np.allclose(geometry.vertices, points, rtol=0, atol=1e-5)  # the file's own grid


def test_dae_says_its_unit_and_which_way_is_up(tmp_path):
    require_reader("dae")
    mesh = trimesh.creation.box((0.1, 0.2, 0.3))
    data = mesh.export(file_type="dae").replace(b"<up_axis>", b'<unit name="centimeter" meter="0.01"/><up_axis>')
    assert np.allclose(np.ptp(read(tmp_path, "box.dae", data).vertices, axis=0), (0.001, 0.003, 0.002), atol=1e-9)


@pytest.mark.parametrize(
    "axis, right, up", [("X_UP", (0, -1, 0), (1, 0, 0)), ("Y_UP", (1, 0, 0), (0, 1, 0)), ("Z_UP", (1, 0, 0), (0, 0, 1))]
)
def test_dae_is_turned_as_its_standard_says_and_never_mirrored(tmp_path, axis, right, up):
    """COLLADA names the direction to the right and the one that is up; the third one follows."""
    require_reader("dae")
    T_file = np.eye(4)
    T_file[:3, :3] = np.column_stack([right, np.cross(up, right), up])  # of x, y and z as they come back
    mesh = trimesh.creation.box(bounds=[[0.1, 0.2, 0.3], [0.2, 0.5, 0.9]]).apply_transform(T_file)
    data = mesh.export(file_type="dae").replace(b"<up_axis>Y_UP", f"<up_axis>{axis}".encode())
    found = read(tmp_path, "box.dae", data)
    assert np.allclose([found.vertices.min(axis=0), found.vertices.max(axis=0)], [[0.1, 0.2, 0.3], [0.2, 0.5, 0.9]])
    assert trimesh.Trimesh(found.vertices, found.faces, process=False).volume == pytest.approx(0.1 * 0.3 * 0.6)


def test_3mf_says_its_unit(tmp_path):
    require_reader("3mf")
    data = trimesh.creation.box((100, 200, 300)).export(file_type="3mf")
    assert np.allclose(np.ptp(read(tmp_path, "box.3mf", data).vertices, axis=0), (0.1, 0.2, 0.3), atol=1e-9)


@pytest.mark.parametrize("ending", ["urdf", "sdf", "xml"])
def test_a_robot_is_one_object_with_its_joints_at_zero(tmp_path, ending):
    geometry = read(tmp_path, f"table.{ending}", mesh_bytes(ending, *mug()))
    assert np.allclose(geometry.vertices.min(axis=0), (-0.4, -0.3, 0), atol=1e-9)
    assert np.allclose(geometry.vertices.max(axis=0), (0.42, 0.3, 1), atol=1e-3)  # the knob is a polyhedron


@pytest.mark.parametrize("name", ["meshes/top.stl", "package://objects/meshes/top.stl", "file://meshes/top.stl"])
def test_urdf_reads_the_meshes_in_its_folder_and_scales_them(tmp_path, name):
    require_reader("urdf")
    (tmp_path / "objects" / "meshes").mkdir(parents=True)
    trimesh.creation.box((100, 200, 300)).export(tmp_path / "objects" / "meshes" / "top.stl")
    mesh = f"<mesh filename='{name}' scale='0.001 0.001 0.001'/>"
    robot = f"<robot name='a'><link name='b'><visual><geometry>{mesh}</geometry></visual></link></robot>"
    assert np.allclose(np.ptp(read(tmp_path / "objects", "a.urdf", robot).vertices, axis=0), (0.1, 0.2, 0.3))
    _, mesh = as_source(tmp_path / "objects" / "a.urdf").parts()
    assert mesh.path == tmp_path / "objects" / "meshes" / "top.stl"


@pytest.mark.parametrize("head", ["<?xml version='0.0' ?>", "\n<?xml version='1.0' ?>"])
def test_urdf_is_read_with_the_declarations_that_people_write(tmp_path, head, caplog):
    """As in PyBullet's own objects; nothing is logged about how the file is parsed."""
    require_reader("urdf")
    shape = "<visual><geometry><box size='0.1 0.2 0.3'/></geometry></visual>"
    geometry = read(tmp_path, "box.urdf", f"{head}<robot name='a'><link name='b'>{shape}</link></robot>")
    assert np.allclose(np.ptp(geometry.vertices, axis=0), (0.1, 0.2, 0.3)) and not caplog.records


@pytest.mark.parametrize("kind", ["urdf", "glb"])
def test_a_mirrored_part_is_seen_from_outside(tmp_path, kind):
    require_reader(kind)
    box, mirror = trimesh.creation.box((0.1, 0.2, 0.3)), np.diag([-1.0, 1, 1, 1])
    box.apply_translation((1, 0, 0)).export(tmp_path / "box.stl")
    mesh = "<mesh filename='box.stl' scale='-1 1 1'/>"
    data = f"<robot name='a'><link name='b'><visual><geometry>{mesh}</geometry></visual></link></robot>"
    if kind != "urdf":
        scene = trimesh.Scene()
        scene.add_geometry(box, transform=mirror)
        data = scene.export(file_type=kind)
    geometry = read(tmp_path, f"a.{kind}", data)
    assert trimesh.Trimesh(geometry.vertices, geometry.faces, process=False).volume == pytest.approx(0.006)
    assert geometry.vertices[:, 0].mean() == pytest.approx(-1)


def test_urdf_may_have_spheres_of_radius_zero(tmp_path):
    """They mark a point, as the toes of PyBullet's Laikago."""
    require_reader("urdf")
    shapes = ["<box size='0.1 0.2 0.3'/>", "<sphere radius='0'/>"]
    visuals = "".join(f"<visual><geometry>{shape}</geometry></visual>" for shape in shapes)
    geometry = read(tmp_path, "box.urdf", f"<robot name='a'><link name='b'>{visuals}</link></robot>")
    assert np.allclose(np.ptp(geometry.vertices, axis=0), (0.1, 0.2, 0.3))


@pytest.mark.parametrize("head", ["\n\n  ", "# von Käthe\n\n", "\ufeff"])
def test_off_has_blanks_and_comments_before_its_header(tmp_path, head):
    text = f"{head}OFF\n# counts\n3 1 0\n\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"
    assert read(tmp_path, "a.off", text).faces.tolist() == [[0, 1, 2]]


def ply_of(faces, order="<", vertices=8):
    name = {"<": "binary_little_endian", ">": "binary_big_endian"}[order]
    header = f"ply\nformat {name} 1.0\nelement vertex {vertices}\nproperty float x\nproperty float y\n"
    header += f"property float z\nproperty uchar red\nelement face {len(faces)}\n"
    header += "property list uchar int vertex_indices\nproperty uchar flag\nend_header\n"
    body = b"".join(struct.pack(f"{order}fffB", n, n % 3, n % 5, 9) for n in range(vertices))
    for face in faces:
        body += struct.pack(f"{order}B{len(face)}iB", len(face), *face, 1)
    return header.encode() + body


@pytest.mark.parametrize("order", ["<", ">"])
def test_ply_cuts_mixed_polygons_into_triangles(tmp_path, order):
    geometry = read(tmp_path, "mixed.ply", ply_of([[0, 1, 2], [2, 3, 4, 5], [0, 4, 5, 6, 7]], order))
    expected = [[0, 1, 2], [2, 3, 4], [2, 4, 5], [0, 4, 5], [0, 5, 6], [0, 6, 7]]
    assert geometry.faces.tolist() == expected
    assert geometry.vertices[4].tolist() == [4.0, 1.0, 4.0]


def test_ply_takes_lists_whose_lengths_only_agree_in_sum(tmp_path):
    faces = [[0, 1, 2, 3], [0, 1, 2], [3, 4, 5, 6, 7]]  # as many bytes as three quads
    assert len(read(tmp_path, "mixed.ply", ply_of(faces)).faces) == 2 + 1 + 3


def test_obj_counts_relative_numbers_from_the_last_vertex_so_far(tmp_path):
    part = "o part\nv 0 0 {0}\nv 1 0 {0}\nv 1 1 {0}\nv 0 1 {0}\nf -4/1 -3/1 -2/1 -1/1\n"
    geometry = read(tmp_path, "two.obj", part.format(0) + part.format(5))
    assert geometry.faces.tolist() == [[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]]


def test_faces_of_two_corners_are_passed_over(tmp_path):
    geometry = read(tmp_path, "edge.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2\nf 1 2 3\nf 3 1\n")
    assert geometry.faces.tolist() == [[0, 1, 2]]


def test_xyz_passes_over_headings_comments_and_further_columns(tmp_path):
    text = "x,y,z,r\n# a scan\n1, 2, 3, 255\n4,5,6,0 // last\n"
    assert read(tmp_path, "scan.xyz", text).vertices.tolist() == [[1, 2, 3], [4, 5, 6]]
    assert len(read(tmp_path, "scan.xyz", "2\n1 2 3 0.5\n4\t5\t6 0.5\n").vertices) == 2


def test_npz_takes_the_only_array_of_points(tmp_path):
    points = np.arange(12.0).reshape(4, 3)
    geometry = read(tmp_path, "drop.npz", npz_bytes(settled=points, radius=np.array(0.01)))
    assert np.array_equal(geometry.vertices, points)
    with pytest.raises(InputError, match="named points or vertices"):
        read(tmp_path, "drop.npz", npz_bytes(a=points, b=points))


def test_pcd_unpacks_runs_that_repeat_themselves():
    from spherefunc_bullet.formats.points.lzf import unpack

    # "ab", then 6 bytes from 2 back: the run reads what it has just written
    packed = np.frombuffer(bytes([1]) + b"ab" + bytes([4 << 5, 1]), dtype=np.uint8)
    out = np.zeros(8, dtype=np.uint8)
    assert unpack(packed, out) == 8 and out.tobytes() == b"abababab"
    assert unpack(packed, out[:7]) == -1


def test_pcd_agrees_with_open3d(tmp_path):
    open3d = pytest.importorskip("open3d", exc_type=ImportError)
    points = np.repeat(np.random.default_rng(1).normal(size=(40, 3)), 8, axis=0)  # repeats: something to pack
    cloud = open3d.geometry.PointCloud(open3d.utility.Vector3dVector(points))
    for options in ({"write_ascii": True}, {}, {"compressed": True}):
        open3d.io.write_point_cloud(str(tmp_path / "scan.pcd"), cloud, **options)
        assert np.allclose(read_geometry(tmp_path / "scan.pcd").vertices, points, atol=1e-6)


def test_pcd_organised_keeps_what_the_sensor_did_not_see_as_nan(tmp_path):
    points = np.full((12, 3), np.nan)
    points[:5] = 1.0
    data = pcd_bytes(points).replace(b"WIDTH 12\nHEIGHT 1", b"WIDTH 4\nHEIGHT 3")
    assert np.isnan(read(tmp_path, "scan.pcd", data).vertices).any(axis=1).sum() == 7


def test_glb_applies_the_transforms_of_all_parts(tmp_path):
    scene = trimesh.Scene()
    box = trimesh.creation.box((0.1, 0.1, 0.1))
    scene.add_geometry(box, transform=trimesh.transformations.translation_matrix((1, 0, 0)))
    scene.add_geometry(box, transform=trimesh.transformations.scale_matrix(2.0))
    geometry = read(tmp_path, "two.glb", scene.export(file_type="glb"))
    assert len(geometry.faces) == 24
    assert np.allclose(np.ptp(geometry.vertices, axis=0), (1.15, 0.2, 0.2))


def gltf_folder(tmp_path):
    folder = tmp_path / "model"
    folder.mkdir()
    trimesh.creation.box((0.1, 0.2, 0.3)).export(folder / "box.gltf")
    return folder


def test_gltf_reads_the_buffers_beside_it(tmp_path):
    geometry = read_geometry(gltf_folder(tmp_path) / "box.gltf")
    assert np.allclose(np.ptp(geometry.vertices, axis=0), (0.1, 0.2, 0.3))


@pytest.mark.parametrize("how", ["parent", "percent", "absolute", "link", "web", "file"])
def test_gltf_does_not_leave_its_folder(tmp_path, how):
    folder = gltf_folder(tmp_path)
    tree = json.loads((folder / "box.gltf").read_text())
    inside = folder / tree["buffers"][0]["uri"]
    outside = tmp_path / "outside.bin"
    inside.rename(outside)
    if how == "link":
        inside.symlink_to(outside)
    names = {"parent": "../outside.bin", "percent": "%2e%2e/outside.bin", "absolute": str(outside)}
    names |= {"link": inside.name, "web": "https://localhost/outside.bin", "file": outside.as_uri()}
    tree["buffers"][0]["uri"] = names[how]
    (folder / "box.gltf").write_text(json.dumps(tree))
    with pytest.raises(InputError, match="in its own folder"):
        read_geometry(folder / "box.gltf")


def test_obj_does_not_open_its_materials(tmp_path, monkeypatch):
    (tmp_path / "secret.mtl").write_text("newmtl a\n")
    opened = []
    monkeypatch.setattr("builtins.open", lambda *args, **kwargs: opened.append(args))
    (tmp_path / "a.obj").write_bytes(b"mtllib secret.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    assert len(read_geometry(tmp_path / "a.obj").faces) == 1
    assert not opened
