"""Code blocks of README and docs run as they stand, in a folder that has the files which the pages name.

But for those that need what no checkout has, or minutes each; `ELSEWHERE` lists them. Shapes are made of one plain cup,
benches of them too, which take minutes for all of DATA; forests are small, spheres and shapes are few: what they say is
not looked at.
"""

from __future__ import annotations

import importlib
import os
import re
import runpy
import shlex
import sys
from itertools import dropwhile, takewhile
from pathlib import Path
from unittest import mock

import clouds
import numpy as np
import pytest
import room_shapes
import trimesh
from catalogues import household
from checkout import ROOT
from typer.core import TyperCommand, TyperGroup
from typer.main import get_command
from usd_stages import stage_of

from spherefunc_bullet.commands.command_line import application
from spherefunc_bullet.viewer.pictures import CameraView

PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
BLOCK = re.compile(r"^```(\w+)\n(.*?)^```", re.MULTILINE | re.DOTALL)
PROSE = {"text", "bibtex", "toml"}
# What other tests run (shapes, exam), or no checkout has: bags (test_ros), images over time (test_fusion), other
# people's and PyBullet's own models; and what takes minutes each: comparisons, copies, virtual rooms, the best shape.
ELSEWHERE = re.compile(
    r"\.bag|scene drive|--frames|SceneFusion|--scheduler|across_sources|\$SLURM|part_\*|spherefunc demo"
    r"|robustness\.exam|household/third"
    r"|compare (DATA|DIR)|mechanics |compare\.demo --out|shapes DIR|pybullet_data"
    r"|poses mug_01|together dining_table_02|places mug_01"  # the gallery, of what mechanics.md and places.md run too
    r"|--impaired|--corruptions|rooms household|dataset (rooms|impair)|shapes mug\.obj|--best|--coacd|compare_shapes"
)
TESTED = {"python.md": "test_answers.py", "backends.md": "test_conformance.py"}
NOT_OURS = {"pip", "pytest", "make", "dask", "sbatch", "python3", "night/ledger.sqlite"}
SLOW = re.compile(
    r"--run night|my_objects|carry |together |shapes mug|--prove|prove=True|DATA --backend bullet"
    r"|scene room|poses |cd household|household household|mug_01|support/(written_shapes|shape_pairs)"
)
FEW = "few"  # in place of DATA for benches of shapes

FEWER = (  # of what costs time: trees, pixels, spheres and seconds of their fall
    ("spherefunc_bullet.learning.function_classifier", "TREES", 8),
    ("spherefunc_bullet.compare.evaluation.features", "MANY", 10**6),  # other processes take longer to start
    ("spherefunc_bullet.compare.evaluation.readings", "WORTH_CORES", 10**6),
    ("spherefunc_bullet.viewer.mechanics_pictures", "TILE", CameraView(size=(90, 75))),
    ("written_shapes", "SIDE", 5),
    ("written_shapes", "SECONDS", 0.3),
)

URDF = """<robot name="mug"><link name="mug"><visual><geometry><mesh filename="mug.obj"/></geometry></visual>
<collision><geometry><mesh filename="mug_col.obj"/></geometry></collision></link></robot>"""


@pytest.fixture(scope="module")
def files(tmp_path_factory) -> Path:
    """Return a folder with what the pages name, small."""
    folder = tmp_path_factory.mktemp("documents")
    known = {item.name: item for item in household()}
    for name, of in MODELS.items():
        known[of].mesh.export(folder / name)
    plain_cup(16).export(folder / "mug.obj")
    plain_cup(16).convex_hull.export(folder / "mug_col.obj")
    (folder / "mug.urdf").write_text(URDF)
    (folder / "mug.usda").write_text(stage_of(plain_cup(16), "convexHull"))
    write_clouds(folder)
    for data in ("DATA", "my_objects", "models"):
        write_data(folder / data, list(known.values()))
    write_cup(folder / FEW)
    return folder


MODELS = {"mug.ply": "mug_01", "chair.ply": "dining_chair_01", "chair.obj": "dining_chair_01"}
MODELS |= {"table.ply": "dining_table_02"}


def write_clouds(folder: Path):
    """Write a scan of one object and one of a room, in several formats."""
    scan, room = clouds.mug().points, room_shapes.room()[0]
    trimesh.PointCloud(scan).export(folder / "scan.ply")
    header = f"VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH {len(scan)}\nHEIGHT 1\n"
    header += f"VIEWPOINT 0 0 0 1 0 0 0\nPOINTS {len(scan)}\nDATA ascii"
    np.savetxt(folder / "scan.pcd", scan, header=header, comments="")
    np.save(folder / "seen.npy", 1000 * scan[:, [1, 2, 0]])  # millimetres, y up
    np.save(folder / "room.npy", room)
    trimesh.PointCloud(room).export(folder / "room.ply")


