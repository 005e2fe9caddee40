"""Every bad file is refused in one line that begins with its name; none crashes, hangs or fills memory."""

import io
import json
import struct
import sys
import zipfile
from functools import cache

import numpy as np
import pytest
import trimesh
from cloud_files import cloud_bytes, mesh_bytes, mug, npy_bytes, npz_bytes, pcd_bytes, require_reader, three_ds_bytes
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import spherefunc_bullet as sf
from spherefunc_bullet.clouds.cloud import Cloud, load_cloud
from spherefunc_bullet.errors import InputError
from spherefunc_bullet.formats import files
from spherefunc_bullet.formats.sources import READERS

KINDS = ["ply", "ply ascii", "obj", "stl", "stl ascii", "off", "glb", "3ds", "npz", "dae", "3mf", "urdf", "sdf", "xml"]
CLOUD_KINDS = ["pcd ascii", "pcd binary", "pcd binary_compressed", "xyz", "csv", "txt", "las", "laz", "npy"]


@cache
def good(kind):
    """Return an undamaged file; made when it is asked for, since a format may need what is not installed."""
    vertices, faces = mug()
    return cloud_bytes(kind, vertices) if kind in CLOUD_KINDS else mesh_bytes(kind, vertices, faces)


ALL_KINDS = KINDS + CLOUD_KINDS


def refusal(path):
    """Return the message with which a file is refused; it is one line and begins with the file's name."""
    with pytest.raises(InputError) as error:
        load_cloud(path)
    message = str(error.value)
    assert "\n" not in message and len(message) < 400
    assert message.startswith((path.name, str(path)))
    return message


@pytest.fixture
def check_refused(tmp_path):
    def message(name, data):
        (tmp_path / name).write_bytes(data)
        return refusal(tmp_path / name)

    return message


def test_paths_that_are_no_file(tmp_path):
    for name in ("folder.ply", "folder"):
        (tmp_path / name).mkdir()
        assert "expected a file, got a folder" in refusal(tmp_path / name)
    assert "check the path" in refusal(tmp_path / "missing.ply")
    for name in ("chair.blend", "chair"):
        assert "expected a file, found none" in refusal(tmp_path / name)
        (tmp_path / name).write_bytes(b"chair")
        assert "expected one of .ply" in refusal(tmp_path / name)


def test_a_file_that_may_not_be_read(tmp_path, monkeypatch):
    path = tmp_path / "locked.ply"
    path.write_bytes(good("ply"))

    def deny(self):
        raise PermissionError(13, "Permission denied", str(self))

    monkeypatch.setattr(type(path), "read_bytes", deny)  # the tests may run as root, who reads everything
    assert "Permission denied" in refusal(path)


def test_a_file_too_large_is_not_read(tmp_path, monkeypatch):
    monkeypatch.setattr(files, "MAX_FILE_BYTES", 1000)
    path = tmp_path / "huge.ply"
    path.write_bytes(good("ply"))
    assert "simplify" in refusal(path)


@pytest.mark.parametrize("ending", READERS)
def test_empty_files(check_refused, ending):
    assert "empty file" in check_refused(f"chair{ending}", b"")


@pytest.mark.parametrize("ending", READERS)
def test_files_of_another_format(check_refused, ending):
    assert "got a PNG file" in check_refused(f"chair{ending}", b"\x89PNG\r\n\x1a\n" + bytes(500))
    pointer = b"version https://git-lfs.github.com/spec/v1\noid sha256:4d7a\nsize 12345\n"
    assert "fetch it by git lfs pull" in check_refused(f"chair{ending}", pointer)
    if ending != ".ply":
        assert "got a PLY file" in check_refused(f"chair{ending}", good("ply"))


@pytest.mark.parametrize("kind", [kind for kind in ALL_KINDS if kind not in ("obj", "xyz", "csv", "txt")])
def test_files_cut_off(check_refused, kind):
    """All formats but OBJ and lines of numbers say how much they hold; those have no end to miss."""
    data = good(kind)
    for share in (0.3, 0.6, 0.95):
        check_refused(f"chair.{kind.split()[0]}", data[: int(share * len(data))])


def test_a_name_with_a_line_break(tmp_path):
    path = tmp_path / "two\nlines.ply"
    path.write_bytes(b"no")
    with pytest.raises(InputError) as error:
        load_cloud(path)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("ending", ["ply", "obj", "off", "glb", "npz"])
def test_vertices_that_are_not_finite(check_refused, ending):
    vertices, faces = mug()
    vertices[3, 1] = np.nan
    vertices[5, 2] = np.inf
    message = check_refused(f"chair.{ending}", mesh_bytes(ending, vertices, faces))
    assert f"2 of {len(vertices)}" in message or "could not read" in message


