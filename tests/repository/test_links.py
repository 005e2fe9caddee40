"""Links of the documents lead somewhere: files of the repository, and headings of pages; nothing is fetched."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from checkout import ROOT

PAGES = [ROOT / "README.md", ROOT / "CHANGELOG.md", *sorted((ROOT / "docs").glob("*.md"))]
LINK = re.compile(r"\]\(([^()\s]+)\)")
FENCE = re.compile(r"^```.*?^```", re.MULTILINE | re.DOTALL)


def anchors_of(page: Path) -> set[str]:
    """Return the anchors of a page: its headings as mkdocs names them, and those that it sets itself."""
    text = FENCE.sub("", page.read_text())
    headings = re.findall(r"^#+ +(.+)$", text, re.MULTILINE)
    slugs = {re.sub(r"[-\s]+", "-", re.sub(r"[^\w\s-]", "", heading.lower()).strip()) for heading in headings}
    return slugs | set(re.findall(r'id="([^"]+)"', text))


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_lead_somewhere(page):
    for link in LINK.findall(FENCE.sub("", page.read_text())):
        if re.match(r"\w+:", link):
            continue
        path, _, anchor = link.partition("#")
        target = page.parent / path if path else page
        assert target.exists(), f"{page.name}: {link}"
        assert not anchor or anchor in anchors_of(target), f"{page.name}: {link}"


def test_the_index_leads_to_every_page():
    linked = set(LINK.findall((ROOT / "docs" / "index.md").read_text()))
    assert {page.name for page in (ROOT / "docs").glob("*.md")} - {"index.md"} <= linked


def test_every_picture_of_the_gallery_has_the_lines_that_made_it():
    sections = (ROOT / "docs" / "gallery.md").read_text().split("\n## ")[1:]
    assert sections and all(FENCE.search(section) for section in sections)


@pytest.mark.parametrize(("page", "most"), [("README.md", 7000), ("docs/method.md", 8000)])
def test_what_everybody_reads_stays_short(page, most):
    assert len((ROOT / page).read_bytes()) <= most
