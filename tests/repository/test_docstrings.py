"""Examples in docstrings do what they say."""

from __future__ import annotations

import doctest
import importlib

import pytest
from checkout import ROOT


def modules_with_examples() -> list[str]:
    """Return the names of all modules whose docstrings hold examples."""
    names = []
    for folder in ("spherefunc_bullet", "fast_sim", "scenes", "compare"):
        for file in sorted((ROOT / folder).rglob("*.py")):
            if ">>> " in file.read_text(encoding="utf-8"):
                name = ".".join(file.relative_to(ROOT).with_suffix("").parts)
                names.append(name if folder == "spherefunc_bullet" else f"spherefunc_bullet.{name}")
    return names


@pytest.mark.parametrize("name", modules_with_examples())
def test_examples_are_true(name):
    failed, tried = doctest.testmod(importlib.import_module(name))
    assert tried and not failed
