"""A name that is mistyped is not taken for a file of an unknown format."""

from __future__ import annotations

import pytest

from spherefunc_bullet.errors import InputError
from spherefunc_bullet.formats.sources import read_geometry


@pytest.mark.parametrize("name", ["mug", "mug.objj", "mug.obj"])
def test_a_file_that_is_missing_is_called_so(tmp_path, name):
    with pytest.raises(InputError, match="expected a file, found none; check the path"):
        read_geometry(tmp_path / name)


def test_a_file_of_an_unknown_format_is_still_refused(tmp_path):
    (tmp_path / "mug.objj").write_text("v 0 0 0\n")
    with pytest.raises(InputError, match=r"expected one of .*, got '\.objj'; convert it"):
        read_geometry(tmp_path / "mug.objj")


@pytest.mark.parametrize("ending", [".bag", ".db3", ".mcap"])
def test_a_bag_is_refused_as_an_object_and_said_to_be_a_scan(tmp_path, ending):
    (tmp_path / f"drive{ending}").write_bytes(b"#ROSBAG V2.0\n")
    with pytest.raises(
        InputError, match=rf"expected one of .*, got '\{ending}'; of a bag, `spherefunc scene` reads the clouds"
    ):
        read_geometry(tmp_path / f"drive{ending}")
