"""Data sets: manifests as people write them, folders of labels, names of catalogues, and what is refused."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from spherefunc_bullet.commands.classify import listed_files
from spherefunc_bullet.commands.shapes import objects_in
from spherefunc_bullet.datasets.dataset import DatasetObject, distinct_names, open_dataset, parse_functions
from spherefunc_bullet.errors import InputError


@pytest.fixture
def write(tmp_path):
    def manifest(text: str | bytes):
        path = tmp_path / "set" / "manifest.csv"
        path.parent.mkdir(exist_ok=True)
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        return path.parent

    return manifest


def check_refused(data, match):
    with pytest.raises(InputError, match=match) as caught:
        open_dataset(data)
    assert "\n" not in str(caught.value)


def test_manifest_keeps_its_order_and_meaning(write):
    folder = write(
        "file,label,also,category,group\n"
        "b.ply,table,sittable,coffee_table,shop\n"
        "a.ply,table; desk ,,desk,\n"
        "sub/c.ply,none,cup,vase,home\n"
    )
    dataset = open_dataset(folder)
    assert dataset.name == "set" and len(dataset) == 3
    assert dataset.functions == ("desk", "table")
    first, second, third = dataset.objects
    assert first.path == folder / "b.ply" and third.path == folder / "sub" / "c.ply"
    assert (first.functions, second.functions, third.functions) == ({"table"}, {"table", "desk"}, frozenset())
    assert (first.also, second.also, third.also) == ({"sittable"}, frozenset(), {"cup"})
    assert (first.group, second.group, first.category) == ("shop", "", "coffee_table")


def test_labels():
    assert parse_functions("table;sittable;none") == {"table", "sittable"}
    assert (
        parse_functions(" none ")
        == parse_functions("None")
        == parse_functions("")
        == parse_functions(";")
        == frozenset()
    )


def test_other_columns_in_another_order_are_fine(write):
    assert len(open_dataset(write("file,label\na.ply,cup,,\n"))) == 1  # as spreadsheets write it
    dataset = open_dataset(write('notes,label,weight,file\n"new, blue",cup,3,a.ply\n'))
    assert dataset.objects[0].path.name == "a.ply" and dataset.objects[0].functions == {"cup"}


@pytest.mark.parametrize(
    "text", [b"\xef\xbb\xbffile,label\na.ply,cup\n", b"file,label\r\na.ply,cup\r\n", b"file, label\na.ply, cup\n"]
)
def test_marks_of_other_systems_are_fine(write, text):
    assert open_dataset(write(text)).objects[0].functions == {"cup"}


def test_the_current_folder_has_a_name(write, monkeypatch):
    monkeypatch.chdir(write("file,label\na.ply,cup\n"))
    assert open_dataset(".").name == open_dataset("manifest.csv").name == "set"


def test_manifest_by_its_own_path(write):
    folder = write("file,label\na.ply,cup\n")
    assert open_dataset(folder / "manifest.csv") == open_dataset(folder) == open_dataset(str(folder))


@pytest.mark.parametrize(
    ("text", "match"),
    [
        ("file,kind\na.ply,cup\n", "columns file and label, separated by commas, got file, kind"),
        ("name,label\na.ply,cup\n", "columns file and label, separated by commas, got name, label"),
        ("file;label\na.ply;cup\n", "separated by commas, got file;label"),
        ("file,label\na.ply,cup\nb.ply,Cup\n", "one spelling of a label, got 'Cup' and 'cup'"),
        ("", "columns file and label, separated by commas, got no columns"),
        ("file,label\n", "at least one row"),
        (b"file,label\n\xff\xfe.ply,cup\n", "UTF-8"),
        (b"\x00\x01\x02", "columns file and label"),
        ("file,label\na.ply\n", "line 2: expected a file and a label"),
        ("file,label\na.ply,cup\n,cup\n", "line 3: expected a file and a label"),
        ("file,label\na.ply, \n", "line 2: expected a file and a label"),
        ("file,label\na.ply,['cup']\n", "line 2: label .*expected functions separated by ;, without"),
        ("file,label\na.ply,{'cup'}\n", "line 2: label .*expected functions separated by ;, without"),
        ("file,label\na.ply,cup,table\n", "line 2: expected a value for each column, got 'table' too"),
        ("file,label,label\na.ply,cup,table\n", "columns file and label, separated by commas, got file, label, label"),
        ('file,label,notes\na.ply,cup,"old\nb.ply,none,\n', "every quote closed; unexpected end of data"),
        ('file,label,notes\na.ply,cup,"old\n' + "b.ply,none,\n" * 20_000, "every quote closed; field larger"),
    ],
)
def test_manifest_that_is_not_usable_is_refused(write, text, match):
    check_refused(write(text), match)


@pytest.mark.parametrize("file", ["../secret.ply", "/etc/passwd", "sub/../../secret.ply", "."])
def test_paths_that_climb_out_are_refused(write, file):
    check_refused(write(f"file,label\n{file},cup\n"), "line 2: expected a file below the manifest's folder")


def test_link_that_leads_out_is_refused(write, tmp_path):
    (tmp_path / "outside.ply").write_text("")
    folder = write("file,label\nlink.ply,cup\n")
    os.symlink(tmp_path / "outside.ply", folder / "link.ply")
    check_refused(folder, "below the manifest's folder")


def test_missing_files_are_each_object_s_own_failure(write):
    """Opening looks at no model: a file that is missing fails when it is simulated, and the rest goes on."""
    assert len(open_dataset(write("file,label\ngone.ply,cup\nalso_gone.ply,none\n"))) == 2


def test_hidden_files_and_folders_are_no_objects(tmp_path):
    kept, hidden = ("cup/a.ply", "cup/more/b.obj"), ("cup/._a.ply", "cup/.git/c.stl", ".cups/a.ply", "__MACOSX/._a.ply")
    for file in kept + hidden:
        (tmp_path / file).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / file).write_text("o")
    dataset = open_dataset(tmp_path)
    assert [str(item.path.relative_to(tmp_path)) for item in dataset.objects] == [*kept]
    assert dataset.functions == ("cup",) and [*listed_files([tmp_path])] == [*objects_in([tmp_path])] != []
    assert [*listed_files([tmp_path / ".cups"])] == [tmp_path / ".cups" / "a.ply"]


def test_folders_named_for_their_label(tmp_path):
    for path in (
        "cup/b.STL",
        "cup/a.ply",
        "cup/deep/c.obj",
        "none/d.npz",
        "table;sittable/e.glb",
        "none/notes.txt",
    ):
        (tmp_path / path).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / path).write_text("")
    dataset = open_dataset(tmp_path)
    assert [each.path.name for each in dataset.objects] == ["a.ply", "b.STL", "c.obj", "d.npz", "e.glb"]
    assert [sorted(each.functions) for each in dataset.objects[2:]] == [["cup"], [], ["sittable", "table"]]
    assert dataset.name == tmp_path.name and "e.glb" not in repr(dataset)  # of thousands, it would fill a notebook


@pytest.mark.parametrize("name", ["cup/link.ply", "cup", "cup/deep"])
def test_link_that_leads_out_of_label_folders_is_refused(tmp_path, name):
    (tmp_path / "outside" / "cup").mkdir(parents=True)
    (tmp_path / "outside" / "secret.ply").write_text("")
    (tmp_path / "set" / "none").mkdir(parents=True)
    (tmp_path / "set" / "none" / "own.ply").write_text("")
    link = tmp_path / "set" / name
    link.parent.mkdir(exist_ok=True)
    os.symlink(tmp_path / "outside" / ("secret.ply" if name.endswith("ply") else ""), link)
    if name == "cup/deep":  # what lies in a linked folder is not looked for at all
        assert [each.path.name for each in open_dataset(tmp_path / "set").objects] == ["own.ply"]
    else:
        check_refused(tmp_path / "set", "a link that leads out of it")


def test_link_within_a_data_set_is_followed(tmp_path):
    (tmp_path / "cup").mkdir()
    (tmp_path / "cup" / "mug.ply").write_text("")
    os.symlink("mug.ply", tmp_path / "cup" / "same.ply")
    assert len(open_dataset(tmp_path)) == 2


def test_folder_without_either_is_refused(tmp_path):
    (tmp_path / "cup").mkdir()
    (tmp_path / "loose.ply").write_text("")
    check_refused(tmp_path, "expected a manifest.csv, or folders")


@pytest.mark.slow
def test_name_of_a_catalogue(tmp_path, monkeypatch):
    monkeypatch.setenv("SPHEREFUNC_CACHE", str(tmp_path))
    dataset = open_dataset("household")
    assert len(dataset) == 200 and dataset.functions == ("cup", "sittable", "table")
    assert all(each.path.is_file() and tmp_path in each.path.parents for each in dataset.objects)
    stamp = dataset.objects[0].path.stat().st_mtime_ns
    assert open_dataset("household") == dataset  # and not built again:
    assert dataset.objects[0].path.stat().st_mtime_ns == stamp


def test_unknown_name_lists_the_catalogues(tmp_path):
    check_refused("no-such-set", "household, surroundings; found nothing of that name")
    (tmp_path / "model.ply").write_text("")
    check_refused(tmp_path / "model.ply", "found a file")


def test_objects_that_are_called_alike_are_told_apart_and_copies_keep_to_their_own():
    files = [("one/early.ply", "mug.ply"), ("one/mug.ply", ""), ("impaired/0.ply", "mug.ply"), ("two/mug.ply", "")]
    files += [("impaired/1.ply", "one/mug.ply"), ("three/cup.ply", "gone.ply")]
    objects = [DatasetObject(path=Path(file), functions=frozenset(), of=of) for file, of in files]
    names, originals = distinct_names(objects)
    assert names == ["early.ply", "mug.ply", "0.ply", "two/mug.ply", "1.ply", "cup.ply"]
    assert originals == ["mug.ply", "", "mug.ply", "", "two/mug.ply", "gone.ply"]


@pytest.mark.parametrize("closed", [".", "cup"])
def test_a_folder_that_cannot_be_read_is_named(tmp_path, monkeypatch, closed):
    (tmp_path / "cup").mkdir()
    (tmp_path / "cup" / "mug.ply").write_text("")
    listed = Path.iterdir

    def iterdir(folder):  # root may read any
        if folder == tmp_path / closed:
            raise PermissionError(13, "Permission denied")
        return listed(folder)

    monkeypatch.setattr(Path, "iterdir", iterdir)
    with pytest.raises(InputError, match="expected a folder that can be read; .*Permission denied"):
        open_dataset(tmp_path)
