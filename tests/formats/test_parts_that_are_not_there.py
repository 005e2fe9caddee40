"""Files that stand for more than they hold: a line says what is not there, instead of an answer about the rest."""

from __future__ import annotations

import json

import numpy as np
import pytest
from read_files import refused

from spherefunc_bullet.formats.sources import read_geometry

BOX = '<link name="{0}"><visual><geometry><box size="0.3 0.3 0.3"/></geometry></visual></link>'
XACRO = 'xmlns:xacro="http://www.ros.org/wiki/xacro"'


@pytest.mark.parametrize("macro", ['<xacro:include filename="legs.xacro"/>', '<xacro:leg name="left"/>'])
def test_a_urdf_with_macros_is_not_read_without_them(tmp_path, macro):
    path = tmp_path / "table.urdf"
    path.write_text(f'<robot name="table" {XACRO}>{BOX.format("top")}{macro}</robot>')
    assert "macros (xacro:" in refused(path) and "expand it with xacro first" in refused(path)


def test_a_urdf_that_was_expanded_may_still_name_the_language(tmp_path):
    path = tmp_path / "table.urdf"
    path.write_text(f'<robot name="table" {XACRO}><!-- <xacro:leg/> -->{BOX.format("top")}</robot>')
    assert len(read_geometry(path).faces) == 12


def test_a_urdf_of_collision_geometry_alone_is_not_called_empty(tmp_path):
    (tmp_path / "box.urdf").write_text(f'<robot name="a">{BOX.format("b").replace("visual", "collision")}</robot>')
    assert refused(tmp_path / "box.urdf").endswith(
        "expected visible parts, found none; has it collision geometry alone?"
    )


@pytest.mark.parametrize("encoding", ["utf-8", "latin-1"])
def test_prefixes_of_names_need_not_be_declared(tmp_path, encoding):
    """Drake's are not, in its own URDFs."""
    head = f'<?xml version="1.0" encoding="{encoding}"?>'
    more = '<drake:joint name="ä"/><transmission type="a" sim:of="b"/>'
    (tmp_path / "box.urdf").write_bytes(f'{head}<robot name="a">{BOX.format("b")}{more}</robot>'.encode(encoding))
    assert len(read_geometry(tmp_path / "box.urdf").faces) == 12


@pytest.mark.parametrize("present", [1.0, 0.5])
def test_a_buffer_that_was_cut_off_is_named(tmp_path, present):
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 0, 1]], np.float32).tobytes()
    (tmp_path / "part.bin").write_bytes(corners[: int(present * len(corners))])
    accessor = {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 0, 1]}
    tree = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "accessors": [accessor],
        "bufferViews": [{"buffer": 0, "byteLength": len(corners)}],
        "buffers": [{"uri": "part.bin", "byteLength": len(corners)}],
    }
    (tmp_path / "triangle.gltf").write_text(json.dumps(tree))
    if present == 1.0:
        assert len(read_geometry(tmp_path / "triangle.gltf").faces) == 1
    else:
        assert "expected 36 bytes in 'part.bin', got 18" in refused(tmp_path / "triangle.gltf")


@pytest.mark.parametrize(("scale", "extent"), [("2", [1.0, 1.0, 1.0]), ("2 1 -1", [1.0, 0.5, 0.5]), ("2 1", None)])
def test_the_scale_of_a_mesh_has_one_factor_or_three(tmp_path, scale, extent):
    corners = [(x, y, z) for x in (0, 0.5) for y in (0, 0.5) for z in (0, 0.5)]
    (tmp_path / "box.obj").write_text("".join(f"v {x} {y} {z}\n" for x, y, z in corners) + "f 1 2 4 3\nf 5 6 8 7\n")
    mesh = f'<visual><geometry><mesh filename="box.obj" scale="{scale}"/></geometry></visual>'
    (tmp_path / "box.urdf").write_text(f'<robot name="box"><link name="box">{mesh}</link></robot>')
    if extent is None:
        assert "expected one or three factors as the scale of a mesh, got 2" in refused(tmp_path / "box.urdf")
    else:
        assert np.ptp(read_geometry(tmp_path / "box.urdf").vertices, axis=0).tolist() == extent
