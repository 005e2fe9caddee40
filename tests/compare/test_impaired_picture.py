"""The picture of impaired copies: its numbers are in it, right is blue and wrong is orange, bad names are refused."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from PIL import Image

from spherefunc_bullet.compare.evaluation.impaired import KindShare, Shares
from spherefunc_bullet.compare.figures.impaired_picture import (
    RIGHT,
    WRONG,
    blocks_of,
    colours,
    columns_of,
    draw_impaired,
    headline,
    kind_words,
)
from spherefunc_bullet.errors import InputError
from spherefunc_bullet.scenes.impairment.impairments import kinds_of


def kind(works: bool, spheres: float, rules: float) -> KindShare:
    return {"works": works, "copies": 6, "share": {"spheres": spheres, "rules": rules, "height_map": 0.77}}


@pytest.fixture
def shares() -> Shares:
    """Return shares of two functions whose means are known: useless 0.2 and 0.6, harmless 0.9 and 0.5."""
    return {
        "cup": {"whole": kind(True, 0.11, 0.12), "lid": kind(False, 0, 0.8), "turned": kind(True, 1.0, 0.4)},
        "table": {
            "half": kind(False, 0.5, 0.3),
            "spikes": kind(False, 0.3, 0.5),
            "smaller": kind(True, 0.8, 0.6),
        },
    }


def words_of(svg: Path) -> list[str]:
    """Return the texts of an SVG file."""
    return [re.sub("<[^>]*>", "", text).strip() for text in re.findall(r"<text.*?</text>", svg.read_text(), re.S)]


def test_the_headline_is_the_mean_over_functions_without_what_is_unchanged(shares):
    assert headline(shares, columns_of(shares)) == [
        "Share of useless copies still classified as useful: spheres 20 %, rules 60 %.",
        "Share of harmless copies still classified as useful: spheres 90 %, rules 50 %.",
    ]


def test_the_svg_holds_every_row_and_number(shares, tmp_path):
    words = words_of(draw_impaired(shares, tmp_path / "new" / "picture.svg"))
    for row in ("lid on top", "turned around", "unchanged", "half of the top gone", "spikes on the top"):
        assert words.count(row) == 1
    assert (words.count("11"), words.count("12")) == (1, 1)  # of what is unchanged, which is in no mean
    assert words.count("100") == 2  # of cups that are turned, and as their mean
    assert "77" not in words and words.count("rules") == 2  # what is not drawn; a heading in each panel
    assert words.count("mean of those below") == 4


def test_the_png_is_drawn_and_the_same_again(shares, tmp_path):
    first, second = (draw_impaired(shares, tmp_path / name).read_bytes() for name in ("a.png", "b.PNG"))
    assert first == second
    colours_in_it = {colour for _, colour in Image.open(tmp_path / "a.png").convert("RGB").getcolors(2**24)}
    assert tuple(bytes.fromhex(RIGHT[1:])) in colours_in_it  # no cup with a lid is called a cup, as it should be


def test_the_headline_is_not_cut_off_beside_a_single_panel(shares, tmp_path):
    cups = {"cup": shares["cup"]}
    for row in cups["cup"].values():
        row["share"] |= {name: 0.5 for name in ("fast", "bullet", "points", "occupancy_sqrt", "examiner")}
    picture = Image.open(draw_impaired(cups, tmp_path / "cups.png")).convert("L")
    assert picture.crop((picture.width - 20, 0, picture.width, 120)).getextrema() == (255, 255)  # beside its lines


def test_right_is_one_end_and_wrong_the_other():
    as_bytes = [tuple(round(255 * part) for part in colours()(end)[:3]) for end in (0.0, 1.0)]
    assert as_bytes == [tuple(bytes.fromhex(colour[1:])) for colour in (WRONG, RIGHT)]


def test_what_is_unchanged_and_the_mean_come_first(shares):
    assert list(blocks_of(shares["cup"], columns_of(shares))[True]) == ["whole", "mean of those below", "turned"]


def test_every_kind_has_words():
    for name in kinds_of():
        assert "_" not in kind_words("table", name)


@pytest.mark.parametrize("name", ["picture.pdf", "picture", "png"])
def test_other_endings_are_refused(shares, tmp_path, name):
    with pytest.raises(InputError, match="ends in .png or .svg"):
        draw_impaired(shares, tmp_path / name)


def test_a_place_that_cannot_be_written_is_said(shares, tmp_path):
    (tmp_path / "file").write_text("in the way")
    with pytest.raises(InputError, match="can be written"):
        draw_impaired(shares, tmp_path / "file" / "picture.png")