@pytest.mark.parametrize("ending", ["ply", "obj", "off", "3ds", "npz"])
def test_faces_out_of_range(check_refused, ending):
    vertices, faces = mug()
    faces[2, 1] = 4321
    check_refused(f"chair.{ending}", mesh_bytes(ending, vertices, faces))


def test_too_few_points_and_no_area(check_refused):
    assert "at least 10 points, got 3" in check_refused("few.xyz", b"0 0 0\n1 1 1\n2 2 2\n")
    assert "without area" in check_refused("flat.obj", b"v 0 0 0\nv 1 1 1\nv 2 2 2\nf 1 2 3\n")
    assert "at least 10 points, got 0" in check_refused("blind.pcd", pcd_bytes(np.full((50, 3), np.nan)))


def test_ply_headers_that_declare_more_than_the_file_holds(check_refused):
    for count in (b"4000000000", b"-5", b"99999999999999999999"):
        data = good("ply").replace(b"element vertex ", b"element vertex " + count + b"\ncomment ", 1)
        message = check_refused("chair.ply", data)
        assert "more than the file holds" in message or "at most 20,000,000 vertices" in message


def test_pcd_headers_that_declare_more_than_the_file_holds(check_refused):
    for kind in ("pcd ascii", "pcd binary", "pcd binary_compressed"):
        data = good(kind).replace(b"\nPOINTS ", b"\nPOINTS 99999999", 1)
        assert "points" in check_refused("scan.pcd", data)
    bomb = good("pcd binary_compressed").partition(b"DATA")[0].replace(b"\nPOINTS ", b"\nPOINTS 9999")
    count = int(bomb.partition(b"\nPOINTS ")[2].split()[0])
    assert "damaged" in check_refused(
        "scan.pcd", bomb + b"DATA binary_compressed\n" + struct.pack("<II", 9, 16 * count % 2**32)
    )


def test_an_archive_of_a_format_that_is_not_read(tmp_path):
    """AMF may be ZIP, and has the ending of what it is."""
    path = tmp_path / "chair.amf"
    path.write_bytes(b"PK\x03\x04" + bytes(500))
    for answer in (load_cloud, sf.classify):
        with pytest.raises(InputError, match="expected one of .ply, .*, got '.amf'; convert it$"):
            answer(path)


def test_npz_bombs_and_pickles(check_refused):
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
        header = io.BytesIO()
        shape = {"descr": "<f8", "fortran_order": False, "shape": (10**9, 3)}
        np.lib.format.write_array_header_1_0(header, shape)
        archive.writestr("points.npy", header.getvalue() + bytes(10**6))
    assert "MiB" in check_refused("bomb.npz", buffer.getvalue())
    pickled = npz_bytes(points=np.array([print, None, {}], dtype=object))
    assert "real numbers" in check_refused("pickle.npz", pickled)
    assert "faces" in check_refused("faces.npz", npz_bytes(vertices=mug()[0], faces=np.array([[0.5, 1, 2]])))


def glb_of(tree, body=b""):
    text = json.dumps(tree).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(body), b"BIN\0") + body
    return b"glTF" + struct.pack("<II", 2, 12 + len(chunks)) + chunks


def test_glb_that_declares_more_than_it_holds(check_refused):
    tree = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}]}
    tree["meshes"] = [{"primitives": [{"attributes": {"POSITION": 0}}]}]
    tree["accessors"] = [{"componentType": 5126, "type": "VEC3", "count": 10**10}]
    assert "declared" in check_refused("huge.glb", glb_of(tree))
    tree["accessors"][0]["count"] = 3 * 10**6
    tree["nodes"] *= 1000
    assert "simplify" in check_refused("many.glb", glb_of(tree))
    tree["extensionsUsed"] = ["KHR_draco_mesh_compression"]
    assert "without compression" in check_refused("draco.glb", glb_of(tree))


def test_glb_that_trimesh_would_misread(check_refused):
    """It reads whole numbers as metres, leaves out what sparse accessors change, and shows one of many instances."""
    data = good("glb")
    length = int.from_bytes(data[12:16], "little")
    tree, body = json.loads(data[20 : 20 + length]), data[28 + length :]
    accessor = tree["accessors"][tree["meshes"][0]["primitives"][0]["attributes"]["POSITION"]]
    for name, value in {"normalized": True, "sparse": {"count": 1}}.items():
        accessor[name] = value
        assert f"got {name} ones" in check_refused("quantized.glb", glb_of(tree, body))
        del accessor[name]
    tree["extensionsUsed"] = ["EXT_mesh_gpu_instancing"]
    assert "and instancing" in check_refused("instances.glb", glb_of(tree, body))


