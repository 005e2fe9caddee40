"""Tables of README and docs are written from saved results, and are as old as the code that they measure."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path

import pytest
from checkout import ROOT

from spherefunc_bullet.compare.documents.__main__ import TABLES, due, measure, wanted, write_tables
from spherefunc_bullet.compare.documents.tables import (
    BLOCK,
    OLDER,
    DocumentTable,
    Measurement,
    blocks_of,
    code_hash,
    complaints,
    quoted,
    with_blocks,
)
from spherefunc_bullet.errors import InputError

SPEED = 'from .model import DROPS\n\n\ndef speed():\n    """Return drops a second."""\n    return 2 * DROPS\n'
MEASUREMENT = Measurement(  # `true` takes the option --json that is put behind
    name="speed",
    command='echo "{\\"drops\\": $(cat count)}"; true',
    modules=("compare/*.py",),
    files=("model.npz",),
)
TABLE = DocumentTable(
    name="drops",
    document="README.md",
    measurements=(MEASUREMENT,),
    render=lambda result: ["| drops |", "|---|", f"| {result['drops']} |"],
)


@pytest.fixture
def repository(tmp_path) -> Path:
    """Return a small repository whose one table has been measured and written."""
    root = tmp_path / "repository"
    (root / "compare").mkdir(parents=True)
    (root / "compare" / "speed.py").write_text(SPEED)
    (root / "compare" / "model.py").write_text("DROPS = 7\n")
    (root / "model.npz").write_bytes(b"forest")
    (root / "count").write_text("14")
    (root / "README.md").write_text("# Speed\n\n<!-- table: drops -->\n<!-- end -->\n\nMore.\n")
    measure(root, [MEASUREMENT])
    write_tables(root, [TABLE])
    return root


def test_what_is_measured_is_written_between_the_markers(repository):
    text = (repository / "README.md").read_text()
    assert text.startswith("# Speed\n\n<!-- table: drops -->\n| drops |\n|---|\n| 14 |\n\nMeasured by `echo")
    assert text.endswith("<!-- end -->\n\nMore.\n") and not complaints(repository, [TABLE])
    saved = json.loads((repository / "docs/results/speed.json").read_text())
    assert saved["result"] == {"drops": 14} and set(saved["code"]) == {
        "compare/speed.py",
        "compare/model.py",
        "model.npz",
    }
    assert saved["date"] and saved["processor"] and saved["versions"]["numpy"]


@pytest.mark.parametrize(
    ("file", "old", "new"),
    [("speed.py", "2 * DROPS", "3 * DROPS"), ("model.py", "7", "8"), ("../model.npz", "forest", "trees")],
    ids=["the module", "another one", "a model"],
)
def test_a_table_is_older_than_code_that_has_changed(repository, file, old, new):
    path = repository / "compare" / file
    path.write_text(path.read_text().replace(old, new))
    code_hash.cache_clear()
    (line,) = complaints(repository, [TABLE])
    assert path.resolve().name in line and "older than" in line and "make tables ONLY=drops" in line


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("drops a second", "how many drops a second holds"),
        ("return", "# doubled\n    return"),
        ("2 * DROPS", "(2*DROPS)"),
    ],
    ids=["docstring", "comment", "layout"],
)
def test_words_may_change(repository, old, new):
    path = repository / "compare" / "speed.py"
    path.write_text(path.read_text().replace(old, new))
    code_hash.cache_clear()
    assert not complaints(repository, [TABLE])


def test_data_outside_the_repository_count_where_they_are(repository):
    data = repository.parent / "data"
    data.mkdir()
    (data / "manifest.csv").write_text("file,label\na.ply,cup\n")
    measured = replace(MEASUREMENT, command=MEASUREMENT.command.replace("echo", "ls ../data > /dev/null; echo"))
    measure(repository, [measured])
    assert not measured.changed(repository)
    (data / "manifest.csv").write_text("file,label\na.ply,none\n")
    assert measured.changed(repository) == ["../data/manifest.csv"]
    (data / "manifest.csv").unlink()  # as in a checkout beside which nobody put them
    assert not measured.changed(repository)


def test_another_command_is_another_measurement(repository):
    other = replace(TABLE, measurements=(replace(MEASUREMENT, command="echo 1"),))
    assert "its command" in complaints(repository, [other])[0]


def test_what_is_typed_into_a_table_is_seen(repository):
    path = repository / "README.md"
    path.write_text(path.read_text().replace("| 14 |", "| 15 |"))
    assert ["expected what the saved results say" in line for line in complaints(repository, [TABLE])] == [True]
    write_tables(repository, [TABLE])
    assert "| 14 |" in path.read_text() and not complaints(repository, [TABLE])


def test_a_table_without_markers_and_markers_without_a_table_are_seen(repository):
    other = replace(TABLE, name="rolls")
    lines = complaints(repository, [other])
    assert any("table rolls: expected its markers" in line for line in lines)
    assert any("table drops: expected an entry" in line for line in lines)


def test_an_older_table_is_kept_only_with_a_line_that_says_so(repository):
    code = repository / "compare" / "speed.py"
    code.write_text(code.read_text().replace("2", "3"))
    code_hash.cache_clear()
    TABLE.keep(repository, "an hour's work.")
    write_tables(repository, [TABLE])
    path = repository / "README.md"
    assert "| 14 |\n\nMeasured by" in path.read_text() and f"{OLDER} an hour's work.*\n<!-- end -->" in path.read_text()
    assert not complaints(repository, [TABLE])
    path.write_text(path.read_text().replace(f"{OLDER} an hour's work.*\n", ""))
    assert complaints(repository, [TABLE])
    assert due(repository, [TABLE], [MEASUREMENT]) == [] and due(repository, [], [MEASUREMENT]) == [MEASUREMENT]
    (repository / "count").write_text("21")
    measure(repository, [MEASUREMENT])  # again, so that what was kept is kept no longer
    write_tables(repository, [TABLE])
    assert "| 21 |" in path.read_text() and OLDER not in path.read_text() and not complaints(repository, [TABLE])


def test_a_command_that_fails_leaves_the_result_as_it_was(repository, capsys):
    before = (repository / "docs/results/speed.json").read_text()
    measure(repository, [replace(MEASUREMENT, command="exit 3; true")])
    assert (repository / "docs/results/speed.json").read_text() == before
    assert "expected exit code 0, got 3" in capsys.readouterr().err


def test_names_mean_tables_documents_and_measurements():
    table = TABLES[0]
    for name in (table.name, table.document, table.measurements[0].name):
        assert table in wanted([name])[0]
    assert wanted([table.measurements[0].name])[1] == [table.measurements[0]]
    with pytest.raises(InputError, match="expected one of"):
        wanted(["no such table"])


def test_blocks_need_both_markers_and_names_of_their_own():
    block = "<!-- table: a -->\nx\n<!-- end -->\n"
    assert blocks_of(block, "") == {"a": "x\n"}
    assert with_blocks(f"1\n{block}2", {"a": "y\n", "b": "z\n"}) == f"1\n{block}2".replace("x", "y")
    for text in (block + block, "<!-- end -->", "<!-- table: a -->", f"<!-- table: b -->\n{block}"):
        with pytest.raises(InputError, match="each name once"):
            blocks_of(text, "README.md")


def test_every_pattern_of_code_finds_files():
    patterns = {pattern for table in TABLES for one in table.measurements for pattern in one.modules}
    assert [pattern for pattern in patterns if not any(ROOT.glob(pattern))] == []


def test_every_table_is_as_old_as_the_code_that_it_measures():
    assert complaints(ROOT, TABLES) == []


def test_every_name_is_used_once():
    assert len({(table.document, table.name) for table in TABLES}) == len(TABLES)
    measurements = {one for table in TABLES for one in table.measurements}
    assert len({one.name for one in measurements}) == len(measurements)


def test_no_measured_table_is_typed():
    """Several F-measures, or shares, stand in a row of a table only where a program wrote them."""
    figure = re.compile(r"^\|.*\b[01]\.\d{3}\b\D{1,6}[01]\.\d{3}\b.*|^\|.*\b0\.\d\d / [01]\.\d\d\b.*", re.MULTILINE)
    for path in {ROOT / "README.md", *(ROOT / "docs").glob("*.md")}:
        typed = figure.findall(BLOCK.sub("", path.read_text(encoding="utf-8")))
        assert not typed, f"{path.name}: {typed[:3]}"


def test_commands_that_differ_by_the_backend_alone_are_named_once():
    assert quoted(["a", "b", "a --backend bullet"]) == "`a` and with `--backend bullet`, `b`"
    assert quoted(["c --backend bullet"]) == "`c --backend bullet`"
