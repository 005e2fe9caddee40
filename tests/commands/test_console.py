"""What is printed does nothing to a terminal, whatever strangers call their files, and names options as they are."""

from __future__ import annotations

import contextlib
import io
import json
import logging
import os
import subprocess
import sys
import warnings
from pathlib import Path

import numpy as np
import pytest
from checkout import ROOT
from cloud_files import mesh_bytes, mug
from commands import spherefunc

import spherefunc_bullet as sf
from spherefunc_bullet import console
from spherefunc_bullet.clouds.conversion import warn
from spherefunc_bullet.errors import InputError

CODE = "from spherefunc_bullet.commands.command_line import main; main()"
ESCAPES = ("\x1b[31mred", "\x1b]0;title\x07", "\r over", "\x9b2J", "[bold]x[/bold]", "[/foo]", "\u202egnp.", "\x7f")


def run(folder: Path, *arguments) -> subprocess.CompletedProcess:
    return subprocess.run([sys.executable, "-c", CODE, *arguments], cwd=folder, capture_output=True, check=False)


def obeyed(text: str) -> list[str]:
    """Return what of a text a terminal would obey."""
    return [each for each in text if each != "\n" and (ord(each) < 32 or 127 <= ord(each) < 160 or each == "\u202e")]


@pytest.mark.parametrize("name", ESCAPES)
def test_everything_that_is_printed_is_text(name, capsys, monkeypatch):
    console.show(name)
    console.say(name)
    console.fail(InputError(name))
    console.print_json([name])
    console.print_table(name, ["a", name], [[name, 1.0]])
    logger = logging.getLogger("spherefunc")
    monkeypatch.setattr(logger, "handlers", [])
    console.log_on_stderr()
    logger.warning(name)
    printed = capsys.readouterr()
    assert not obeyed(printed.out) and not obeyed(printed.err)
    bare = console.printable(name)
    assert printed.out.count(bare) >= 4 and printed.err.count(bare) >= 2  # an error is one line, without a return


def test_a_warning_is_one_line_in_the_words_of_the_command_line(capsys, monkeypatch):
    monkeypatch.setattr(logging.getLogger("spherefunc"), "handlers", [])
    others = []
    with warnings.catch_warnings():
        warnings.simplefilter("always")
        warnings.showwarning = lambda message, *_: others.append(str(message))
        console.log_on_stderr()
        warn('a.obj: took its unit to be m;\nunits="mm" says otherwise')
        warnings.warn("old", FutureWarning, stacklevel=1)
    assert capsys.readouterr().err == "a.obj: took its unit to be m; --units mm says otherwise\n"
    assert others == ["old"]


def test_a_table_for_a_pipe_is_as_wide_as_its_cells(capsys):
    columns = ["copy", *(f"spheres by bullet, copies learnt, kind {number} left out" for number in range(12))]
    console.print_table("title", columns, [["cup, whole", *(["0.93"] * 12)]])
    head, row = capsys.readouterr().out.splitlines()[1:]
    assert all(column in head for column in columns) and row.split() == ["cup,", "whole", *(["0.93"] * 12)]


def test_whole_numbers_of_a_table_have_all_their_digits(capsys):
    console.print_table("title", ["file", "points", "share"], [["a.ply", np.int64(1_234_567), 0.12345678]])
    assert capsys.readouterr().out.splitlines()[-1].split() == ["a.ply", "1234567", "0.123457"]


def test_progress_on_a_terminal_takes_no_orders_from_names(monkeypatch):
    class Terminal(io.StringIO):
        def isatty(self):
            return True

    terminal = Terminal()
    monkeypatch.setattr(sys, "stderr", terminal)
    assert list(console.progress(range(3), 3, "on \x1b]0;title\x07 [/foo]")) == [0, 1, 2]
    assert "\x1b]0" not in terminal.getvalue()


