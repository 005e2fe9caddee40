"""SDF is read as Gazebo shows it, or refused by what it says and is not read."""

from __future__ import annotations

import pytest
from read_files import extent, refused

BOX = "<geometry><box><size>0.1 0.2 0.3</size></box></geometry>"
SDF = """<sdf version="1.9">{0}<model name="m">{1}<link name="a">{2}<visual name="v">{3}{4}</visual></link></model>
</sdf>"""


def write(tmp_path, before="", model="", link="", geometry=BOX, material=""):
    path = tmp_path / "m.sdf"
    path.write_text(SDF.format(before, model, link, geometry, material))
    return path


def test_a_model_that_was_stood_up_is_read_as_it_stands(tmp_path):
    pose = "<pose degrees='true'>0 0 5 90 0 0</pose>"
    assert extent(write(tmp_path, model=pose)) == [0.1, 0.3, 0.2]
    path = write(tmp_path, model=pose)
    path.write_text(path.read_text().replace("<model", "<world name='w'><model").replace("</sdf>", "</world></sdf>"))
    assert extent(path) == [0.1, 0.3, 0.2]


@pytest.mark.parametrize("clear", ["<transparency>1</transparency>", "<material><diffuse>1 1 1 0</diffuse></material>"])
def test_what_is_transparent_is_not_seen(tmp_path, clear):
    assert "expected visible parts, found none" in refused(write(tmp_path, material=clear))
    half = clear.replace("1</t", "0.5</t").replace(" 0<", " 0.5<")
    assert extent(write(tmp_path, material=half)) == [0.1, 0.2, 0.3]


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"link": "<pose relative_to='top'></pose>"}, "got one relative to 'top'"),
        ({"link": "<pose frame='top'>0 0 0 0 0 0</pose>"}, "got one relative to 'top'"),
        ({"link": "<pose>0 0 0</pose>"}, "expected poses of 6 numbers, got one of 3"),
        ({"geometry": BOX.replace("0.3", "")}, "expected 3 numbers as box/size, got 2"),
        ({"geometry": "<geometry><mesh><uri> </uri></mesh></geometry>"}, "expected the name of a file, got ''"),
        ({"model": "<model name='b'/>"}, "expected one model, got 1 more"),
        ({"before": "<include><uri>model://b</uri></include>"}, "expected one model, got 1 more"),
    ],
)
def test_what_is_not_read_is_refused_in_one_line(tmp_path, given, words):
    assert words in refused(write(tmp_path, **given))


def test_the_models_of_a_plugin_are_none_of_the_file(tmp_path):
    assert extent(write(tmp_path, model="<plugin><model>m</model><include>m</include></plugin>")) == [0.1, 0.2, 0.3]


@pytest.mark.parametrize("text", ["<robot name='a'/>", "<sdf><world name='w'/></sdf>"])
def test_a_file_without_a_model_is_called_that(tmp_path, text):
    (tmp_path / "m.sdf").write_text(text)
    assert "expected an SDF with a model" in refused(tmp_path / "m.sdf")
    (tmp_path / "m.sdf").write_text("<sdf><include><uri>model://b</uri></include></sdf>")
    assert "got one that is included" in refused(tmp_path / "m.sdf")
