"""A library with links whose files were not fetched, as git-annex keeps them: they are reported, not left out."""

from __future__ import annotations

import pytest
from commands import spherefunc

from spherefunc_bullet.commands.shapes import objects_in


@pytest.fixture
def library(tmp_path):
    """A box, a link to a file that is missing, one to a folder that is, and one to a folder of the library."""
    (tmp_path / "box.obj").write_text("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n")
    (tmp_path / "missing.ply").symlink_to(".git/annex/objects/missing.ply")
    (tmp_path / "others").symlink_to("nowhere")
    (tmp_path / "folder.ply").mkdir()
    (tmp_path / "same.ply").symlink_to("folder.ply")
    return tmp_path


def test_classify_says_which_files_are_missing(library):
    done = spherefunc("classify", library)
    assert done.returncode == 2 and "box.obj" in done.stdout
    (error, *_) = done.stderr.splitlines()
    assert "missing.ply: expected a file, found none" in error
    assert "1 of 2 files could not be classified" in done.stderr


def test_shapes_takes_them_for_objects_too(library):
    assert [path.name for path in objects_in([library])] == ["box.obj", "missing.ply"]
