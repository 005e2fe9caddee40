"""A person can follow an answer: it is decided in one file, and runs through few."""

from __future__ import annotations

from pathlib import Path

from spherefunc_bullet.compare.figures.architecture import DECISION, draw, files_of_classify, layers

MOST_FILES = 50  # more, and nobody reads them; with a new one, another has to go


def test_a_first_answer_runs_through_few_files(tmp_path: Path):
    found = files_of_classify()
    assert len(found) <= MOST_FILES, "\n".join(found)
    assert {place.split(".")[0] for place in found} <= set(layers())
    assert {"classify", "decide", "check_stability", "doubts"} <= set(found[DECISION])
    draw(found, tmp_path / "picture.svg")
    assert (tmp_path / "picture.svg").stat().st_size
