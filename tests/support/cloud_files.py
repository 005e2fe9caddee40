"""One mug written in every format, for the tests of reading."""

import io
import struct
import zipfile
from importlib.util import find_spec
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest
import trimesh

MESH_ENDINGS = ("ply", "obj", "stl", "off", "glb", "3ds", "npz")
# What the extra ``formats`` brings, by ending; without it the tests of these formats are skipped, each by itself.
NEEDED = {"dae": ("collada",), "3mf": ("lxml",), "urdf": ("yourdfpy",), "las": ("laspy",), "laz": ("laspy", "lazrs")}
USD_ENDINGS = ("usd", "usda", "usdc", "usdz")
NEEDED |= {ending: ("pxr",) for ending in USD_ENDINGS} | {"xml": ("mujoco",), "mjcf": ("mujoco",)}
CLOUD_ENDINGS = ("ply", "pcd", "xyz", "npz", "npy", "csv", "txt")


def missing_packages(ending):
    """Return the packages that a format needs and that are not installed."""
    return [name for name in NEEDED.get(ending.removeprefix(".").split()[0], ()) if find_spec(name) is None]


def require_reader(ending):
    """Skip a test of a format that needs a package that is not installed."""
    for name in missing_packages(ending):
        pytest.skip(f"{name} is not installed: pip install 'spherefunc-bullet[formats]'")


def mug():
    """Return the vertices (N, 3) in metres and faces (M, 3) of a closed tube on a plate, 10 cm high."""
    tube = trimesh.creation.annulus(0.036, 0.04, 0.1, sections=16)
    plate = trimesh.creation.box((0.05, 0.05, 0.004))
    plate.apply_translation((0, 0, -0.048))
    mesh = trimesh.util.concatenate([tube, plate])
    mesh.apply_translation((0.3, -0.2, 1.0))
    # float32 values: PLY, STL, GLB and 3DS hold no more
    return np.array(mesh.vertices, dtype=np.float32).astype(np.float64), np.array(mesh.faces)


def _chunk(identifier, body):
    return struct.pack("<HI", identifier, 6 + len(body)) + body


def three_ds_bytes(vertices, faces):
    """Return a 3DS file of one object."""
    corners = np.column_stack([faces, np.zeros(len(faces))]).astype("<u2")
    mesh = _chunk(0x4110, struct.pack("<H", len(vertices)) + vertices.astype("<f4").tobytes())
    mesh += _chunk(0x4120, struct.pack("<H", len(faces)) + corners.tobytes())
    editor = _chunk(0x4000, b"mug\0" + _chunk(0x4100, mesh))
    return _chunk(0x4D4D, _chunk(0x0002, struct.pack("<I", 3)) + _chunk(0x3D3D, editor))


def npz_bytes(**arrays):
    """Return an NPZ file of the arrays."""
    buffer = io.BytesIO()
    np.savez_compressed(buffer, **arrays)
    return buffer.getvalue()


# A table of a metre's height, with a drawer on a joint that is shut at zero.
URDF = """<?xml version="1.0"?>
<robot name="table">
  <link name="top"><visual><origin xyz="0 0 0.95"/><geometry><box size="0.8 0.6 0.1"/></geometry></visual></link>
  <link name="leg"><visual><geometry><cylinder radius="0.05" length="0.9"/></geometry></visual></link>
  <link name="knob"><visual><geometry><sphere radius="0.02"/></geometry></visual></link>
  <joint name="stands" type="fixed"><parent link="top"/><child link="leg"/><origin xyz="0 0 0.45"/></joint>
  <joint name="slides" type="prismatic"><parent link="top"/><child link="knob"/><origin xyz="0.4 0 0.95"/>
    <axis xyz="1 0 0"/><limit lower="0" upper="0.3" effort="1" velocity="1"/></joint>
</robot>
"""


# The same table of Gazebo, and of MuJoCo, whose sizes are halves.
SDF = """<?xml version="1.0"?>
<sdf version="1.9"><model name="table">
  <link name="top"><pose>0 0 0.95 0 0 0</pose><visual name="v"><geometry><box><size>0.8 0.6 0.1</size></box></geometry>
    </visual></link>
  <link name="leg"><visual name="v"><pose>0 0 0.45 0 0 0</pose><geometry>
    <cylinder><radius>0.05</radius><length>0.9</length></cylinder></geometry></visual></link>
  <link name="knob"><pose>0.4 0 0.95 0 0 0</pose><visual name="v"><geometry><sphere><radius>0.02</radius></sphere>
    </geometry></visual></link>
</model></sdf>
"""
MJCF = """<mujoco model="table"><worldbody>
  <body name="top" pos="0 0 0.95"><geom type="box" size="0.4 0.3 0.05"/>
    <body name="knob" pos="0.4 0 0"><joint type="slide" range="0 0.3"/><geom type="sphere" size="0.02"/></body></body>
  <body name="leg" pos="0 0 0.45"><geom type="cylinder" size="0.05 0.45"/></body>
</worldbody></mujoco>
"""
TABLES = {"urdf": URDF, "sdf": SDF, "xml": MJCF, "mjcf": MJCF}


def in_metres(three_mf):
    """Return a 3MF file whose unit is the metre; trimesh writes metres and calls them millimetres."""
    out = io.BytesIO()
    with zipfile.ZipFile(io.BytesIO(three_mf)) as old, zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as new:
        for name in old.namelist():
            new.writestr(name, old.read(name).replace(b'unit="millimeter"', b'unit="meter"'))
    return out.getvalue()


