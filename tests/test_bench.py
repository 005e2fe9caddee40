"""What the benches print."""

from __future__ import annotations

import re

from spherefunc_bullet.compare.bench import answers, backends


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
