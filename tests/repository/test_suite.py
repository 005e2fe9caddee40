"""The suite itself: no file of tests is empty, as one was for a day after a merge."""

from __future__ import annotations

from checkout import ROOT


def test_every_file_of_tests_holds_some():
    files = sorted((ROOT / "tests").rglob("test_*.py"))
    texts = {file.relative_to(ROOT): file.read_text(encoding="utf-8") for file in files}
    empty = [str(file) for file, text in texts.items() if "def test_" not in text and "import *" not in text]
    assert len(files) > 100 and not empty
