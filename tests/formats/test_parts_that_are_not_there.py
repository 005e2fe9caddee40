"""Files that stand for more than they hold: a line says what is not there, instead of an answer about the rest."""

from __future__ import annotations

import pytest

from spherefunc_bullet.errors import InputError
from spherefunc_bullet.formats.sources import read_geometry

BOX = '<link name="{0}"><visual><geometry><box size="0.3 0.3 0.3"/></geometry></visual></link>'
XACRO = 'xmlns:xacro="http://www.ros.org/wiki/xacro"'


def refused(path) -> str:
    with pytest.raises(InputError) as error:
        read_geometry(path)
    return str(error.value)


@pytest.mark.parametrize("macro", ['<xacro:include filename="legs.xacro"/>', '<xacro:leg name="left"/>'])
def test_a_urdf_with_macros_is_not_read_without_them(tmp_path, macro):
    path = tmp_path / "table.urdf"
    path.write_text(f'<robot name="table" {XACRO}>{BOX.format("top")}{macro}</robot>')
    assert "macros (xacro:" in refused(path) and "expand it with xacro first" in refused(path)


def test_a_urdf_that_was_expanded_may_still_name_the_language(tmp_path):
    path = tmp_path / "table.urdf"
    path.write_text(f'<robot name="table" {XACRO}><!-- <xacro:leg/> -->{BOX.format("top")}</robot>')
    assert len(read_geometry(path).faces) == 12
