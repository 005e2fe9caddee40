"""What is read is what is hashed, and nothing is read that is no ordinary file where a reader may look."""

from __future__ import annotations

import json
import os
import pickle
import socket
import sys
from pathlib import Path

import numpy as np
import pytest
import trimesh
from cloud_files import cloud_bytes, mesh_bytes, mug, require_reader
from commands import spherefunc
from typer.testing import CliRunner

from spherefunc_bullet.batch.task import source_stamp
from spherefunc_bullet.commands.command_line import application
from spherefunc_bullet.errors import InputError
from spherefunc_bullet.formats import sources
from spherefunc_bullet.formats.sources import READERS, as_source, read_geometry
from spherefunc_bullet.settling.cached_runs import DropConfig
from spherefunc_bullet.settling.records import object_record

DROPPING = DropConfig(simulator="fast", radii=(0.02,))


def robot(mesh: str) -> str:
    visual = f"<visual><geometry><mesh filename='{mesh}'/></geometry></visual>"
    return f"<robot name='a'><link name='b'>{visual}</link></robot>"


def write_gltf(folder: Path, shape: trimesh.Trimesh, uri: str) -> Path:
    """Write a glTF file and its one buffer, which is called as the file names it."""
    files = shape.export(file_type="gltf")
    tree = json.loads(files.pop("model.gltf"))
    buffers = [files[each["uri"]] for each in tree["buffers"]]
    for view in tree["bufferViews"]:
        view["byteOffset"] = view.get("byteOffset", 0) + sum(len(each) for each in buffers[: view["buffer"]])
        view["buffer"] = 0
    tree["buffers"] = [{"uri": uri, "byteLength": sum(len(each) for each in buffers)}]
    (folder / uri).parent.mkdir(parents=True, exist_ok=True)
    (folder / uri).write_bytes(b"".join(buffers))
    (folder / "object.gltf").write_text(json.dumps(tree))
    return folder / "object.gltf"


def as_glb(gltf: Path) -> Path:
    """Write the same as a GLB file whose buffer stays a file of its own."""
    text = gltf.read_bytes()
    text += b" " * (-len(text) % 4)
    glb = b"glTF" + (2).to_bytes(4, "little") + (20 + len(text)).to_bytes(4, "little")
    gltf.with_suffix(".glb").write_bytes(glb + len(text).to_bytes(4, "little") + b"JSON" + text)
    gltf.unlink()
    return gltf.with_suffix(".glb")


SDF = """<sdf version="1.9"><model name="a"><link name="b"><visual name="c"><geometry><mesh><uri>{}</uri></mesh>
</geometry></visual></link></model></sdf>"""
MJCF = """<mujoco><compiler meshdir="."/><asset><mesh name="c" file="{}"/></asset>
<worldbody><geom type="mesh" mesh="c"/></worldbody></mujoco>"""


def write_object(kind: str, folder: Path, shape: trimesh.Trimesh) -> Path:
    """Write an object of which the files beside it hold the geometry; the file itself stays the same."""
    folder.mkdir(exist_ok=True)
    if kind in ("gltf", "glb"):
        path = write_gltf(folder, shape, "data/geometry.bin")
        return path if kind == "gltf" else as_glb(path)
    (folder / "meshes").mkdir(exist_ok=True)
    if kind == "urdf of gltf":
        write_gltf(folder / "meshes", shape, "data/geometry.bin")
    else:
        shape.export(folder / "meshes" / "object.stl")
    name = f"meshes/object.{'gltf' if kind == 'urdf of gltf' else 'stl'}"
    text = {"sdf": SDF, "xml": MJCF, "mjcf": MJCF}[kind].format(name) if kind in ("sdf", "xml", "mjcf") else robot(name)
    path = folder / f"a.{kind.split()[0]}"
    path.write_text(text)
    return path


def shapes() -> tuple[trimesh.Trimesh, trimesh.Trimesh]:
    """Return a tube and one half as high, whose files differ in their coordinates alone."""
    return trimesh.creation.annulus(0.036, 0.04, 0.1), trimesh.creation.annulus(0.036, 0.04, 0.05)


@pytest.mark.parametrize("kind", ["gltf", "glb", "urdf", "urdf of gltf", "sdf", "xml"])
def test_an_object_is_simulated_again_when_a_file_that_it_names_has_changed(tmp_path, kind):
    require_reader(kind)
    high, low = shapes()
    path = write_object(kind, tmp_path / "model", high)
    unchanged, stamp, first = path.read_bytes(), source_stamp(path), object_record(path, DROPPING)
    assert object_record(write_object(kind, tmp_path / "model", high), DROPPING).size == pytest.approx(first.size)
    write_object(kind, tmp_path / "model", low)
    if kind not in ("gltf", "glb"):  # a glTF file itself says how large its parts are
        assert path.read_bytes() == unchanged
    assert object_record(path, DROPPING).size.min() < 0.06 < 0.07 < first.size.min()
    assert source_stamp(path) != stamp


def test_a_replaced_buffer_below_the_folder_is_another_object(tmp_path):
    high, low = shapes()
    path = write_gltf(tmp_path, high, "data/geometry.bin")
    kept, before = path.read_bytes(), DROPPING.content_hash(path)
    write_gltf(tmp_path, low, "data/geometry.bin")
    path.write_bytes(kept)
    assert DROPPING.content_hash(path) != before


def test_a_replaced_part_is_seen_though_sizes_and_the_newest_time_stay(tmp_path):
    path = write_object("urdf", tmp_path / "model", shapes()[0])
    mesh = tmp_path / "model" / "meshes" / "object.stl"
    os.utime(mesh, ns=(10**9, 10**9))
    before = source_stamp(path)
    shapes()[1].export(mesh)
    os.utime(mesh, ns=(2 * 10**9, 2 * 10**9))
    assert source_stamp(path) != before