def plain_cup(sides: int = 12) -> trimesh.Trimesh:
    """Return a cup of so many sides; with twelve, PyBullet does not hold all that V-HACD makes of it."""
    profile = [(0, 0), (0.034, 0), (0.034, 0.06), (0.03, 0.06), (0.03, 0.006), (0, 0.006)]
    return trimesh.creation.revolve(np.array(profile), sections=sides)


def write_cup(folder: Path):
    """Write a data set of one plain cup."""
    folder.mkdir()
    plain_cup().export(folder / "cup.ply")
    (folder / "manifest.csv").write_text("file,label,group\ncup.ply,cup,a\n")


def write_data(folder: Path, objects: list, each: int = 2):
    """Write a small data set: so many small objects of each label."""
    folder.mkdir()
    rows = ["file,label,group"]
    for label in ("cup", "table", "sittable", "none"):
        own = [one for one in objects if one.label == label]
        for number, one in enumerate(sorted(own, key=lambda one: np.prod(one.mesh.extents))[:each]):
            one.mesh.export(folder / f"{one.name}.ply")
            rows.append(f"{one.name}.ply,{label},{'ab'[number % 2]}")
    (folder / "manifest.csv").write_text("\n".join(rows) + "\n")


def steps(page: Path) -> list[str]:
    """Return what a reader runs, in order: commands, and whole blocks of Python."""
    found = []
    for kind, text in BLOCK.findall(page.read_text(encoding="utf-8")):
        if kind == "python":
            found.append(text)
        elif kind not in PROSE:
            lines = text.replace("\\\n", " ").splitlines()
            found += [line.removeprefix("$ ").partition(" # ")[0].strip() for line in lines if line.strip()]
    return found


def follow(step: str) -> int:
    """Run one command, or one block of Python, where the reader is; return its exit code."""
    words = shlex.split(step, comments=True) if "\n" not in step else []
    if not words:
        Path("block.py").write_text(step)
        runpy.run_path("block.py", run_name="__main__")
        return 0
    if words[0] == "cd":
        os.chdir(words[1])
        return 0
    if words[0] == "spherefunc":
        return application(words[1])(words[1:], prog_name="spherefunc", standalone_mode=False) or 0
    if words[0] == "python":
        of_ours = words[1] == "-m"  # else one of the repository's own programs: a bench of shapes
        name, options = (words[2], words[3:]) if of_ours else (Path(words[1]).stem, words[2:])
        if not of_ours:
            options = [FEW, *dropwhile(lambda word: not word.startswith("-"), options)]
        module = importlib.import_module(name)
        assert Path(module.__file__).read_text().endswith('if __name__ == "__main__":\n    main()\n')
        with mock.patch.object(sys, "argv", [name, *options]):
            return module.main() or 0
    return 0 if words[0] in NOT_OURS else 1


def parse(command: TyperCommand | TyperGroup, words: list[str]) -> str:
    """Read the words after a command's name as it does, without running it; return the name of what would run."""
    context = command.make_context(command.name, list(words))
    if isinstance(command, TyperGroup):
        _, inner, left = command.resolve_command(context, [*context._protected_args, *context.args])
        return parse(inner, left)
    return command.name


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_every_command_takes_the_options_that_pages_give_it(page, files, monkeypatch):
    """Also those that take minutes, or what no checkout has."""
    monkeypatch.chdir(files)
    commands = [re.sub(r"\$\(.*?\)", "FILE", step) for step in steps(page) if step.startswith("spherefunc ")]
    for words in map(shlex.split, commands):
        own = list(takewhile(lambda word: word not in ("|", ">", "&", "&&"), words[1:]))
        assert parse(get_command(application(words[1])), own)


def steps_here(page: Path) -> list[str]:
    """Return the steps of a page that can be taken here."""
    return [step for step in steps(page) if not ELSEWHERE.search(step)]


def marked(page: Path):
    """Return a page as a parameter, marked as slow where a step of it is."""
    slow = any(SLOW.search(step) for step in steps_here(page))
    return pytest.param(page, id=page.name, marks=[pytest.mark.slow] * slow)


@pytest.mark.parametrize("page", [marked(page) for page in PAGES if page.name not in TESTED])
@pytest.mark.slow
def test_code_blocks_run_as_they_stand(page, files, monkeypatch, few_candidates):
    monkeypatch.chdir(files)
    for module, name, few in FEWER:
        monkeypatch.setattr(importlib.import_module(module), name, few)
    for step in steps_here(page):
        assert follow(step) == 0, step


def test_the_gallery_names_objects_of_the_catalogue():
    named = set(re.findall(r"\b(\w+_\d\d)\.ply", (ROOT / "docs" / "gallery.md").read_text(encoding="utf-8")))
    assert named and named <= {item.name for item in household()}