def test_glb_whose_nodes_run_in_a_circle(check_refused):
    vertices, faces = mug()
    data = good("glb")
    length = int.from_bytes(data[12:16], "little")
    tree = json.loads(data[20 : 20 + length])
    tree["nodes"] = [{"children": [1], "name": "a"}, {"children": [0], "name": "b", "mesh": 0}]
    tree["scenes"] = [{"nodes": [0]}]
    check_refused("circle.glb", glb_of(tree, data[28 + length :]))


def test_3ds_whose_chunks_do_not_fit(check_refused):
    data = bytearray(three_ds_bytes(*mug()))
    for position, size in ((2, 2**31), (2, 5), (18, 0), (18, 2**32 - 1)):
        damaged = bytearray(data)
        damaged[position : position + 4] = struct.pack("<I", size)
        assert "fit into each other" in check_refused("chair.3ds", bytes(damaged))
    nested = b""
    for _ in range(5000):
        nested = struct.pack("<HI", 0x4D4D, 6 + len(nested)) + nested
    check_refused("deep.3ds", nested)


def test_pcd_of_an_image_alone(check_refused):
    data = good("pcd ascii").replace(b"FIELDS x y z rgb", b"FIELDS u v w rgb")
    assert "expected fields x, y and z, got u v w rgb" in check_refused("image.pcd", data)


def test_csv_whose_columns_are_called_otherwise(check_refused):
    assert "columns named x, y and z, got east, north, up" in check_refused("a.csv", b"east,north,up\n1,2,3\n" * 20)


def test_npy_of_no_points(check_refused):
    assert "(N, 3)" in check_refused("image.npy", npy_bytes(np.zeros((40, 30))))
    check_refused("pickle.npy", npy_bytes(np.array([print, None, {}], dtype=object)))
    data = good("npy").replace(f"({len(mug()[0])}, 3)".encode(), b"(99999999, 3)")
    assert "at most 20,000,000 points" in check_refused("many.npy", data)


LAUGHS = b'<?xml version="1.0"?><!DOCTYPE a [<!ENTITY a "ha"><!ENTITY b "&a;&a;&a;">]><robot>&b;</robot>'


@pytest.mark.parametrize("ending", ["dae", "urdf", "sdf", "xml"])
def test_xml_with_entities(check_refused, ending):
    require_reader(ending)
    assert "document type" in check_refused(f"laughs.{ending}", LAUGHS)


@pytest.mark.parametrize("encoding", ["utf-8", "utf-16", "utf-16-be", "latin-1"])
@pytest.mark.parametrize("ending", ["dae", "urdf", "sdf", "xml", "3mf"])
def test_xml_with_a_document_type_in_any_encoding(check_refused, ending, encoding):
    require_reader(ending)
    root = {"dae": "COLLADA", "urdf": "robot", "sdf": "sdf", "xml": "mujoco", "3mf": "model"}[ending]
    declared = encoding.removesuffix("-be")
    text = f"<?xml version='1.0' encoding='{declared}'?><!DOCTYPE a [<!ENTITY a 'ha'>]><{root}>&a;</{root}>"
    data = text.encode(encoding) if encoding != "utf-16-be" else b"\xfe\xff" + text.encode(encoding)
    if ending == "3mf":
        buffer = io.BytesIO()
        with zipfile.ZipFile(buffer, "w") as archive:
            archive.writestr("3D/3dmodel.model", data)
        data = buffer.getvalue()
    assert "document type" in check_refused(f"laughs.{ending}", data)


def repeated_3mf(levels):
    """Return a 3MF file of objects each of which shows the next twice."""
    resources = "".join(
        f'<object id="{n}" type="model"><components><component objectid="{n + 1}"/><component objectid="{n + 1}"/>'
        "</components></object>"
        for n in range(1, levels)
    )
    model = (
        f'<model unit="meter" xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02"><resources>{resources}'
    )
    model += f'<object id="{levels}"/></resources><build><item objectid="1"/></build></model>'
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w") as archive:
        archive.writestr("3D/3dmodel.model", model)
    return buffer.getvalue()


def repeated_dae(levels):
    """Return a DAE file of nodes each of which shows the next twice."""
    nodes = "".join(
        f'<node id="n{n}"><instance_node url="#n{n + 1}"/><instance_node url="#n{n + 1}"/></node>'
        for n in range(levels)
    )
    scene = '<library_visual_scenes><visual_scene id="s"><node id="r"><instance_node url="#n0"/></node></visual_scene>'
    tree = f"<library_nodes>{nodes}<node id='n{levels}'/></library_nodes>{scene}</library_visual_scenes>"
    return f"<COLLADA xmlns='http://www.collada.org/2005/11/COLLADASchema' version='1.4.1'>{tree}</COLLADA>".encode()