OPENED: list[str] = []
sys.addaudithook(lambda event, args: OPENED.append(str(args[0])) if event == "open" else None)


def example(kind: str, folder: Path) -> Path:
    """Write a file of a format, with files beside it where it may name any."""
    if kind in (".gltf", ".glb", ".urdf", ".sdf", ".xml", ".mjcf"):
        return write_object(kind[1:], folder, shapes()[0])
    vertices, faces = mug()
    clouds = (".pcd", ".xyz", ".csv", ".txt", ".las", ".laz", ".npy")
    text = b"mtllib secret.mtl\nusemtl a\n" if kind == ".obj" else b""
    (folder / "secret.mtl").write_text("newmtl a\nmap_Kd secret.png\n")
    data = cloud_bytes(kind[1:], vertices) if kind in clouds else mesh_bytes(kind[1:], vertices, faces)
    (folder / f"object{kind}").write_bytes(text + data)
    return folder / f"object{kind}"


@pytest.mark.parametrize("kind", READERS)
def test_every_file_that_a_reader_opens_is_among_those_that_are_hashed(tmp_path, kind):
    """Also of a format that is added later: it is read here because it is in the table of readers."""
    require_reader(kind)
    path = example(kind, tmp_path)
    OPENED.clear()
    read_geometry(path)
    opened = {name for name in OPENED if Path(name).is_relative_to(tmp_path)}
    assert opened <= {str(part.path) for part in as_source(path).parts()} and str(path) in opened


@pytest.mark.parametrize("kind", READERS)
def test_an_object_is_read_of_the_bytes_that_were_hashed(tmp_path, kind):
    """Without a second look at the disk, where another file may stand by now; a source travels with its content."""
    require_reader(kind)
    path = example(kind, tmp_path)
    there, source = read_geometry(path), as_source(path)
    content = DROPPING.content_hash(source)
    for part in source.parts():
        part.path.write_bytes(b"another file by now")
    sent = pickle.loads(pickle.dumps(source))
    assert np.array_equal(read_geometry(sent).vertices, there.vertices)
    assert DROPPING.content_hash(sent) == content


LOOKS = [read_geometry, DROPPING.content_hash, lambda path: source_stamp(path) or refuse()]


def refuse():
    raise InputError("no file")


@pytest.mark.parametrize("look", LOOKS, ids=["read", "hashed", "looked at"])
@pytest.mark.parametrize("ending", READERS)
def test_what_never_ends_or_cannot_be_is_refused_whatever_it_is_called(tmp_path, ending, look):
    os.mkfifo(tmp_path / f"pipe{ending}")
    (tmp_path / f"device{ending}").symlink_to("/dev/zero")
    (tmp_path / f"circle{ending}").symlink_to(tmp_path / f"circle{ending}")
    for name in (f"pipe{ending}", f"device{ending}", f"circle{ending}", f"{'a' * 5000}{ending}", f"a\0b{ending}"):
        if look is LOOKS[2] and ending not in sources.NAMING and name[:4] in ("pipe", "devi"):
            continue  # its size alone is asked for, and there is one
        with pytest.raises(InputError) as error:
            look(tmp_path / name)
        assert len(str(error.value)) < 400 and "\n" not in str(error.value)


def test_sockets_are_refused(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)  # a socket's path is short
    with socket.socket(socket.AF_UNIX) as there:
        there.bind("a.urdf")
        with pytest.raises(InputError, match="ordinary file"):
            DROPPING.content_hash(Path("a.urdf"))


@pytest.mark.parametrize("mesh", ["a%00b.stl", "a" * 5000 + ".stl", "pipe.stl", "circle.stl", "missing.stl", "a.urdf"])
def test_one_bad_urdf_costs_itself_alone(tmp_path, mesh):
    os.mkfifo(tmp_path / "pipe.stl")
    (tmp_path / "circle.stl").symlink_to(tmp_path / "circle.stl")
    (tmp_path / "a.urdf").write_text(robot(mesh))
    (tmp_path / "good.ply").write_bytes(mesh_bytes("ply", *mug()))
    asked = ["classify", str(tmp_path / "a.urdf"), str(tmp_path / "good.ply"), "--json"]
    done = CliRunner().invoke(application("classify"), asked, catch_exceptions=False)
    bad, good = json.loads(done.stdout)
    assert done.exit_code == 2 and bad["error"].startswith(f"{tmp_path / 'a.urdf'}: ") and good["functions"]
    assert "\n" not in bad["error"] and len(bad["error"]) < 400


@pytest.mark.parametrize("command", ["classify", pytest.param("shapes", marks=pytest.mark.slow)])
def test_a_folder_without_files_costs_itself_alone(tmp_path, command, few_candidates):
    (tmp_path / "empty.ply").mkdir()
    (tmp_path / "good.ply").write_bytes(mesh_bytes("ply", *mug()))
    done = spherefunc(command, tmp_path / "empty.ply", tmp_path / "good.ply", "--json")
    rows = sorted(json.loads(done.stdout), key=lambda row: "error" not in row)
    assert done.returncode == 2 and rows[0]["error"].startswith(f"{tmp_path / 'empty.ply'}: expected a folder with ")
    assert done.stderr.count("empty.ply") == 1 and "error" not in rows[1]


def test_files_that_no_machine_could_hold_are_refused_with_what_they_name(tmp_path, monkeypatch):
    path = write_object("urdf", tmp_path / "model", shapes()[0])
    monkeypatch.setattr(sources, "MAX_FILE_BYTES", 1000)
    with pytest.raises(InputError, match="with the files that it names"):
        DROPPING.content_hash(path)
