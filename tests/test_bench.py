"""What the benches print."""

from __future__ import annotations

import re
from importlib.util import find_spec

import pytest

from spherefunc_bullet.compare.bench import answers, backends, engine_share
from spherefunc_bullet.scenes.household.parts.solids import box
from spherefunc_bullet.simulator import DropSettings


def test_an_answer_s_steps_are_printed_for_a_mug_a_chair_and_a_sofa(capsys):
    answers.print_answers(repeats=1)
    printed = capsys.readouterr().out
    assert "first classify of a mug" in printed and "second classify of it" in printed and "import" in printed
    assert re.search(r"object +reading +sampling +simulation +features +scores +all", printed)
    for name in ("mug", "chair", "sofa"):
        (line,) = re.findall(rf"^{name} \(\w+\) +(.*)$", printed, re.MULTILINE)
        *steps, whole = map(float, line.split())
        assert len(steps) == 5 and abs(sum(steps) - whole) < 0.5  # each is rounded to a tenth


def test_backends_stand_beside_each_other(capsys):
    backends.print_backends("household", ["fast"], 8)
    printed = capsys.readouterr().out
    assert "spheres kept" in printed and re.search(r"^fast +8 +\d+ ", printed, re.MULTILINE)


@pytest.mark.skipif(find_spec("pybullet") is None, reason="PyBullet is not installed")
def test_the_engine_s_share_is_of_all_the_time_of_a_run(tmp_path):
    path = tmp_path / "plate.ply"
    box(0.2, 0.2, 0.02).export(path)
    shares = engine_share.shares_of(path, DropSettings(radius=0.02, max_drops=20, miss_limit=20))
    parts = (shares.surface, shares.loading, shares.stepping, shares.rest)
    assert shares.drops == 20 and min(parts) > 0
    assert float(shares.row[-1]) == pytest.approx(shares.stepping / sum(parts), abs=0.006)  # two decimals