def las_bytes(points, packed):
    """Return a LAS file, or a LAZ file, of points on a grid of a hundredth of a millimetre."""
    import laspy

    header = laspy.LasHeader(point_format=0, version="1.2")
    header.scales, header.offsets = np.full(3, 1e-5), points.mean(axis=0).round(2)
    cloud, buffer = laspy.LasData(header), io.BytesIO()
    cloud.x, cloud.y, cloud.z = points.T
    cloud.write(buffer, do_compress=packed)
    return buffer.getvalue()


def usd_bytes(ending, vertices, faces):
    """Return a stage of one mesh, in metres and z up."""
    from pxr import Usd, UsdGeom, UsdUtils, Vt

    with TemporaryDirectory() as folder:
        path = f"{folder}/mug.{ending.replace('z', 'c')}"
        stage = Usd.Stage.CreateNew(path)
        UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
        UsdGeom.SetStageMetersPerUnit(stage, 1.0)
        mesh = UsdGeom.Mesh.Define(stage, "/Mug")
        mesh.CreatePointsAttr(Vt.Vec3fArray.FromNumpy(np.float32(vertices)))
        mesh.CreateFaceVertexCountsAttr([3] * len(faces))
        mesh.CreateFaceVertexIndicesAttr(faces.ravel().tolist())
        stage.GetRootLayer().Save()
        if ending == "usdz":
            UsdUtils.CreateNewUsdzPackage(path, path := f"{folder}/mug.usdz")
        return Path(path).read_bytes()


def npy_bytes(array):
    """Return an NPY file of an array."""
    buffer = io.BytesIO()
    np.save(buffer, array)
    return buffer.getvalue()


def mesh_bytes(ending, vertices, faces):
    """Return a mesh as a file of any mesh format; ``ply ascii`` and ``stl ascii`` are formats too."""
    require_reader(ending)
    if ending == "3ds":
        return three_ds_bytes(vertices, faces)
    if ending == "npz":
        return npz_bytes(vertices=vertices, faces=faces)
    if ending in USD_ENDINGS:
        return usd_bytes(ending, vertices, faces)
    mesh = trimesh.Trimesh(vertices, faces, process=False)
    if ending == "dae":  # trimesh writes what it has and calls it y up
        return mesh.export(file_type="dae").replace(b"Y_UP", b"Z_UP")
    if ending == "3mf":
        return in_metres(mesh.export(file_type="3mf"))
    if ending in TABLES:
        return TABLES[ending].encode()
    if ending == "ply ascii":
        return mesh.export(file_type="ply", encoding="ascii")
    exported = mesh.export(file_type="stl_ascii" if ending == "stl ascii" else ending)
    return exported.encode() if isinstance(exported, str) else exported


def _pcd_header(points, data):
    lines = [
        "# .PCD v0.7",
        "VERSION 0.7",
        "FIELDS x y z rgb",
        "SIZE 4 4 4 4",
        "TYPE F F F U",
        "COUNT 1 1 1 1",
    ]
    lines += [
        f"WIDTH {len(points)}",
        "HEIGHT 1",
        "VIEWPOINT 0 0 0 1 0 0 0",
        f"POINTS {len(points)}",
        f"DATA {data}",
    ]
    return ("\n".join(lines) + "\n").encode()


def _lzf_literals(data):
    """Return bytes in LZF's framing, without compression: a valid file, if a poor one."""
    pieces = (data[start : start + 32] for start in range(0, len(data), 32))
    return b"".join(bytes([len(piece) - 1]) + piece for piece in pieces)


def pcd_bytes(points, data="binary"):
    """Return a PCD file of points (N, 3) with colours; ``data`` is ascii, binary or binary_compressed."""
    if data == "ascii":
        rows = "".join(f"{x:.17g} {y:.17g} {z:.17g} 255\n" for x, y, z in points)
        return _pcd_header(points, data) + rows.encode()
    columns = [points[:, axis].astype("<f4") for axis in range(3)] + [np.full(len(points), 255, dtype="<u4")]
    if data == "binary":
        return _pcd_header(points, data) + np.rec.fromarrays(columns).tobytes()
    body = b"".join(column.tobytes() for column in columns)
    packed = _lzf_literals(body)
    return _pcd_header(points, data) + struct.pack("<II", len(packed), len(body)) + packed


def cloud_bytes(ending, points):
    """Return points as a file of any format for clouds."""
    require_reader(ending)
    if ending.startswith("pcd"):
        return pcd_bytes(points, *ending.split()[1:])
    if ending == "npz":
        return npz_bytes(points=points)
    if ending == "npy":
        return npy_bytes(points)
    if ending in ("las", "laz"):
        return las_bytes(points, ending == "laz")
    if ending == "csv":
        rows = "".join(f"7,{z!r},{x!r},{y!r},a chair\n" for x, y, z in points.tolist())
        return f'"time","Z","X","Y","of"\n{rows}'.encode()
    if ending == "txt":
        return ("//X Y Z R\n" + "".join(f"{x!r} {y!r} {z!r} 9\n" for x, y, z in points.tolist())).encode()
    if ending == "xyz":
        return "".join(f"{x!r} {y!r} {z!r}\n" for x, y, z in points.tolist()).encode()
    header = f"ply\nformat binary_little_endian 1.0\nelement vertex {len(points)}\n"
    header += "".join(f"property double {axis}\n" for axis in "xyz") + "end_header\n"
    return header.encode() + points.astype("<f8").tobytes()