@pytest.mark.slow
def test_a_file_is_classified_whatever_it_is_called(tmp_path):
    names = [os.fsencode(f"{name.replace('/', '')}.ply") for name in ESCAPES[:-1]] + [b"\xff\xfe.ply"]
    for name in names:
        (tmp_path / os.fsdecode(name)).write_bytes(mesh_bytes("ply", *mug()))
    for options in ([], ["--explain"]):
        done = run(tmp_path, "classify", *names, b"missing\x1b[2J.ply", *options)
        assert done.returncode == 2 and not obeyed(done.stdout.decode()) and not obeyed(done.stderr.decode())
        assert b"Traceback" not in done.stderr and done.stdout.count(b".ply") >= len(names)


@pytest.mark.slow
def test_names_of_training_objects_are_text(tmp_path, monkeypatch):
    for number, name in enumerate(("\x1b[31mcup", "[/foo]")):
        (tmp_path / "cup").mkdir(exist_ok=True)
        points = mug()[0] * (1 + 0.1 * number)
        np.savez(tmp_path / "cup" / f"{name.replace('/', '')}.npz", vertices=points, faces=mug()[1])
    (tmp_path / "none").mkdir()
    np.savez(tmp_path / "none" / "\x1b[32mslab.npz", points=np.random.default_rng(0).random((500, 3)) * [1, 1, 0.02])
    monkeypatch.chdir(tmp_path)
    trained = spherefunc("train", ".", "--method", "cubes", "--radii", "2cm", "--out", "model.npz", "--jobs", "1")
    assert trained.returncode == 0, trained.stderr
    done = spherefunc("classify", "--model", "model.npz", "--explain", "cup/\x1b[31mcup.npz")
    assert done.returncode == 0 and "slab" in done.stdout
    assert not obeyed(done.stdout) and not obeyed(done.stderr)


def test_errors_name_arguments_in_python_and_options_on_the_command_line(tmp_path):
    (tmp_path / "mug.ply").write_bytes(mesh_bytes("ply", mug()[0] * 1e4, mug()[1]))
    with pytest.raises(InputError) as error:
        sf.load_cloud(tmp_path / "mug.ply")
    assert 'units="mm"' in str(error.value) and "--" not in str(error.value)
    done = run(tmp_path, "classify", "mug.ply", "--json")
    (row,) = json.loads(done.stdout)
    for text in (row["error"], done.stderr.decode()):
        assert "--units mm" in text and "units=" not in text


@pytest.mark.parametrize("options", [{"units": "km"}, {"up": "w"}])
def test_arguments_that_are_none_are_named_as_in_python(options):
    ((name, value),) = options.items()
    with pytest.raises(InputError, match=f'{name}="{value}": expected one of'):
        sf.classify(mug()[0], **options)


def test_nothing_but_the_console_prints():
    """Ruff holds the rest; here that nobody takes the rule out."""
    with contextlib.chdir(ROOT):
        checked = ["spherefunc_bullet", "fast_sim", "scenes", "compare"]
        ruff = [sys.executable, "-m", "ruff", "check", "--isolated", "--select", "T20", *checked]
        assert subprocess.run(ruff, capture_output=True, check=False).returncode == 0


@pytest.mark.parametrize(
    ("wrong", "code", "said"), [(">/dev/full", 2, 1), ("2>&-", 0, 0), (">&-", 0, 0), ("| true", 1, 0)]
)
def test_output_that_is_full_or_closed_is_no_traceback(tmp_path, wrong, code, said):
    if "full" in wrong and not Path("/dev/full").exists():
        pytest.skip("needs /dev/full, which Linux has")
    shell = f"{sys.executable} -c '{CODE}' backends {wrong}; exit ${{PIPESTATUS[0]}}"
    done = subprocess.run(["bash", "-c", shell], cwd=tmp_path, capture_output=True, check=False)
    assert (done.returncode, len(done.stderr.splitlines())) == (code, said), done.stderr
