"""One word for one concept: what the glossary retires stands nowhere in code and documents."""

from __future__ import annotations

import re
import subprocess
from fnmatch import fnmatch
from pathlib import Path

from checkout import ROOT

GLOSSARY = ROOT / "docs" / "glossary.md"
TEXT = {".py", ".pyi", ".md", ".html", ".js", ".toml", ".ipynb", ".yml"}
# Field names of JSON and of kept files, which do not change, and tables that commands wrote before words did.
KEPT = {
    "spherefunc_bullet/settling/dropping.py": {"KeptFile"},
    "docs/changes.md": {"*"},
    "docs/glossary.md": {"*"},
    "docs/results/*": {"*"},
    "tests/repository/test_plain_words.py": {"*"},
    "tests/commands/test_old_names.py": {"things"},
    "scenes/arrangements/together.py": {"things"},
    "spherefunc_bullet/learning/function_classifier.py": {"kin_"},
    "compare/evaluation/robustness/corruptions.py": {"told"},
    "compare/figures/impaired_picture.py": {"told"},
    "tests/datasets/test_in_use.py": {"told"},
    "compare/mechanics/*": {"things"},
    "compare/commands/mechanics.py": {"things"},
    "compare/comparison/tables.py": {"things"},
    "compare/documents/*": {"told"},
    "scenes/report/*.js": {"thing", "things"},
}


def retired() -> set[str]:
    """Return the words of the glossary's last column."""
    rows = [line.strip("|\n").split("|") for line in GLOSSARY.read_text().splitlines() if line.startswith("| **")]
    assert len(rows) >= 40 and all(len(row) == 3 for row in rows)
    return {word for row in rows for word in re.findall(r"`([^`]+)`", row[2])}


def sources() -> list[Path]:
    """Return the files of the repository that people read."""
    listed = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=True).stdout
    return [ROOT / name for name in listed.splitlines() if Path(name).suffix in TEXT and (ROOT / name).is_file()]


def without_written_tables(text: str) -> str:
    """Return a document without what commands write in it."""
    return re.sub(r"<!-- table: .*?<!-- end -->", "", text, flags=re.S)


def test_retired_words_stand_nowhere():
    words = retired()
    words |= {word.capitalize() for word in words if word.islower()}
    pattern = re.compile(r"(?<![\w-])(" + "|".join(map(re.escape, sorted(words))) + r")(?![\w-])")
    found = []
    for path in sources():
        name = path.relative_to(ROOT).as_posix()
        kept = set().union(*(own for glob, own in KEPT.items() if fnmatch(name, glob)))
        if "*" in kept:
            continue
        text = without_written_tables(path.read_text(encoding="utf-8"))
        found += [f"{name}: {match[0]}" for match in pattern.finditer(text) if match[0] not in kept]
    assert not found, f"{len(found)} retired words, see docs/glossary.md:\n" + "\n".join(found)
