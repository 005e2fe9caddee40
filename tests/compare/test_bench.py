"""What the benches print."""

from __future__ import annotations

import re
from importlib.util import find_spec

import numpy as np
import pytest

from spherefunc_bullet.compare.bench import answers, peers
from spherefunc_bullet.compare.bench.harness import Case, apart
from spherefunc_bullet.errors import InputError
from spherefunc_bullet.scenes.household.parts.solids import box

pytestmark = pytest.mark.slow


def test_an_answer_s_steps_are_printed_for_a_mug_a_chair_and_a_sofa(capsys):
    answers.print_answers(repeats=1)
    printed = capsys.readouterr().out
    assert "first classify of a mug" in printed and "second classify of it" in printed and "import" in printed
    assert re.search(r"object +reading +sampling +simulation +features +scores +all", printed)
    for name in ("mug", "chair", "sofa"):
        (line,) = re.findall(rf"^{name} \(\w+\) +(.*)$", printed, re.MULTILINE)
        *steps, whole = map(float, line.split())
        assert len(steps) == 5 and abs(sum(steps) - whole) < 0.5  # each is rounded to a tenth


def test_overlaps_and_what_hangs_are_measured_on_the_mesh(tmp_path):
    path, r = tmp_path / "plate.ply", 0.005
    box(0.2, 0.2, 0.02).export(path)  # its top lies at 0.02
    plate = Case(title="plate", path=path, radius=r)
    centers = np.array([[0, 0, 0.02 + r], [0, 1.5 * r, 0.02 + r], [0.05, 0, 0.02 + 0.8 * r], [-0.05, 0, 0.02 + 2 * r]])
    run = peers.measured("mine", plate, centers, 10, 2.0)
    assert run.in_spheres == pytest.approx(0.5, abs=1e-3) and run.in_object == pytest.approx(0.2, abs=1e-3)
    assert run.hanging == 1 and run.row(2.5)[3:5] == ["5", "2.0"]


@pytest.mark.skipif(find_spec("pybullet") is None, reason="PyBullet is not installed")
def test_peers_meet_the_objects_that_are_asked_for(tmp_path):
    chair, table = peers.cases(["chair", "table"], tmp_path)
    assert chair.path.is_file() and table.path.parent == tmp_path and (chair.radius, table.radius) == (0.02, 0.01)
    with pytest.raises(InputError, match="'sofa': expected some of mug, table, chair"):
        peers.cases(["sofa"], tmp_path)


@pytest.mark.skipif(find_spec("pybullet") is None, reason="PyBullet is not installed")
def test_the_naive_script_drops_as_many_as_asked(tmp_path):
    run = apart(peers.naive_run, *peers.cases(["mug"], tmp_path), 12)  # it closes standard output to PyBullet
    assert run.drops == 12 and 0 < run.settled < 12 and run.seconds > 0
