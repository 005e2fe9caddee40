"""The site builds without a warning and without the network, and the notebook runs."""

from __future__ import annotations

import json
import os
import re
import runpy
import subprocess
import sys
import tempfile
from pathlib import Path

import matplotlib
import pytest
from checkout import ROOT

import spherefunc_bullet

NOTEBOOK = ROOT / "docs" / "notebooks" / "from_a_folder_to_a_picture.ipynb"


@pytest.fixture(scope="module")
def site(tmp_path_factory) -> Path:
    """Return the folder of the site, built with no way out."""
    pytest.importorskip("mkdocstrings")
    folder = tmp_path_factory.mktemp("site")
    command = [sys.executable, "-m", "mkdocs", "build", "--strict", "--site-dir", folder]
    nowhere = {name: "http://127.0.0.1:9" for name in ("http_proxy", "https_proxy", "HTTP_PROXY", "HTTPS_PROXY")}
    done = subprocess.run(command, cwd=ROOT, env=os.environ | nowhere, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return folder


@pytest.mark.slow
def test_every_public_name_has_its_entry(site):
    page = (site / "api.html").read_text()
    for name in set(dir(spherefunc_bullet)) - {"__version__"}:
        assert re.search(rf'id="[.\w]+\.{name}"', page), name


@pytest.mark.slow
def test_pages_fetch_nothing_from_the_network(site):
    for page in site.rglob("*.html"):
        fetched = re.findall(r'<(?:script|img|iframe)[^>]*src="(\w+:)?//', page.read_text())
        fetched += re.findall(r'<link[^>]*rel="(?:stylesheet|preconnect)"[^>]*href="(?:\w+:)?//', page.read_text())
        assert not fetched, page


@pytest.mark.slow
def test_every_document_is_in_the_menu(site):
    menu = (site / "index.html").read_text()
    for page in (ROOT / "docs").glob("*.md"):
        assert f'href="{page.stem}.html' in menu, page


@pytest.mark.slow
def test_the_notebook_runs_and_draws(tmp_path, monkeypatch, capsys):
    """Its cells one after the other, which are plain Python, in this process."""
    cells = [cell for cell in json.loads(NOTEBOOK.read_text())["cells"] if cell["cell_type"] == "code"]
    assert not any(cell["outputs"] for cell in cells), "strip its outputs"
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    (tmp_path / "cells.py").write_text("\n".join("".join(cell["source"]) for cell in cells))
    with matplotlib.rc_context({"backend": "agg"}):
        runpy.run_path(str(tmp_path / "cells.py"), run_name="__main__")
    printed = capsys.readouterr().out.splitlines()
    picture = Path(printed[-1])
    assert picture.is_relative_to(tmp_path) and picture.stat().st_size > 20_000
    assert any(line.startswith("mug_02 cup cup ") for line in printed)  # what it is for, and why
