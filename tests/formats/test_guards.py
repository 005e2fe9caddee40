"""Whatever file a command is given, it is looked at before it is opened: none hangs it, none ends it in a traceback."""

from __future__ import annotations

import os
import signal
from contextlib import contextmanager
from pathlib import Path

import pytest
from cloud_files import mesh_bytes, mug
from commands import spherefunc

from spherefunc_bullet.formats.files import write_bytes, write_csv, write_text

LONG = "a" * 5000
HUNG = 120  # seconds after which a command waits for ever


@contextmanager
def no_wait_for_ever():
    """Interrupt what waits for ever, such as for somebody to write into a pipe."""

    def interrupt(*_):
        raise TimeoutError(f"still waiting after {HUNG} s")

    before = signal.signal(signal.SIGALRM, interrupt)
    signal.alarm(HUNG)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)


def refused(*arguments: str, text: str = "") -> str:
    """Return the one line with which a command refuses a file."""
    with no_wait_for_ever():
        done = spherefunc(*arguments, text=text)
    assert done.returncode == 2, done.stderr
    return done.stderr


@pytest.fixture
def folder(tmp_path, monkeypatch) -> Path:
    """Return the folder where the command is called."""
    monkeypatch.chdir(tmp_path)
    for name in ("pipe.ply", "pipe.png", "pipe.npy", "pipe.json", "pipe.npz", "pipe.urdf", "pipe.xyz", "pipe.gltf"):
        os.mkfifo(tmp_path / name)
    (tmp_path / "mug.ply").write_bytes(mesh_bytes("ply", *mug()))
    return tmp_path


@pytest.mark.parametrize(
    "arguments",
    [
        *[[command, "pipe.urdf"] for command in ("classify", "poses", "stand", "carry", "view")],
        ["together", "pipe.urdf", "mug.ply"],
        ["simulate", "pipe.gltf", "--radius", "1cm"],
        ["classify", "mug.ply", "--model", "pipe.npz"],
        *[["scene", name] for name in ("pipe.xyz", "pipe.png", "pipe.npy", "pipe.urdf")],
    ],
    ids=" ".join,
)
def test_a_pipe_is_not_waited_for(folder, arguments):
    lines = refused(*arguments).splitlines()
    assert any("expected an ordinary file" in line for line in lines) and len(lines) <= 2, lines


def test_a_camera_s_file_is_looked_at_as_well(folder):
    image = pytest.importorskip("PIL.Image")
    image.new("I;16", (64, 48), 1000).save(folder / "depth.png")
    for option in (["--intrinsics", "pipe.json"], ["--color", "pipe.png"]):
        assert "expected an ordinary file" in refused("scene", "depth.png", *option)


@pytest.mark.parametrize("command", ["classify", "scene", "view"])
def test_a_name_that_no_file_can_have(folder, command):
    line = refused(command, f"{LONG}.ply")
    assert "File name too long" in line and len(line) < 500


def test_names_on_stdin_may_hold_anything(folder):
    lines = refused("classify", "-", text=f"a\0b.ply\n{LONG}.ply\npipe.urdf\nmug.ply\n").splitlines()
    assert sum(line.startswith("spherefunc: ") for line in lines) == 3, lines


@pytest.mark.parametrize("data", [LONG, f"{LONG}.csv"])
def test_data_of_a_name_that_no_folder_can_have(folder, data):
    assert "spherefunc: " in refused("evaluate", data)


def test_a_manifest_may_name_what_it_likes(folder):
    (folder / "data").mkdir()
    (folder / "data" / "manifest.csv").write_text(f"file,label\na\0b.ply,cup\n{LONG}.ply,none\n")
    line = refused("train", "data", "--out", "model.npz", "--radii", "2cm")
    assert "manifest.csv" in line


@pytest.mark.parametrize("command", [["train", "data", "--out", "model.npz"], ["evaluate", "data"]], ids=" ".join)
def test_an_object_with_two_labels_is_named_before_spheres_fall(folder, command):
    (folder / "data").mkdir()
    (folder / "data" / "manifest.csv").write_text("file,label\na.ply,cup\nb.ply,none\nc.ply,cup\na.ply,table\n")
    assert "a.ply: expected one label for one object, got cup and table" in refused(*command)


def test_what_is_written_is_whole_or_as_before(tmp_path, monkeypatch):
    path = write_text(tmp_path / "table.csv", "before")

    def interrupted(*_):
        raise KeyboardInterrupt

    with monkeypatch.context() as patch, pytest.raises(KeyboardInterrupt):
        patch.setattr("os.replace", interrupted)
        write_bytes(path, b"after")
    assert path.read_text() == "before" and os.listdir(tmp_path) == ["table.csv"]
    link = tmp_path / "link.csv"
    link.symlink_to("table.csv")
    write_csv(link, ["file"], [["\udcff.ply"]])  # the name of a file need not be text
    assert link.is_symlink() and path.read_text().split() == ["file", "?.ply"]


def test_a_pipe_is_written_to_and_not_replaced(tmp_path):
    pipe = tmp_path / "pipe.csv"
    os.mkfifo(pipe)
    with open(os.open(pipe, os.O_RDONLY | os.O_NONBLOCK)) as end:
        write_text(pipe, "a line")
        assert end.read() == "a line"
    assert pipe.is_fifo()