@pytest.mark.parametrize("ending", ["dae", "3mf"])
def test_parts_of_parts_that_double_without_end(check_refused, ending):
    require_reader(ending)
    make = repeated_dae if ending == "dae" else repeated_3mf
    assert "at most 10,000 parts" in check_refused(f"doubling.{ending}", make(60))
    assert "parts of parts that end" in check_refused(f"deep.{ending}", make(400))


def test_urdf_does_not_leave_its_folder(tmp_path, check_refused):
    require_reader("urdf")
    (tmp_path / "robot").mkdir()
    trimesh.creation.box((1, 1, 1)).export(tmp_path / "outside.stl")
    for name in ("../outside.stl", str(tmp_path / "outside.stl"), "package://../outside.stl", "file:///etc/passwd"):
        shape = f"<visual><geometry><mesh filename='{name}'/></geometry></visual>"
        data = f"<robot name='a'><link name='b'>{shape}</link></robot>"
        assert "in its own folder or its package" in check_refused("robot/a.urdf", data.encode())


def test_what_the_extra_would_read_is_said_where_it_is_missing(tmp_path, monkeypatch):
    (tmp_path / "mug.dae").write_bytes(good("dae"))
    monkeypatch.setitem(sys.modules, "collada", None)
    assert "pip install 'spherefunc-bullet[formats]'" in refusal(tmp_path / "mug.dae")


@st.composite
def damaged(draw, data):
    """Draw a damaged copy of a file: bits flipped, cut, bytes moved, a number in its header changed."""
    how = draw(st.sampled_from(["flip", "cut", "splice", "extreme", "random", "number"]))
    at = draw(st.integers(0, len(data) - 1) | st.integers(0, min(300, len(data) - 1)))
    if how == "flip":
        return data[:at] + bytes([data[at] ^ (1 << draw(st.integers(0, 7)))]) + data[at + 1 :]
    if how == "cut":
        return data[:at]
    if how == "splice":
        return data[:at] + draw(st.binary(min_size=0, max_size=40)) + data[at + draw(st.integers(0, 60)) :]
    if how == "extreme":
        value = draw(st.sampled_from([0, 1, 2**31 - 1, 2**31, 2**32 - 1, 0x7FC00000, 0x7F800000]))
        return data[:at] + struct.pack("<I", value) + data[at + 4 :]
    if how == "number":
        words = data.split(b" ")
        word = draw(st.integers(0, min(40, len(words) - 1)))
        words[word] = draw(st.sampled_from([b"-1", b"0", b"nan", b"1e308", b"4294967295", b"\xff", b"x"]))
        return b" ".join(words)
    return draw(st.binary(max_size=300))


@pytest.mark.parametrize("kind", ALL_KINDS)
@given(choice=st.data())
@settings(
    max_examples=60,
    deadline=None,  # of the clock, which other work on the machine lengthens; test_fuzz.py counts processor time
    derandomize=True,
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)
def test_damage_gives_a_cloud_or_one_line(tmp_path, kind, choice):
    path = tmp_path / f"chair.{kind.split()[0]}"
    path.write_bytes(choice.draw(damaged(good(kind))))
    try:
        cloud = load_cloud(path, report=lambda line: None)
    except InputError as error:
        assert "\n" not in str(error) and str(error).startswith((path.name, str(path)))
    else:
        assert isinstance(cloud, Cloud) and np.isfinite(cloud.points).all()


@pytest.mark.parametrize("number", ["nan", "inf"])
def test_a_ply_may_begin_with_a_point_that_was_not_seen(tmp_path, number):
    points = np.random.default_rng(0).random((40, 3))
    points[0] = float(number)
    head = "ply\nformat {} 1.0\nelement vertex 40\nproperty float x\nproperty float y\nproperty float z\nend_header\n"
    text = head.format("ascii") + "\n".join(" ".join(map(str, row)) for row in points) + "\n"
    (tmp_path / "text.ply").write_text(text)
    (tmp_path / "binary.ply").write_bytes(head.format("binary_little_endian").encode() + points.astype("<f4").tobytes())
    for name in ("text.ply", "binary.ply"):
        lines = []
        assert len(load_cloud(tmp_path / name, report=lines.append)) == 39
        assert lines == [f"{name}: dropped 1 of 40 points that are not finite"]
