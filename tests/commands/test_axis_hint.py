"""What the library proposes as an argument of Python is proposed as an option on the command line."""

from __future__ import annotations

import pytest
from commands import spherefunc

# A square metre that stands on its edge: with y up it would lie.
WALL = "v 0 0 0\nv 1 0 0\nv 1 0 1\nv 0 0 1\nf 1 2 3 4\n"


@pytest.mark.parametrize("options", [[], ["--explain"]])
def test_a_doubtful_axis_is_named_as_an_option(tmp_path, options):
    (tmp_path / "wall.obj").write_text(WALL)
    said = spherefunc("classify", tmp_path / "wall.obj", *options).stdout
    assert "is its up axis right? --up y says so" in said and 'up="y"' not in said
