"""Files from strangers are data: what is too large, climbs out or never ends is refused before it is loaded."""

from __future__ import annotations

import io
import os
import struct
import time
import zipfile
from pathlib import Path

import numpy as np
import pytest
from cloud_files import mesh_bytes, mug, npz_bytes, pcd_bytes

from spherefunc_bullet.clouds.cloud import load_cloud
from spherefunc_bullet.errors import InputError
from spherefunc_bullet.formats import files
from spherefunc_bullet.formats.npz import cached_check, entry_path, write_entry
from spherefunc_bullet.learning.model_file import load_model
from spherefunc_bullet.settling.cached_runs import DropConfig
from spherefunc_bullet.settling.settling import peak_bytes, reset_peak

DROPPING = DropConfig(simulator="fast", radii=(0.02,))
MANY = 100_000_000  # triangles


def refused(path: Path, read=load_cloud) -> str:
    """Return why a file is refused, in one line, at once (by the processor's time) and without filling memory."""
    started = time.process_time()
    reset_peak()
    before = peak_bytes()
    with pytest.raises(InputError) as error:
        read(path)
    assert time.process_time() - started < 5 and peak_bytes() - before < 300 << 20
    assert "\n" not in str(error.value) and path.name in str(error.value)
    return str(error.value)


def many_ply() -> bytes:
    ply = mesh_bytes("ply", *mug())
    at = ply.index(b"element face ") + len(b"element face ")
    return ply[:at] + str(MANY).encode() + ply[ply.index(b"\n", at) :]


def many_off() -> bytes:
    return b"OFF\n%d %d 0\n" % (len(mug()[0]), MANY) + b"0 0 0\n" * 100


def many_npz() -> bytes:
    header = io.BytesIO()
    np.lib.format.write_array_header_1_0(header, {"descr": "|u1", "fortran_order": False, "shape": (MANY, 3)})
    file = io.BytesIO(npz_bytes(vertices=mug()[0]))
    with zipfile.ZipFile(file, "a") as archive:
        archive.writestr("faces.npy", header.getvalue())
    return declaring(file.getvalue(), "faces.npy", len(header.getvalue()) + 3 * MANY)


def declaring(data: bytes, name: str, size: int) -> bytes:
    """Return an archive whose directory declares a size of a member that it has not."""
    at = data.rindex(name.encode()) - 46  # where the member's entry in the directory begins
    assert data[at : at + 4] == b"PK\x01\x02"
    return data[: at + 24] + struct.pack("<I", size) + data[at + 28 :]


@pytest.mark.parametrize("make", [many_ply, many_off, many_npz])
def test_a_hundred_million_triangles_are_refused_by_their_declaration(tmp_path, make):
    path = tmp_path / make.__name__.replace("_", ".")
    path.write_bytes(make())
    assert "at most 10,000,000 triangles, got 100,000,000" in refused(path)


@pytest.mark.parametrize("read", [load_cloud, DROPPING.content_hash])
def test_a_file_of_a_hundred_million_triangles_is_not_even_opened(tmp_path, read):
    path = tmp_path / "many.stl"
    path.write_bytes(bytes(80) + struct.pack("<I", MANY))
    os.truncate(path, 84 + 50 * MANY)  # takes no room on the disk
    assert "at most 512 MiB, got 4768 MiB" in refused(path, read)


def test_triangles_of_a_binary_stl_are_counted_before_they_are_read(tmp_path, monkeypatch):
    monkeypatch.setattr(files, "MAX_TRIANGLES", 10)
    (tmp_path / "mug.stl").write_bytes(mesh_bytes("stl", *mug()))
    assert "at most 10 triangles" in refused(tmp_path / "mug.stl")


@pytest.mark.parametrize("ending", ["obj", "off", "xyz", "ply ascii", "stl ascii", "pcd ascii"])
def test_text_has_a_limit_of_its_own(tmp_path, monkeypatch, ending):
    monkeypatch.setattr(files, "MAX_TEXT_BYTES", 1 << 10)
    data = {"xyz": b"0 0 0\n" * 1000, "pcd ascii": pcd_bytes(np.ones((1000, 3)), "ascii")}
    path = tmp_path / f"mug.{ending.split()[0]}"
    path.write_bytes(data.get(ending) or mesh_bytes(ending, *mug()))
    assert "of text" in refused(path)


@pytest.mark.parametrize("name", ["../points.npy", "/etc/points.npy", "a/../../points.npy", "..\\points.npy"])
def test_members_that_climb_out_are_refused(tmp_path, name):
    with zipfile.ZipFile(tmp_path / "cloud.npz", "w") as archive:
        array = io.BytesIO()
        np.save(array, np.ones((100, 3)))
        archive.writestr(name, array.getvalue())
    assert "inside the archive" in refused(tmp_path / "cloud.npz")


def bomb() -> bytes:
    """Return an archive of a few kilobytes whose only array unpacks to three gigabytes, as it says."""
    header = io.BytesIO()
    np.lib.format.write_array_header_1_0(header, {"descr": "|u1", "fortran_order": False, "shape": (1 << 30, 3)})
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("points.npy", header.getvalue() + bytes(1 << 20))
    return declaring(file.getvalue(), "points.npy", len(header.getvalue()) + (3 << 30))


@pytest.mark.parametrize("read", [load_cloud, load_model])
def test_compressed_bombs_are_refused_by_what_they_declare(tmp_path, read):
    (tmp_path / "bomb.npz").write_bytes(bomb())
    assert "MiB unpacked" in refused(tmp_path / "bomb.npz", read)


@pytest.mark.parametrize("read", [load_cloud, DROPPING.content_hash])
def test_pipes_are_refused_and_not_waited_for(tmp_path, read):
    os.mkfifo(tmp_path / "pipe.ply")
    assert "ordinary file" in refused(tmp_path / "pipe.ply", read)


def test_pickles_in_models_are_not_opened(tmp_path):
    class Trap:
        def __reduce__(self):
            return os.mkdir, (str(tmp_path / "sprung"),)

    np.savez(tmp_path / "model.npz", about=np.array([Trap()], dtype=object))
    refused(tmp_path / "model.npz", load_model)
    assert not (tmp_path / "sprung").exists()


def test_a_cached_result_under_another_name_is_computed_again(tmp_path):
    """As another version of this package may have written it; it ended in a KeyError."""
    write_entry(entry_path("falls_over", "0" * 64, tmp_path), {"answer": np.array(True)})
    assert not cached_check("0" * 64, "falls_over", lambda: False, tmp_path)
